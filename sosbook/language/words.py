"""Words of theorems beside `block`, `eye` and `he`."""

import numpy as np

from .expression import eye
from .layout import block
from .matrices import Symbols


def kron(factors, x):
    """The Kronecker product of a small matrix of numbers and a matrix.

    ``factors``, (k, l) list of lists of scalars, or a scalar: the numbers; ``x``: of
    any kind that the theorems can be read in.

    >>> kron([[0, 1], [2, 0]], np.array([[5]]))
    array([[ 0,  5],
           [10,  0]])
    """
    if not isinstance(factors, list) and np.ndim(factors) == 0:
        return factors * x
    if isinstance(x, Symbols):
        return x.times_each(factors)
    return block([[f * x for f in row] for row in factors])


def turned(x):
    """The transpose of a matrix-like ``x``, or of the 0 that stands for none.

    Examples
    --------
    >>> turned(np.array([[1, 2]])).tolist(), turned(0)
    ([[1], [2]], 0)
    """
    return 0 if isinstance(x, int) else x.T


def tr(x):
    """The trace of a matrix, as a 1 x 1 matrix.

    ``x``, (k, k): of any kind that the theorems can be read in.

    >>> tr(np.array([[1, 5], [5, 2]]))
    array([[3]])
    """
    if isinstance(x, Symbols):
        return x.word("tr")
    first, *others = (e[None] @ x @ e[:, None] for e in eye(x.shape[0]))
    return sum(others, first)


def pick(k, parts, size):
    """The matrix that picks the k-th of some parts of a long vector, counted from 0.

    ``k``, ``parts``, ``size``: which part, how many there are, and how many entries
    each has.

    >>> pick(1, 2, 2)
    array([[0, 0, 1, 0],
           [0, 0, 0, 1]])
    """
    if isinstance(size, Symbols):
        return size.pick(k, parts)
    return np.eye(parts * size, dtype=int)[k * size : (k + 1) * size]


def named(name, x):
    """A matrix ``x`` itself, which the text of a theorem calls by a ``name``."""
    return x.named(name) if isinstance(x, Symbols) else x
