"""Move the requirements of a design."""

import numpy as np

from ...display.escape import page_text
from ...requirements.input_bound import Saturation
from ...requirements.pole_region import PoleRegion
from ...synthesis.problem import Request
from ..plots import BLUE, COLOURS, GREEN, GREY, VERMILLION, window_of
from .charts import plane, set_point_chart
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

__all__ = ["explore_design"]


def explore_design(
    plant,
    U=None,
    region=None,
    gamma=None,
    saturation=None,
    K_A=None,
    coupling="pairs",
    mu=None,
):
    """Move the requirements; see poles, gains, response and margins.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant; of a polytope, the poles and the response of every vertex
        are drawn.
    U, region, gamma, saturation, K_A, coupling, mu
        As in `design_pid`; ``region`` is a `PoleRegion`. Each
        requirement that is given gets its slider.

    Returns
    -------
    Explorer
        The sliders and the figure.
    """
    Request(
        plant, U, K_A=K_A, coupling=coupling, mu=mu
    )  # no slider mends what it refuses
    sliders = {}
    if region is not None and region.sigma is not None:
        top = 3 * region.sigma or 1.0
        sliders["sigma"] = linear("decay rate sigma (1/s)", region.sigma, 0, top)
    if region is not None and region.theta is not None:
        sliders["theta"] = linear(
            "half-angle theta (degrees)", np.degrees(region.theta), 2, 90
        )
    if region is not None and region.rho is not None:
        sliders["rho"] = linear(
            "radius rho (rad/s)", region.rho, region.rho / 5, 3 * region.rho
        )
    if gamma is not None:
        sliders["gamma"] = log("norm bound gamma", gamma, 10, 10)
    if saturation is not None:
        sliders["u_max"] = log("input bound u_max", saturation.u_max, 10, 5)

    follow = Follower()

    def draw(sigma=None, theta=None, rho=None, gamma=None, u_max=None):
        theta = None if theta is None else np.radians(theta)
        asked = {sigma, theta, rho} - {None}
        wanted = PoleRegion(sigma, theta, rho) if asked else None
        bound = u_max and Saturation(u_max, saturation.x0)
        design = follow(
            plant,
            U,
            region=wanted,
            gamma=gamma,
            saturation=bound,
            K_A=K_A,
            coupling=coupling,
            mu=mu,
        )
        yield _design_page(design, wanted)
        if design.status != "feasible":
            yield _design_page(design, wanted, design.advice)

    return Explorer(sliders, draw)


def _design_page(design, region, advice=""):
    plant = design.request.plant
    feasible = design.status == "feasible"
    open_loop = np.concatenate([v.poles() for v in plant.vertices])
    poles = np.ravel(design.poles()) if feasible else np.array([])
    window = window_of([poles if feasible else open_loop], region)
    chart = plane(
        window,
        "Poles in the complex plane",
        region,
        GREEN if feasible else VERMILLION,
        not feasible,
    )
    chart.marks(open_loop.real, open_loop.imag, GREY, "circle")
    chart.marks(np.real(poles), np.imag(poles), BLUE, "cross")
    message = f"<strong>{design.status}</strong>. {page_text(advice)}"
    if not feasible:
        return note(message) + page(chart.svg())
    message += f"Poles: {_poles(poles)}. Crosses: closed loop; circles: plant."
    return note(message, BLUE) + page(
        chart.svg(),
        _step_chart(design, poles),
        gains_table(design),
        margins_table(design.margins),
    )


def _poles(poles):
    upper = poles[poles.imag >= 0]
    return ", ".join(
        f"{s.real:.3g} ± {s.imag:.3g}j" if s.imag else f"{s.real:.3g}" for s in upper
    )


def _step_chart(design, poles):
    end = float(f"{min(10 / -poles.real.max(), 60):.1g}")
    t = np.linspace(0, end, 161)
    answer = design.simulate(t, r=np.ones(design.request.plant.n))
    answers = answer if isinstance(answer, list) else [answer]
    z = np.stack([answer.z for answer in answers])
    chart = set_point_chart(end, z)
    for k in range(z.shape[1]):
        for j, vertex in enumerate(z):
            chart.line(
                t,
                vertex[k],
                COLOURS[k % len(COLOURS)],
                k % 2,
                name="" if j else f"z{k + 1}",
            )
    return chart.svg()
