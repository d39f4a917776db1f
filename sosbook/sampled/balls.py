"""Arrays of balls: each entry a real number and how far it may be off.

They are numpy arrays of python-flint's arb; the operations enclose, in
the precision of flint's context.
"""

from functools import reduce
from operator import mul

import numpy as np
from flint import arb, arb_mat

from ..exact.definite import exact

__all__ = [
    "balls",
    "balls_of",
    "entries",
    "exponential",
    "hull",
    "middle",
    "orthonormal",
    "product",
    "series",
    "solve",
]


def balls(x):
    """An array of arb from x: floats (as decimals), rationals or balls."""
    x = np.asarray(x)
    if x.dtype != object:
        x = exact(x)
    array = np.empty(x.shape, object)
    array.flat = [arb(e) for e in x.flat]
    return array


def balls_of(x):
    """The floats of an array x themselves, as an array of arb."""
    array = np.empty(x.shape, object)
    array.flat = [arb(e) for e in x.ravel().tolist()]
    return array


def hull(matrices):
    """Balls that hold all mixtures of some matrices of balls."""
    array = np.empty(matrices[0].shape, object)
    array.flat = [reduce(arb.union, e) for e in zip(*(x.flat for x in matrices))]
    return array


def _matrix(x):
    return arb_mat(*x.shape, x.ravel().tolist())


def entries(x):
    """The entries of an arb_mat x, as an array."""
    array = np.empty((x.nrows(), x.ncols()), object)
    array.flat = x.entries()
    return array


def solve(A, B):
    """A^-1 B; ZeroDivisionError unless A is proven to be regular."""
    return entries(_matrix(A).solve(_matrix(B)))


def product(*several):
    """The product of ``several`` matrices of balls, faster than theirs as arrays."""
    return entries(reduce(mul, map(_matrix, several)))


def exponential(x):
    """The exponential of a square matrix x of balls."""
    return entries(_matrix(x).exp())


def middle(x):
    """The midpoints of the balls x, as floats."""
    return np.array([[float(e.mid()) for e in row] for row in x])


def orthonormal(x):
    """Balls that hold a matrix whose rows are orthonormal, exactly.

    Gram and Schmidt make it of the rows of x, which are so but for roundings.
    """
    rows = []
    for row in x:
        for other in rows:
            row = row - (row @ other) * other
        rows.append(row / (row @ row).sqrt())
    return np.array(rows, object)


def series(terms):
    """The matrix of x + x1 s + x2 t + x12 s t with s^2 = t^2 = 0, or of x.

    The ``terms`` are [x, x1, x2, x12], or [x] alone.

    Such matrices multiply as the series do; the last block of the first
    row is the last term.
    """
    if len(terms) == 1:
        return terms[0]
    x, x1, x2, x12 = terms
    o = 0 * x
    return np.block([[x, x1, x2, x12], [o, x, o, x2], [o, o, x, x1], [o, o, o, x]])
