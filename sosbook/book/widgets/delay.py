"""Move a delay and the decay rate under it."""

from functools import lru_cache

import numpy as np

from ...delay.design import DelayDesign
from ...delay.request import DelayRequest
from ...delay.solve import solve_delay
from ...runtime.libraries import library
from .. import thesis
from ..elements.chart import Chart
from ..elements.delay import DELAY_KINDS, output_name, signal_of, unit_set_point
from ..plots import BLUE, GREEN, GREY, INK, VERMILLION
from .explorer import Explorer, gains_table, linear, log, margins_table, note, page

Dropdown = library("ipywidgets").Dropdown
ToggleButtons = library("ipywidgets").ToggleButtons


__all__ = ["explore_delay"]

PRINTED, OURS = "printed gains", "our design"
DELAYS = (
    ("shortest", GREEN, "circle"),
    ("nominal", GREY, "circle"),
    ("longest", BLUE, "cross"),
)


def explore_delay(example=None):
    """Move the delay and the rate; see the verdict beside the truth.

    "our design" solves the corrected Theorem 2.3 for a gain; "printed
    gains" looks for a certificate of the example's own by the corrected
    Theorem A.3, where alpha plays no part. Drawn are the rightmost roots for
    the shortest, nominal and longest delay, the response to a unit set
    point under a delay that varies, and the input as it arrives.

    Parameters
    ----------
    example : thesis.DelayExample, optional
        Example 2 of section 3.2 if left out.

    Returns
    -------
    Explorer
        The sliders and the figure.

    Notes
    -----
    Source: thesis, Theorems 2.3 and A.3 with their errata, section 3.2.
    """
    ex = thesis.delay_example_2() if example is None else example
    sliders = {
        "tau": linear("nominal delay tau (s)", ex.tau, ex.tau / 10, 2.5 * ex.tau),
        "ratio": linear("variation mu / tau", ex.mu / ex.tau, 0, 1),
        "delta": linear("decay rate delta (1/s)", ex.delta, 0, 4 * ex.delta),
        "alpha": log("scalar alpha (s)", ex.alpha, 10, 10),
        "gain": ToggleButtons(options=[PRINTED, OURS], value=OURS, description="gain"),
        "kind": Dropdown(
            options=DELAY_KINDS, value=DELAY_KINDS[1], description="the delay is"
        ),
    }
    r = unit_set_point(ex.U)
    t = np.linspace(0, ex.t_end, 301)

    solve = lru_cache(99)(solve_delay)

    @lru_cache(99)
    def asked(tau, ratio, delta, alpha):
        return DelayRequest(
            ex.plant,
            ex.U,
            tau,
            ratio * tau,
            delta,
            alpha,
            gain=ex.K if alpha is None else None,
        )

    def draw(tau, ratio, delta, alpha, gain, kind):
        request = asked(tau, ratio, delta, None if gain == PRINTED else alpha)
        if gain == PRINTED:
            yield note("Looking for a certificate.", GREY) + page(
                _roots(DelayDesign(request, "", ex.K))
            )
        design = solve(request, refuse=False)
        if design.status == "undecided":
            yield note(
                "No certificate was found at once: looking for a "
                "proof that there is none."
            ) + page(_roots(design))
            design = solve(request)
        verdict, roots = _verdict(design), _roots(design)
        colour = BLUE if design.status == "feasible" else VERMILLION
        if design.K is None:
            yield note(verdict, colour) + page(roots)
            return
        margins = design.margins and margins_table(design.margins)
        tables = gains_table(design) + (margins or "")
        yield note(verdict, colour) + page(roots, tables)
        comparison = truth(design)
        answer = simulated(design, t, signal_of(kind, tau, request.mu), r)
        yield note(verdict + comparison, colour) + page(
            roots, output_figure(answer, ex.U), input_figure(answer), tables
        )

    return Explorer(sliders, draw)


