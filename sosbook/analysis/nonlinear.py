"""Responses of a nonlinear plant under the linear PID controller.

The plant is M z'' + D z' + S z + f(z, z') = B u + F w: a second-order
system joined by a force f that no matrix holds, such as gravity on a
swinging arm.
"""

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from ..plants.checks import matrix
from ..plants.descriptor import descriptors
from ..plants.second_order import SecondOrderSystem
from .linear import loop_matrix
from .response import Response, Sine

__all__ = ["Steps", "arm_gravity", "simulate_nonlinear"]


@dataclass(frozen=True, eq=False)
class Steps:
    """A set point that is constant piece by piece.

    Parameters
    ----------
    times : (k,) array_like
        When each level begins, in seconds; increasing, the first is 0.
    levels : (k, n) array_like
        The set points, one a row.

    Examples
    --------
    >>> r = Steps([0, 2], [[1, 0], [3, 0]])
    >>> r([1.9, 2.0])
    array([[1., 3.],
           [0., 0.]])
    """

    times: np.ndarray
    levels: np.ndarray

    def __post_init__(self):
        times = matrix("times", [self.times])[0]
        if len(times) == 0 or times[0] != 0 or (np.diff(times) <= 0).any():
            raise ValueError("times must increase from 0")
        levels = matrix("levels", self.levels, (len(times), None))
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "levels", levels)

    def __call__(self, t):
        """The set point at the times t, one column each."""
        now = np.searchsorted(self.times, t, side="right") - 1
        return self.levels[now].T


def arm_gravity(z, dz):
    """Gravity on the link of Example 4: [m g l sin(phi1), 0], in Nm.

    Notes
    -----
    Source: thesis (3.2), with m g l = 1 Nm. The rest of the plant is
    ``thesis.arm(0.0)``.

    Examples
    --------
    >>> arm_gravity([np.pi / 2, 0.0], [0.0, 0.0])
    array([1., 0.])
    """
    return np.array([1.0 * np.sin(z[0]), 0.0])


