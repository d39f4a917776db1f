"""Exact responses of a loop with a sampled controller."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from ..plants.response import Response, entering, times, vector
from ..plants.signals import signal_parts, steps

__all__ = ["SampledResponse", "simulate_sampled"]


@dataclass(frozen=True, eq=False)
class SampledResponse(Response):
    """Signals of a sampled loop; columns belong to the times t.

    ``t``, ``z``, ``dz``, ``e``: as in `Response`; ``u``, (m, k): what the computer
    asked for at its last tick; ``x``, ``w``: as in `Response`; ``applied``, (m, k):
    what reaches the plant: the u of ``delay`` seconds ago.
    """

    applied: np.ndarray | None = None


def simulate_sampled(d, K, timing, t, r=None, w=None, x0=None):
    """Simulate one vertex exactly, between the samples too.

    ``d``: the plant in descriptor form; ``K``, (m, N + m q): in u(k) = K [x(k); u(k-1);
    ...; u(k-q)], with the q older inputs that ``timing`` needs; ``timing``: when the
    computer samples, and how late it acts; ``t``, (k,): increasing times, in seconds,
    from 0, where the first sample is; ``r``, (n,) Step, Steps or Ramps: set point, K_D
    sees its slope; ``w``: disturbance; ``x0``, (N,): initial state; zero without it.
    The older inputs are zero. Returns the motion at the times t.
    """
    n, (N, m), p = len(d.C), d.Bu.shape, d.Bw.shape[1]
    t, r, x = times(t), steps(r, n), vector("x0", x0, N)
    on, off, sine, level, pieces = signal_parts("w", w, p, "F")
    A, B, Bw = d.state_space()
    T, fraction = float(timing.T), float(timing.remainder)
    ticks = np.array([float(timing.T * k) for k in range(int(t[-1] / T) + 1)])
    arrivals = ticks + fraction
    corners = [s for s in (on, off, *r.times) if 0 < s < t[-1]]
    corners += [] if pieces is None else [s for s in pieces.times if s < t[-1]]
    nodes = np.concatenate([t, ticks, arrivals[arrivals < t[-1]], corners])
    nodes = np.unique(nodes[nodes <= t[-1]])
    where = np.eye(N)[:, 2 * n :]
    where = where if pieces is None else np.hstack([where, Bw])
    inward, chain, v = entering(A[2 * n :, : 2 * n], r, pieces, nodes)
    # the state joined by the applied u, v and [1, sin(omega t), cos(omega t)]
    L = N + m + len(v)
    quiet = np.zeros((L + 3, L + 3))
    quiet[:N, :N], quiet[:N, N : N + m] = A, B
    quiet[:N, N + m : N + m + len(inward)] = where[:, inward]
    quiet[N + m : L, N + m : L] = chain
    loud = quiet.copy()
    if sine is not None:
        loud[:N, -3], loud[:N, -2] = Bw @ level, Bw @ sine
        loud[-2, -1], loud[-1, -2] = w.omega, -w.omega
    phase = (0.0 if sine is None else w.omega) * nodes
    outside = np.vstack([v, nodes**0, np.sin(phase), np.cos(phase)])
    goal = np.vstack([r(nodes), r.slope(nodes), np.zeros((N - 2 * n, len(nodes)))])
    inputs = [np.zeros(m)] * (timing.n_past_inputs + 1)  # the last one first
    applied, cache = np.zeros(m), {}
    states = np.empty((N, len(nodes)))
    asked, reached = np.empty((2, m, len(nodes)))
    for k, now in enumerate(nodes):
        if now in ticks:
            new = K @ np.concatenate([x - goal[:, k], *inputs[: timing.n_past_inputs]])
            inputs = [new, *inputs][: timing.n_past_inputs + 1]
        if now in arrivals:
            applied = inputs[timing.whole_samples]
        states[:, k], asked[:, k], reached[:, k] = x, inputs[0], applied
        if k + 1 == len(nodes):
            break
        active, span = on <= now < off, nodes[k + 1] - now
        key = (active, f"{span:.11e}")
        if key not in cache:
            cache[key] = expm((loud if active else quiet) * span)
        x = (cache[key] @ np.concatenate([x, applied, outside[:, k]]))[:N]
    here = np.searchsorted(nodes, t)
    x, goal = states[:, here], r(t)
    values = np.zeros((p, len(t)))
    if w is not None:
        values[:] = w(t)
    return SampledResponse(
        t,
        x[:n],
        x[n : 2 * n],
        x[:n] - goal,
        asked[:, here],
        x,
        values,
        reached[:, here],
    )
