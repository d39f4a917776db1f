"""The sampled loops of a polytope, enclosed in balls."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from flint import arb, ctx
from scipy.linalg import solve_triangular

from ..exact.definite import exact
from .balls import balls, exponential, hull, middle, series, solve
from .discretize import SampleTiming

__all__ = ["BALL_BITS", "SampledPolytope", "halves", "pivot"]

BALL_BITS = 128  # of the balls' midpoints; a double has 53
#: Values of t that `SampledPolytope.least` may take.
SHARES = tuple(10.0 ** (k / 4) for k in range(-24, 5))


@dataclass(frozen=True, eq=False)
class SampledPolytope:
    """The sampled loops of all mixtures of exact vertices, in balls.

    ``timing`` is a `SampleTiming`; ``full`` and ``own`` are the maps of its
    `feedback`; ``known`` holds what was found of equal polytopes.
    """

    vertices: list
    timing: SampleTiming
    full: np.ndarray  # from [x; older; own] to [x; older; u(k)]
    own: np.ndarray  # and to own(k + 1): see `SampleTiming.feedback`
    known: dict = field(default_factory=dict)  # loops and pivots that were found

    @classmethod
    def of(cls, vertices, timing, K):
        """The loops of a gain or controller K with some vertices in a timing."""
        maps = timing.feedback(K, vertices[0], exact)
        vertices = [d.map(exact) for d in vertices]
        numbers = [x for d in vertices for x in (d.E, d.A, d.Bu)]
        known = _known(timing, ctx.prec, tuple(map(_key, (*maps, *numbers))))
        return cls(vertices, timing, *map(balls, maps), known)

    def least(self, weights, L, last, rate):
        """A positive number if |L x| falls in all loops of a simplex of plants.

        With G = L F L^-1 of a corner and D what a loop differs from the
        mixture of the corners', (G + D)'(G + D) is at most (1 + t) G'G +
        (1 + 1/t) D'D for every t, and the first term is convex: at each
        corner rate^2 less both is proven to be positive definite.

        Parameters
        ----------
        weights : (corners, vertices) array of rationals
            The corners of the simplex, one a row.
        L : (N, N) array
            The matrix of the Lyapunov function |L x|^2.
        last : int
            The corner from which the edges of `bends` go.
        rate : float
            The rate at which motions shall decay.
        """
        key = (_key(weights), _key(exact(L)), last, exact(rate))
        if key not in self.known:
            self.known[key] = self._least(weights, L, last, rate)
        return self.known[key]

    def _least(self, weights, L, last, rate):
        L, pace = balls(L), arb(exact(rate))
        corners = [self.loop(w) for w in weights]
        order = [*(k for k in range(len(weights)) if k != last), last]
        try:
            inside = [within(F, L) for F in corners]
            turn = _slowest_first(inside)  # so that its axes are those of the slack
            L, inside = turn @ L, [within(F, turn) for F in inside]
            bends = self.bends(weights[order], L)
        except ZeroDivisionError:  # some E in the hull is singular
            return -np.inf
        grams, bent = [G.T @ G for G in inside], gram_bound(bends)
        square = pace**2 * np.eye(len(L), dtype=int)
        if bent is None:
            return min(least_pivot(square - gram) for gram in grams)
        t = arb(exact(_best_share(float(rate), list(map(middle, grams)), middle(bent))))
        return min(
            least_pivot(square - (1 + t) * gram - (1 + 1 / t) * bent) for gram in grams
        )

    def mixed(self, weights):
        """E and [A B] of one mixture, by its weights, exactly."""
        E = sum(w * d.E for w, d in zip(weights, self.vertices))
        both = sum(w * np.hstack([d.A, d.Bu]) for w, d in zip(weights, self.vertices))
        return E, both

    def loop(self, weights):
        """The loop matrix of one mixture, by its weights: balls of tiny radius."""
        key = _key(weights)  # neighbouring simplices share corners
        if key not in self.known:
            self.known[key] = self._loop(weights)
        return self.known[key]

    def _loop(self, weights):
        E, both = self.mixed(weights)
        step = self._step([solve(balls(E), balls(both))])
        older = self.timing.shift_register(*self.vertices[0].Bu.shape)
        picked = balls(self.timing.selector(*self.vertices[0].Bu.shape))
        return np.vstack(
            [np.vstack([step @ picked, balls(older)]) @ self.full, self.own]
        )

    def bends(self, weights, L):
        """The second derivatives of L F L^-1 along the edges of a simplex of weights.

        With edges d_j from the last corner, F - sum w_i F_i is a sum of
        second derivatives H_jk along d_j and d_k, at many points, which are
        weighed by sum_i w_i |v_ij| |v_ik| / 2, where v_i is what leads to
        corner i, and these sums don't exceed a quarter. With E X = A the
        derivatives are E X_j = A_j - E_j X and E X_jk = - E_j X_k - E_k X_j.

        Returns
        -------
        list of (int, array)
            How often each counts, and balls that hold it at every point.
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
        bends = []
        for j, (E1, X1) in enumerate(edges):
            for k, (E2, X2) in enumerate(edges[: j + 1]):
                X12 = solve(E, -(E1 @ X2 + E2 @ X1))
                bend = L[:, :N] @ (self._step([X, X1, X2, X12]) @ inner)
                bends.append((1 if j == k else 2, bend))
        return bends

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


