"""Let the mobile inverted pendulum fall."""

import numpy as np
from scipy.linalg import expm

from ...pendulum import V_MAX, Mip
from ...runtime.libraries import library
from ..elements.chart import Chart
from ..plots import BLUE, GREY, VERMILLION
from .explorer import Explorer, linear, note, page

ToggleButtons = library("ipywidgets").ToggleButtons


__all__ = ["explore_fall", "falls"]

NONE, FULL = "J = 0", "rotors' inertia on the body"
END_TIME, TIME_STEPS = 0.8, 160


def explore_fall():
    """Let the pendulum go, with a push of the motors; see both models.

    The voltage acts from the start for as long as the pulse lasts; then
    it is zero, which brakes.

    Returns
    -------
    Explorer
        The sliders and the figure.

    Notes
    -----
    Source: thesis (4.13) and (4.15), mended.
    """
    sliders = {
        "angle": linear("let go at theta (degrees)", 10.0, 0, 90),
        "volts": linear("voltage (V)", 0.0, -V_MAX, V_MAX),
        "pulse": linear("length of the pulse (s)", 0.1, 0, 0.8),
        "rotors": ToggleButtons(options=[NONE, FULL], value=NONE, description="rotors"),
    }
    robots = {
        name: Mip.from_ratios(30.52, 7.133, 110.6, 208.8, rotors=name == FULL)
        for name in (NONE, FULL)
    }

    def draw(angle, volts, pulse, rotors):
        t = np.linspace(0, END_TIME, TIME_STEPS + 1)
        V = np.where(t[:-1] < pulse - 1e-9, volts, 0.0)
        true, line = falls(robots[rotors], np.radians(angle), V, t[1])
        true, line = np.degrees(true[:2]), np.degrees(line[:2])
        apart = np.abs(true[0] - line[0]) > 5
        message = f"The two thetas stay within 5° for {END_TIME} s."
        if apart.any():
            message = f"The thetas are 5° apart at {t[apart.argmax()]:.2f} s."
        yield note(message, BLUE) + page(
            _angles(t, true[0], line[0], "theta", "Body angle theta"),
            _angles(t, true[1], line[1], "phi", "Wheel angle phi"),
        )

    return Explorer(sliders, draw)


def falls(mip, angle, V, T):
    """The motion from rest, by the nonlinear and the linear model.

    Parameters
    ----------
    mip : Mip
        The pendulum.
    angle : float
        theta at the start, in rad.
    V : (N,) array_like
        Voltages, each held for T seconds.
    T : float
        Time step in s, also that of Runge and Kutta's method for the nonlinear
        model.

    Returns
    -------
    true, line : (4, N + 1) arrays
        theta, phi and their rates.

    Examples
    --------
    >>> true, line = falls(Mip.printed(), 0.01, np.zeros(40), 0.005)
    >>> bool(np.allclose(true, line, atol=1e-3))
    True
    """
    plant = mip.plant()
    A = np.zeros((5, 5))
    A[:2, 2:4] = np.eye(2)
    A[2:4] = np.linalg.solve(plant.M, np.hstack([-plant.S, -plant.D, plant.B]))
    step = expm(A * T)[:4]

    def rates(x, volt):
        return np.append(x[2:], mip.acceleration(x[:2], x[2:], volt))

    x = y = np.array([angle, 0.0, 0.0, 0.0])
    true, line = [x], [y]
    for volt in np.asarray(V, float):
        k1 = rates(x, volt)
        k2 = rates(x + T / 2 * k1, volt)
        k3 = rates(x + T / 2 * k2, volt)
        k4 = rates(x + T * k3, volt)
        x = x + T / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        y = step @ np.append(y, volt)
        true.append(x)
        line.append(y)
    return np.transpose(true), np.transpose(line)


def _angles(t, true, line, name, title):
    low, high = min(true.min(), -10), max(true.max(), 10)
    room = 0.08 * (high - low)
    chart = Chart((0, t[-1]), (low - room, high + room), "t (s)", "degrees", title)
    chart.line([0, t[-1]], [0, 0], GREY, True)
    chart.line(t, line, VERMILLION, True, "linear")
    chart.line(t, true, BLUE, name=name)
    return chart.svg()
