"""The thesis's D-region: a half-plane, a sector and a disk."""

from collections.abc import Sequence

import numpy as np

from ..plants.checks import finite, positive
from ..runtime.read_only import put
from .lmi_region import LMIRegion, Region

__all__ = ["LMIRegion", "PoleRegion", "Region"]

SETTLED = 4.0  # time constants: exp(-4) is 2 %


class PoleRegion(Region):
    """The thesis's D-region (Fig. 2.1); any part may be left out.

    Parameters
    ----------
    sigma : float, optional
        Re s < -sigma, in rad/s.
    theta : float, optional
        HALF the angle of the sector around the negative real axis, in
        radians, at most pi/2.
    rho : float, optional
        |s| < rho, in rad/s.
    theta_deg : float, optional
        theta in degrees, instead of radians.
    settling_time : float, optional
        Seconds in which exp(-sigma t) is down to 2 %, instead of sigma = 4 / time.
    overshoot : float, optional
        Of one mode alone that is let go, 0.05 for 5 %, instead of theta: its logarithm
        is -pi / tan(theta). Several modes together may overshoot more.

    Raises
    ------
    ValueError
        If nothing is given, a value is out of range, or the
        intersection is empty.

    Notes
    -----
    Source: Theorem 2.2, (2.18)-(2.20).

    Examples
    --------
    >>> region = PoleRegion(sigma=0.7, theta=np.pi / 4, rho=5)
    >>> region.distances([-1 + 0.5j])["half-plane"]
    array([0.3])
    >>> PoleRegion(settling_time=5).sigma
    0.8
    """

    def __init__(
        self,
        sigma: float | None = None,
        theta: float | None = None,
        rho: float | None = None,
        *,
        theta_deg: float | None = None,
        settling_time: float | None = None,
        overshoot: float | None = None,
    ) -> None:
        """Check the numbers; other words become sigma and theta."""
        if settling_time is not None:
            if sigma is not None:
                raise ValueError("give sigma or settling_time, not both")
            sigma = SETTLED / positive("settling_time", settling_time)
        if overshoot is not None:
            if theta is not None or theta_deg is not None:
                raise ValueError("give theta, theta_deg or overshoot, not several")
            share = positive("overshoot", overshoot)
            if share >= 1:
                raise ValueError(
                    f"overshoot = {overshoot} must be below 1: it is a share, 0.05 "
                    "for 5 %"
                )
            theta = float(np.arctan2(np.pi, -np.log(share)))
        if theta_deg is not None:
            if theta is not None:
                raise ValueError("give theta (in radians) or theta_deg, not both")
            theta = float(np.radians(finite("theta_deg", theta_deg)))
            if not 0 < theta <= np.pi / 2:
                raise ValueError(
                    f"theta_deg = {theta_deg} is outside (0, 90]: it is the "
                    "half-angle of the sector"
                )
        parts = []
        if sigma is not None:
            if finite("sigma", sigma) < 0:
                raise ValueError(
                    f"sigma = {sigma} is negative; for a region that "
                    "reaches right of the imaginary axis use "
                    "LMIRegion.half_plane"
                )
            parts.append(LMIRegion.half_plane(sigma))
        if theta is not None:
            parts.append(LMIRegion.sector(theta))
        if rho is not None:
            parts.append(LMIRegion.disk(rho))
        if not parts:
            raise ValueError("PoleRegion needs sigma, theta or rho")
        if None not in (sigma, rho) and rho <= sigma:
            raise ValueError(
                f"the region is empty: rho = {rho} must exceed sigma = {sigma}"
            )
        put(self, sigma=sigma, theta=theta, rho=rho, parts=tuple(parts))

    @classmethod
    def of(cls, parts: Sequence[LMIRegion]) -> Region:
        """The region of these parts: a PoleRegion where they make one."""
        bounds = {p.parameter.key: p.bound for p in parts if p.parameter}
        if len(bounds) == len(parts):
            try:
                region = cls(**bounds)
            except ValueError:
                return Region(parts)
            if [_same(p) for p in parts] == [_same(p) for p in region.parts]:
                return region
        return parts[0] if len(parts) == 1 else Region(parts)

    def __repr__(self):
        return f"PoleRegion(sigma={self.sigma}, theta={self.theta}, rho={self.rho})"


def _same(part):
    return part.name, part.alpha.tolist(), part.beta.tolist()
