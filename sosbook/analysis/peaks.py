"""The largest size of a signal that dies out, sampled closely enough for the fastest
mode that is still alive. Between samples a cubic of the squared size finds each
maximum, and Newton's steps make its slope vanish, until a bound excludes any larger
value.
"""

import numpy as np
from scipy.linalg import expm, matrix_balance

from .riccati import lyapunov

STEP = 0.05  # rad of the fastest mode that is alive, between samples
DOUBLINGS = 10  # a run has 2^10 steps
MOST_RUNS = 2000  # after which the largest value so far is taken
ALIVE = 1e-9  # share of a mode that is left
CLOSE = 1e-6  # relative; the error of a cubic is below that
REFINED = 4  # maxima of a run, at most
NEWTON_STEPS = 4
LARGEST_CONDITION = 1e8  # of eigenvectors whose sums bound a signal


def largest_size(motion, runs=MOST_RUNS):
    """The largest |u(t)| for t >= 0; after so many ``runs`` the largest value so far.

    A ``motion`` has ``poles``, ``alive(top)`` for each of them, ``run(step)``, which
    returns u and u' at the samples of a run and goes on, ``near(k, t)``, which returns
    u, u' and u'' at a time t after the k-th sample of the last run, and ``bound()`` of
    |u| from now on.
    """
    top = 0.0
    for _ in range(runs):
        alive = motion.poles[motion.alive(top)]
        if not len(alive):
            break
        step = STEP / np.abs(alive).max()
        u, slope = motion.run(step)
        g, dg = (u * u).sum(axis=0), 2 * (u * slope).sum(axis=0) * step
        top = max(top, np.sqrt(g.max()))
        k = np.flatnonzero((dg[:-1] > 0) & (dg[1:] < 0))
        share, height = _cubic_top(g[k], dg[k], g[k + 1], dg[k + 1])
        best = np.argsort(-height)[:REFINED]
        for i in best[np.sqrt(height[best]) > top * (1 - CLOSE)]:
            top = max(top, _refined(motion, k[i], share[i] * step, step))
        if motion.bound() <= top:
            break
    return float(top)


def _cubic_top(g, dg, h, dh):
    """Where in [0, 1] cubics with ends g, h and slopes dg > 0, dh < 0 are largest."""
    a, b = 3 * (dg + dh) + 6 * (g - h), -2 * (2 * dg + dh) - 6 * (g - h)
    root = np.sqrt(np.maximum(b * b - 4 * a * dg, 0.0))
    t = np.clip(2 * dg / (root - b), 0.0, 1.0)  # of a t^2 + b t + dg
    return t, g + t * (dg + t * (b / 2 + t * a / 3))


def _refined(motion, k, t, step):
    """|u| at the maximum near a time t after a sample."""
    size = 0.0
    for _ in range(NEWTON_STEPS):
        u, slope, bend = motion.near(k, t)
        size = max(size, np.linalg.norm(u))
        curvature = slope @ slope + u @ bend
        if not curvature < 0:
            break
        t = min(max(t - (u @ slope) / curvature, 0.0), step)
    return size


class FreeMotion:
    """u = C x of x' = A x, stable, from an initial state x, in floats, timed by the
    fastest mode, with balanced states: units don't matter.
    """

    def __init__(self, A, C, x):
        with np.errstate(invalid="ignore"):  # scipy casts units, as if for the order
            self.A, (units, _) = matrix_balance(A, permute=False, separate=True)
        self.poles, vectors = np.linalg.eig(self.A)
        rate = np.abs(self.poles).max()
        self.A, self.poles = self.A / rate, self.poles / rate
        self.C, self.x, self.now = C * units, np.asarray(x, float) / units, 0.0
        X = lyapunov(self.A.T, -np.eye(len(self.A)))
        self.X, self.reach = X, np.linalg.norm(self.C @ np.linalg.solve(X, self.C.T), 2)
        self.waves = None
        if np.linalg.cond(vectors) < LARGEST_CONDITION:
            self.waves = self.C @ vectors, np.linalg.inv(vectors)

    def alive(self, top):
        """Which modes haven't died out, beside a ``top`` that is known."""
        return np.exp(self.poles.real * self.now) > ALIVE

    def run(self, step):
        """u and u' at samples every ``step``; the motion goes on."""
        forward, states = expm(self.A * step), self.x[:, None]
        for _ in range(DOUBLINGS):
            states = np.hstack([states, forward @ states])
            forward = forward @ forward
        self.states = np.hstack([states, (forward @ self.x)[:, None]])
        self.x, self.now = self.states[:, -1], self.now + step * 2**DOUBLINGS
        return self.C @ self.states, self.C @ (self.A @ self.states)

    def near(self, k, t):
        """u, u' and u'' at a time ``t`` after the ``k``-th sample of the last run."""
        x = expm(self.A * t) @ self.states[:, k]
        v = self.A @ x
        return self.C @ x, self.C @ v, self.C @ (self.A @ v)

    def bound(self):
        """Of |u| from now on: by x'Xx, which falls, and by the modes' amplitudes."""
        energy = np.sqrt(self.reach * max(self.x @ self.X @ self.x, 0.0))
        if self.waves is None:
            return energy
        seen, rows = self.waves
        return min(energy, amplitude(seen * (rows @ self.x), self.poles))


def amplitude(parts, poles):
    """The sum of the largest sizes of the real waves in the sum of ``parts[:, k]
    exp(poles[k] t)``, those of conjugate ``poles`` together; parts are (m, N).
    """
    upper, real = poles.imag > 0, poles.imag == 0
    waves = np.stack([parts.real, parts.imag], axis=2).transpose(1, 0, 2)
    sizes = np.linalg.norm(waves, 2, axis=(1, 2))
    return 2 * sizes[upper].sum() + np.linalg.norm(parts[:, real].real, axis=0).sum()
