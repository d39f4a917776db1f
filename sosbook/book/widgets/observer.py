"""Move an observer's weights; see what is proven, and how it moves."""

import numpy as np
from scipy.linalg import expm, solve_continuous_are

from ...pendulum import Mip, reduced
from ...plants.descriptor import mean_descriptor
from ...plants.descriptor_system import DescriptorSystem
from ...synthesis.error_loop import observer_loop
from ...synthesis.lqr import design_lqr
from ...synthesis.observer import design_observer
from ...synthesis.pid import analyse_loop
from ..elements.chart import Chart
from ..plots import BLUE, GREY, VERMILLION
from .charts import pole_chart
from .explorer import Explorer, linear, log, note, page

__all__ = ["explore_observer"]

START_TILT = 5  # degrees, at the start
WINDOW_LEFT = -40  # 1/s, end of the window of poles
SAMPLING_RATE = 100  # Hz, of the robot's processor
RELEASE_TIMES = np.linspace(0, 1.5, 151)  # s, since the pendulum was let go
KALMAN, THEOREM = "Kalman filter", "theorem"
PROVEN = "proven stable"
STATES = "theta", "theta'", "phi'"


def explore_observer():
    """Move noises, R and the spread; see L, the loop and its proof.

    The plant is the mobile inverted pendulum without phi, K the
    regulator (Q = I) of its first vertex. What is quick is drawn first:
    the Kalman filter of the mean plant. Then come Theorem 2.5 with the
    same weights, and for both the certificate of the whole polytope
    with K and L fixed. The pendulum is let go at 5 degrees, the
    observer starts upright.

    Returns
    -------
    Explorer
        The sliders and the figure.

    Notes
    -----
    Source: thesis section 4.3.2, Theorem 2.5; it begins with Table 4.3.
    The responses are those of the linear loop (2.40).
    """
    return Explorer(
        {
            "factor": log("process noise, factor of [2 E⁻¹B; 0]", 1, 10, 10),
            "gyro": log("variance of the gyroscope", 0.01, 100, 100),
            "wheels": log("variance of the wheels' speed", 0.1, 100, 100),
            "R": log("R, weight of the voltage", 1.0, 10, 100),
            "spread": linear("spread (%)", 4.0, 0, 70),
        },
        _draw,
    )


def _draw(factor, gyro, wheels, R, spread):
    plant = reduced(Mip.printed(), spread / 100)
    mean = mean_descriptor(plant.vertices)
    first = plant.vertices[0]
    K = design_lqr(DescriptorSystem(first.E, first.A, first.Bu), np.eye(3), [[R]]).K
    input_noise = 2 * factor * np.linalg.solve(mean.E, mean.Bu)
    R_F = np.sqrt(np.diag([gyro, wheels]))
    filtered = Loop(KALMAN, VERMILLION, plant, K, _kalman(mean, input_noise, R_F))
    loops = [filtered]
    yield note(filtered.message(), GREY) + _page(loops)
    filtered.analyse()
    design = design_observer(plant, K, np.vstack([input_noise, 0 * input_noise]), R_F)
    message = f"Theorem 2.5: <strong>{design.status}</strong> at the vertices"
    if design.L is None:
        message += ", no L. "
    else:
        message += f", tr J = {design.bound:.4g}. "
        loops.append(Loop(THEOREM, BLUE, plant, K, design.L))
        loops[-1].analyse()
    colour = BLUE if loops[-1].status == PROVEN else VERMILLION
    yield note(message + loops[-1].message(), colour) + _page(loops)


def _kalman(d, input_noise, R_F):
    A, C, R = d.state_space()[0], d.C, R_F @ R_F.T
    X = solve_continuous_are(A.T, C.T, input_noise @ input_noise.T, R)
    return -np.linalg.solve(R, C @ X).T


