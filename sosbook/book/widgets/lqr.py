"""Move the weights and the spread of a robust linear-quadratic design."""

import numpy as np
from scipy.linalg import solve_continuous_are

from ...analysis.linear import loop_matrix
from ...pendulum import Mip, polytope
from ...plants.descriptor import descriptors
from ...plants.second_order import Polytope
from ...requirements.cost import QuadraticCost, noise_cost
from ...runtime.libraries import library
from ...synthesis.lqr import design_lqr
from ..elements.chart import Chart
from ..plots import BLUE, GREY, VERMILLION
from .charts import pole_chart
from .explorer import Explorer, linear, log, note, page

ToggleButtons = library("ipywidgets").ToggleButtons


__all__ = ["explore_lqr"]

PAIRS, SLACK = "pairs", "slack"
SLACK_EPSILON = 0.003  # s, of the slack matrix: near the best for all positions
SAMPLED_PLANTS = 30  # plants between the vertices
WINDOW_LEFT = -25  # 1/s, end of the window of poles


def explore_lqr():
    """Move R, two weights, the spread and the coupling; see K and cost.

    The plant is the mobile inverted pendulum. What is quick is drawn
    first: the gain of the Riccati equation of the pendulum in the
    middle. Then comes Theorem 2.4 for the four vertices. Both are shown
    with their true costs at the vertices and at 30 plants between.

    Returns
    -------
    Explorer
        The sliders and the figure.

    Notes
    -----
    Source: thesis Theorem 2.4 by pairs of vertices, or with a slack
    matrix (epsilon = 3 ms), noise on all states.
    """
    sliders = {
        "R": log("R, weight of the voltage", 1.0, 100, 100),
        "q_theta": log("weight of theta", 1.0, 100, 1000),
        "q_phi": log("weight of phi", 1.0, 100, 1000),
        "spread": linear("spread (%)", 4.0, 0, 80),
        "coupling": ToggleButtons(
            options=[PAIRS, SLACK], value=PAIRS, description="coupling"
        ),
    }
    return Explorer(sliders, _draw)


def _draw(R, q_theta, q_phi, spread, coupling):
    middle = Mip.printed()
    plants = polytope(middle, spread / 100)
    cost = QuadraticCost(np.diag([q_theta, q_phi, 1, 1]), [[R]])
    loops = descriptors(plants) + descriptors(
        Polytope(plants.sample(SAMPLED_PLANTS, 0))
    )
    K = _riccati(middle.plant(), cost)
    alone = "LQR of the middle", VERMILLION, K, _costs(loops, K, cost)
    message = _worst(alone)
    yield _page(loops, message, [alone])
    design = design_lqr(
        plants,
        cost.Q,
        cost.R,
        coupling=coupling,
        slack=SLACK_EPSILON if coupling == SLACK else None,
    )
    if design.K is None:
        yield _page(
            loops,
            f"Robust design: <strong>{design.status}</strong>. " + message,
            [alone],
            quick=False,
        )
        return
    bound = design.request.cost.bound
    robust = "robust", BLUE, design.K, _costs(loops, design.K, cost)
    message = (
        f"Certified for all plants: cost &lt; "
        f"<strong>{bound:.4g}</strong>. {_worst(robust)} {message}"
    )
    yield _page(loops, message, [alone, robust], bound, False)


def _riccati(plant, cost):
    (d,) = descriptors(plant)
    A, B, _ = d.state_space()
    X = solve_continuous_are(A, B, cost.Q, cost.R)
    return -np.linalg.solve(cost.R, B.T @ X)


def _costs(loops, K, cost):
    return np.array([noise_cost(d, K, cost) for d in loops])


def _worst(design):
    name, _, _, costs = design
    worst = costs.max()
    if np.isinf(worst):
        count = np.isinf(costs).sum()
        return f"{name}: UNSTABLE for {count} of {len(costs)} plants."
    return f"{name}: true worst cost {worst:.4g}."


def _page(loops, message, designs, bound=None, quick=True):
    colour = GREY if quick else BLUE if bound else VERMILLION
    return note(message, colour) + page(
        _poles(loops, designs), _bars(designs, bound), _gains(designs)
    )


def _poles(loops, designs):
    """Poles at the four vertices; a fast one or two lie beyond the window."""
    pole_sets = [
        np.ravel([np.linalg.eigvals(loop_matrix(d, K)) for d in loops[:4]])
        for _, _, K, _ in designs
    ]
    colours = [colour for _, colour, *_ in designs]
    title = f"Poles at the four vertices with Re s above {WINDOW_LEFT}"
    return pole_chart(pole_sets, colours, WINDOW_LEFT, title)


def _bars(designs, bound):
    """True costs, the plants in the order of the first design's."""
    order = np.argsort(designs[0][3], kind="stable")
    every = np.concatenate([costs for *_, costs in designs])
    finite = every[np.isfinite(every)]
    top = 1.1 * max([bound or 0, *np.minimum(finite, 4 * np.median(finite))])
    chart = Chart(
        (0, len(order) + 1),
        (0, top),
        "plant, in order",
        "cost",
        "True cost of each plant, and the bound",
    )
    if bound:
        chart.line([0, len(order) + 1], [bound, bound], BLUE, True, "bound")
    for (_, colour, _, costs), shape in zip(designs, ("circle", "cross")):
        shown = np.isfinite(costs[order])
        chart.marks(1 + np.flatnonzero(shown), costs[order][shown], colour, shape)
    return chart.svg()


def _gains(designs):
    heads = "".join(
        f"<th scope='col'>{name}</th>" for name in ("theta", "phi", "theta'", "phi'")
    )
    rows = "".join(
        f"<tr><th scope='row' style='color:{colour}'>{name}</th>"
        + "".join(
            f"<td style='padding:0 .6em;text-align:right'>{k:.4g}</td>" for k in K[0]
        )
        + "</tr>"
        for name, colour, K, _ in designs
    )
    return (
        f"<table class='gains'><caption>Gains</caption>"
        f"<tr><th></th>{heads}</tr>{rows}</table>"
    )
