"""A controller of one order is one of the next: its last state does nothing yet.

So a search of order k begins, among others, where that of order k - 1 has ended.
"""

from dataclasses import replace

import numpy as np

from .moving_gain import MovingGain
from .search import search

NUDGE = 0.03  # of a unit: what does nothing has no slope
STARTS = 2  # of each order but the last, besides the end of the one before


class _Part(MovingGain):
    """A `MovingGain` whose free numbers are ``some`` of those of ``whole``; the others
    stay as they are in ``rest``.
    """

    def __init__(self, whole, some, rest):
        super().__init__(whole.plants, whole.measured, whole.noisy, whole.form)
        self.whole, self.some, self.rest = whole, some, rest
        self.directions = whole.directions[some]

    def K(self, kappa):
        return self.whole.K(self.full(kappa))

    def full(self, kappa):
        """The free numbers of the whole."""
        found = self.rest.copy()
        found[self.some] = kappa
        return found


def from_lower_orders(task, loops, free, seed):
    """Free numbers, as `search` takes them near, and how many starts they took: where a
    search of a ``task`` for ``loops`` has ended whose order is one less than ``free``,
    the number of v; none where one has found nothing. ``seed``: of random numbers.
    """
    m, near, count = task.m, (), 0
    entries = [np.argwhere(direction) for direction in loops.directions]
    if free < 2 or not all(len(e) == 1 for e in entries):
        return (), 0
    row, column = np.array([e[0] for e in entries]).T
    q = loops.directions.shape[2] - free
    of = np.maximum(row - m, column - q)  # which state it is about; < 0: none
    own = (row - m == of) & (column - q == of)
    rng, units = np.random.default_rng(seed), loops.units(task.rate)
    idle = task.inside(np.where(own, -task.rate, 0.0))
    for order in range(1, free):
        part = _Part(loops, of < order, idle)
        known = replace(task, ends=task.ends[:, part.some])
        near = tuple(kappa[part.some] for kappa in near)
        found = search(known, part, STARTS, seed, near, turns=0)  # it only begins
        count += found.starts
        if found.kappa is None or found.stopped:
            return (), count
        moved = part.full(found.kappa)
        last = (of == order) & ~own
        moved[last] = (NUDGE * units * rng.choice([-1, 1], len(units)))[last]
        near = (task.inside(moved),)
    return near, count
