"""The plants of a known gain, as points and as cells that are halved."""

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import comb
from typing import Any

import numpy as np
from flint import fmpq

from ..exact.rational import exact
from ..plants.bernstein import means
from ..plants.descriptor import combined
from ..plants.simplex import halves
from ..requirements.known_gain import KnownLoop
from ..runtime.read_only import ReadOnly

__all__ = ["Cell"]

MOST_PARAMETERS = 8  # of a box of vertices; it has 256 corners


@dataclass(frozen=True, eq=False)
class Cell(ReadOnly):
    """A part of a ``family`` of loops: the hull of some of them holds it. ``place``
    holds its corners in the family's own terms.
    """

    family: Any
    place: Any

    @cached_property
    def loops(self):
        """The loops whose hull holds the cell, in rationals."""
        return self.family.loops_of(self.place)

    @cached_property
    def means(self):
        """Its loops that repeat or are means of others, as `means` has them."""
        if len(self.loops) < 3:
            return {}
        rows = [np.concatenate([x.ravel() for x in y.matrices]) for y in self.loops]
        return means(np.array(rows))

    def way(self, T, rate, noisy):
        """The edge or the axis that moves the loop most, in x = ``T`` xi and units of
        the ``rate``, rad/s; ``noisy``: whether it counts how B_w moves, too.
        """
        ways = self.family.ways(self.place)
        moved = [_moved(T, rate, noisy, *ends) for _, ends in ways]
        return ways[int(np.argmax(moved))][0]

    def cut(self, way):
        """Two cells that cover it, cut in the middle of a ``way``, edge or axis."""
        return [Cell(self.family, part) for part in self.family.cut(self.place, way)]

    @property
    def words(self):
        """Where it lies, in words."""
        return self.family.place_words(self.place)


def _moved(T, rate, noisy, *ends):
    """How far E^-1 A moves between two loops, in units of the rate, and E^-1 B."""
    quotients = []
    for loop in ends:
        E, A, B, *_ = loop.in_floats
        solved = np.linalg.solve(E @ T, np.hstack([A @ T, B]))
        quotients.append((solved[:, : len(T)], solved[:, len(T) :]))
    (A, B), (A2, B2) = quotients
    far = np.linalg.norm(A2 - A, 2) / rate
    size = np.linalg.norm(B, 2) + np.linalg.norm(B2, 2) if noisy else 0.0
    return far + (np.linalg.norm(B2 - B, 2) / size if size else 0.0)


class Mixtures:
    """All mixtures of some ``loops``, the vertices; a cell is a simplex of weights."""

    def __init__(self, loops):
        self.loops = loops
        self.dimension = len(loops)
        self.whole = Cell(self, exact(np.eye(len(loops))))

    def points(self):
        """Weights, one a row, from which the worst plant is sought."""
        corners = np.eye(self.dimension)
        middles = [(a + b) / 2 for k, a in enumerate(corners) for b in corners[:k]]
        return corners, middles

    def inside(self, point):
        """The nearest point of the family, roughly."""
        weights = np.maximum(point, 0)
        return weights / (weights.sum() or 1.0)

    def random(self, rng, count):
        """So many random points of a generator."""
        return rng.dirichlet(np.full(self.dimension, 0.5), count)

    def rounded(self, point, digits):
        """A point in rationals near it: shares of whole numbers, none negative."""
        parts = [round(w * 10**digits) for w in point]
        k = int(np.argmax(point))
        parts[k] = max(parts[k], 1)
        return [fmpq(part, sum(parts)) for part in parts]

    def exactly(self, point):
        """A point of the search in rationals, as `at` takes it."""
        return [exact(float(x)) for x in point]

    def at(self, weights):
        """The loop of rational weights."""
        first, *others = self.loops
        return first.mixed(others, weights)

    def near(self, point):
        """The plant at a point of the search, in floats."""
        plant, rows = self._spread
        mixed, k = self.shares(point) @ rows, 0

        def cut(x):
            nonlocal k
            if x.ndim == 2:
                return x
            k += x[0].size
            return mixed[k - x[0].size : k].reshape(x[0].shape)

        return plant.map(cut)

    @cached_property
    def _spread(self):
        """The plants of the vertices in floats, each of their matrices in a stack, and
        all that differs in a row for each vertex.
        """
        loops = [x.plant_in_floats for x in self.whole.loops]
        plant, rows = combined(loops, np.stack), []
        plant.map(lambda x: x if x.ndim == 2 else rows.append(x.reshape(len(x), -1)))
        return plant, np.hstack(rows)

    def shares(self, point):
        """Of the vertices, at a point of the search."""
        return point

    def loops_of(self, corners):
        """See `Cell.loops`."""
        return [self.at(list(row)) for row in corners]

    def nearer(self, place, loops, k):
        """By way, loops that halves have in the place of loop k; none for a plant."""
        return {}

    def point(self, corners, k):
        """Where the plant is that is loop k of a cell."""
        return list(corners[k])

    def ways(self, corners):
        """The edges, with the loops at their ends."""
        loops = self.loops_of(corners)
        return [
            ((i, j), (loops[i], loops[j])) for i in range(len(loops)) for j in range(i)
        ]

    def cut(self, corners, edge):
        """Two simplices, cut in the middle of an edge."""
        far = np.zeros((len(corners), len(corners)))
        far[edge] = 1.0
        return halves(corners, far)

    def point_words(self, weights):
        """A point in words."""
        if len(weights) == 1:
            return "the plant"
        for k, w in enumerate(weights):
            if w == 1:
                return f"the vertex {k + 1}"
        return f"the plant with the weights {', '.join(map(str, weights))}"

    def place_words(self, corners):
        """A cell in words."""
        if len(corners) == 1:
            return "the plant"
        if (corners == np.eye(len(corners), dtype=int)).all():
            return "the whole polytope"
        rows = "; ".join(", ".join(map(str, row)) for row in corners)
        return f"the plants between those with the weights {rows}"


