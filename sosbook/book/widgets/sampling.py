"""Move a computer's clock; see the loop, its margin and a kick."""

from functools import lru_cache

import numpy as np

from ...display.escape import page_text
from ...pendulum import Mip, SampledLaw, polytope, vertices
from ...pendulum.margins import SENSING, SampledLoop
from ...plants.checks import positive
from ...runtime.libraries import library
from ...synthesis.lqr import design_lqr
from ..elements.chart import Chart
from ..plots import BLUE, COLOURS, GREY, INK, VERMILLION
from .explorer import Explorer, gains_table, linear, log, note, page
from .pendulum_control import PD, PID, ROBUST, SINGLE

ToggleButtons = library("ipywidgets").ToggleButtons


__all__ = ["explore_sampling", "kick"]

END_TIME, KICK_RATE = 1.0, 0.5  # s, rad/s
WARNING_PEAK = 3.0  # of the sensitivity: it leaves little room


def explore_sampling():
    """Move R, T, the delay and what is sensed; see poles and margins.

    "one vertex" is the ordinary regulator of vertex 1 (PD) or 4 (PID),
    as the thesis's tables have it; "all vertices" is Theorem 2.4 by
    pairs, Q = I. Either is then run by a computer, on the four vertices
    of the pendulum.

    Returns
    -------
    Explorer
        The sliders and the figure.

    Notes
    -----
    Source: thesis Tables 4.1 and 4.2, section 4.3.1 (100 Hz).
    """
    sliders = {
        "R": log("R, weight of the voltage", 5.0, 10, 100),
        "T": linear("T, time between samples (ms)", 10.0, 2, 40),
        "ticks": linear("delay (ticks)", 0.0, 0, 2),
        "sensing": ToggleButtons(
            options=SENSING, value="firmware", description="sensing"
        ),
        "law": ToggleButtons(options=[PD, PID], value=PD, description="law"),
        "design": ToggleButtons(
            options=[SINGLE, ROBUST], value=SINGLE, description="design"
        ),
    }
    return Explorer(sliders, _draw)


def kick(loop, rate, count):
    """Hit the body of a pendulum that stands and rests; nothing saturates.

    Before the kick all angles, rates and voltages are zero, and so is
    what the law and the sensors remember.

    Parameters
    ----------
    loop : SampledLoop
        The sampled loop.
    rate : float
        theta' just after the kick, in rad/s.
    count : int
        Number of ticks; the first comes just after the kick.

    Returns
    -------
    (4, count) array
        theta, phi, theta', phi' at the ticks, in rad and rad/s.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> law = SampledLaw.of_gain(thesis.mip().gains["PD"][5], 0.01)
    >>> x = kick(SampledLoop(Mip.printed(), law), 0.5, 201)
    >>> round(float(abs(x[0]).max()), 3), bool(abs(x[0, -1]) < 1e-3)
    (0.023, True)
    """
    F = loop.matrix
    x = np.zeros(len(F))
    x[2], states = rate, []
    for _ in range(count):
        states.append(x[:4])
        x = F @ x
    return np.array(states).T


@lru_cache(maxsize=64)
def _design(R, law, design):
    index, order = (3, 5) if law == PID else (0, 4)
    U = [[0, 1]] if law == PID else None
    plant = polytope(Mip.printed())
    if design == SINGLE:
        plant = plant.vertices[index]
    return design_lqr(plant, np.eye(order), [[R]], U)


def _draw(R, T, ticks, sensing, law, design):
    regulator = _design(R, law, design)
    if regulator.K is None:
        yield note(
            f"<strong>{regulator.status}</strong>. " + page_text(regulator.advice)
        )
        return
    T = positive("T", T) / 1000
    runs = SampledLaw.of_gain(regulator.gain, T)
    loops = [
        SampledLoop(robot, runs, ticks * T, sensing)
        for robot in vertices(Mip.printed())
    ]
    radius = max(loop.radius for loop in loops)
    message = f"{1 / T:.0f} Hz. Radius {radius:.4f}: "
    yield note(
        message + ("stable at all four vertices." if radius < 1 else "UNSTABLE."),
        BLUE if radius < 1 else VERMILLION,
    ) + page(_poles(loops), _nyquist(loops), _tilt(loops), gains_table(regulator))
    peak = max(loop.sensitivity for loop in loops)
    if radius < 1:
        message += (
            f"stable at all four vertices. Peak of the sensitivity "
            f"<strong>{peak:.2f}</strong>: Nyquist's curve keeps "
            f"{1 / peak:.2f} away from the critical point."
        )
    else:
        message += (
            f"UNSTABLE at {sum(loop.radius >= 1 for loop in loops)} of 4 vertices."
        )
    yield note(message, BLUE if peak < WARNING_PEAK else VERMILLION) + page(
        _poles(loops), _nyquist(loops), _tilt(loops), gains_table(regulator)
    )


def _poles(loops):
    """The poles in the z-plane, with the unit circle."""
    poles = [loop.poles for loop in loops]
    far = np.clip(max(abs(p).max() for p in poles), 1.15, 3)
    chart = Chart(
        (-far, far),
        (-far, far),
        "Re z",
        "Im z",
        "Poles at the four vertices",
        square=True,
    )
    turn = np.exp(2j * np.pi * np.arange(121) / 120)
    chart.line(turn.real, turn.imag, GREY)
    for p, colour in zip(poles, COLOURS):
        p = p[abs(p) < 1.4 * far]
        chart.marks(p.real, p.imag, colour, "cross")
    return chart.svg()


def _nyquist(loops):
    """Nyquist's curve from 2 Hz, or the slowest there is, to half the rate."""
    T = loops[0].law.T
    angles = np.geomspace(min(4 * np.pi * T, 1), np.pi, 90)
    chart = Chart(
        (-2.6, 2.6),
        (-2.2, 2.2),
        "Re L",
        "Im L",
        "Nyquist's curve: the critical point is 1",
        square=True,
    )
    for loop, colour in zip(loops, COLOURS):
        L = loop.open_loop(np.exp(1j * angles), squeeze=True)
        L = L[abs(L) < 6]
        chart.line(L.real, L.imag, colour)
    chart.marks([1], [0], INK, "cross")
    return chart.svg()


def _tilt(loops):
    T = loops[0].law.T
    count = round(END_TIME / T) + 1
    runs = [np.degrees(kick(loop, KICK_RATE, count)[0]) for loop in loops]
    runs = np.clip(runs, -20, 20)
    low, high = min(runs.min(), -1), max(runs.max(), 1)
    room = 0.08 * (high - low)
    chart = Chart(
        (0, END_TIME),
        (low - room, high + room),
        "t (s)",
        "degrees",
        f"Tilt after a kick of {KICK_RATE} rad/s",
    )
    chart.line([0, END_TIME], [0, 0], GREY, True)
    for k, row in enumerate(runs):
        chart.line(T * np.arange(count), row, COLOURS[k], k > 0, f"{k + 1}")
    return chart.svg()
