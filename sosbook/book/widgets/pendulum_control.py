"""Move the weights of the pendulum's controller; see it stand up."""

from types import SimpleNamespace

import numpy as np

from ...analysis.linear import loop_matrix
from ...display.escape import page_text
from ...pendulum import V_MAX, Mip, polytope, vertices
from ...plants.descriptor import descriptors
from ...runtime.libraries import library
from ...synthesis.lqr import design_lqr
from ..elements.chart import Chart
from ..plots import BLUE, COLOURS, GREY, VERMILLION, window_of
from .charts import plane
from .explorer import Explorer, gains_table, linear, log, note, page

ToggleButtons = library("ipywidgets").ToggleButtons


__all__ = ["explore_pendulum_control", "recover"]

PD, PID = "PD", "PID"
SINGLE, ROBUST = "one vertex", "all vertices"
END_TIME, TIME_STEP = 1.5, 0.0025  # s


def explore_pendulum_control():
    """Move R, the spread and the tilt; see poles, recovery and voltage.

    "one vertex" is the ordinary regulator of vertex 1 (PD) or 4 (PID),
    as the thesis's tables have it; "all vertices" is Theorem 2.4 by
    pairs, Q = I. Both then meet the four nonlinear pendulums, whose
    motors give no more than 7.4 V.

    Returns
    -------
    Explorer
        The sliders and the figure.

    Notes
    -----
    Source: thesis Tables 4.1 and 4.2, Procedures 2.3 and 2.4, (4.13).
    """
    sliders = {
        "R": log("R, weight of the voltage", 1.0, 10, 1000),
        "spread": linear("spread (%)", 4.0, 0, 70),
        "tilt": linear("let go at (degrees)", 5.0, 0, 85),
        "law": ToggleButtons(options=[PD, PID], value=PD, description="law"),
        "design": ToggleButtons(
            options=[SINGLE, ROBUST], value=SINGLE, description="design"
        ),
    }
    return Explorer(sliders, _draw)


def recover(robots, K, angle, t, limit=V_MAX):
    """Let nonlinear pendulums go at an angle, under V = K x.

    Parameters
    ----------
    robots : sequence of Mip
        The pendulums.
    K : (1, 4) or (1, 5) array_like
        [K_P K_D] or [K_P K_D K_I], with x3' = phi.
    angle : float
        theta at the start, in rad; the rest is zero.
    t : (k,) array_like
        Equally spaced times from 0, in s; each is a Runge-Kutta step.
    limit : float
        The motors' largest voltage, in V.

    Returns
    -------
    x : (N, len(robots), k) array
        The states [theta; phi; theta'; phi'; x3].
    V : (len(robots), k) array
        The voltages, after the limit.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> t = np.linspace(0, 1, 401)
    >>> x, V = recover([Mip.printed()], thesis.mip().pd[5], 0.1, t)
    >>> V[0, 0].round(3), abs(x[0, 0, -1]) < 0.02
    (np.float64(2.127), np.True_)
    """
    fleet = SimpleNamespace(
        **{
            name: np.array([getattr(r, name) for r in robots])
            for name in ("a", "b", "c", "d", "e", "f", "J")
        }
    )
    K = np.asarray(K, float)
    x = np.zeros((K.shape[1], len(robots)))
    x[0], T = angle, t[1] - t[0]

    def volts(x):
        return np.clip((K @ x)[0], -limit, limit)

    def rate(x):
        fall = Mip.acceleration(fleet, x[:2], x[2:4], volts(x))
        return np.concatenate([x[2:4], fall, x[1:2]])[: len(x)]

    states = [x]
    for _ in t[1:]:
        k1 = rate(x)
        k2 = rate(x + T / 2 * k1)
        k3 = rate(x + T / 2 * k2)
        k4 = rate(x + T * k3)
        x = x + T / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        states.append(x)
    states = np.moveaxis(states, 0, 2)
    return states, np.clip(np.einsum("i,ijk->jk", K[0], states), -limit, limit)


def _draw(R, spread, tilt, law, design):
    U = [[0, 1]] if law == PID else None
    robots = vertices(Mip.printed(), spread / 100)
    plants = polytope(Mip.printed(), spread / 100)
    index = 3 if law == PID else 0
    plant = plants if design == ROBUST else robots[index].plant()
    regulator = design_lqr(plant, np.eye(5 if U else 4), [[R]], U)
    if regulator.K is None:
        yield note(
            f"<strong>{regulator.status}</strong>. " + page_text(regulator.advice)
        )
        return
    loops = [loop_matrix(d, regulator.K) for d in descriptors(plants, U)]
    poles = np.array([np.sort_complex(np.linalg.eigvals(A)) for A in loops])
    message = f"regulator of vertex {index + 1}. "
    if design == ROBUST:
        message = (
            "Certified for all plants: cost &lt; <strong>"
            f"{regulator.request.cost.bound:.4g}</strong>. "
        )
    t = np.arange(0, END_TIME + TIME_STEP / 2, TIME_STEP)
    x, V = recover(robots, regulator.K, np.radians(tilt), t)
    stands = np.abs(x[0, :, -1]) < np.radians(max(tilt / 2, 1))
    peak = np.abs(V).max()
    message += f"Rightmost pole {poles.real.max():.2f} 1/s. Peak voltage {peak:.3g} V"
    message += ", the motors' LIMIT. " if peak >= V_MAX else ". "
    good = poles.real.max() < 0 and stands.all()
    if not stands.all():
        message += f"FALLS at {np.sum(~stands)} of 4 vertices."
    yield note(message, BLUE if good else VERMILLION) + page(
        _poles(poles), _tilt(t, np.degrees(x[0])), _volts(t, V), gains_table(regulator)
    )


def _poles(poles):
    """All but the fastest of each loop, which lies far left."""
    slow = poles[:, 1:]
    window = window_of([np.append(slow, 1)])
    chart = plane(window, "Slow poles at the four vertices", axis=True)
    for row, colour in zip(slow, COLOURS):
        chart.marks(row.real, row.imag, colour, "cross")
    return chart.svg()


def _tilt(t, theta):
    theta = np.clip(theta, -90, 90)
    low, high = min(theta.min(), -1), max(theta.max(), 1)
    room = 0.08 * (high - low)
    chart = Chart(
        (0, t[-1]),
        (low - room, high + room),
        "t (s)",
        "degrees",
        "Tilt of the nonlinear pendulums",
    )
    chart.line([0, t[-1]], [0, 0], GREY, True)
    for k, row in enumerate(theta):
        chart.line(t[::4], row[::4], COLOURS[k], k > 0, f"{k + 1}")
    return chart.svg()


def _volts(t, V):
    chart = Chart(
        (0, t[-1]), (-1.1 * V_MAX, 1.1 * V_MAX), "t (s)", "V", "Voltage of the motors"
    )
    for side in (-V_MAX, V_MAX):
        chart.line([0, t[-1]], [side, side], VERMILLION, True)
    for k, row in enumerate(V):
        chart.line(t[::4], row[::4], COLOURS[k], k > 0)
    return chart.svg()
