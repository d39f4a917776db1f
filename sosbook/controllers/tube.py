r"""Tubes: the motions of all plants of a cell, enclosed from tick to tick.

Let F(q) be the loops of a cell with weights :math:`w_i(q) \ge 0` of sum one, P(q) the
mean :math:`\sum w_i P_i` and :math:`|v|_q^2 = v^\top P(q) v`. What
`sosbook.sampled.cells` proves of the cell is :math:`|F(q) v|_q \le \rho |v|_q`.

**Theorem.** Let p_k be any polynomials in q, :math:`|x_0 - p_0|_q \le e_0`, and
:math:`\delta_k \ge |p_{k+1} - F p_k|_q` in the cell. With
:math:`e_{k+1} = \rho e_k + \delta_k` every motion :math:`x_{k+1} = F x_k` has
:math:`|h x_k - h p_k| \le c e_k` with :math:`c = \max_i \sqrt{h P_i^{-1} h^\top}`, and
:math:`|h x_k| \le c \rho^{k-n} (|p_n|_q + e_n)` for k >= n.

*Proof.* d = x - p moves by F and is pushed by F p_k - p_{k+1}. A plant is constant, so
its norm is the same at all ticks, and the triangle inequality gives :math:`|d_k|_q \le
e_k`. :math:`|h d| \le \sqrt{h P^{-1} h^\top} |d|_q`, and h P^-1 h' is convex in P. []

So what differs from plant to plant as a polynomial is no error. The loop is one, too,
by Taylor's formula (`SampledFamily.expansion`): how much its highest derivatives differ
in the cell is an error, and what they are in the middle is not.

**Which numbers are balls, and which are floats.** Loops, P and c are balls.
The p_k are whatever floats the recursion makes, and delta_k is bounded afterwards: a
sum of n products of floats, in any order, is off by at most n u / (1 - n u) times the
sum of their sizes, u = 2^-53 (Higham, Accuracy and Stability of Numerical Algorithms,
section 3.1). `_gamma` is more, by what subtractions and conversions need; ``TINY`` is
more than what underflows. Bounds are sums and products of positive floats, fewer than
1e6 in a row, and ``SAFE`` holds their roundings.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations_with_replacement as choices
from itertools import product as cartesian

import numpy as np
from flint import arb

from ..exact.rational import exact
from ..sampled.balls import balls, balls_of, middle, product, solve
from ..sampled.cells import least_pivot, size
from ..sampled.loops import over

SAFE = 1 + 1e-9
TINY = 1e-150
BLOCK = 64  # ticks at once, a power of two
TICKS = 256  # whose errors are bounded at once
ABOVE = 1 + 1e-6  # of the largest eigenvalue of a P, which balls then confirm
EXPANDED = (0, 4, 3)  # the degree of the loops, likewise; of more, 2
DEGREES = (0, 7, 3, 2, 2)  # of the polynomials, by the number of axes; of more, 1


@dataclass(frozen=True, eq=False)
class Tube:
    """The motions of a cell of some ``joined`` loops, whose inputs are at tick 0.

    ``weights``: of its corners; ``L``, ``P``: |L x| by the mean of the P, one for each
    corner, falls by ``rho`` a tick; the three are rationals.
    """

    joined: object
    weights: np.ndarray
    L: np.ndarray
    P: np.ndarray
    rho: float

    @cached_property
    def frame(self):
        """The coordinates of everything below, in floats: P is near one in them."""
        root = np.linalg.cholesky(self.P.astype(float).mean(axis=0)).T
        return root @ self.L.astype(float)

    @cached_property
    def matrices(self):
        """P of each corner in the frame, in balls."""
        back = over(balls(self.L), balls_of(self.frame))
        return [product(back.T, balls(x), back) for x in self.P]

    @cached_property
    def longest(self):
        """A number above |v|_q for |v| = 1."""
        found, one = [], np.eye(len(self.L), dtype=int)
        for x in self.matrices:
            most = arb(ABOVE * np.linalg.eigvalsh(middle(x))[-1])
            found.append(most if least_pivot(most * one - x) > 0 else size(x))
        return max(float(x.sqrt().upper()) for x in found)

    @cached_property
    def points(self):
        """q of each corner: at the ends of a box's axes, or a simplex's weights less
        their means, without the last one.
        """
        many, axes = len(self.weights), self.joined.family.shape.axes
        if axes or many == 2:
            return np.array(list(cartesian((-1.0, 1.0), repeat=axes or 1)))
        return np.eye(many)[:, :-1] - 1 / many

    @cached_property
    def exponents(self):
        """Of the monomials of p, by degree: tuples."""
        axes = self.points.shape[1]
        degree = DEGREES[axes] if axes < len(DEGREES) else 1
        several = [some for d in range(degree + 1) for some in choices(range(axes), d)]
        return [tuple(map(some.count, range(axes))) for some in several]

    @cached_property
    def at_corners(self):
        """(corners, monomials): what each one is there."""
        powers = self.points[:, None, :] ** np.array(self.exponents, int)[None]
        return np.prod(powers, axis=2)

    @cached_property
    def bent(self):
        """How far each monomial is from the mixture of what it is at the corners.

        In a box that is the product of the q whose exponents are odd: off by 1 at most,
        and not at all where no exponent is above 1. In a simplex both are below the
        monomial's largest size.
        """
        e = np.array(self.exponents, int)
        if 2 ** e.shape[1] == len(self.points):
            return (e.max(axis=1, initial=0) > 1).astype(float)
        return 2 * self.largest(self.exponents) * (e.sum(axis=1) > 1)

    def largest(self, exponents):
        """(count,) largest sizes of monomials with these ``exponents`` in the cell."""
        most = abs(self.points).max(axis=0, initial=0.0)
        return np.array([np.prod(most ** np.array(e)) for e in exponents])

    @cached_property
    def pieces(self):
        """The loop with its inputs as a polynomial, {exponents: matrix}, what its
        entries are off by at most, and how much it bends along each axis.
        """
        family, timing = self.joined.family, self.joined.controller.timing
        N, axes = len(self.frame), self.points.shape[1]
        wide = np.eye(N + self.joined.inputs)
        wide[:N, :N] = self.frame
        wide = balls_of(wide)
        degree = EXPANDED[axes] if axes < len(EXPANDED) else 2
        found = family.expansion(self.weights, degree, wide, timing)
        floats = {e: middle(F) for e, F in found.items()}
        off = 0 * wide
        for (e, F), most in zip(found.items(), self.largest(found)):
            off = off + abs(F - balls_of(floats[e])) * arb(most)
        twice = 2 * np.eye(axes, dtype=int)
        return floats, _above(off), [np.linalg.norm(floats[tuple(e)]) for e in twice]

    @cached_property
    def recursion(self):
        """(monomials, N, coefficients and inputs): how the coefficients move, and last
        what leaves the polynomials; the largest sizes of all these monomials.
        """
        floats, _, _ = self.pieces
        N, count, j = len(self.frame), len(self.exponents), self.joined.inputs
        place = {e: k for k, e in enumerate(self.exponents)}
        left = {}
        A = np.zeros((count, N, count * N + j))
        columns = [*zip(self.exponents, np.split(np.arange(count * N), count))]
        columns.append((self.exponents[0], np.arange(count * N, count * N + j)))
        for k, (e, at) in enumerate(columns):
            part = slice(0, N) if k < count else slice(N, N + j)
            for g, F in floats.items():
                goal = tuple(a + b for a, b in zip(e, g))
                if goal in place:
                    A[place[goal]][:, at] += F[:N, part]
                else:
                    rest = left.setdefault(goal, np.zeros((N, count * N + j)))
                    rest[:, at] += F[:N, part]
        left, gone = np.array([*left.values()]).reshape(-1, N, count * N + j), [*left]
        return np.concatenate([A, left]), self.largest([*self.exponents, *gone])

    def motion(self, first=None, away=0.0, column=None, ticks=1):
        """The `Motion` over ``ticks`` from within ``away`` of a polynomial, ``first``,
        (monomials, N); or from zero, where the input of a ``column`` is one at tick 0.
        """
        A, _ = self.recursion
        count, (N, j) = len(self.exponents), (len(self.frame), self.joined.inputs)
        X = np.zeros((ticks + 1, count * N + j))
        e = np.zeros(ticks + 1)
        if first is None:
            X[0, count * N + column] = 1.0
        else:
            X[0, : count * N], e[0] = first.ravel(), away
        moves = A[:count].reshape(count * N, -1)
        X[1, : count * N] = moves @ X[0]
        moves = moves[:, : count * N].T
        done, reach = 1, moves
        while done < ticks:  # as many at once as there are already, up to BLOCK
            more = min(ticks - done, done, BLOCK)
            first = done + 1 - min(done, BLOCK)
            X[done + 1 : done + 1 + more, : count * N] = (
                X[first : first + more, : count * N] @ reach
            )
            done += more
            reach = reach if done > BLOCK else reach @ reach
        lost = self.defect(X[:-1].T, X[1:, : count * N].T)
        for k, delta in enumerate(lost):
            e[k + 1] = self.rho * e[k] + delta
        return Motion(self, X[:, : count * N].reshape(ticks + 1, count, N), e)

    def solved(self, goal):
        """y with (I - F) y near a ``goal``, polynomials in floats, (monomials, N)."""
        floats, _, _ = self.pieces
        N, zero = len(self.frame), self.exponents[0]
        place = {e: k for k, e in enumerate(self.exponents)}
        one, y = np.eye(N) - floats[zero][:N, :N], np.zeros_like(goal)
        for k, e in enumerate(self.exponents):  # by degree
            right = goal[k]
            for g, F in floats.items():
                rest = tuple(a - b for a, b in zip(e, g))
                if g != zero and rest in place:
                    right = right + F[:N, :N] @ y[place[rest]]
            y[k] = np.linalg.solve(one, right)
        return y

    def rest(self, x=None):
        """(y, away): where the first input being one holds the loop at rest, a
        polynomial in floats, to within ``away`` in the norm: x, (N, 1), where that is
        known in rationals, else at most |F y + G - y| / (1 - rho) from there.
        """
        floats, _, _ = self.pieces
        N, j = len(self.frame), self.joined.inputs
        if x is not None:
            y, whole = (
                np.zeros((len(self.exponents), N)),
                balls_of(self.frame) @ balls(x),
            )
            y[0] = middle(whole)[:, 0]
            off = np.linalg.norm(_above(whole[:, 0] - balls_of(y[0])))
            return y, self.longest * off + TINY
        push = [
            floats[e][:N, N] if e in floats else np.zeros(N) for e in self.exponents
        ]
        y = self.solved(np.array(push))
        now = np.concatenate([y.ravel(), np.eye(j)[0]])
        lost = self.defect(now[:, None], y.ravel()[:, None])[0]
        return y, lost / (1 - self.rho) * SAFE

    def seen_by(self, row):
        """(h, doubt, c) of a ``row``, (N,) in rationals: it is h in the frame, each
        entry but for the doubt, and |h x| is at most c |x|_q.
        """
        g = solve(balls_of(self.frame).T, balls(exact(row)[:, None]))
        worst = max((g.T @ solve(P, g))[0, 0].upper() for P in self.matrices)
        h = middle(g)[:, 0]
        doubt = _above(g - balls_of(h[:, None]))[:, 0]
        return h, doubt, float(arb(worst).sqrt().upper())

    def defect(self, now, then):
        """(k,) bounds of |F p + G i - p'|_q for polynomials p and p': the columns of
        ``now``, (coefficients and inputs, k), and ``then``, (coefficients, k).
        """
        A, sizes = self.recursion
        count, N = len(self.exponents), len(self.frame)
        off, flat, lost = self.pieces[1][:N], A.reshape(-1, A.shape[2]), []
        gamma, k = _gamma(A.shape[2]), count * N
        wide = sizes @ np.linalg.norm(A, axis=(1, 2))  # by Cauchy and Schwarz

        def lengths(x):
            return _norms(x.reshape(-1, N, x.shape[1]), "ijk,ijk->ik")

        for j in range(0, now.shape[1], TICKS):  # as many as a processor's cache holds
            some, goal = now[:, j : j + TICKS], then[:, j : j + TICKS]
            left = flat @ some
            left[:k] -= goal
            doubt = wide * _norms(some, "jk,jk->k") + sizes[:count] @ lengths(goal)
            whole = abs(some)
            push, whole = whole[k:], whole[:k].reshape(count, -1)
            whole = np.vstack([(sizes[:count] @ whole).reshape(N, -1), push])
            lost.append(sizes @ lengths(left) + gamma * doubt)
            lost[-1] += _norms(off @ whole, "jk,jk->k")
        return self.longest * np.concatenate(lost) + TINY

    def halves(self):
        """The two halves, cut where the loop bends most."""
        shape = self.joined.family.shape
        if shape.axes:
            cut = int(np.argmax(self.pieces[2]))
        else:
            floats, _, _ = self.pieces
            one = np.eye(self.points.shape[1], dtype=int)
            ends = [*(floats[tuple(e)] for e in one), 0 * floats[tuple(0 * one[0])]]
            far = np.array([[np.linalg.norm(a - b) for a in ends] for b in ends])
            cut = tuple(int(x) for x in np.unravel_index(far.argmax(), far.shape))
        several = zip(shape.halves(self.weights, cut), shape.halves(self.P, cut))
        return [replace(self, weights=w, P=P) for w, P in several]


@dataclass(frozen=True, eq=False)
class Motion:
    """The motions of a `Tube`: ``X``, (ticks, monomials, N), the polynomials in floats;
    ``e``, (ticks,): the theorem's.
    """

    tube: Tube
    X: np.ndarray
    e: np.ndarray

    @cached_property
    def lengths(self):
        """(ticks,) more than |x| of any plant."""
        tube = self.tube
        sizes = tube.largest(tube.exponents)
        return _norms(self.X, "ijk,ijk->ij") @ sizes

    def seen(self, row):
        """(near, off, tail) of ``row``, (N,) in rationals, times x.

        h x is no further than ``off``, (ticks,), from the mixture of ``near``, (ticks,
        corners); from the last tick on |h x| is at most ``tail``, and
        falls by rho.
        """
        tube, count = self.tube, self.X.shape[1]
        h, doubt, c = tube.seen_by(row)
        Y = self.X @ h
        doubt = np.linalg.norm(_gamma(len(h) + count) * abs(h) + doubt)
        off = abs(Y) @ tube.bent + doubt * self.lengths + c * self.e
        tail = c * (tube.longest * self.lengths[-1] + self.e[-1])
        return Y @ tube.at_corners.T, (off + TINY) * SAFE, tail * SAFE


def _norms(x, axes):
    """Euclidean norms of x, whose ``axes`` are those of a sum of squares, for einsum.

    A number below 1e-150 has no square, and ``TINY`` is more than it.
    """
    return np.sqrt(np.einsum(axes, x, x))


def _gamma(n):
    """More than a sum of n products is off by, and some roundings beside it."""
    return 1.01 * (n + 9) * 2.0**-53


def _above(x):
    """Upper bounds of the sizes of some balls, but for a rounding, as floats."""
    return np.array([float(e.abs_upper()) for e in x.flat]).reshape(x.shape)
