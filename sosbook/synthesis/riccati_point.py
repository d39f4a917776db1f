"""The optima of one plant, from its Riccati equations.

For one plant the optimum of Theorem 2.4 is known: P is the inverse of the equation's
solution X, and tr J the trace of noise' X noise; so is that of Theorem 2.5, from the
dual equation. What is left to the solver is a certificate of that gain, inside a bound
that is a little larger.
"""

from dataclasses import replace

import numpy as np

from ..analysis.riccati import lyapunov, riccati
from ..plants.descriptor import twins
from .scaling import Frame
from .solution import Solution

BOUND_BACKOFF = 1e-4  # a fraction: the proven bound exceeds the optimum by this
FIRST_SHORT = 1e-5  # of the mean of what is taken, in every direction
STEPS_BESIDE = 2
UNLIKE_ONE = 1e-3  # an eigenvalue of X, in coordinates in which they are near one


def bound_of(least):
    """The bound that is asked for the ``least`` cost: it exceeds that a little."""
    return float(f"{least * (1 + BOUND_BACKOFF):.5e}")


def riccati_point(request):
    """The Solution with the gain of least cost, the `bound_of` that cost, and a point
    inside; None where the ``request`` asks more than the cost of one plant, or the
    equation's solution isn't positive definite by far.
    """
    several = len(request.requirements) > 1 or len(request.distinct) > 1
    if several or request.coupling.own_P or request.step is not None:
        return None
    (cost,) = request.requirements
    frame = Frame.of(request)
    d, T, R = request.vertices[0], frame.T, cost.R
    A, B, _ = d.change(frame.left, T).state_space()
    noise = np.linalg.solve(T, cost.noise_input(d))
    Q = T.T @ cost.Q @ T
    try:
        X = _near_one(riccati(A, B, Q, R))
        K = -np.linalg.solve(R, B.T @ X)
        least = np.trace(noise.T @ X @ noise)
        bound = bound_of(least)
        X, J, _ = _inside(X, (A + B @ K).T, noise, bound - least)
    except (np.linalg.LinAlgError, ValueError):
        return None
    K = np.linalg.solve(T.T, K.T).T
    P = T @ np.linalg.inv(X) @ T.T
    given = replace(request.with_bounds({cost.parameter.key: bound}), gain=K)
    return Solution(given, "feasible", K, P, K @ P, frame=frame, own={"J": J})


def riccati_observer(problem):
    """L, bound and unknowns by name of the observer of least cost, for a ``problem``,
    an `ObserverProblem`, of one plant; or None.
    """
    if len(set(twins(problem.vertices))) > 1:
        return None
    T, rest = problem.T
    d, N, back = problem.vertices[0], len(T), np.linalg.inv(T.T)
    A, B, _ = d.state_space()
    # x = T'^-1 xi of the error: there the solution is near the identity
    C, source = problem.C @ back, T.T @ problem.Q_F[:N]
    R = problem.R_F @ problem.R_F.T
    Q, errors = source @ source.T, T.T @ A @ back
    noise = back.T @ np.linalg.solve(d.E, problem.noises[0])
    try:
        X = _near_one(riccati(errors.T, C.T, Q, R))
        L = -np.linalg.solve(R, C @ X).T
        least = np.trace(noise.T @ X @ noise)
        bound = bound_of(least)
        X, J, room = _inside(X, errors + L @ C, noise, bound - least)
        P1 = np.linalg.inv(X)
        P1 = (P1 + P1.T) / 2
        there = np.linalg.inv(rest.T)
        far, push = rest.T @ problem.Q_F[N:], rest.T @ B @ problem.K @ back
        mixed = P1 @ source @ far.T - push.T
        taken = mixed.T @ np.linalg.solve(P1 @ room @ P1, mixed) + far @ far.T
        P2 = _beside(rest.T @ (A + B @ problem.K) @ there, taken)
    except (np.linalg.LinAlgError, ValueError):
        return None
    values = dict(P1=P1, P2=P2, J=J / problem.unit**2)
    return np.linalg.solve(T.T, L), bound, values


def _near_one(X):
    """X, or a LinAlgError where it is singular in coordinates that suit it."""
    if not np.linalg.eigvalsh(X)[0] > UNLIKE_ONE:
        raise np.linalg.LinAlgError("the solution isn't positive definite")
    return X


def _inside(X, loop, noise, room):
    """A little more than X, J for it, and by what Lyapunov's equation falls short.

    The equation is loop X + X loop' + S = 0. It falls short by R, X grows by Z with
    loop Z + Z loop' + R = 0, and tr J by tr(noise' Z noise) = tr(W R). Of the
    ``room`` of tr J one part is left, one for each entry of J's diagonal goes to J,
    and n parts go to R, which is where the barrier of the blocks is about least:
    there inv(R) = W / part + G, with the derivative G of four times log det X.
    """
    n, channels = noise.shape
    part = room / (n + channels + 1)
    W = lyapunov(loop.T, -noise @ noise.T)
    if not np.trace(W) > 0:
        raise ValueError("there is no noise")
    G = lyapunov(loop.T, -4 * np.linalg.inv(X))
    R = np.linalg.inv(W / part + G)
    X = X + lyapunov(loop, -R)
    J = noise.T @ X @ noise + part * np.eye(channels)
    return (X + X.T) / 2, (J + J.T) / 2, R  # for a proof they are exactly symmetric


def _beside(loop, taken):
    """P2 with loop X + X loop' + taken < 0 for its inverse X, well inside; what is
    taken may be of low rank. The barrier is least where X falls short by the inverse of
    G, the derivative of three times log det X: from a guess a few steps lead near it.
    """
    n = len(taken)
    short = taken / 2 + FIRST_SHORT * np.trace(taken) / n * np.eye(n)
    for _ in range(STEPS_BESIDE):
        P2 = np.linalg.inv(lyapunov(loop, -taken - short))
        short = np.linalg.inv(lyapunov(loop.T, -1.5 * (P2 + P2.T)))
    P2 = np.linalg.inv(lyapunov(loop, -taken - short))
    return (P2 + P2.T) / 2
