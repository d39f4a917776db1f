"""Exact responses of a closed loop to set points and disturbances."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from .linear import loop_matrix

__all__ = ["Response", "Sine", "simulate"]


@dataclass(frozen=True)
class Sine:
    """amplitude sin(omega t) + offset for start <= t < stop, else 0.

    Parameters
    ----------
    amplitude, offset : float or (p,) array_like
        One number acts on every disturbance channel.
    omega : float
        In rad/s.
    start, stop : float
        In seconds.
    """

    amplitude: float
    omega: float
    offset: float = 0.0
    start: float = 0.0
    stop: float = np.inf

    def __call__(self, t):
        """Values at the times t, one row for each channel."""
        t = np.asarray(t, float)
        on = (t >= self.start) & (t < self.stop)
        amplitude = np.atleast_1d(self.amplitude)[:, None]
        offset = np.atleast_1d(self.offset)[:, None]
        return on * (amplitude * np.sin(self.omega * t) + offset)


@dataclass(frozen=True, eq=False)
class Response:
    """Signals of a simulated loop; columns belong to the times t.

    Parameters
    ----------
    t : (k,) array
        Times, in seconds.
    z, dz, e : (n, k) arrays
        Displacement, velocity, error z - r.
    u : (m, k) array
        The whole control signal, with K_A e'' where there is one.
    x : (N, k) array
        The state [z; z'; x3].
    w : (p, k) array
        The disturbance.
    """

    t: np.ndarray
    z: np.ndarray
    dz: np.ndarray
    e: np.ndarray
    u: np.ndarray
    x: np.ndarray
    w: np.ndarray


def simulate(d, K, t, r=None, w=None, x0=None, K_A=None):
    """Simulate one vertex exactly (matrix exponentials, no ODE solver).

    Parameters
    ----------
    d : Descriptor
    K : (m, N) array
    t : (k,) array_like
        Increasing times, in seconds, from 0.
    r : (n,) array_like, optional
        Constant set point from t = 0 on. Its impulse r' is left out.
    w : Sine, optional
        Disturbance.
    x0 : (N,) array_like, optional
        Initial state; zero without it.
    K_A : (m, n) array, optional
        Acceleration gain, to be counted in u.

    Returns
    -------
    Response
    """
    n, N, p = len(d.C), len(d.E), d.Bw.shape[1]
    t = times(t)
    r = vector("r", r, n)
    x0 = vector("x0", x0, N)
    A = loop_matrix(d, K)
    _, B, Bw = d.state_space()
    constant = -B @ (K[:, :n] @ r)
    constant[2 * n:] -= d.A[2 * n:, :n] @ r
    on, off, sine, level = disturbance(w, p)
    # the state joined by [1, sin(omega t), cos(omega t)]
    quiet = np.zeros((N + 3, N + 3))
    quiet[:N, :N] = A
    quiet[:N, N] = constant
    loud = quiet.copy()
    if w is not None:
        loud[:N, N] += Bw @ level
        loud[:N, N + 1] = Bw @ sine
        loud[N + 1, N + 2], loud[N + 2, N + 1] = w.omega, -w.omega
    nodes = np.unique(np.concatenate(
        [t, [s for s in (on, off) if 0 < s < t[-1]]]
    ))
    x = np.empty((N, len(nodes)))
    x[:, 0] = x0
    cache = {}
    for k, (now, then) in enumerate(zip(nodes, nodes[1:])):
        active = on <= now < off
        key = (active, f"{then - now:.11e}")
        if key not in cache:
            cache[key] = expm((loud if active else quiet) * (then - now))
        phase = 0.0 if w is None else w.omega * now
        joined = np.concatenate(
            [x[:, k], [1, np.sin(phase), np.cos(phase)]]
        )
        x[:, k + 1] = (cache[key] @ joined)[:N]
    x = x[:, np.searchsorted(nodes, t)]
    values = np.zeros((p, len(t)))
    if w is not None:
        values[:] = w(t)
    reference = np.concatenate([r, np.zeros(N - n)])[:, None]
    u = K @ (x - reference)
    if K_A is not None and np.any(K_A):
        rate = A @ x + constant[:, None] + Bw @ values
        u = u + K_A @ rate[n:2 * n]
    z = x[:n]
    return Response(t, z, x[n:2 * n], z - r[:, None], u, x, values)


def times(t):
    """An array of times that increase from 0."""
    t = np.asarray(t, float)
    good = t.ndim == 1 and len(t) > 1 and np.isfinite(t).all()
    if not good or t[0] != 0 or (np.diff(t) <= 0).any():
        raise ValueError("t must increase from 0 and hold two times")
    return t


def vector(name, value, size):
    """An array of ``size`` finite numbers; zero for None."""
    vector = np.zeros(size) if value is None else np.asarray(value, float)
    if vector.shape != (size,) or not np.isfinite(vector).all():
        raise ValueError(f"{name} must hold {size} finite numbers")
    return vector


def disturbance(w, p):
    """Times on and off, amplitude and offset of a checked Sine."""
    if w is None:
        return np.inf, np.inf, None, None
    if not isinstance(w, Sine):
        raise ValueError("w must be a Sine (or None)")
    if p == 0:
        raise ValueError("w is given but the plant has no F")
    for name in ("amplitude", "offset"):
        if np.shape(getattr(w, name)) not in ((), (1,), (p,)):
            raise ValueError(f"w: {name} must be one number or {p} of them")
    sine = np.broadcast_to(np.asarray(w.amplitude, float), (p,))
    level = np.broadcast_to(np.asarray(w.offset, float), (p,))
    return w.start, w.stop, sine, level