class Box(Mixtures):
    """Loops that are multi-affine in parameters from 0 to 1; a cell is a box of them.
    ``corners`` has the `KnownLoop` of each corner, by its zeros and ones, ``order`` the
    corner of each vertex of the polytope.
    """

    def __init__(self, corners, order):
        self.corners, self.order = corners, order
        self.dimension = len(order[0])
        zero, one = [fmpq(0)] * self.dimension, [fmpq(1)] * self.dimension
        self.whole, self.degrees = Cell(self, (zero, one)), (1,) * self.dimension

    def shares(self, point):
        """Of the vertices, at a point of the search: Bernstein's polynomials."""
        shares = np.ones(1)
        for t, d in zip(point, self.degrees):
            k, counts = np.arange(d + 1), [comb(d, i) for i in range(d + 1)]
            one = counts * t**k * (1 - t) ** (d - k)
            shares = np.outer(shares, one).ravel()
        return shares

    @property
    def straight(self):
        """True if each corner is the sum of the changes along its parameters."""
        data = {
            corner: np.concatenate([x.ravel() for x in loop.matrices])
            for corner, loop in self.corners.items()
        }
        first = data[min(data)]
        edges = [data[corner] - first for corner in sorted(data) if sum(corner) == 1]
        return all(
            (data[c] == first + sum(e * t for e, t in zip(edges, c[::-1]))).all()
            for c in data
        )

    def points(self):
        """The corners, and what lies halfway unless there are many parameters."""
        steps = (0, 0.5, 1) if self.dimension < 5 else (0, 1)
        points = np.array(list(product(steps, repeat=self.dimension)), float)
        between = (points == 0.5).any(axis=1)
        return points[~between], points[between]

    def inside(self, point):
        """The nearest point of the box."""
        return np.clip(point, 0, 1)

    def random(self, rng, count):
        """So many random points of a generator."""
        return rng.random((count, self.dimension))

    def rounded(self, point, digits):
        """A point in rationals with so many decimals."""
        return [fmpq(round(x * 10**digits), 10**digits) for x in point]

    def weights(self, point):
        """Of the polytope's vertices, at a point."""
        weights = []
        for corner in self.order:
            w = fmpq(1)
            for t, end in zip(point, corner):
                w *= t if end else 1 - t
            weights.append(w)
        return weights

    def at(self, point):
        """The loop of a rational point."""
        first, *others = (self.corners[c] for c in self.order)
        return first.mixed(others, self.weights(point))

    def point(self, ends, k):
        """As for `Mixtures`."""
        return list(list(product(*zip(*ends)))[k])

    def loops_of(self, ends):
        """See `Cell.loops`."""
        return [self.at(list(corner)) for corner in product(*zip(*ends))]

    def ways(self, ends):
        """The parameters, with the loops at their ends and the others halfway."""
        low, high = ends
        middle = [(a + b) / 2 for a, b in zip(low, high)]
        ways = []
        for k in range(self.dimension):
            two = [list(middle), list(middle)]
            two[0][k], two[1][k] = low[k], high[k]
            ways.append((k, tuple(map(self.at, two))))
        return ways

    def cut(self, ends, k):
        """Two boxes, cut in the middle of a parameter's range."""
        low, high = ends
        middle = (low[k] + high[k]) / 2
        below, above = list(high), list(low)
        below[k] = above[k] = middle
        return [(low, below), (above, high)]

    def point_words(self, point):
        """A point in words."""
        return super().point_words(self.weights(point))

    def place_words(self, ends):
        """A cell in words."""
        if ends == self.whole.place:
            return "the whole polytope"
        corners = product(*zip(*ends))
        rows = "; ".join(", ".join(map(str, self.weights(c))) for c in corners)
        return f"the plants between those with the weights {rows}"


def known_loops(request):
    """The loops of the vertices that differ."""
    K = request.exact_gain
    return [KnownLoop(d, K) for d in request.vertices_in(exact, request.distinct)]


def corners_of_box(loops):
    """Each loop's corner where ``loops`` are a box of four or more, else None."""
    count = len(loops).bit_length() - 1
    if not 1 < count <= MOST_PARAMETERS or len(loops) != 2**count:
        return None
    data = [np.concatenate([x.ravel() for x in loop.matrices]) for loop in loops]
    used = np.flatnonzero(np.any([row != data[0] for row in data], axis=0))
    rows = [tuple((row - data[0])[used]) for row in data]
    scale = np.max(np.abs(np.array(rows, float)), axis=0)
    sizes = [np.linalg.norm(np.array(row, float) / scale) for row in rows]
    reached, edges = {rows[0]: ()}, 0
    for k in np.argsort(sizes):
        if rows[k] in reached:
            continue
        reached = {r: (*corner, 0) for r, corner in reached.items()} | {
            tuple(a + b for a, b in zip(r, rows[k])): (*corner, 1)
            for r, corner in reached.items()
        }
        edges += 1
        if edges > count:
            return None
    if edges != count or not all(row in reached for row in rows):
        return None
    order = [reached[row] for row in rows]
    return order if len(set(order)) == len(loops) else None
