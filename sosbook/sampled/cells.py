r"""Cells of plants, and the theorem that one P for each corner proves all of a cell.

**Theorem.** Let a loop F(a, t) of a plant a with the clock t differ from a mixture
:math:`\sum a_i \tau_j F_{ij}` of the loops at the corners of two cells, one of plants
and one of clocks, by a mixture :math:`\sum \tau_j D_j(a, t)` with
:math:`D_j^\top D_j \le W_j`. If there are :math:`P_i = P_i^\top > 0`, a matrix G and
numbers :math:`s_j > 0` with, at all corners,

.. math::

    \begin{bmatrix} r^2 P_i - s_j W_j & (G F_{ij})^\top \\
    G F_{ij} & G + G^\top - P_i - G G^\top / s_j \end{bmatrix} > 0 ,

then with :math:`P = \sum a_i P_i` every motion of :math:`x_{k+1} = F(a, t_k) x_k`
falls: :math:`x_{k+1}^\top P x_{k+1} < r^2 x_k^\top P x_k`, however the clock t_k moves
in its cell. With the same P_i, and G and s_j of its own for each of several cells of
clocks, it may move in all of them.

*Proof.* In the mean of the blocks stand P and the mixture of the F_ij. By
2 y'G D x <= s x'D'D x + y'G G'y / s for each j it stays positive definite if the
loop F takes the place of the mixture and the terms in s_j are left out. Since
(G - P) P^-1 (G - P)' is never negative, G + G' - P <= G P^-1 G'. So F'P F < r^2 P
by Schur's complement (G is regular, as the last block is positive definite). []

With w and z / gamma joined to x_k and x_{k+1}, and P_i beside the identity in the place
of P_i, the theorem for r = 1 is the bounded real lemma: the sum of |z|^2 is below
gamma^2 times that of |w|^2.

With P_i = G = I it is the statement that F'F < r^2 I. Source: Oliveira, Bernussou and
Geromel (1999) for G; this edition's for D.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np
from flint import arb
from scipy.linalg import solve_triangular

from ..bisection import highest
from ..exact.definite import exact
from .balls import balls, balls_of, middle, orthonormal, product, solve
from .loops import SampledFamily, key_of, within
from .timing import TimeBox

__all__ = ["PlantCell", "gram_bound", "least_pivot"]

SHARES = 10.0 ** (np.arange(-24, 5) / 4)  # of W that are tried
HUGE = 1e100  # no loop with such an entry is seen to fall, and floats overflow near it


@dataclass(frozen=True, eq=False)
class PlantCell:
    """A cell of plants with one Lyapunov matrix for each corner.

    ``family``: the loops; ``weights``, (corners, vertices) of rationals: the corners,
    one a row; ``L``, (N, N): the coordinates L x, in which P and G are given;
    ``clocks``: all clocks; `least` is of a part of them; ``last``: the corner from
    which the edges of `SampledFamily.bends` go; ``P``, (corners, N, N) or None: the
    Lyapunov matrix of each corner; None for the identity.
    """

    family: SampledFamily
    weights: np.ndarray
    L: np.ndarray
    clocks: TimeBox
    last: int = 0
    P: np.ndarray | None = None

    def least(self, box, rate, G=None):
        """A positive number if the theorem holds for the clocks of a `TimeBox`.

        ``box``: the cell of clocks; ``rate``: the rate at which motions shall decay;
        ``G``, (N, N): the multiplier; the mean of P without it.
        """
        multiplier = None if G is None else key_of(G)
        key = self._key, self._key_of_P, multiplier, box, rate
        return self.family.remember(key, lambda: self._least(box, rate, G))

    @cached_property
    def _key(self):
        return key_of(self.weights), key_of(self.L), self.last, self.clocks

    @cached_property
    def _key_of_P(self):
        return None if self.P is None else key_of(self.P)

    @cached_property
    def _turned_P(self):
        return [_turned(x, self.turn) for x in self.P]

    def _least(self, box, rate, G):
        """The least pivot of a ``box`` of clocks, in balls; -inf if unknown."""
        pace, one = arb(exact(rate)), np.eye(len(self.L), dtype=int)
        try:
            several, bent = self.loops(box), self.bent(box)
            if self.P is not None:
                G = _turned(self.P.mean(axis=0) if G is None else G, self.turn)
        except ZeroDivisionError:  # some E in the hull is singular
            return -np.inf
        known = chain(*several, (W for W in bent if W is not None))
        if not all(abs(e) < HUGE for x in known for e in x.flat):
            return -np.inf  # a hull so wide that nothing is known in it
        pivots = []
        for loops, W in zip(several, bent):
            if pivots and not min(pivots) > 0:
                break
            if self.P is None:
                blocks = less_grams(pace**2 * one, loops, W)
            else:
                blocks = _blocks(pace, self._turned_P, G, loops, W)
            pivots += map(least_pivot, blocks)
        return min(pivots)

    @cached_property
    def _frame(self):
        """L behind a rotation, in balls, and the rotation.

        To the axes along which the loops are closest to one. The balls hold an exact
        rotation, so that what is proven behind it is true before it.
        """
        return self.family.remember((self._key, "frame"), self._made_frame)

    def _made_frame(self):
        L, corners = balls(self.L), self.clocks.corners
        loops = [middle(F) for timing in corners for F in self._within(timing, L)]
        axes = np.linalg.eigh(sum(F.T @ F for F in loops))[1]
        turn = orthonormal(balls_of(axes.T[::-1]))
        return product(turn, L), turn

    @property
    def turn(self):
        """The rotation behind L, in balls."""
        return self._frame[1]

    def loops(self, box):
        """L F L^-1 of the plants at the corners, for each corner of a box of clocks."""
        return [self._loops(timing) for timing in box.corners]

    def _loops(self, timing):
        key, L = (self._key, "loops", timing), self._frame[0]
        return self.family.remember(key, lambda: self._within(timing, L))

    def _within(self, timing, L):
        return [within(self.family.loop(w, timing), L) for w in self.weights]

    def bent(self, box):
        """W of the theorem for each corner of a box of clocks; None where D = 0."""
        along = self._along(box)
        return [_sum(along, self._across(timing)) for timing in box.corners]

    def _along(self, box):
        """The bound of D for a change of the clock."""
        if not box.varies:
            return None
        key, L = (self._key, "along", box), self._frame[0]
        return self.family.remember(
            key, lambda: gram_bound(self.family.time_bends(self.weights, L, box))
        )

    def bends_across(self, box):
        """True if several plants with P bend more than clocks do in their box."""
        if self.P is None:
            return False
        along = _trace(self._along(box))
        return any(_trace(self._across(timing)) > along for timing in box.corners)

    def _across(self, timing):
        """The bound of D for a change of the plant."""
        if len(self.weights) == 1:
            return None
        key = self._key, "across", timing
        return self.family.remember(key, lambda: gram_bound(self._bends(timing)))

    def _bends(self, timing):
        key, L = (self._key, timing), self._frame[0]
        return self.family.remember(
            key, lambda: self.family.bends(self.weights, self.last, L, timing)
        )

    def expected(self, timing):
        """W of a clock's ``timing`` in floats, as if the bends were exact; or None."""
        if len(self.weights) == 1:
            return None
        W = gram_bound([(n, balls_of(middle(H))) for n, H in self._bends(timing)])
        turn = middle(self.turn)
        return None if W is None else turn.T @ middle(W) @ turn

    def widest(self, timing):
        """Where loops with a ``timing`` bend most: an axis of a box, or two corners."""
        bends = [H for _, H in self._bends(timing)]
        if self.family.shape.axes:
            return int(np.argmax([float(size(H)) for H in bends]))
        rest = [k for k in range(len(self.weights)) if k != self.last]
        pairs = [(j, k) for j in range(len(rest)) for k in range(j + 1)]
        found = dict(zip(pairs, map(middle, bends)))
        far = {}
        for j, k in pairs:
            H, ends = found[j, j], (self.last, rest[j])
            if j != k:
                H, ends = H + found[k, k] - 2 * found[j, k], (rest[k], rest[j])
            far[ends] = np.linalg.norm(H)
        return list(max(far, key=far.get))

    def halves(self, cut):
        """The two cells on either side of a ``cut``, with the mixed P."""
        weights = self.family.shape.halves(self.weights, cut)
        several = self.family.shape.halves(self.P, cut)
        return [replace(self, weights=w, P=x) for w, x in zip(weights, several)]


