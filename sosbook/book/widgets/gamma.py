"""Move the unit of the disturbance: what the joint gamma measures."""

import numpy as np

from ...studies.gamma_bounds import gamma_lower_bounds
from ...synthesis.pid import analyse_pid
from ..elements.chart import Chart
from ..plots import BLUE, GREEN, ORANGE, VERMILLION
from .explorer import Explorer, linear, margins_table, note, page

__all__ = ["explore_mu"]


def explore_mu(plant, K, U=None, region=None, saturation=None, K_A=None):
    """Move mu; see the smallest joint gamma and its lower bounds.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant, with its ``F``.
    K : (m, N) array_like
        The gain that is analysed.
    U, region
        As in `design_pid`.
    saturation : Saturation
        Its u_max and x0 are where the sliders start.
    K_A
        As in `design_pid`.

    Returns
    -------
    Explorer
        ``sliders["mu"]`` is the decimal logarithm of mu.
    """
    lower = gamma_lower_bounds(plant, K, U, saturation, K_A)
    low = np.log10(lower.mu) - 0.5
    high = max(0.0, np.log10(lower.corner)) + 1.0
    ticks = np.linspace(low, high, 13)

    def smallest(mu):
        return analyse_pid(
            plant,
            K,
            U,
            region=region,
            gamma=None,
            saturation=saturation,
            K_A=K_A,
            mu=mu,
            minimize="gamma",
            backoff=1e-3,
        )

    curve = [(x, smallest(10**x).gamma) for x in ticks]
    curve = np.array([(x, np.log10(g)) for x, g in curve if g is not None])
    sliders = {"mu": linear("log10 of mu", 0.0, low, high, ".2f")}
    floor = np.log10(lower.norm)
    ceiling = max(curve[:, 1].max() if len(curve) else 0, floor) + 0.3

    def draw(mu):
        chart = Chart(
            (low, high),
            (floor - 0.4, ceiling),
            "mu",
            "gamma",
            "Smallest gamma over mu, and its walls",
            log=True,
        )
        chart.line([low, high], [floor] * 2, GREEN, True, "norm")
        rising = (np.array([low, high]) + np.log10(lower.energy)) / 2
        chart.line([low, high], rising, ORANGE, True, "x(0)")
        chart.line(
            [np.log10(lower.mu)] * 2, [floor - 0.4, ceiling], VERMILLION, True, "u_max"
        )
        if len(curve):
            chart.line(*curve.T, BLUE, name="LMI")
        analysed = smallest(10**mu)
        message = f"mu = {10**mu:.3g}: "
        if analysed.status != "feasible":
            message += f"<strong>{analysed.status}</strong>."
            yield note(message) + page(chart.svg())
            return
        chart.marks([mu], [np.log10(analysed.gamma)], BLUE, "circle")
        message += (
            f"gamma = <strong>{analysed.gamma:.3g}</strong>, "
            f"{analysed.gamma / lower.norm:.1f} times the norm "
            f"{lower.norm:.3g}. From rest |K x| stays below "
            f"{saturation.u_max:.4g} for every w of energy up to "
            f"{10**-mu:.3g}."
        )
        yield note(message, BLUE) + page(chart.svg(), margins_table(analysed.margins))

    return Explorer(sliders, draw)
