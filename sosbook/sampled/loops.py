"""The sampled loops of a family of plants, enclosed in balls."""

from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import sha256
from math import prod

import numpy as np
from flint import arb, arb_mat, ctx

from ..exact.definite import exact
from . import series as power
from .balls import (
    balls,
    balls_of,
    entries,
    exponential,
    hull,
    middle,
    product,
    series,
    solve,
)
from .channel import with_channel
from .discretize import generators
from .shapes import PlantShape

__all__ = ["BALL_BITS", "SampledFamily", "key_of", "over", "within"]

BALL_BITS = 128  # of the balls' midpoints; a double has 53
NARROWINGS = 3  # of the balls around E^-1 A; more of them gain nothing


@dataclass(frozen=True, eq=False)
class SampledFamily:
    """The sampled loops of all plants of a ``shape``, in balls.

    ``full`` and ``own`` are the maps of `SampleTiming.feedback`; the ``centre`` times
    the identity is taken away from each loop; ``held``: how many disturbances w, held
    over a tick, and outputs z, in units of a bound, are joined: the loop leads from
    [state; w] to [next state; z] then; ``known`` holds what was found of equal ones.
    """

    shape: PlantShape
    full: np.ndarray  # from [x; older; own] to [x; older; u(k)]
    own: np.ndarray  # and to own(k + 1): see `SampleTiming.feedback`
    centre: float = 0.0
    held: int = 0
    known: dict = field(default_factory=dict)  # loops, bends and pivots

    @classmethod
    def of(cls, plant, vertices, timing, K, centre=0.0, norm=None):
        """The loops of a gain or controller K with the ``vertices`` of a plant.

        The ``timing``, a `SampleTiming`, is what K is made for; the ``centre`` is that
        of the class; ``norm``: a bound of H-infinity whose channel is joined.
        """
        maps, held = timing.feedback(K, vertices[0], exact), 0
        if norm is not None:
            read = timing.read(K, vertices[0])
            *maps, vertices, held = with_channel(norm, vertices, *maps, read)
        shape = PlantShape.of(plant, vertices)
        numbers = [x for pair in shape.corners for x in pair]
        whole = timing.whole_samples, shape.axes, ctx.prec, centre, held
        known = _known(whole, tuple(map(key_of, (*maps, *numbers))))
        return cls(shape, *map(balls, maps), centre, held, known)

    def remember(self, key, make):
        """The first result of ``make()`` that was stored by a key."""
        if key not in self.known:
            self.known[key] = make()
        return self.known[key]

    def loop(self, weights, timing):
        """The loop matrix of one mixture, by its weights, with a timing.

        Its balls have a tiny radius.
        """
        key = key_of(weights), timing  # neighbouring cells share corners
        return self.remember(key, lambda: self._loop(weights, timing))

    def _loop(self, weights, timing):
        E, both = self.shape.mixed(weights)
        step = self._flow([solve(balls(E), balls(both))], timing)
        older = timing.shift_register(self.shape.N, self.shape.m - self.held)
        older = np.hstack([older, np.zeros((len(older), self.held))])
        moved = np.vstack([product(step, self._picked(timing)), balls(older)])
        moved = product(moved, self.full)
        loop = np.vstack([moved, self.own])
        if self.centre:
            loop = loop - arb(exact(self.centre)) * np.eye(len(loop), dtype=int)
        return loop

    def _picked(self, timing):
        N, m, k = self.shape.N, self.shape.m - self.held, self.held
        S = timing.selector(N, m)
        if k:  # [x; first; w; second; w]
            w = np.eye(k, S.shape[1] + k, S.shape[1])
            S = np.hstack([S, np.zeros((len(S), k))])
            inputs = np.split(S[N:], len(timing.acting))
            S = np.vstack([S[:N], *(x for some in inputs for x in (some, w))])
        return balls(S)

    def bends(self, weights, last, L, timing):
        """The second derivatives of L F L^-1 along the edges of a cell of plants.

        The ``weights`` are its corners, the ``timing`` is a `SampleTiming`. In a
        simplex, with edges d_j from its corner ``last``, F - sum w_i F_i is a sum of
        second derivatives H_jk along d_j and d_k, at many points, which are weighed
        by sum_i w_i |v_ij| |v_ik| / 2, where v_i is what leads to corner i, and these
        sums don't exceed a quarter. In a box it is a sum of the H_kk, one axis after
        the other, which are weighed by an eighth at most. With E X = A the
        derivatives are E X_j = A_j - E_j X and E X_jk = - E_j X_k - E_k X_j.

        Returns list of (int, array): how often each counts, and balls that hold it at
        every point.
        """
        corners, out, inner = self._framed(weights, L, timing)
        E, X, edges = self._solved(corners, last)
        bends = []
        for j, (E1, X1) in enumerate(edges):
            others = edges[j : j + 1] if self.shape.axes else edges[: j + 1]
            for E2, X2 in others:
                X12 = solve(E, -(E1 @ X2 + E2 @ X1))
                bend = self._flow([X, X1, X2, X12], timing) @ inner
                bends.append((1 if X1 is X2 else 2, out @ bend))
        return bends

    def expansion(self, weights, degree, L, timing):
        """L F L^-1 of a cell of plants as a polynomial: {exponents: balls}.

        The ``weights`` are its corners, the ``timing`` is a `SampleTiming`, and the
        unknowns are those of `series.parts`. By Taylor's formula around the middle
        of the cell, the terms of ``degree`` are balls, which hold what the derivatives
        are at any point; the others are those of the middle, and tiny.
        """
        corners, out, inner = self._framed(weights, L, timing)
        box, X, found = bool(self.shape.axes) or len(corners) == 2, None, {}
        for whole in (False, True):
            E, both = (power.parts(x, box, whole) for x in zip(*corners))
            X = self._narrowed(E, both, degree, X, box)
            flow = self._flows(X, degree, timing)
            some = {e: M for e, M in flow.items() if not whole or sum(e) == degree}
            found |= {e: out @ entries(M) @ inner for e, M in some.items()}
        mean = sum(weights) / len(weights)
        found[(0,) * len(next(iter(found)))] = within(self.loop(mean, timing), L)
        return found

    def _narrowed(self, E, both, degree, centre, box):
        """The series of E X = A around all points, from that around the ``centre``; or
        that one, where ``centre`` is None.
        """
        found = power.quotient(E, both, degree)
        if centre is None:
            return found
        axes = len(next(iter(E)))
        low, high = (-1, 1) if box else (arb(-1) / (axes + 1), arb(axes) / (axes + 1))
        ends, one = arb(low).union(arb(high)), arb(1)
        for _ in range(NARROWINGS):
            terms = {e: found[e] if sum(e) == degree else M for e, M in centre.items()}
            first = sum(
                (M * prod([ends] * sum(e), start=one) for e, M in terms.items()),
                0 * found[(0,) * axes],
            )
            found = power.quotient(E, both, degree, first)
        return found

    def _flows(self, X, degree, timing):
        """As `_flow`, of a series of [A B], {exponents: arb_mat}."""
        N, flow = self.shape.N, None
        exponential = power.moved if timing.steps else power.exponential
        several = {e: timing.segments(*self._parts(entries(M))) for e, M in X.items()}
        for pieces in zip(*several.values()):
            step = {
                e: arb_mat(*M.shape, balls(M).ravel().tolist()) * arb(exact(t))
                for e, (M, t) in zip(several, pieces)
            }
            step = exponential(step, degree)
            flow = step if flow is None else power.times(step, flow, degree)
        rows = next(iter(flow.values())).ncols()
        first = arb_mat(N, rows, np.eye(N, rows, dtype=int).ravel().tolist())
        return {e: first * M for e, M in flow.items()}

    def _edges(self, corners, last):
        """The changes of E and [A B] along each edge of a cell, or axis, in balls."""
        if not self.shape.axes:
            rest = [c for k, c in enumerate(corners) if k != last]
            return [[x - y for x, y in zip(c, corners[last])] for c in rest]
        stacks = [np.array(x, object) for x in zip(*corners)]
        edges = []
        for axis in range(self.shape.axes):
            ends = [self.shape.along(x, axis) for x in stacks]
            edges.append([hull((y - x).reshape(-1, *x.shape[-2:])) for x, y in ends])
        return edges

    def _solved(self, corners, last):
        """E, X = E^-1 [A B] and (E_j, X_j) along the edges, in a cell, in balls.

        By the mean value theorem X differs from what it is in the middle by the
        X_j times the way to it; with X the X_j become narrower, too.
        """
        E, both = (hull(x) for x in zip(*corners))
        middles = (sum(x) / len(x) for x in zip(*corners))
        centre, X = solve(*middles), solve(E, both)
        edges = self._edges(corners, last)
        share = 2 if self.shape.axes else len(corners)
        way = arb(-1).union(arb(share - 1)) / share  # of a weight, from the middle
        for _ in range(NARROWINGS):
            slopes = [solve(E, A1 - E1 @ X) for E1, A1 in edges]
            X = centre + sum(way * X1 for X1 in slopes)
        return E, X, [(E1, X1) for (E1, _), X1 in zip(edges, slopes)]

    def _framed(self, weights, L, timing):
        """A cell's corners for R x, and what leads from R x to L F and into [R x; u].

        With L = Q R on the plant's states, Q orthonormal: there loops that contract
        are short, and balls of matrices grow less. E is near one there.
        """
        N = self.shape.N
        corners = [self.shape.mixed(w) for w in weights]
        R = np.linalg.qr(middle(L[:, :N]))[1]
        E = sum(E for E, _ in corners).astype(float) / len(corners)
        try:
            rows = balls_of(R @ np.linalg.inv(E))
        except np.linalg.LinAlgError:  # so the hull holds a singular E
            raise ZeroDivisionError from None
        R = balls_of(R)
        framed = []
        for E, both in corners:
            E, both = rows @ balls(E), rows @ balls(both)
            framed.append((over(E, R), np.hstack([over(both[:, :N], R), both[:, N:]])))
        inner = over(product(self._picked(timing), self.full), L)
        inner[:N] = product(R, inner[:N])
        return framed, over(L[:, :N], R), inner

    def time_bends(self, weights, L, box):
        """The second derivatives of L F L^-1 in a ``box`` of clocks, as of `bends`.

        Along T and along the delay, in the cell of plants with some ``weights``.
        """
        if not box.cuts:
            return self._age_bends(weights, L, box)
        corners, out, inner = self._framed(weights, L, box.corners[0])
        _, X, _ = self._solved(corners, 0)
        first, second = generators(*self._parts(X))
        T, late = (arb(low).union(arb(high)) for low, high in (box.T, box.late))
        before = exponential(first * late) @ inner if box.shared else inner
        after, bends = exponential(second * (T - late if box.shared else T)), []
        for name, (low, high) in (("T", box.T), ("delay", box.late)):
            if low == high:
                continue
            change = second @ second
            if name == "delay":
                turn = second - first
                change = second @ turn - turn @ first
            bend = (after @ (change @ before))[: self.shape.N] * arb(high - low) ** 2
            bends.append((1, out @ bend))
        return bends

    def _age_bends(self, weights, L, box):
        """As `time_bends`, in a `ManyTicks`."""
        corners, out, inner = self._framed(weights, L, box.whole)
        A, B = self._parts(self._solved(corners, 0)[1])
        T, h = arb(0).union(arb(box.T[0])), max(b - a for a, b in box.pieces)
        slope = out @ A @ exponential(A * T) @ B * arb(h) ** 2
        rows = np.split(inner[self.shape.N :], box.oldest + 1)
        return [(1, slope @ (x - y)) for x, y in zip(rows, rows[1:])]

    def _parts(self, both):
        return both[:, : self.shape.N], both[:, self.shape.N :]

    def _flow(self, terms, timing):
        """The last term of the series of x and what is acting to next x."""
        N, flow = self.shape.N, None
        pieces = zip(*(timing.segments(*self._parts(x)) for x in terms))
        for piece in pieces:
            span = balls(np.array([piece[0][1]]))[0]
            step = series([M for M, _ in piece]) * span
            one = np.eye(len(step), dtype=int)
            step = one + step if timing.steps else exponential(step)
            # its last columns, of which the first rows are wanted
            flow = step[:, -len(piece[0][0]) :] if flow is None else step @ flow
        return flow[:N]


def key_of(matrix):
    """A digest of the shape and the numbers of a matrix, to find it again."""
    text = f"{matrix.shape} {matrix.ravel().tolist()}"
    return sha256(text.encode()).digest()


@lru_cache(maxsize=2)
def _known(*_):
    """The results known of a family: a proof is looked at as soon as it is made."""
    return {}


def over(F, L):
    """F L^-1, of balls; ZeroDivisionError unless L is proven to be regular."""
    return solve(L.T, F.T).T


def within(F, L):
    """L F L^-1, as `over`."""
    return over(product(L, F), L)