def _sum(first, second):
    """A matrix above (D + H)'(D + H), from those above D'D and H'H."""
    if first is None or second is None:
        return second if first is None else first
    one, other = map(_trace, (first, second))
    share = np.sqrt(other / one) if one > 0 and other > 0 else 1.0
    t = arb(exact(float(share))) if 1e-9 < share < 1e9 else arb(1)
    return (1 + t) * first + (1 + 1 / t) * second


def _trace(W):
    return 0.0 if W is None else float(sum(W.diagonal(), arb(0)).mid())


def _turned(X, turn):
    """turn^-T X turn^-1."""
    return solve(turn.T, solve(turn.T, balls(X).T).T)


def _blocks(pace, P, G, loops, W):
    """The theorem's matrices at the corners of one clock, with the best s."""
    GG, rests = product(G, G.T), [G + G.T - x for x in P]
    cross = [product(G, F) for F in loops]
    s = None if W is None else arb(exact(_best_s(pace, P, GG, rests, cross, W)))
    for x, rest, C in zip(P, rests, cross):
        top = pace**2 * x
        if W is not None:
            top, rest = top - s * W, rest - GG / s
        yield np.block([[top, C.T], [C, rest]])


def _best_s(pace, P, GG, rests, cross, W):
    """The s that leaves the most room, in floats."""
    pace, W, GG, o = float(pace.mid()), middle(W), middle(GG), np.zeros(W.shape)
    blocks = [
        middle(np.block([[pace**2 * x, C.T], [C, rest]]))
        for x, rest, C in zip(P, rests, cross)
    ]
    first, second = np.block([[W, o], [o, o]]), np.block([[o, o], [o, GG]])
    return most_room(blocks, [first], second, 1 + 1 / SHARES)[0]


