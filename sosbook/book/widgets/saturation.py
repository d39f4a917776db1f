"""Move the input bound and the initial state."""

import numpy as np

from ...display.escape import page_text
from ...requirements.input_bound import Saturation
from ..elements.chart import Chart
from ..plots import BLUE, INK, SKY, VERMILLION, ellipse_outline
from .explorer import Explorer, Follower, gains_table, linear, log, note, page

__all__ = ["explore_saturation"]


def explore_saturation(plant, U, region, saturation, gamma=None):
    """Move u_max and the size of x(0): ellipsoid and |K x(t)|.

    Parameters
    ----------
    plant, U, region
        As in `design_pid`.
    saturation : Saturation
        Where the sliders start.
    gamma
        As in `design_pid`.

    Returns
    -------
    Explorer
        The sliders and the figure.
    """
    sliders = {
        "u_max": log("input bound u_max", saturation.u_max, 5, 5),
        "scale": linear("x(0), times", 1.0, 0.1, 3.0),
    }

    follow = Follower()

    def draw(u_max, scale):
        bound = Saturation(u_max, scale * saturation.x0)
        design = follow(plant, U, region=region, gamma=gamma, saturation=bound)
        if design.status != "feasible":
            message = f"<strong>{design.status}</strong>."
            yield note(message)
            yield note(f"{message} {page_text(design.advice)}")
            return
        n = plant.n
        slowest = -design.poles().real.max()
        t = np.linspace(0, float(f"{6 / slowest:.1g}"), 201)
        answer = design.simulate(t, x0=bound.x0)
        outline = ellipse_outline(design.P, (0, n))
        reach = 1.1 * np.abs(outline).max(axis=1)
        shadow = Chart(
            (-reach[0], reach[0]),
            (-reach[1], reach[1]),
            "z1",
            "z1'",
            "Shadow of the ellipsoid, and x(t)",
        )
        shadow.polygon(*outline, SKY)
        shadow.line(answer.x[0], answer.x[n], INK)
        shadow.marks(bound.x0[:1], bound.x0[n : n + 1], VERMILLION, "circle")
        effort = np.linalg.norm(answer.u, axis=0)
        chart = Chart(
            (0, t[-1]),
            (0, 1.1 * u_max),
            "t (s)",
            "|K x|",
            "Norm of the input, and its bound",
        )
        chart.line(t, effort, BLUE, name="|K x(t)|")
        chart.line([0, t[-1]], [u_max] * 2, VERMILLION, True, "u_max")
        yield page(shadow.svg(), chart.svg(), gains_table(design))

    return Explorer(sliders, draw)
