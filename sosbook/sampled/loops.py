"""The sampled loops of a polytope, enclosed in balls."""

from dataclasses import dataclass

import numpy as np
from flint import arb
from scipy.linalg import solve_triangular

from ..lmi.exact import exact
from .balls import balls, exponential, hull, middle, series, solve
from .discretize import SampleTiming

__all__ = ["BALL_BITS", "SampledPolytope", "halves", "pivot"]

BALL_BITS = 128  # of the balls' midpoints; a double has 53


@dataclass(frozen=True, eq=False)
class SampledPolytope:
    """The sampled loops of all mixtures of exact vertices, in balls.

    ``timing`` is a `SampleTiming`; ``full`` and ``own`` are the maps of its
    `feedback`.
    """

    vertices: list
    timing: SampleTiming
    full: np.ndarray  # from [x; older; own] to [x; older; u(k)]
    own: np.ndarray  # and to own(k + 1): see `SampleTiming.feedback`

    @classmethod
    def of(cls, vertices, timing, K):
        """The loops of a gain or controller K with some vertices in a timing."""
        full, own = map(balls, timing.feedback(K, vertices[0], exact))
        return cls([d.map(exact) for d in vertices], timing, full, own)

    def least(self, weights, corners, L, last, rate):
        """`pivot` of the worst corner of a simplex, for all plants inside.

        Parameters
        ----------
        weights : (corners, vertices) array of rationals
            The corners of the simplex, one a row.
        corners : list
            Their loops.
        L : (N, N) array
            The matrix of the Lyapunov function |L x|^2.
        last : int
            The corner from which `bulge` measures.
        rate : float
            The rate at which motions shall decay.
        """
        L = balls(L)  # once for all corners
        order = [*(k for k in range(len(weights)) if k != last), last]
        try:
            pace = arb(exact(rate)) - self.bulge(weights[order], L)
        except ZeroDivisionError:  # some E in the hull is singular
            return -np.inf
        return min(pivot(F, L, pace) for F in corners)

    def mixed(self, weights):
        """E and [A B] of one mixture, by its weights, exactly."""
        E = sum(w * d.E for w, d in zip(weights, self.vertices))
        both = sum(w * np.hstack([d.A, d.Bu]) for w, d in zip(weights, self.vertices))
        return E, both

    def loop(self, weights):
        """The loop matrix of one mixture, by its weights: balls of tiny radius."""
        E, both = self.mixed(weights)
        step = self._step([solve(balls(E), balls(both))])
        older = self.timing.shift_register(*self.vertices[0].Bu.shape)
        picked = balls(self.timing.selector(*self.vertices[0].Bu.shape))
        return np.vstack(
            [np.vstack([step @ picked, balls(older)]) @ self.full, self.own]
        )

    def bulge(self, weights, L):
        """How far the loops of a simplex of weights are from mixtures of its corners'.

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
        inner = balls(self.timing.selector(N, m)) @ self.full
        inner = solve(L.T, inner.T).T
        edges = [[balls(x - y) for x, y in zip(corner, last)] for corner in mixtures]
        edges = [(E1, solve(E, A1 - E1 @ X)) for E1, A1 in edges]
        total = arb(0)
        for j, (E1, X1) in enumerate(edges):
            for k, (E2, X2) in enumerate(edges[: j + 1]):
                X12 = solve(E, -(E1 @ X2 + E2 @ X1))
                curvature = self._step([X, X1, X2, X12])
                curvature = L[:, :N] @ (curvature @ inner)
                length = sum(e.abs_upper() ** 2 for e in curvature.flat).sqrt()
                total += length if j == k else 2 * length
        return total / 8

    def _step(self, terms):
        """The last term of the series of [x; first; second] to next x."""
        N, m = self.vertices[0].Bu.shape
        pieces = zip(*(self.timing.segments(x[:, :N], x[:, N:]) for x in terms))
        flow = None  # its last columns, of which the first rows are wanted
        for piece in pieces:
            span = balls(np.array([piece[0][1]]))[0]
            step = exponential(series([M for M, _ in piece]) * span)
            flow = step[:, -(N + 2 * m) :] if flow is None else step[:N] @ flow
        return flow[:N]


def pivot(F, L, pace):
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
    W = solve_triangular(root, np.eye(len(root)), lower=True)
    W = np.array([[arb(e) for e in row] for row in W.tolist()], object)  # any will do
    S = W @ S @ W.T
    if not all(2 * row[i] > sum(map(abs, row)) for i, row in enumerate(S)):
        return -np.inf
    return float(root.diagonal().min() ** 2)


def halves(weights, i, j):
    """Cut a simplex of weights in the middle of the edge between corners i and j."""
    first, second = weights.copy(), weights.copy()
    first[i] = second[j] = (weights[i] + weights[j]) / 2
    return [first, second]
