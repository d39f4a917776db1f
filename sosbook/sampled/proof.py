"""Proofs, in ball arithmetic, that sampled loops are stable."""

from dataclasses import dataclass, field

import control
import numpy as np
from flint import arb, arb_mat, ctx
from scipy.linalg import (
    matrix_balance,
    solve_discrete_lyapunov,
    solve_triangular,
)

from ..lmi import Unknown
from ..lmi.centre import Blocks, phase_one
from ..lmi.exact import exact, round_digits
from ..lmi.proof import Proof
from ..plants.checks import matrix, positive
from .balls import balls, entries, exponential, hull, middle, series, solve
from .discretize import Clock, input_vertices

__all__ = ["SampledCertificate", "certify_sampled", "prove_schur"]

BITS = 128  # of the balls' midpoints
DIGITS = 12  # of the Lyapunov functions


@dataclass(frozen=True, eq=False)
class SampledCertificate(Proof):
    """A proof, in ball arithmetic, that sampled loops are stable.

    Parameters
    ----------
    proven, claims, failed
        As in `Proof`.
    blocks : dict
        From a cell's name to the smallest pivot of rate^2 - F'F, as a
        float, in coordinates where |L x| is the length of x. The rate
        is lowered by what the cell's loops F differ from mixtures of
        its corners' loops.
    rate : float
    cells : tuple of (weights, L)
        For every plant whose weights lie in the simplex with these
        corners (rows), |L x|^2 is a Lyapunov function.
    K : (m, N) or (m, N + m d) array, control.StateSpace or None
        What the proof is about; a gain is rounded to the printed digits.
    """

    rate: float
    cells: tuple = field(repr=False, default=())
    K: np.ndarray = None


def prove_schur(matrices, rate=1.0):
    """Prove that each of some matrices has all eigenvalues below rate.

    Parameters
    ----------
    matrices : sequence of arb_mat or (N, N) array_like
        Entries that are balls of positive radius stand for every matrix
        inside. Floats are read as decimals.
    rate : float
        Motions decay at least as rate^k; read as a decimal.

    Returns
    -------
    SampledCertificate
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
    rate, matrices = _rate(rate), list(matrices)
    if not matrices:
        raise ValueError("matrices is empty: there is nothing to prove")
    blocks, failed, cells = {}, [], []
    with ctx.workprec(BITS):
        for k, given in enumerate(matrices):
            name, F = f"matrix {k + 1}", _given(f"matrices[{k}]", given)
            trouble = _too_slow(middle(F), rate)
            if not trouble:
                L = _lyapunov([middle(F)], rate)
                blocks[name] = _pivot(F, L, arb(exact(rate)))
                cells.append((np.ones((1, 1)), L))
                trouble = "" if blocks[name] > 0 else "undecided"
            if trouble:
                failed.append(f"{name}: {trouble}")
    claims = tuple(_claim(name, rate) for name in blocks)
    return SampledCertificate(
        not failed, () if failed else claims, blocks, tuple(failed), rate,
        () if failed else tuple(cells))


def certify_sampled(plant, K, T, delay=0.0, U=None, rate=1.0, digits=6,
                    cells=64):
    """Prove a sampled loop stable, for every plant of a polytope.

    Parameters
    ----------
    plant, T, delay, U
        As for `hold`. All floats are read as decimals.
    K : (m, N) or (m, N + m d) array_like, or control.StateSpace
        A gain is rounded to ``digits`` significant digits before the
        proof; of a sampled controller all digits are taken.
    rate : float
        Prove that motions decay at least as rate^k.
    digits : int
    cells : int
        How many simplices of weights may resist one Lyapunov function
        and are halved, at most.

    Returns
    -------
    SampledCertificate
        Of constant plants: a plant that changes from sample to sample
        isn't covered. Not proven doesn't mean unstable: ``failed`` says
        whether a plant was found that is.

    Notes
    -----
    The exponentials of the exact data are enclosed in balls. In a
    simplex of weights the loop F is the mixture of the corners' F_i, up
    to its second derivatives, which exponentials of truncated Taylor
    series enclose for the whole simplex. In the norm |L x| no mixture
    is larger than the largest F_i; so it is enough that the corners
    leave room for the difference.
    Made for a few vertices: with many there are too many halves.

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
    clock, floats = Clock.of(T, delay), input_vertices(plant, U)
    if not isinstance(digits, int) or digits < 1:
        raise ValueError(f"digits must be 1 or more, got {digits!r}")
    if not isinstance(cells, int) or cells < 1:
        raise ValueError(f"cells must be 1 or more, got {cells!r}")
    for d in floats:
        clock.held(d)  # raises where a motion overflows
    if not isinstance(K, control.StateSpace):
        K = round_digits(clock.gain(K, floats[0]), digits)
    with ctx.workprec(BITS):
        family = Family(
            [d.map(exact) for d in floats], clock,
            *map(balls, clock.feedback(K, floats[0], exact)))
        blocks, failed, proofs = _cover(family, rate, cells)
    where = "the plant" if len(floats) == 1 else (
        "every plant of the polytope")
    claims = () if failed else (
        _claim(f"the sampled loop of {where}", rate),)
    return SampledCertificate(
        not failed, claims, blocks, failed, rate, tuple(proofs), K)


