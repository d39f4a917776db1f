"""Responses of M z'' + D z' + S z + f(z, z') = B u + F w under the linear PID
controller, f a force that no matrix holds, such as gravity on a swinging arm.
"""

from collections.abc import Callable

import numpy as np

from ..plants.checks import matrix, positive
from ..plants.descriptor import descriptors
from ..plants.gain import gain_of
from ..plants.response import Response, times, vector
from ..plants.second_order import SecondOrderSystem
from ..plants.signals import Sine, Step, Steps, signal_parts, steps
from ..runtime.array_like import ArrayLike
from .linear import loop_matrix

FINEST = 1e-13  # relative tolerance; floats know no finer one


def arm_gravity(z, dz):
    """Gravity on the link of Example 4 at z: [m g l sin(phi1), 0], in Nm.

    It doesn't depend on dz, the rates.

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


def simulate_nonlinear(
    plant: SecondOrderSystem,
    force: Callable[[np.ndarray, np.ndarray], ArrayLike],
    K: ArrayLike,
    t: ArrayLike,
    U: ArrayLike | None = None,
    r: ArrayLike | Step | Steps | None = None,
    w: Sine | Step | Steps | None = None,
    x0: ArrayLike | None = None,
    K_A: ArrayLike | None = None,
    rtol: float = 1e-9,
) -> Response:
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
    r : (n,) array_like, Step, Steps or Ramps, optional
        Set point; its jumps send no impulse through K_D or K_A. At a
        jump e and u have the value after it.
    w : Sine, Step, Steps or Ramps, optional
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
        The motion, sampled at t.

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
    from scipy.integrate import solve_ivp  # it loads thirty modules

    if not isinstance(plant, SecondOrderSystem):
        raise ValueError(
            "plant must be a SecondOrderSystem: the nonlinear force takes "
            f"the place of a Polytope, got {type(plant).__name__}"
        )
    (d,) = descriptors(plant, U, K_A)
    n, N, p = plant.n, len(d.E), plant.p
    K = matrix("K", gain_of(K, plant, U), (plant.m, N))
    t, r, x0 = times(t), steps(r, n), vector("x0", x0, N)
    K_A = None if K_A is None else matrix("K_A", K_A, (plant.m, n))
    if not FINEST <= positive("rtol", rtol) < 1:
        raise ValueError(f"rtol must be from {FINEST:g} to 1, got {rtol!r}")
    if not callable(force):
        raise ValueError(f"force must be a function, got {type(force).__name__}")
    on, off, *_, pieces = signal_parts("w", w, p, "F")
    pieces = steps(pieces, p)

    def pushed(x):
        f = np.asarray(force(x[:n], x[n : 2 * n]))
        if f.shape != (n,) or f.dtype.kind not in "iuf" or not np.isfinite(f).all():
            raise ValueError(
                f"force(z, dz) must return {n} finite numbers, got {f.tolist()!r:.80} "
                f"at z = {x[:n].tolist()!r:.80}"
            )
        return f

    A = loop_matrix(d, K)
    _, B, Bw = d.state_space()
    inward = -np.linalg.inv(d.E)[:, n : 2 * n]

    memory = d.A[2 * n :, : 2 * n]

    def rates(begin, shaken):
        aim, force, slope = r.index(begin), pieces.index(begin), r.slope(begin)

        def rate(now, x):
            goal = np.concatenate([r.within(aim, now), slope])
            dx = A @ x - B @ (K[:, : 2 * n] @ goal) + inward @ pushed(x)
            dx[2 * n :] -= memory @ goal
            dx += Bw @ pieces.within(force, now)
            if shaken:
                dx = dx + Bw @ _wave(w, now, p)
            return dx

        return rate

    breaks = [*r.times, *pieces.times, on, off]
    ends = np.unique([0.0, *(s for s in breaks if 0 < s < t[-1]), t[-1]])
    x, dx = np.empty((N, len(t))), np.empty((N, len(t)))
    state = x0
    for now, then in zip(ends, ends[1:]):
        rate = rates(now, on <= now < off)
        how = dict(rtol=rtol, atol=1e-3 * rtol, events=_far, dense_output=True)
        done = solve_ivp(rate, (now, then), state, "DOP853", **how)
        if done.status != 0:
            raise ValueError(
                f"the motion can't be followed beyond t = {done.t[-1]:.3g} "
                "s: is the loop unstable?"
            )
        inside = (t >= now) & (t <= then)
        x[:, inside] = done.sol(t[inside])
        moved = zip(t[inside], x[:, inside].T)
        dx[:, inside] = np.transpose([rate(s, y) for s, y in moved])
        state = done.y[:, -1]
    goal = r(t)
    u = K @ x - K[:, : 2 * n] @ np.vstack([goal, r.slope(t)])
    if K_A is not None:
        u = u + K_A @ dx[n : 2 * n]
    values = np.zeros((p, len(t)))
    if w is not None:
        values[:] = w(t)
    z = x[:n]
    return Response(t, z, x[n : 2 * n], z - goal, u, x, values)


def _far(now, x):
    """A number that turns negative where a motion runs away."""
    return 1e30 - np.abs(x).max()


_far.terminal = True


def _wave(w, now, p):
    """The disturbance while it is on, also at its very end."""
    phase = np.sin(w.omega * now)
    return np.broadcast_to(np.asarray(w.amplitude) * phase + np.asarray(w.offset), (p,))
