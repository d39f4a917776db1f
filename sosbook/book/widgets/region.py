"""Move the parts of a D-region."""

import numpy as np

from ...requirements.pole_region import LMIRegion
from ..plots import BLUE
from .charts import plane
from .explorer import Explorer, linear, page

__all__ = ["explore_region"]


def explore_region(A=None):
    """Move the parts of a D-region over the poles of a matrix.

    Parameters
    ----------
    A : (k, k) array_like, optional
        Default: poles at -1, -2 and -1.5 +- 2j.

    Returns
    -------
    Explorer
        The sliders and the figure.
    """
    if A is None:
        A = np.zeros((4, 4))
        A[0, 0], A[1, 1] = -1, -2
        A[2:, 2:] = [[-1.5, 2], [-2, -1.5]]
    poles = np.linalg.eigvals(np.asarray(A, float))
    sliders = {
        "sigma": linear("half-plane sigma (1/s)", 0.5, 0, 3),
        "theta": linear("sector theta (degrees)", 60, 5, 90),
        "rho": linear("disk radius rho (rad/s)", 4, 0.5, 8),
        "centre": linear("disk centre (1/s)", 0, -6, 1),
    }

    def draw(sigma, theta, rho, centre):
        region = (
            LMIRegion.half_plane(sigma)
            & LMIRegion.sector(np.radians(theta))
            & LMIRegion.disk(rho, centre)
        )
        window = (-9.0, 2.0, 6.0)
        chart = plane(window, "Poles and the region", region)
        chart.marks(poles.real, poles.imag, BLUE, "cross")
        rows = "".join(
            f"<li>{name}: {d.min():+.2f} rad/s "
            f"{'inside' if d.min() > 0 else 'OUTSIDE'}</li>"
            for name, d in region.distances(poles).items()
        )
        verdict = "inside" if region.contains(poles) else "not all inside"
        yield page(
            chart.svg(),
            f"<div><strong>The poles are {verdict}.</strong><ul>{rows}</ul></div>",
        )

    return Explorer(sliders, draw)
