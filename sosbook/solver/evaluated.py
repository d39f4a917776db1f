"""Small blocks, their constants and slopes read at once.

`Readings` of all free entries go through the theorems in a single reading. For
few variables that is faster than writing products of matrices first.
"""

from functools import lru_cache

import numpy as np

from ..language.expression import lower_triangle
from ..language.matrices import Readings
from .blocks import Blocks

__all__ = ["EvaluatedBlocks", "unit_readings"]


class EvaluatedBlocks(Blocks):
    """Blocks that are read with `unit_readings`.

    ``values``: the blocks; a plain matrix is a constant; ``unknowns``: their free
    entries, one unknown after the other, are the variables.
    """

    def __init__(self, values, unknowns):
        self.unknowns = list(unknowns)
        self.variables = sum(u.size for u in unknowns)
        self.constants, self.slopes = [], []
        for g in values:
            if isinstance(g, Readings):
                constant, slopes = g.array[0], g.array[1:]
            else:
                constant, slopes = g, np.zeros((self.variables, *g.shape))
            self.constants.append(constant.astype(float, copy=False))
            self.slopes.append(slopes.astype(float, copy=False))

    def joined(self, write):
        """These blocks and more, which ``write`` makes of a list of values."""
        values = write([*unit_readings(self.unknowns).values()])
        more = EvaluatedBlocks(values, self.unknowns)
        more.constants = [*self.constants, *more.constants]
        more.slopes = [*self.slopes, *more.slopes]
        more.settings = self.settings
        return more


def unit_readings(unknowns):
    """The `Readings` of some ``unknowns`` by their names.

    Their constants are zero; each slope has one free entry that is one.

    Examples
    --------
    >>> from sosbook.lmi import Unknown
    >>> unit_readings([Unknown("x", 1), Unknown("y", 1)])["y"].array.ravel()
    array([0., 0., 1.])
    """
    arrays = _arrays(_kinds(unknowns))
    return {u.name: Readings(array) for u, array in zip(unknowns, arrays)}


def _kinds(unknowns):
    """The shape of each of some ``unknowns``, and whether it is symmetric."""
    return tuple((u.shape, u.symmetric) for u in unknowns)


@lru_cache(16)
def _arrays(kinds):
    parts, start = [], 1
    for (rows, cols), symmetric in kinds:
        i, j = lower_triangle(rows) if symmetric else np.indices((rows, cols))
        i, j = np.ravel(i), np.ravel(j)
        parts.append((rows, cols, i, j, symmetric, start))
        start += len(i)
    arrays = []
    for rows, cols, i, j, symmetric, first in parts:
        array = np.zeros((start, rows, cols))
        at = first + np.arange(len(i))
        array[at, i, j] = 1.0
        if symmetric:
            array[at, j, i] = 1.0
        array.flags.writeable = False
        arrays.append(array)
    return arrays
