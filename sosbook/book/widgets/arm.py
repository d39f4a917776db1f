"""Move the swing range of the flexible arm."""

import numpy as np

from ...analysis.nonlinear import arm_gravity, simulate_nonlinear
from ...display.escape import page_text
from ...plants.second_order import Polytope
from ...requirements.pole_region import PoleRegion
from ...runtime.libraries import library
from .. import thesis
from ..elements.chart import Chart
from ..plots import BLUE, GREEN, GREY, VERMILLION, window_of
from .charts import plane
from .explorer import Explorer, Follower, gains_table, linear, note, page

ToggleButtons = library("ipywidgets").ToggleButtons


__all__ = ["explore_swing"]

REST, STEPS = "return to rest", "every set point"


def explore_swing():
    """Move the range of the swing and the region; see the true arm.

    "return to rest" designs for factors in [sinc(phi_max), 1] and lets
    the arm of Example 4 go at phi_max. "every set point" designs for
    [cos(phi_max), 1], the factors between any two motions in that
    range, and steps the set point from 0 to phi_max.

    Returns
    -------
    Explorer
        The sliders and the figure.

    Notes
    -----
    Source: thesis (3.2)-(3.4); the responses are those of (3.2) itself.
    """
    ex = thesis.example_4()
    region = ex.region
    sliders = {
        "phi_max": linear("swing phi_max (degrees)", 90.0, 10, 180),
        "sigma": linear("decay rate sigma (1/s)", region.sigma, 0, 10),
        "theta": linear("half-angle theta (degrees)", np.degrees(region.theta), 20, 90),
        "rho": linear("radius rho (rad/s)", region.rho, 10, 40),
        "task": ToggleButtons(options=[REST, STEPS], value=REST, description="task"),
    }

    follow = Follower()

    def draw(phi_max, sigma, theta, rho, task):
        top = np.radians(phi_max)
        low = np.cos(top) if task == STEPS else np.sinc(phi_max / 180)
        arms = Polytope([thesis.arm(1.0), thesis.arm(float(low))])
        wanted = PoleRegion(sigma, np.radians(theta), rho)
        design = follow(arms, ex.U, region=wanted)
        message = f"<strong>{design.status}</strong> for factors from {low:.3f} to 1. "
        if design.status != "feasible":
            chart = _poles(np.array([]), wanted, VERMILLION)
            yield note(message) + page(chart)
            yield note(message + page_text(design.advice)) + page(chart)
            return
        chart = _poles(design.poles(samples=15), wanted, GREEN)
        yield note(message, BLUE) + page(chart, gains_table(design))
        t, goal = np.linspace(0, 3, 241), np.full(2, top)
        if task == STEPS:
            asked = dict(r=goal)
        else:
            asked = dict(x0=np.r_[goal, 0, 0, 0])
        answer = simulate_nonlinear(
            thesis.arm(0.0), arm_gravity, design.K, t, ex.U, **asked
        )
        swing = np.degrees(answer.z)
        reach = np.abs(swing[0]).max()
        message += f"The arm swings to {reach:.0f} degrees"
        if reach > phi_max * (1 + 1e-9):
            message += ": BEYOND phi_max, where this polytope says nothing"
        message += f"; peak torque {np.abs(answer.u).max():.3g} Nm."
        yield note(message, BLUE) + page(
            chart,
            _angles(t, swing, phi_max),
            _torque(t, answer.u[0]),
            gains_table(design),
        )

    return Explorer(sliders, draw)


def _poles(poles, region, colour):
    window = window_of([np.append(poles, -region.rho)], region)
    chart = plane(window, "Poles for frozen factors", region, colour, colour != GREEN)
    inner = np.ravel(poles[2:])
    chart.marks(inner.real, inner.imag, GREY, "circle")
    ends = np.ravel(poles[:2])
    chart.marks(ends.real, ends.imag, BLUE, "cross")
    return chart.svg()


def _angles(t, swing, phi_max):
    low, high = min(swing.min(), -phi_max), max(swing.max(), phi_max)
    room = 0.06 * (high - low)
    chart = Chart(
        (0, t[-1]),
        (low - room, high + room),
        "t (s)",
        "degrees",
        "Angles of the nonlinear arm",
    )
    for side in (-phi_max, phi_max):
        chart.line([0, t[-1]], [side, side], GREY, True)
    chart.line(t, swing[0], BLUE, name="phi1")
    chart.line(t, swing[1], VERMILLION, True, "phi2")
    return chart.svg()


def _torque(t, u):
    room = 0.06 * (np.ptp(u) or 1.0)
    chart = Chart(
        (0, t[-1]),
        (u.min() - room, u.max() + room),
        "t (s)",
        "Nm",
        "Torque of the motor",
    )
    chart.line(t, u, BLUE, name="u")
    return chart.svg()