def _rate(rate):
    if not positive("rate", rate) <= 1:
        raise ValueError(f"rate must be at most 1, for stability; got {rate!r}")
    return float(rate)


def _claim(name, rate):
    words = f"{name} is stable"
    if rate != 1:
        words += f": every motion decays at least as {rate!r}^k"
    return words


def _cover(family, rate, budget):
    """(blocks, failed, cells) of `certify_sampled`."""
    one = len(family.vertices) == 1
    blocks, proofs, queue = {}, [], [exact(np.eye(len(family.vertices)))]
    while queue:
        weights = queue.pop()
        try:
            corners = [family.loop(w) for w in weights]
        except ZeroDivisionError:
            return blocks, (
                "a plant of the polytope has no regular mass: near weights "
                + np.array2string(weights.astype(float).mean(axis=0),
                                  precision=3, separator=", "),), ()
        middles = [middle(F) for F in corners]
        for w, F in zip(weights.astype(float), middles):
            if trouble := _too_slow(F, rate):
                where = "the plant" if one else (
                    "weights " + np.array2string(w, separator=", "))
                return blocks, (f"{where}: {trouble}",), ()
        L = _lyapunov(middles, rate)
        far = _distances(middles, L)
        nearest_last = np.argsort(-far.sum(axis=0), kind="stable")
        try:
            pace = arb(exact(rate)) - family.bulge(weights[nearest_last], L)
        except ZeroDivisionError:  # some E in the hull is singular
            pace = arb(0)
        pivot = min(_pivot(F, L, pace) for F in corners)
        if pivot > 0:
            proofs.append((weights.astype(float), L))
            blocks["plant" if one else f"cell {len(proofs)}"] = pivot
            continue
        budget -= 1
        if one or len(queue) + 2 > budget:
            where = "the plant" if one else "weights around " + (
                np.array2string(weights.astype(float).mean(axis=0),
                                precision=3, separator=", "))
            return blocks, (f"{where}: undecided",), ()
        queue += _halves(weights, far)
    return blocks, (), proofs


@dataclass(frozen=True, eq=False)
class Family:
    """The sampled loops of all mixtures of exact vertices, in balls."""

    vertices: list
    clock: Clock
    full: np.ndarray  # from [x; older; own] to [x; older; u(k)]
    own: np.ndarray  # and to own(k + 1): see `Clock.feedback`

    def mixed(self, weights):
        """E and [A B] of one mixture, exactly."""
        E = sum(w * d.E for w, d in zip(weights, self.vertices))
        both = sum(w * np.hstack([d.A, d.Bu])
                   for w, d in zip(weights, self.vertices))
        return E, both

    def loop(self, weights):
        """The loop matrix of one mixture: balls of tiny radius."""
        E, both = self.mixed(weights)
        step = self._step([solve(balls(E), balls(both))])
        older = self.clock.shift(*self.vertices[0].Bu.shape)
        picked = balls(self.clock.pick(*self.vertices[0].Bu.shape))
        return np.vstack([
            np.vstack([step @ picked, balls(older)]) @ self.full, self.own])

    def bulge(self, weights, L):
        """How far a simplex's loops are from mixtures of its corners'.

        A bound of the spectral norm of L (F - sum w_i F_i) L^-1. With
        edges d_j from the last corner it is an eighth of the sum over j
        and k of the bounds of the derivatives along d_j and d_k: they
        are weighed by sum_i w_i |v_ij| |v_ik| / 2, where v_i is what
        leads to corner i, and these sums don't exceed a quarter. With
        E X = A the derivatives are E X_j = A_j - E_j X and E X_jk = -
        E_j X_k - E_k X_j.
        """
        *mixtures, last = [self.mixed(w) for w in weights]
        N, m = self.vertices[0].Bu.shape
        E, both = (hull(x) for x in zip(*mixtures, last))
        X = solve(E, both)
        L = balls(L)
        inner = balls(self.clock.pick(N, m)) @ self.full
        inner = solve(L.T, inner.T).T
        edges = [[balls(x - y) for x, y in zip(corner, last)]
                 for corner in mixtures]
        edges = [(E1, solve(E, A1 - E1 @ X)) for E1, A1 in edges]
        total = arb(0)
        for j, (E1, X1) in enumerate(edges):
            for k, (E2, X2) in enumerate(edges[:j + 1]):
                X12 = solve(E, -(E1 @ X2 + E2 @ X1))
                bent = self._step([X, X1, X2, X12])
                bent = L[:, :N] @ (bent @ inner)
                size = sum(e.abs_upper()**2 for e in bent.flat).sqrt()
                total += size if j == k else 2 * size
        return total / 8

    def _step(self, terms):
        """The last term of the series of [x; first; second] to next x."""
        N, m = self.vertices[0].Bu.shape
        pieces = zip(*(self.clock.pieces(x[:, :N], x[:, N:])
                       for x in terms))
        flow = None
        for piece in pieces:
            span = balls(np.array([piece[0][1]]))[0]
            step = exponential(series([M for M, _ in piece]) * span)
            flow = step if flow is None else step @ flow
        return flow[:N, -(N + 2 * m):]


