"""Arithmetic of robots side by side in arrays, or of one in plain numbers, in a sixth
of the time: the same operations in the same order either way.
"""

from contextlib import nullcontext
from functools import partial
from types import SimpleNamespace

import numpy as np

from ..plants.checks import count


class Lanes:
    """The numbers that so many robots (``runs``) reckon with, all in one precision
    (``kind``).

    >>> lanes = Lanes(1, float)
    >>> volts = lanes.taken(lanes.array(3.0))
    >>> lanes.shown(lanes.where(volts > 2.0, 2.0, volts))
    array([2.])
    """

    def __init__(self, runs, kind):
        self.runs, self.kind = count("runs", runs, least=1), np.dtype(kind)
        self.real = float if self.kind.type is np.float64 else self.kind.type
        self.where = _choice if runs == 1 else np.where
        self.zero = self.taken(self.array(0))

    def silent(self):
        """A context in which arithmetic beyond the numbers says nothing."""
        if self.real is float and self.runs == 1:  # plain numbers never do
            return nullcontext()
        return np.errstate(invalid="ignore", over="ignore")

    def array(self, value):
        """(runs,) array of a value for all robots, or one for each."""
        return np.broadcast_to(np.asarray(value, self.kind), self.runs)

    def read(self, value):
        """A given value as the arithmetic takes it."""
        if self.runs == 1 and isinstance(value, (float, int)):
            return self.real(value)
        array = np.asarray(value, self.kind)
        return self.taken(array if array.shape == (self.runs,) else self.array(array))

    def numbers(self, given):
        """The ``given`` numbers and arrays, by name, as the arithmetic takes them."""
        with np.errstate(over="ignore"):
            return SimpleNamespace(**{x: self._number(y) for x, y in given.items()})

    def _number(self, value):
        if np.ndim(value):
            return [self._number(row) for row in value]
        return value if isinstance(value, int) else self.real(value)

    def total(self, *pairs):
        """The sum of factors times values in all pairs, from the left, from zero."""
        total = self.zero
        for factors, values in pairs:
            for factor, value in zip(factors, values):
                total = total + factor * value
        return total

    def cut(self, value, bound):
        """A value within -bound and bound; what is no number stays so."""
        low = self.where(value < -bound, -bound, value)
        return self.where(value > bound, bound, low)

    def answered(self, n, k, x, y, r=()):
        """As <name>_tick.h: the law's output k, with its numbers n, of x, y and r."""
        return self.total((n.C[k], x), (n.D[k], y), (n.DR[k], r))

    def begun(self, n, y):
        """As <name>_tick.h: the memory at rest, where y is measured; n has numbers."""
        return [self.total((row, y)) for row in n.START]

    def remembered(self, n, x, y, r, withheld):
        """As <name>_tick.h: x after a tick, with numbers n and y, r, withheld."""
        return [
            self.total((a, x), (b, y), (br, r), (w, withheld))
            for a, b, br, w in zip(n.A, n.B, n.BR, n.W)
        ]

    def taken(self, array):
        """An array as the arithmetic takes it."""
        if self.runs != 1:
            return array
        return array.item() if self.real is float else array[0]

    def shown(self, value):
        """The array of a value that the arithmetic gave."""
        return np.array([value]) if self.runs == 1 else value

    def keeper(self, good):
        """A function of new and old, which answers the new where robots are good."""
        if self.runs != 1 and good.all():
            return lambda new, old: new.copy()
        return partial(self.where, good)

    def counted(self, ticks):
        """A number of ticks among the arithmetic's other numbers."""
        return self.real(ticks) if self.runs == 1 else ticks.astype(self.kind)

    def believable(self, moved, most, lost):
        """As <name>_tick.h: it ``moved``, ``most`` is for a tick, ``lost`` past."""
        return within(moved, most * self.counted(lost + 1))


def _choice(condition, yes, no):
    """As np.where, of one robot."""
    return yes if condition else no


def within(value, bound):
    """-bound <= value <= bound; false for what isn't a number."""
    return (value >= -bound) & (value <= bound)
