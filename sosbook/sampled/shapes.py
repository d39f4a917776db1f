"""Which plants there are between some vertices: mixtures, or a box of parameters."""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from flint import fmpq_mat

from ..exact.definite import exact
from ..plants.hull import quotient_in_hull

__all__ = ["PlantShape"]


@dataclass(frozen=True, eq=False)
class PlantShape:
    """Plants E x' = A x + B u between exact corners.

    ``corners``, list of (array, array): E and [A B] of each corner, in rationals;
    ``axes``: 0: the plants are all mixtures of the corners. p: they are the plants of a
    box with p parameters and 2^p corners, the last parameter first, and affine in each
    parameter; ``order``: the vertex of the plant at each corner; ``N``, ``m``: how many
    states and inputs there are.
    """

    corners: list
    axes: int
    order: list
    N: int
    m: int

    @classmethod
    def of(cls, plant, vertices):
        """The shape of a ``plant`` with some `Descriptor` as ``vertices``.

        Corners that are a box are read as one. Where the plants' E^-1 [A B] are
        such mixtures too, the corners have them, and E = I: exponentials bend less
        along them.
        """
        several = [d.map(exact) for d in vertices]
        pairs = [(d.E, np.hstack([d.A, d.Bu])) for d in several]
        order, axes = list(range(len(pairs))), 0
        family = plant.family
        if family and family.multi_affine and len(pairs) == 2 ** len(family.degree):
            axes = len(family.degree)
        elif found := _box([np.hstack(pair) for pair in pairs]):
            order, axes = found, (len(pairs) - 1).bit_length()
        axes = axes if axes > 1 else 0
        pairs = [pairs[k] for k in order]
        if _separable(pairs, axes) if axes else quotient_in_hull(several):
            with suppress(ZeroDivisionError):  # one E, and singular
                pairs = [(exact(np.eye(len(E))), _solved(E, x)) for E, x in pairs]
        return cls(pairs, axes, order, *several[0].Bu.shape)

    def whole(self):
        """The cell of all plants: the corners' weights, a corner of the cell a row."""
        return exact(np.eye(len(self.corners)))

    def mixed(self, weights):
        """E and [A B] of one mixture, by its weights, exactly."""
        pairs = list(zip(weights, self.corners))
        return tuple(sum(w * pair[k] for w, pair in pairs) for k in (0, 1))

    def halves(self, weights, cut):
        """The two halves of a cell with some ``weights``.

        ``cut`` is the axis of a box, or the two corners of a simplex between which
        it is cut.
        """
        first, second = weights.copy(), weights.copy()
        if self.axes:
            low, high = (self.along(x, cut) for x in (first, second))
            low[1] = high[0] = (low[0] + low[1]) / 2
        else:
            i, j = cut
            first[i] = second[j] = (weights[i] + weights[j]) / 2
        return [first, second]

    def checked_cut(self, cut):
        """The ``cut`` of a file, or a ValueError."""
        if self.axes:
            if not (type(cut) is int and cut in range(self.axes)):
                raise ValueError("a box is halved along one of its axes")
            return cut
        i, j = cut
        if i == j or not {i, j} <= set(range(len(self.corners))):
            raise ValueError("halve must name two corners")
        return cut

    def along(self, stack, axis):
        """A view of a stack that belongs to a box's corners: both ends of an axis."""
        box = stack.reshape((2,) * self.axes + stack.shape[1:])
        return np.moveaxis(box, axis, 0)


def _solved(E, both):
    solved = fmpq_mat(E.tolist()).solve(fmpq_mat(both.tolist()))
    return exact(np.array(solved.tolist(), object))


def _box(points):
    """The order of points that makes them the corners of a box; None if they aren't."""
    points = [tuple(x.ravel()) for x in points]
    count = len(points)
    if count < 4 or count & count - 1 or len(set(points)) < count:
        return None
    left = sorted(points)
    reached = [left[0]]
    for point in left:  # the first one that isn't reached ends a change of its own
        if 2 * len(reached) > count or point in reached:
            continue
        change = [a - b for a, b in zip(point, left[0])]
        reached = [
            x for p in reached for x in (p, tuple(a + b for a, b in zip(p, change)))
        ]
    places = {p: k for k, p in enumerate(points)}
    if set(reached) != places.keys():
        return None
    return [places[p] for p in reached]


def _separable(pairs, axes):
    """True if E^-1 [A B] is affine in a parameter of its own for each axis.

    Along an axis that leaves E as it is, it is affine in the parameter. Where all
    changes along an axis are multiples of one column, it moves on a segment, at t r /
    (1 - t + t r) of its length, where det E is r times as large at its end (Sherman
    and Morrison); this is one function of t if all edges have the same r, as det E
    is affine in each parameter.
    """
    wide = np.array([np.hstack(pair) for pair in pairs], object)
    order = wide.shape[1]
    dets = [fmpq_mat(E.tolist()).det() for E, _ in pairs]
    if not (all(d > 0 for d in dets) or all(d < 0 for d in dets)):
        return False
    box, dets = (2,) * axes, np.array(dets, object)
    for axis in range(axes):
        low, high = np.moveaxis(wide.reshape(*box, *wide.shape[1:]), axis, 0)
        changes = np.concatenate((high - low).reshape(-1, *wide.shape[1:]), axis=1)
        moved = (high - low)[..., :order]
        if not any(moved.flat):
            continue
        low, high = np.moveaxis(dets.reshape(box), axis, 0)
        if len(set((high / low).flat)) > 1:
            return False
        if fmpq_mat(changes.tolist()).rank() > 1:
            return False
    return True