class Loop:
    """Regulator and observer with the four vertices."""

    def __init__(self, name, colour, plant, K, L):
        self.name, self.colour, self.K, self.L = name, colour, K, L
        mean = mean_descriptor(plant.vertices)
        A, B, _ = mean.state_space()
        self.controller = np.linalg.eigvals(A + B @ K + L @ mean.C)
        self.system = observer_loop(plant, K, L, mean.C)
        self.matrices = np.array(
            [np.linalg.solve(v.E, v.A) for v in self.system.vertices]
        )
        self.poles = np.linalg.eigvals(self.matrices)
        self.fastest = np.abs(self.controller).max()
        self.run = self._released()
        self.peak = np.abs(K @ (self.run[:, 3:] - self.run[:, :3])).max()
        self.status = ""

    def _released(self):
        """[e; x] at the vertices, (4, 6, times); x^ starts at zero."""
        x = np.zeros((6, 1))
        x[[0, 3]] = np.radians(START_TILT)
        step, states = expm(self.matrices * RELEASE_TIMES[1]), [x + np.zeros((4, 6, 1))]
        for _ in RELEASE_TIMES[1:]:
            states.append(step @ states[-1])
        return np.concatenate(states, axis=2)

    def analyse(self):
        analysed = analyse_loop(self.system.E, self.system.A)
        proven = analysed.status == "feasible" and analysed.certify().proven
        self.status = PROVEN if proven else f"not proven ({analysed.status})"

    def message(self):
        half = np.pi * SAMPLING_RATE
        message = f"With the L of the {self.name} "
        if self.poles.real.max() >= 0:
            message += "the loop is UNSTABLE at a vertex. "
        elif self.status:
            message += f"the whole polytope is <strong>{self.status}</strong>. "
        else:
            message += "the vertices are stable. "
        side = "BEYOND" if self.fastest > half else "within"
        message += (
            f"The controller's fastest pole, {self.fastest:.4g} rad/s, lies "
            f"{side} half the sampling rate of {SAMPLING_RATE} Hz, {half:.0f} rad/s."
        )
        if self.controller.real.max() >= 0:
            message += " The controller alone is UNSTABLE."
        return message


def _page(loops):
    theta = [np.degrees(loop.run[:, 3]) for loop in loops]
    error = [np.degrees(loop.run[:, 0]) for loop in loops]
    return page(
        _poles(loops),
        _curves(loops, theta, "body angle"),
        _curves(loops, error, "estimation error"),
        _gains(loops),
        _facts(loops),
    )


def _poles(loops):
    """Poles of error and state; the fast ones lie beyond the window."""
    title = f"Poles of error and state at the vertices, Re s above {WINDOW_LEFT}"
    pole_sets = [loop.poles.ravel() for loop in loops]
    return pole_chart(pole_sets, [loop.colour for loop in loops], WINDOW_LEFT, title)


def _curves(loops, runs, name):
    """One line for each vertex; an unstable loop leaves the window."""
    runs = [np.clip(run, -6 * START_TILT, 6 * START_TILT) for run in runs]
    low, high = np.min(runs), np.max(runs)
    room = 0.06 * (high - low)
    chart = Chart(
        (0, RELEASE_TIMES[-1]),
        (low - room, high + room),
        "t (s)",
        f"{name} (degrees)",
        f"The {name} at the four vertices",
    )
    chart.line([0, RELEASE_TIMES[-1]], [0, 0], GREY, True)
    for loop, run in zip(loops, runs):
        for k, row in enumerate(run):
            chart.line(
                RELEASE_TIMES,
                row,
                loop.colour,
                loop is loops[0],
                "" if k else loop.name,
            )
    return chart.svg()


def _gains(loops):
    """K, and the columns of each L."""
    cell = "style='padding:0 .6em;text-align:right'"
    heads = "".join(
        f"<th scope='colgroup' colspan='2' style='color:{loop.colour}'>"
        f"L, {loop.name}</th>"
        for loop in loops
    )
    rows = "".join(
        f"<tr><th scope='row'>{name}</th>"
        + "".join(
            f"<td {cell}>{k:.4g}</td>"
            for k in (loops[0].K[0, i], *(k for loop in loops for k in loop.L[i]))
        )
        + "</tr>"
        for i, name in enumerate(STATES)
    )
    return (
        f"<table class='gains'><caption>Gains: K as a column, and L"
        f"</caption><tr><th></th><th>K</th>{heads}</tr>{rows}</table>"
    )


def _facts(loops):
    """What the curves can't show, one row for each observer."""
    heads = "".join(
        f"<th scope='col' style='padding:0 .6em'>{name}</th>"
        for name in (
            "whole polytope",
            "rightmost pole (1/s)",
            "peak voltage (V)",
            "controller's fastest pole (rad/s)",
        )
    )
    rows = "".join(
        f"<tr><th scope='row' style='color:{loop.colour}'>{loop.name}</th>"
        f"<td>{loop.status}</td>"
        + "".join(
            f"<td style='padding:0 .6em;text-align:right'>{x:.4g}</td>"
            for x in (loop.poles.real.max(), loop.peak, loop.fastest)
        )
        + "</tr>"
        for loop in loops
    )
    return f"<table class='facts'><tr><th></th>{heads}</tr>{rows}</table>"
