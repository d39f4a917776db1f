"""The plants of a known gain where parameters have ranges: cells are boxes of them."""

from dataclasses import replace

import numpy as np
from flint import fmpq

from ..exact.rational import exact, round_digits
from ..plants.bernstein import spelled
from ..requirements.known_gain import KnownLoop
from .cells import Box, Cell, Mixtures, corners_of_box, known_loops

__all__ = ["family"]


class Ranges(Box):
    """The loops of a ``request`` for an `Uncertain`; a cell is a box of its parameters.
    A point of the search has shares of the ranges, one in rationals values.
    """

    def __init__(self, request):
        self.request, plants = request, request.plant.family
        self.K, self.box = request.exact_gain, plants.box
        self.plants = plants.within(self.box)  # which cells cut, not pieces
        self.dimension = len(self.box.names)
        self.whole = Cell(self, self.plants)
        self.degrees = tuple(map(int, self.plants.degree.values()))

    def exactly(self, point):
        """A point of the search in rationals, as `at` takes it."""
        ends = zip(self.box.low, self.box.high, exact(np.asarray(point, float)))
        return [low + (high - low) * share for low, high, share in ends]

    def rounded(self, point, digits):
        """Values with so many significant digits, in their ranges."""
        values = []
        for x, low, high in zip(self.exactly(point), self.box.low, self.box.high):
            near = exact(float(round_digits(float(x), digits)))
            values.append(min(max(near, low), high))
        return values

    def at(self, values):
        """The loop of rational values."""
        return self._loop(self.plants.exactly_at(values))

    def _loop(self, plant):
        (d,) = self.request.described(plant)
        return KnownLoop(d.map(exact), self.K)

    def loops_of(self, plants):
        """See `Cell.loops`."""
        return [self._loop(v) for v in plants.vertices]

    def _index(self, k):
        """Which of Bernstein's coefficients loop k is, and how many there are."""
        shape = [d + 1 for d in self.degrees]
        return np.array(np.unravel_index(k, shape)), shape

    def nearer(self, plants, loops, k):
        """By each parameter that has no end of its range there: as for `Mixtures`."""
        place, shape = self._index(k)
        beside = {
            axis: [np.ravel_multi_index(place + s * step, shape) for s in (1, -1)]
            for axis, step in enumerate(np.eye(len(shape), dtype=int))
            if 0 < place[axis] < shape[axis] - 1
        }
        return {
            axis: [loops[k].mixed([loops[i]], [fmpq(1, 2)] * 2) for i in several]
            for axis, several in beside.items()
        }

    def point(self, plants, k):
        """As for `Mixtures`."""
        ends = zip(plants.box.low, plants.box.high, self._index(k)[0])
        return [high if i else low for low, high, i in ends]

    def ways(self, plants):
        """The parameters, with the loops at their ends and the others halfway."""
        return super().ways((plants.box.low, plants.box.high))

    def cut(self, plants, k):
        """Two families, cut in the middle of a parameter's range."""
        return plants.halves(self.box.names[k])

    def cornered(self, values):
        """A polytope of the family with the plant of some values as a vertex: which."""
        box, low, high, k = self.box, [], [], 0
        for x, a, b, d in zip(values, box.low, box.high, self.plants.degree.values()):
            low.append(x if x < b else a)
            high.append(b if x < b else x)
            k = (d + 1) * k + (0 if x < b else d)
        part = replace(box, low=tuple(low), high=tuple(high))
        plants = self.plants if part == box else self.plants.within(part)
        return plants.polytope(), int(k)

    def point_words(self, values):
        """A point in words."""
        pairs = (f"{n} = {spelled(x)}" for n, x in zip(self.box.names, values))
        return f"the plant with {', '.join(pairs)}"

    def place_words(self, plants):
        """A cell in words."""
        return f"the plants with {plants.box}"


def family(request):
    """The loops of a ``request`` with a given gain: `Ranges`, a `Box` of vertices or
    `Mixtures`.
    """
    if request.plant.family is not None:
        return Ranges(request)
    loops = known_loops(request)
    order = corners_of_box(loops)
    if order is None:
        return Mixtures(loops)
    return Box(dict(zip(order, loops)), order)