def _too_slow(F, rate):
    """In words, that floats don't see the radius below the rate."""
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
    return round_digits(L, DIGITS)


def _refined(L, loops, rate):
    """A better L: of one Lyapunov equation, or the LMIs of some."""
    loops = [L @ F @ np.linalg.inv(L) for F in loops]
    worst = max(abs(np.linalg.eigvals(F)).max() for F in loops)
    pace = max(np.sqrt(min(worst, rate) * rate), 0.1 * rate)
    if len(loops) == 1 and worst >= rate:
        return L
    if len(loops) == 1:
        F = loops[0] / pace
        P = solve_discrete_lyapunov(F.T, np.eye(len(F)))
    else:
        P = Unknown("P", len(L), symmetric=True)
        found = phase_one(Blocks.of(
            [P, *(P * pace**2 - F.T @ P @ F for F in loops)], [P]),
            multipliers=False)
        if found.x is None:
            return L
        P = P.unpack(found.x)
    try:
        return np.linalg.cholesky((P + P.T) / 2).T @ L
    except np.linalg.LinAlgError:  # too close to the rate
        return L


def _pivot(F, L, pace):
    """The smallest pivot of L^-T (pace^2 L'L - F'L'LF) L^-1.

    A positive number comes with a proof, a rigorous one, that it is
    positive definite: some congruence makes it diagonally dominant,
    and thereby proves that the congruence is regular, too.
    """
    L = balls(L)
    try:
        inside = solve(L.T, (L @ F).T).T
    except ZeroDivisionError:
        return -np.inf
    if not pace > 0:
        return -np.inf
    S = pace**2 * np.eye(len(L), dtype=int) - inside.T @ inside
    try:
        root = np.linalg.cholesky(middle(S))
    except np.linalg.LinAlgError:
        return -np.inf
    W = balls(solve_triangular(root, np.eye(len(root)), lower=True))
    S = W @ S @ W.T
    if not all(2 * row[i] > sum(map(abs, row)) for i, row in enumerate(S)):
        return -np.inf
    return float(root.diagonal().min() ** 2)


def _distances(loops, L):
    """From each loop to each other, in the norm of |L x|."""
    inside = [L @ F @ np.linalg.inv(L) for F in loops]
    return np.array([
        [np.linalg.norm(F - G, 2) for G in inside] for F in inside])


def _halves(weights, far):
    """Cut a simplex in the middle of its longest edge."""
    if not far.any():  # the corners' loops are the same
        w = weights.astype(float)
        far = np.linalg.norm(w[:, None] - w[None], axis=2)
    i, j = np.unravel_index(far.argmax(), far.shape)
    first, second = weights.copy(), weights.copy()
    first[i] = second[j] = (weights[i] + weights[j]) / 2
    return [first, second]


def _given(name, value):
    """A square matrix of balls; floats are read as decimals."""
    if isinstance(value, arb_mat):
        found = entries(value)
    else:
        found = balls(matrix(name, value))
    if found.shape[0] != found.shape[1] or not found.size:
        raise ValueError(f"{name} must be square, got {found.shape}")
    if not all(x.is_finite() for x in found.flat):
        raise ValueError(f"{name} has a ball that isn't finite")
    return found
