"""Quadratic inequalities of a controller's loop, proven for every plant in balls.

The loop is that of a sampled controller to which inputs are joined: F holds [x; i] to
[x; 0], with columns for what i does. What is proven of a cell of plants is
F' P F < R for given P and R, with the corners' loops and a bound of what the others
differ from their mixtures, as in `sosbook.sampled.cells`.
"""

from dataclasses import dataclass
from functools import cached_property, wraps

import numpy as np
from flint import ctx

from ..exact.definite import exact
from ..runtime.threads import one_thread
from ..sampled.balls import balls, middle, solve
from ..sampled.cells import PlantCell, least_pivot, less_grams
from ..sampled.loops import BALL_BITS, SampledFamily
from ..sampled.system import SampledSystem
from ..sampled.timing import TimeBox


class _Exactly(SampledSystem):
    """One in rationals, none of which is rounded."""

    def __post_init__(self):
        """Leave the matrices as they are."""


def unrounded(A, B, C, D, T):
    """The `SampledSystem` of ``A``, ``B``, ``C``, ``D`` in rationals, none of which is
    rounded, every ``T`` s.
    """
    return _Exactly(A, B, C, D, T)


@dataclass(frozen=True, eq=False)
class Joined:
    """The loops of a ``controller`` with k inputs on its memory by ``own``, (l, k), and
    on u by ``direct``, (m, k), decimals; a share ``less`` of u is taken away.
    """

    controller: object
    own: np.ndarray
    direct: np.ndarray
    less: object = 0

    @cached_property
    def family(self):
        """The loops in balls; with inputs as states that are zero at the next tick."""
        c, k = self.controller, self.own.shape[1]
        W, C = exact(c.W), exact(c.C)
        B, D = (exact(M) @ exact(c.readings.rows) for M in (c.B, c.D))
        A, B = exact(c.A) - self.less * W @ C, B - self.less * W @ D
        zeros = np.zeros((k, len(A) + k + B.shape[1]))
        rows = np.vstack([np.hstack([A, exact(self.own), B]), exact(zeros)])
        A, B = np.split(rows, [len(A) + k], axis=1)
        C = np.hstack([(1 - self.less) * C, exact(self.direct)])
        wide = unrounded(A, B, C, (1 - self.less) * D, c.T)
        return SampledFamily.of(c.plant, c.vertices, c.timing, wide)

    @property
    def inputs(self):
        """How many inputs are joined."""
        return self.own.shape[1]

    def cell(self, weights, L):
        """The `JoinedCell` of corners with these ``weights``, in L [x; i]."""
        c = self.controller
        return JoinedCell(
            self, PlantCell(self.family, weights, L, TimeBox.only(c.timing))
        )

    def middle(self, weights):
        """The loop of the mean of corners with these ``weights``, in floats."""
        mean = weights.sum(axis=0) / len(weights)
        return middle(self.family.loop(mean, self.controller.timing))


@dataclass(frozen=True, eq=False)
class JoinedCell:
    """A cell of plants of some ``joined`` loops; ``cell`` is that of `sampled`."""

    joined: Joined
    cell: PlantCell

    @cached_property
    def parts(self):
        """L, the corners' L F L^-1, and a bound of D'D (None where it is zero)."""
        box = self.cell.clocks
        (loops,), (bent,) = self.cell.loops(box), self.cell.bent(box)
        return self.cell.turn @ balls(self.cell.L), loops, bent

    def least(self, R):
        """A positive number if F'PF < R, in balls, in the whole cell, P = L'L."""
        try:
            L, loops, bent = self.parts
        except ZeroDivisionError:
            return -np.inf
        right = solve(L.T, solve(L.T, R).T)
        return min(map(least_pivot, less_grams(right, loops, bent)))


def work(function):
    """The function, with the precision of balls around it, and one thread."""

    @one_thread
    @wraps(function)
    def inside(*arguments, **named):
        with ctx.workprec(BALL_BITS):
            return function(*arguments, **named)

    return inside
