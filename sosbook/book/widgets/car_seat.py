"""Move the range of the driver's mass in the car-seat example."""

import numpy as np

from ...analysis.linear import poles
from ...display.escape import page_text
from ...plants.descriptor import descriptors
from ...plants.response import simulate
from ...plants.second_order import Polytope
from ...requirements.input_bound import Saturation
from ...requirements.pole_region import PoleRegion
from ..elements.chart import Chart
from ..plots import BLUE, GREY, INK, VERMILLION, track_poles, window_of
from ..thesis import car_seat, example_2
from .charts import plane
from .explorer import (
    Explorer,
    Follower,
    gains_table,
    linear,
    log,
    margins_table,
    note,
    page,
)

__all__ = ["explore_mass_range"]


def explore_mass_range():
    """Move the lightest and the heaviest driver, and the requirements.

    Each move designs one controller for all masses between, with all
    requirements of Example 2 and sound blocks for the whole range. The
    poles are drawn over the range, the seat's response to a set point of
    10 cm for both ends.

    Returns
    -------
    Explorer
        The sliders and the figure.
    """
    ex = example_2()
    sliders = {
        "low": linear("lightest seat (kg)", 70, 20, 100),
        "high": linear("heaviest seat (kg)", 120, 101, 400),
        "sigma": linear("decay rate sigma (1/s)", 0.9, 0, 4),
        "theta": linear("half-angle theta (degrees)", 60, 5, 90),
        "rho": linear("radius rho (rad/s)", 15, 3, 30),
        "gamma": log("norm bound gamma (m/N)", ex.gamma, 10, 10),
        "u_max": log("input bound u_max (N)", ex.saturation.u_max, 100, 2),
    }

    follow = Follower()

    def draw(low, high, sigma, theta, rho, gamma, u_max):
        region = PoleRegion(sigma, np.radians(theta), rho)
        design = follow(
            Polytope([car_seat(low), car_seat(high)]),
            ex.U,
            region=region,
            gamma=gamma,
            saturation=Saturation(u_max, ex.saturation.x0),
        )
        message = f"One controller for {low:g} to {high:g} kg: "
        message += f"<strong>{design.status}</strong>."
        if design.status != "feasible":
            yield note(message)
            yield note(f"{message} {page_text(design.advice)}")
            return
        masses = np.linspace(low, high, 21)
        loops = descriptors(Polytope([car_seat(m) for m in masses]), ex.U)
        yield note(message, BLUE) + page(
            _pole_chart(loops, design.K, region),
            _step_chart(loops, design.K, masses),
            gains_table(design),
            margins_table(design.margins),
        )

    return Explorer(sliders, draw)


def _pole_chart(loops, K, region):
    tracks = track_poles([poles(d, K) for d in loops])
    window = window_of([tracks], region)
    chart = plane(
        window, "Poles for all masses; circles: lightest, crosses: heaviest", region
    )
    for branch in tracks.T:
        chart.line(branch.real, branch.imag, BLUE)
    chart.marks(tracks[0].real, tracks[0].imag, INK, "circle")
    chart.marks(tracks[-1].real, tracks[-1].imag, VERMILLION, "cross")
    return chart.svg()


def _step_chart(loops, K, masses):
    t, r = np.linspace(0, 5, 201), np.array([0.1, 0.1])
    ends = [simulate(loops[k], K, t, r).z[0] for k in (0, -1)]
    high = 1.1 * max(0.1, *(z.max() for z in ends))
    low = 1.1 * min(0.0, *(z.min() for z in ends))
    chart = Chart(
        (0, 5), (low, high), "t (s)", "z1 (m)", "Seat for a set point of 0.1 m"
    )
    chart.line([0, 5], [0.1, 0.1], GREY, dashed=True)
    for z, m, colour in zip(ends, masses[[0, -1]], (INK, VERMILLION)):
        chart.line(t, z, colour, name=f"{m:g} kg")
    return chart.svg()
