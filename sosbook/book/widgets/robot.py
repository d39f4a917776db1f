"""Sliders over the simulated robot: its weight, clock and sensors."""

import numpy as np

from ...display.escape import page_text
from ...pendulum import V_MAX, Firmware, Mip, SampledLaw, polytope, vertices
from ...pendulum.simulator import Sensors, simulate
from ...runtime.libraries import library
from ...synthesis.lqr import design_lqr
from ..elements.chart import Chart
from ..plots import BLUE, COLOURS, GREY, VERMILLION
from .explorer import Explorer, gains_table, linear, log, note, page

ToggleButtons = library("ipywidgets").ToggleButtons


__all__ = ["explore_robot"]

PD, PID = "PD", "PID"
SINGLE, ROBUST = "one vertex", "all vertices"
END_TIME, T, REST_TIME = 2.0, 0.01, 0.5  # s
CHATTER_VOLTS = 3.0  # V; a robot at rest with more than this chatters
NEVER_STALLED = 10**6  # ticks: no stall protection, so that chatter is seen


def explore_robot():
    """Move R, the tilt, the delay and the sensors; see the robot.

    "one vertex" is the ordinary regulator of vertex 1 (PD) or 4 (PID),
    as the thesis's tables have it; "all vertices" is Theorem 2.4 by
    pairs, Q = I. The gains run at 100 Hz in `Firmware`, on the four
    nonlinear pendulums with gyro and encoders.

    Returns
    -------
    Explorer
        The sliders and the figure.

    Notes
    -----
    Source: thesis Tables 4.1 and 4.2, (4.13).
    """
    sliders = {
        "R": log("R, weight of the voltage", 20.0, 20, 5),
        "tilt": linear("let go at (degrees)", 10.0, 0, 75),
        "delay": linear("delay (ms)", 5.0, 0, 30),
        "noise": linear("gyro noise (times)", 1.0, 0, 20),
        "offset": linear("gyro offset left (°/s)", 0.0, 0, 2),
        "law": ToggleButtons(options=[PD, PID], value=PID, description="law"),
        "design": ToggleButtons(
            options=[SINGLE, ROBUST], value=ROBUST, description="design"
        ),
    }
    return Explorer(sliders, _draw)


def _draw(R, tilt, delay, noise, offset, law, design):
    robots = vertices(Mip.printed())
    index, U, N = (3, [[0, 1]], 5) if law == PID else (0, None, 4)
    plant = polytope(Mip.printed()) if design == ROBUST else robots[index].plant()
    regulator = design_lqr(plant, np.eye(N), [[R]], U)
    if regulator.K is None:
        yield note(
            f"<strong>{regulator.status}</strong>. " + page_text(regulator.advice)
        )
        return
    yield _page(robots, regulator, tilt, delay, noise, offset)


def _page(robots, regulator, tilt, delay, noise, offset):
    firmware = Firmware(
        SampledLaw.of_gain(regulator.gain, T), tip=1.5, stall=NEVER_STALLED
    )
    sensors = Sensors(noise=noise * Sensors.noise)
    bias = Sensors().offset - np.radians(offset)
    run = simulate(
        robots,
        firmware,
        np.radians(tilt),
        END_TIME,
        delay / 1000,
        sensors,
        bias=bias,
        substeps=4,
    )
    message = _verdict(run)
    good = run.settled.all() and "chatters" not in message
    return note(message, BLUE if good else VERMILLION) + page(
        _tilt(run), _volts(run), _wheels(run), gains_table(regulator)
    )


def _verdict(run):
    """What happened, in words."""
    last = run.t > run.t[-1] - REST_TIME
    loud = run.V[:, last].std(axis=1).max()
    far = np.degrees(np.abs(run.x[1]).max())
    message = (
        f"Peak voltage {run.peak_voltage.max():.1f} V; at rest "
        f"{loud:.2f} V of noise; wheels turn {far:.0f}°. "
    )
    if run.fell.any():
        return message + f"FALLS at {run.fell.sum()} of 4 vertices."
    if loud > CHATTER_VOLTS:
        return message + "It <strong>chatters</strong>."
    if not run.settled.all():
        return message + "It sways by more than 3°."
    return message + "All four vertices <strong>stand</strong>."


def _tilt(run):
    theta = np.degrees(run.x[0])
    chart = Chart(
        (0, END_TIME), _range(theta), "t (s)", "degrees", "Tilt of the four vertices"
    )
    return _lines(chart, run, theta, True)


def _volts(run):
    chart = Chart(
        (0, END_TIME),
        (-1.1 * V_MAX, 1.1 * V_MAX),
        "t (s)",
        "V",
        "Voltage of the motors",
    )
    for side in (-V_MAX, V_MAX):
        chart.line([0, END_TIME], [side, side], VERMILLION, True)
    return _lines(chart, run, run.V)


def _wheels(run):
    phi = np.degrees(run.x[1])
    chart = Chart((0, END_TIME), _range(phi), "t (s)", "degrees", "Angle of the wheels")
    return _lines(chart, run, phi)


def _range(values):
    low, high = min(values.min(), -1), max(values.max(), 1)
    room = 0.08 * (high - low)
    return low - room, high + room


def _lines(chart, run, rows, named=False):
    chart.line([0, END_TIME], [0, 0], GREY, True)
    for k, row in enumerate(rows):
        chart.line(run.t, row, COLOURS[k], k > 0, f"{k + 1}" if named else "")
    return chart.svg()
