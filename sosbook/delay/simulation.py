"""Responses of a closed loop whose control signal comes late."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from ..plants.checks import matrix
from ..plants.descriptor import Descriptor
from ..plants.response import Response, times, vector
from ..plants.signals import Step, Steps, signal_parts
from .control_signal import GAUSS_POINTS, PARABOLAS, ControlSignal
from .mesh import step_kinds, time_mesh

STEP_FRACTION = 0.04  # the default step, as a part of the shortest time scale


@dataclass(frozen=True, eq=False)
class DelayedResponse(Response):
    """Signals of a loop with a delay; columns belong to the times t.

    Parameters
    ----------
    t, z, dz, e
        As in `Response`.
    u : (m, k) array
        What the controller asks for at t.
    x, w
        As in `Response`.
    applied : (m, k) array
        What reaches the plant at t: u(t - d(t)).
    dx : (N, k) array
        The derivative of the state, from the right where it jumps.
    d : (k,) array
        The delay, in seconds.
    """

    applied: np.ndarray
    dx: np.ndarray
    d: np.ndarray


def simulate_delay(d, K, t, delay, r=None, w=None, x0=None, history=None, step=None):
    r"""Simulate one vertex whose input is late: u(t - d(t)).

    Parameters
    ----------
    d : Descriptor
        The plant in descriptor form.
    K : (m, N) array_like
        For t >= 0 the controller asks for u = K (x - [r; 0; 0]).
    t : (k,) array_like
        Increasing times, in seconds, from 0.
    delay : delay signal
        Such as `ConstantDelay`, see `sosbook.delay.profiles`.
    r : (n,) array_like, optional
        Constant set point from t = 0 on. The integrators get it at
        once, the plant late and through u. Its impulse r' is left out.
    w : Sine or Step, optional
        Disturbance; it isn't delayed.
    x0 : (N,) array_like, optional
        State at t = 0; without it history(0), or zero.
    history : callable, optional
        ``history(s)`` is the state, an (N,) array_like, at one time
        s <= 0; then u(s) = K history(s) for s < 0. Without it the
        controller was off: u(s) = 0 for s < 0, also where x0 is given.
    step : float, optional
        Longest step, in seconds. Without it a step that suits the rates of loop, delay
        and disturbance: about eight digits. A plant with a very fast mode needs very
        short ones; give a longer step where that mode doesn't matter.

    Returns
    -------
    DelayedResponse
        The motion at the times t.

    Raises
    ------
    ValueError
        On wrong shapes, a delay that is none, a step that isn't positive or asks for
        more than a million steps, and where the motion runs away to infinity.

    Notes
    -----
    Method of steps with an exponential integrator. In each step a parabola through
    three Gauss points stands for the late input; the rest, matrix exponential and
    disturbance, is exact. The past of u is read off cubic Hermite polynomials: order
    four in the step. Jumps of the input, and the times at which these come back late,
    are ends of steps. Where t - d(t) lies within the step, a linear system is solved.

    Examples
    --------
    x' = -x(t - 1) from x = 1: the line 1 - t, then a parabola.

    >>> from sosbook.delay.profiles import ConstantDelay
    >>> from sosbook.plants.descriptor import Descriptor
    >>> one, none = np.eye(1), np.zeros((1, 1))
    >>> d = Descriptor(one, none, one, np.zeros((1, 0)), one)
    >>> answer = simulate_delay(d, [[-1.0]], [0, 1, 2], ConstantDelay(1),
    ...                         history=lambda s: [1.0])
    >>> answer.x.round(9) + 0.0
    array([[ 1. ,  0. , -0.5]])
    """
    if not isinstance(d, Descriptor):
        raise ValueError(
            f"d must be a Descriptor, got {type(d).__name__}: ask the loop of a plant, "
            "loop.late(tau).simulate(t)"
        )
    n, N, p = len(d.C), len(d.E), d.Bw.shape[1]
    K = matrix("K", K, (d.Bu.shape[1], N))
    t = times(t)
    if isinstance(w, Steps) or isinstance(r, (Step, Steps)) or callable(r):
        raise ValueError(
            "behind a delay r must be constant, and w a Sine or a Step: ask the loop "
            "at ticks, loop.at(T, delay).simulate(seconds, r), which takes functions"
        )
    r = vector("r", r, n)
    past = _past(history, N)
    x0 = past(0.0) if x0 is None else vector("x0", x0, N)
    on, off, sine, level, _ = signal_parts("w", w, p, "F")
    omega = 0.0 if w is None else w.omega
    A, B, Bw = d.state_space()
    _check(delay)
    if step is None:
        step = _default_step(A, B @ K, delay, omega, t[-1])
    tolerance = 1e-13 * t[-1]
    nodes, user = time_mesh(t, delay, (on, off), step, tolerance)
    h = np.diff(nodes)
    middle = nodes[:-1] + h / 2

    # what isn't fed back in x': columns for 1, sin and cos of omega t
    columns = np.zeros((2, N, 3))
    columns[:, 2 * n :, 0] = -d.A[2 * n :, :n] @ r
    if w is not None:
        columns[1, :, 0] += Bw @ level
        columns[1, :, 1] = Bw @ sine
    active = ((on < middle) & (middle < off)).astype(int)
    waves = np.stack(
        [np.ones(len(nodes)), np.sin(omega * nodes), np.cos(omega * nodes)]
    )
    kinds, kind = step_kinds(active, h)
    flow, forced, weights = _exponentials(A, B, columns[active[kinds]], omega, h[kinds])
    push = np.einsum("kij,jk->ki", forced[kind], waves[:, :-1])
    outside = np.stack(
        [
            np.einsum("kij,jk->ki", columns[active], waves[:, side])
            for side in (slice(None, -1), slice(1, None))
        ],
        1,
    )

    arrival = nodes[:-1, None] + h[:, None] * GAUSS_POINTS
    asked = arrival - delay(arrival)
    if not (asked <= arrival + tolerance).all():
        raise ValueError("delay must be a number >= 0 at all times")
    control = ControlSignal(nodes, K, K[:, :n] @ r, past, tolerance)
    late = asked[:, 1] >= -tolerance
    with np.errstate(over="ignore", invalid="ignore"):
        x = control.march(A, B, x0, asked, late, h, kind, flow, weights, push, outside)
    if not np.isfinite(x).all():
        raise ValueError("the motion runs away to infinity: end t earlier")

    x, delays = x[user].T, delay(t)
    asked = t - delays
    applied = control(asked, asked >= -tolerance).T
    values = np.zeros((p, len(t)))
    if w is not None:
        values[:] = w(t)
    dx = A @ x + B @ applied + columns[0, :, :1] + Bw @ values
    u, z = K @ x - (K[:, :n] @ r)[:, None], x[:n]
    return DelayedResponse(
        t, z, x[n : 2 * n], z - r[:, None], u, x, values, applied, dx, delays
    )


def _check(delay):
    names = ("low", "high", "jumps")
    if not callable(delay) or not all(hasattr(delay, s) for s in names):
        raise ValueError(
            f"delay must be a delay signal such as ConstantDelay(0.2), got {delay!r}"
        )


def _past(history, N):
    """history as a function that checks what it returns."""
    if history is None:
        return lambda s: np.zeros(N)
    if not callable(history):
        raise ValueError("history must be a function of one time s <= 0")

    def past(s):
        x = np.asarray(history(s), float)
        if x.shape != (N,) or not np.isfinite(x).all():
            raise ValueError(f"history(s) must hold {N} finite numbers")
        return x

    return past


def _default_step(A, BK, delay, omega, end):
    """A small part of the shortest time scale.

    Wherever the loop vibrates or diverges, s lies within the spectra of
    A + BK exp(-s d) with modulus <= 1; three of them stand for all.
    """
    spectra = np.linalg.eigvals(np.stack([A, A + BK, A - BK]))
    rate = max(np.abs(spectra).max(), abs(omega))
    own = getattr(delay, "rate", 0.0)
    rate = rate * (1 + own * (delay.high - delay.low) / 2) + own
    return min(STEP_FRACTION / rate, end) if rate > 0 else end


def _exponentials(A, B, columns, omega, h):
    """The matrices of a step: of the state, of [1, sin, cos] and of the input.

    The state is joined by these three and by the input's parabola (three values, one
    after the other, of m entries each); the time is measured in steps.
    """
    (N, m), h = B.shape, h[:, None, None]
    joined = np.zeros((len(h), N + 3 + 3 * m, N + 3 + 3 * m))
    joined[:, :N, :N] = A * h
    joined[:, :N, N : N + 3] = columns * h
    joined[:, N + 1, N + 2] = omega * h[:, 0, 0]
    joined[:, N + 2, N + 1] = -omega * h[:, 0, 0]
    joined[:, :N, N + 3 : N + 3 + m] = B * h
    ahead = np.arange(N + 3, N + 3 + 2 * m)
    joined[:, ahead, ahead + m] = 1
    done = expm(joined)[:, :N]
    powers = done[:, :, N + 3 :].reshape(-1, N, 3, m)
    scaled = np.array([1, 1, 2])[:, None] * PARABOLAS
    weights = np.einsum("knim,ij->knjm", powers, scaled)
    return done[:, :, :N], done[:, :, N : N + 3], weights
