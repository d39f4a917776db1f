"""Proofs, in ball arithmetic, that sampled loops are stable."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from flint import arb, arb_mat, ctx
from numpy.typing import ArrayLike
from scipy.linalg import matrix_balance

from ..exact.definite import exact, round_digits
from ..exact.proof import Stopped, first_proven, proven_within
from ..exact.rational import decimals
from ..language import Unknown
from ..lmi.problem import LMIProblem
from ..plants.checks import matrix, positive
from ..plants.kinds import Plant, checked_plant
from ..runtime.threads import one_thread
from ..runtime.time_limit import check_time
from .balls import balls, entries, middle
from .certificate import SampledCertificate, SchurCertificate, balls_data
from .discretize import SampleTiming, input_vertices, is_controller
from .loops import BALL_BITS, SampledPolytope, halves, pivot
from .lyapunov import discrete_lyapunov

__all__ = ["SampledCertificate", "certify_sampled", "prove_schur"]

LYAPUNOV_DIGITS = 12  # significant decimal digits of the rounded Lyapunov functions


@one_thread
def prove_schur(matrices, rate=1.0):
    """Prove that no matrix of several has an eigenvalue of magnitude rate or more.

    Parameters
    ----------
    matrices : sequence of arb_mat or (N, N) array_like
        Entries that are balls of positive radius stand for every matrix
        inside. Floats are read as decimals.
    rate : float
        Motions decay at least as rate^k; read as a decimal.

    Returns
    -------
    SchurCertificate
        One Lyapunov function for each matrix: nothing is said of a loop
        that switches between them.

    Examples
    --------
    >>> print(prove_schur([[[0.5, 1], [0, 0.5]]], rate=0.6))
    proven:
    - matrix 1 is stable: every motion decays at least as 0.6^k
    >>> print(prove_schur([[[1, 1], [0, 0.5]]]))
    not proven: matrix 1: its spectral radius is 1
    """
    if not isinstance(matrices, Iterable):
        raise ValueError(
            f"matrices must be a list of matrices, got {type(matrices).__name__}"
        )
    rate, matrices = _rate(rate), list(matrices)
    if not matrices:
        raise ValueError("matrices is empty: there is nothing to prove")
    failed, cells, contents = [], [], []
    with ctx.workprec(BALL_BITS):
        for k, matrix in enumerate(matrices):
            name, F = f"matrix {k + 1}", _given(f"matrices[{k}]", matrix)
            contents.append(
                balls_data(
                    F if isinstance(matrix, arb_mat) else np.array(matrix, float)
                )
            )
            trouble = _too_slow(middle(F), rate)
            if not trouble:
                L = _lyapunov([middle(F)], rate)
                cells.append(L)
                good = pivot(F, L, arb(exact(rate))) > 0
                trouble = "" if good else "undecided"
            if trouble:
                failed.append(f"{name}: {trouble}")
        return SchurCertificate.of(
            SchurCertificate.contents(contents, rate, None if failed else cells, failed)
        )


@one_thread
def certify_sampled(
    plant: Plant,
    K: Any,
    T: float,
    delay: float = 0.0,
    U: ArrayLike | None = None,
    rate: float = 1.0,
    digits: int | None = None,
    cells: int = 64,
    time_limit: float | None = None,
    progress: bool = False,
) -> SampledCertificate | Stopped:
    """Prove a sampled loop stable, for every plant of a polytope.

    Parameters
    ----------
    plant
        As for `c2d`. All floats are read as decimals.
    K : (m, N) or (m, N + m d) array_like, SampledSystem or control.StateSpace
        A gain is rounded to ``digits`` significant digits before the
        proof; of a sampled controller all digits are taken.
    T, delay, U
        As for `c2d`.
    rate : float
        Prove that motions decay at least as rate^k.
    digits : int, optional
        Without it 6, 8, 10, 12 and 17 are tried.
    cells : int
        How many simplices of weights may resist one Lyapunov function
        and are halved, at most.
    time_limit : float, optional
        Seconds after which nothing is proven, and the answer says so.
    progress : bool
        Show a bar of the seconds that have passed.

    Returns
    -------
    SampledCertificate
        The proof is about constant plants: a plant that changes from sample to
        sample isn't covered. Not proven doesn't mean unstable: ``failed`` says
        whether a plant was found that is.

    Notes
    -----
    The exponentials of the exact data are enclosed in balls. In a
    simplex of weights the loop F is the mixture of the corners' F_i, up
    to its second derivatives, which exponentials of truncated Taylor
    series enclose for the whole simplex. In the norm |L x| no mixture
    is larger than the largest F_i; so it is enough that the corners
    leave room for the difference.
    The method is made for a few vertices: with many there are too many halves.

    Examples
    --------
    >>> from sosbook import Polytope, SecondOrderSystem
    >>> cart = Polytope([
    ...     SecondOrderSystem([[M]], [[0]], [[0]], [[1]]) for M in (1, 2)])
    >>> print(certify_sampled(cart, [[-1, -1.5]], T=0.2, delay=0.1))
    proven:
    - the sampled loop of every plant of the polytope is stable
    """
    rate = _rate(rate)
    plant = checked_plant(plant)
    timing, floats = SampleTiming.of(T, delay), input_vertices(plant, U)
    if not isinstance(cells, int) or cells < 1:
        raise ValueError(f"cells must be 1 or more, got {cells!r}")
    for d in floats:
        timing.held(d)  # raises where a motion overflows

    def attempt(digits, _):
        gain = K
        if not is_controller(K):
            gain = round_digits(timing.gain(K, floats[0]), digits)
        with ctx.workprec(BALL_BITS):
            family = SampledPolytope.of(floats, timing, gain)
            tree, failed = _cover(family, rate, cells)
        return SampledCertificate.of(
            SampledCertificate.contents(plant, U, T, delay, gain, rate, tree, failed)
        )

    return proven_within(
        time_limit, lambda: first_proven(attempt, digits, places=(12,)), progress
    )


def _rate(rate):
    if not positive("rate", rate) <= 1:
        raise ValueError(f"rate must be at most 1, for stability; got {rate!r}")
    return float(rate)


def _cover(family, rate, budget):
    """(tree, failed) of `certify_sampled`: see `SampledCertificate`."""
    one, tree, proven = len(family.vertices) == 1, {}, 0
    queue = [(exact(np.eye(len(family.vertices))), tree)]
    while queue:
        check_time()
        weights, node = queue.pop()
        near = "weights around " + np.array2string(
            weights.astype(float).mean(axis=0), precision=3, separator=", "
        )
        try:
            corners = [family.loop(w) for w in weights]
        except ZeroDivisionError:
            near = near.replace("around ", "")
            return None, f"a plant of the polytope has no regular mass: near {near}"
        middles = [middle(F) for F in corners]
        for w, F in zip(weights.astype(float), middles):
            if trouble := _too_slow(F, rate):
                where = "weights " + np.array2string(w, separator=", ")
                return None, f"{'the plant' if one else where}: {trouble}"
        L = _lyapunov(middles, rate)
        far = _distances(middles, L)
        last = int(np.argsort(far.sum(axis=0), kind="stable")[0])
        if family.least(weights, L, last, rate) > 0:
            node.update(L=decimals(L), last=last)
            proven += 1
            continue
        budget -= 1
        if one or len(queue) + 2 > budget:
            return None, f"{'the plant' if one else near}: undecided"
        i, j = _longest(weights, far)
        node.update(halve=[i, j], halves=[{}, {}])
        queue += zip(halves(weights, i, j), node["halves"])
    return tree, ""


def _too_slow(F, rate):
    """What to say where floats don't see the radius below the rate; else empty."""
    radius = abs(np.linalg.eigvals(F)).max()
    if radius < rate * (1 - 1e-9):
        return ""
    return f"its spectral radius is {radius:.6g}"