def simulate_nonlinear(plant, force, K, t, U=None, r=None, w=None,
                       x0=None, K_A=None, rtol=1e-9):
    r"""Simulate :math:`M \ddot z + D \dot z + S z + f = B u + F w`.

    Parameters
    ----------
    plant : SecondOrderSystem
        The linear part.
    force : callable
        ``force(z, dz)`` is f, an (n,) array_like.
    K : (m, 2n + a) array_like
        ``[K_P K_D K_I]``; u = K_P e + K_D e' + K_I x3 (+ K_A e'').
    t : (k,) array_like
        Increasing times, in seconds, from 0.
    U : (a, n) array_like, optional
        Which errors are integrated.
    r : (n,) array_like or Steps, optional
        Set point; its jumps send no impulse through K_D or K_A. At a
        jump e and u have the value after it.
    w : Sine, optional
        Disturbance.
    x0 : (2n + a,) array_like, optional
        Initial state; zero without it.
    K_A : (m, n) array_like, optional
        Acceleration gain.
    rtol : float
        Relative tolerance of the integrator (Dormand and Prince's
        eighth order). It restarts at every jump of r or w.

    Returns
    -------
    Response

    Raises
    ------
    ValueError
        On wrong shapes, or where the motion runs away.

    Notes
    -----
    Source: thesis (3.2), (2.2), with x3 = + integral of U e.

    Examples
    --------
    >>> from sosbook.book import thesis
    >>> ex = thesis.example_4()
    >>> answer = simulate_nonlinear(
    ...     thesis.arm(0.0), arm_gravity, ex.K, [0, 9], ex.U, r=[1, 1])
    >>> answer.z[:, -1].round(3)  # phi1 hangs back by sin(phi1) / 50
    array([0.983, 1.   ])
    """
    if not isinstance(plant, SecondOrderSystem):
        raise ValueError(
            "plant must be a SecondOrderSystem: the nonlinear force takes "
            f"the place of a Polytope, got {type(plant).__name__}"
        )
    (d,) = descriptors(plant, U, K_A)
    n, N, p = plant.n, len(d.E), plant.p
    K = matrix("K", K, (plant.m, N))
    t = np.asarray(t, float)
    good = t.ndim == 1 and len(t) > 1 and np.isfinite(t).all()
    if not good or t[0] != 0 or (np.diff(t) <= 0).any():
        raise ValueError("t must increase from 0 and hold two times")
    r = _steps(r, n)
    x0 = np.zeros(N) if x0 is None else np.asarray(x0, float)
    if x0.shape != (N,) or not np.isfinite(x0).all():
        raise ValueError(f"x0 must hold {N} finite numbers")
    if np.shape(force(x0[:n], x0[n:2 * n])) != (n,):
        raise ValueError(f"force(z, dz) must return {n} numbers")
    if w is not None and not isinstance(w, Sine):
        raise ValueError("w must be a Sine (or None)")
    if w is not None and p == 0:
        raise ValueError("w is given but the plant has no F")

    A = loop_matrix(d, K)
    _, B, Bw = d.state_space()
    inward = -np.linalg.inv(d.E)[:, n:2 * n]

    def rates(goal, shaken):
        constant = -B @ (K[:, :n] @ goal)
        constant[2 * n:] -= d.A[2 * n:, :n] @ goal

        def rate(now, x):
            dx = A @ x + constant + inward @ force(x[:n], x[n:2 * n])
            if shaken:
                dx = dx + Bw @ _wave(w, now, p)
            return dx

        return rate

    breaks = [*r.times] + ([] if w is None else [w.start, w.stop])
    ends = np.unique([0.0, *(s for s in breaks if 0 < s < t[-1]), t[-1]])
    x, dx = np.empty((N, len(t))), np.empty((N, len(t)))
    state = x0
    for now, then in zip(ends, ends[1:]):
        rate = rates(r.levels[np.searchsorted(r.times, now, "right") - 1],
                     w is not None and w.start <= now < w.stop)
        done = solve_ivp(
            rate, (now, then), state, "DOP853", dense_output=True,
            rtol=rtol, atol=1e-3 * rtol, events=_far)
        if done.status != 0:
            raise ValueError(
                f"the motion can't be followed beyond t = {done.t[-1]:.3g} "
                "s: is the loop unstable?"
            )
        inside = (t >= now) & (t <= then)
        x[:, inside] = done.sol(t[inside])
        dx[:, inside] = np.transpose(
            [rate(s, y) for s, y in zip(t[inside], x[:, inside].T)])
        state = done.y[:, -1]
    goal = r(t)
    u = K @ x - K[:, :n] @ goal
    if K_A is not None:
        u = u + np.asarray(K_A, float) @ dx[n:2 * n]
    values = np.zeros((p, len(t)))
    if w is not None:
        values[:] = w(t)
    z = x[:n]
    return Response(t, z, x[n:2 * n], z - goal, u, x, values)


def _far(now, x):
    """Turns negative where a motion runs away."""
    return 1e30 - np.abs(x).max()


_far.terminal = True


def _steps(r, n):
    """A constant set point is one step."""
    if not isinstance(r, Steps):
        r = np.zeros(n) if r is None else np.asarray(r, float)
        if r.shape != (n,) or not np.isfinite(r).all():
            raise ValueError(f"r must be Steps or hold {n} finite numbers")
        return Steps([0.0], [r])
    if r.levels.shape[1] != n:
        raise ValueError(
            f"r has levels of {r.levels.shape[1]} numbers, needs {n}"
        )
    return r


def _wave(w, now, p):
    """The disturbance while it is on, also at its very end."""
    phase = np.sin(w.omega * now)
    return np.broadcast_to(
        np.asarray(w.amplitude) * phase + np.asarray(w.offset), (p,))