def _verdict(design):
    request = design.request
    low, high = request.tau - request.mu, request.tau + request.mu
    rate = "stability"
    if request.delta:
        rate = f"the rate {request.delta:.3g} 1/s"
    promise = f"{rate} under the delay {low:.3g} s"
    if request.mu:
        promise = f"{rate}, however the delay varies within [{low:.3g}, {high:.3g}] s"
    if design.status == "feasible":
        sentence = f"a certificate of {promise}."
    elif design.status == "undecided":
        sentence = (
            f"neither a certificate of {promise}, nor a proof that there is none."
        )
    elif request.gain is None:
        sentence = (
            "with this alpha the corrected LMI has no solution, by exact "
            f"multipliers, for {promise}. Move delta, tau or mu down, or alpha."
        )
    else:
        sentence = (
            f"no functional of this form certifies {promise}: that "
            "alone doesn't make the loop slower."
        )
    return f"<strong>{design.status}</strong>: {sentence} "


def truth(design):
    rate, delay = design.slowest_decay()
    if rate <= 0:
        sentence = (
            f"<strong>unstable</strong> for the constant delay "
            f"{delay:.3g} s, where it grows at {-rate:.3g} 1/s"
        )
    else:
        sentence = (
            f"its slowest rate over the constant delays is {rate:.3g} "
            f"1/s (at {delay:.3g} s)"
        )
    return f"The true loop: {sentence}; asked: {design.request.delta:.3g} 1/s."


def _roots(design):
    """Roots of the loop for three constant delays, beside the line -delta."""
    tau, mu, delta = (getattr(design.request, name) for name in ("tau", "mu", "delta"))
    root_sets = (
        []
        if design.K is None
        else [design.roots(d, count=8) for d in (tau - mu, tau, tau + mu)]
    )
    rightmost = np.concatenate([roots[:4] for roots in root_sets] or [[-1 + 1j]])
    left = min(1.15 * rightmost.real.min(), -2 * delta)
    right = max(rightmost.real.max(), -0.2 * left)
    height = 1.15 * max(abs(rightmost.imag).max(), right - left)
    chart = Chart(
        (left, 1.15 * right),
        (-height, height),
        "Re s (1/s)",
        "Im s (rad/s)",
        "Rightmost roots for constant delays",
    )
    chart.line([0, 0], [-height, height], INK)
    chart.line([-delta, -delta], [-height, height], VERMILLION, True)
    for roots, (name, colour, shape) in zip(root_sets, DELAYS):
        chart.marks(roots.real, roots.imag, colour, shape)
        chart.names.append((name, colour))
    return chart.svg()


def simulated(design, t, delay, r):
    """The response, as far as numbers go if it runs away."""
    while True:
        try:
            return design.simulate(t, delay, r=r)
        except ValueError as error:
            if "runs away" not in str(error):
                raise
            t = t / 2


def output_figure(answer, U):
    name = output_name(U)
    y = U @ answer.z
    chart = _chart(
        answer.t, y, (-0.5, 2), name, f"Response of {name} to a unit set point"
    )
    chart.line([0, answer.t[-1]], [1, 1], GREY, dashed=True)
    for row in y:
        _line(chart, answer.t, row, BLUE)
    return chart.svg()


def input_figure(answer):
    reach = np.abs(answer.applied[:, : len(answer.t) // 3]).max()
    limit = 2 * max(reach, 1e-9)
    chart = _chart(
        answer.t,
        np.vstack([answer.u, answer.applied]),
        (-limit, limit),
        "u",
        "Control signal",
    )
    for name, rows, colour in (
        ("asked", answer.u, GREY),
        ("arrives", answer.applied, VERMILLION),
    ):
        for i, row in enumerate(rows):
            _line(chart, answer.t, row, colour, "" if i else name)
    return chart.svg()


def _chart(t, values, window, label, title):
    """A chart that holds the values, but no more than the window."""
    low, high = np.clip([values.min(), values.max()], *window)
    if low == high:
        low, high = low - 0.5, high + 0.5
    room = 0.06 * (high - low)
    return Chart((0, t[-1]), (low - room, high + room), "t (s)", label, title)


def _line(chart, t, values, colour, name=""):
    low, high = chart.y
    far = 5 * (high - low)
    chart.line(t, np.clip(values, low - far, high + far), colour, name=name)