def _lyapunov(loops, rate):
    """A regular L so that |L x|^2 might decay in all of some loops."""
    mean = sum(loops) / len(loops)
    scale = matrix_balance(mean, permute=False, separate=True)[1][0]
    L = _refined(np.diag(1 / scale), [mean], rate)
    inside = [L @ F @ np.linalg.inv(L) for F in loops]
    if max(np.linalg.norm(F, 2) for F in inside) >= rate:
        L = _refined(L, loops, rate)
    return round_digits(L, LYAPUNOV_DIGITS)


def _refined(L, loops, rate):
    """A better L: of one Lyapunov equation, or the LMIs of some."""
    loops = [L @ F @ np.linalg.inv(L) for F in loops]
    worst = max(abs(np.linalg.eigvals(F)).max() for F in loops)
    pace = max(np.sqrt(min(worst, rate) * rate), 0.1 * rate)
    if len(loops) == 1 and worst >= rate:
        return L
    if len(loops) == 1:
        F = loops[0] / pace
        P = discrete_lyapunov(F, np.eye(len(F)))
    else:

        def decay(values, cast):
            P = values["P"]
            drops = [P * pace**2 - F.T @ P @ F for F in loops]
            return {"P": P} | {f"loop {k}": g for k, g in enumerate(drops)}

        problem = LMIProblem(decay, [Unknown("P", len(L), symmetric=True)])
        solution = problem.find(refuse=False).values
        if solution is None:
            return L
        P = solution["P"]
    try:
        return np.linalg.cholesky((P + P.T) / 2).T @ L
    except np.linalg.LinAlgError:  # too close to the rate
        return L


def _distances(loops, L):
    """The distances of the loops from each other, in the norm of |L x|."""
    inside = [L @ F @ np.linalg.inv(L) for F in loops]
    return np.array([[np.linalg.norm(F - G, 2) for G in inside] for F in inside])


def _longest(weights, far):
    """The two corners of a simplex whose loops are furthest apart."""
    if not far.any():  # the corners' loops are the same
        w = weights.astype(float)
        far = np.linalg.norm(w[:, None] - w[None], axis=2)
    i, j = np.unravel_index(far.argmax(), far.shape)
    return int(i), int(j)


def _given(name, value):
    """A square matrix of balls; floats are read as decimals."""
    if isinstance(value, arb_mat):
        array = entries(value)
    else:
        array = balls(matrix(name, value))
    if array.shape[0] != array.shape[1] or not array.size:
        raise ValueError(f"{name} must be square, got {array.shape}")
    if not all(x.is_finite() for x in array.flat):
        raise ValueError(f"{name} has a ball that isn't finite")
    return array