def less_grams(right, loops, W):
    """Balls below ``right`` less (F + D)'(F + D) for each F of some ``loops``, where
    D'D is below W; None where D is zero.
    """
    grams = [product(F.T, F) for F in loops]
    if W is None:
        return [right - gram for gram in grams]
    less, bent, several = middle(right), middle(W), np.array([*map(middle, grams)])
    t, _ = most_room(less - bent - several, several, bent, SHARES)
    t = arb(exact(t))
    return [right - (1 + t) * gram - (1 + 1 / t) * W for gram in grams]


def most_room(blocks, first, second, points):
    """(s, room): with which of some ``points`` the smallest eigenvalue of ``blocks``
    less s ``first`` less ``second`` / s, which is concave in s, is largest; in floats.
    """
    blocks, first = (np.array(x)[:, None] for x in (blocks, first))

    def room(s):
        s = s[:, None, None]
        left = np.linalg.eigvalsh(blocks - s * first - second / s)
        return left[..., 0].min(axis=0)

    return highest(room, points)


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
    W = balls_of(W)  # any will do
    S = product(W, S, W.T)
    if not all(2 * row[i] > sum(map(abs, row)) for i, row in enumerate(S)):
        return -np.inf
    return float(root.diagonal().min() ** 2)


def size(H):
    """A ball above the Frobenius norm of each matrix in the balls H."""
    return sum((e.abs_upper() ** 2 for e in H.flat), arb(0)).sqrt()


def gram_bound(bends):
    """A matrix above D'D, for D a sum of bends as in `SampledFamily.bends`.

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
        one = ((1 + t) * product(M.T, M) + (1 + 1 / t) * wide) * (n * n / much)
        bound = one if bound is None else bound + one
    return None if bound is None else bound * (total / 64)