def _key(matrix):
    """The shape and the rationals of a matrix, to find it again."""
    return matrix.shape, *matrix.flat


@lru_cache(maxsize=2)
def _known(*_):
    """What was found of a polytope: a proof is looked at as soon as it is made."""
    return {}


def pivot(F, L, pace):
    """The smallest pivot of L^-T (pace^2 L'L - F'L'LF) L^-1.

    A positive number comes with a proof that it is positive definite.
    """
    try:
        inside = within(F, balls(L))
    except ZeroDivisionError:
        return -np.inf
    if not pace > 0:
        return -np.inf
    return least_pivot(pace**2 * np.eye(len(L), dtype=int) - inside.T @ inside)


def least_pivot(S):
    """The smallest pivot of a symmetric matrix S of balls.

    A positive number comes with a proof, a rigorous one, that each matrix
    in S is positive definite: some congruence makes it diagonally dominant,
    and thereby proves that the congruence is regular, too.
    """
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


def within(F, L):
    """L F L^-1, of balls; ZeroDivisionError unless L is proven to be regular."""
    return solve(L.T, (L @ F).T).T


def size(H):
    """A ball above the Frobenius norm of each matrix in the balls H."""
    return sum((e.abs_upper() ** 2 for e in H.flat), arb(0)).sqrt()


def _slowest_first(loops):
    """A rotation, in balls, to the axes along which loops are closest to one."""
    grams = [middle(G).T @ middle(G) for G in loops]
    return balls(np.linalg.eigh(sum(grams))[1].T[::-1])


def gram_bound(bends):
    """A matrix above D'D, for D a sum of bends as in `SampledPolytope.bends`.

    It is None if D is zero.

    By Cauchy and Schwarz, with the sizes n of the bends H, |D x|^2 is at
    most (sum n) (sum |H x|^2 / n) / 64. Of H = M + R with a midpoint M and
    |R| below a radius r, |H x|^2 is at most (1 + t) |M x|^2 + (1 + 1/t)
    |R x|^2, and |R x|^2 at most sum_j (sum_i s_i r_ij) x_j^2, with the sums
    s_i of the rows of r.
    """
    sizes = [n * size(H) for n, H in bends]
    total, bound = sum(sizes, arb(0)), None
    for (n, H), much in zip(bends, sizes):
        if not much > 0:
            continue
        M, r = (
            np.reshape([part(e) for e in H.flat], H.shape)
            for part in (lambda e: e.mid(), lambda e: arb(e.rad()))
        )
        t = size(r) / size(M) if size(M) > 0 else arb(1)
        t = t.mid() if t > 0 else arb(1)
        wide = np.diag(r.sum(axis=1) @ r)
        one = ((1 + t) * (M.T @ M) + (1 + 1 / t) * wide) * (n * n / much)
        bound = one if bound is None else bound + one
    return None if bound is None else bound * (total / 64)


def _best_share(rate, grams, bent):
    """The t of `SHARES` that leaves the most room, in floats."""
    room, t = rate**2 * np.eye(len(bent)), np.array(SHARES)[:, None, None]
    less = room - (1 + 1 / t) * bent
    left = [np.linalg.eigvalsh(less - (1 + t) * g)[:, 0] for g in grams]
    return SHARES[int(np.min(left, axis=0).argmax())]


def halves(weights, i, j):
    """Cut a simplex of weights in the middle of the edge between corners i and j."""
    first, second = weights.copy(), weights.copy()
    first[i] = second[j] = (weights[i] + weights[j]) / 2
    return [first, second]
