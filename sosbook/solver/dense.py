"""A symmetric matrix that is written part by part, and its Cholesky factor."""

import numpy as np
from scipy.linalg.blas import dsyr
from scipy.linalg.lapack import dpotrf, dpotrs


class Dense:
    """A symmetric matrix, of which only the diagonal and what is above is read.

    ``entries``, (k, k): it is written to.
    """

    def __init__(self, entries):
        self.entries = entries

    def clear(self):
        """Write zeros everywhere: large arrays take long to be made."""
        self.entries.fill(0)

    def part(self, u, v):
        """The place of the derivatives by two unknowns, to be written to.

        A (size of ``u``, size of ``v``) array, for two `UnknownLayout`.
        """
        if u.start > v.start:
            return self.part(v, u).T
        rows, cols = u.start + u.size, v.start + v.size
        return self.entries[u.start : rows, v.start : cols]

    def write_column(self, index, column):
        """Write a whole (k,) ``column`` at an ``index``, and its mirror."""
        self.entries[:index, index] = column[:index]
        self.entries[index, index:] = column[index:]

    def add_square(self, g):
        """Add g g', for a (k,) array ``g``."""
        dsyr(1.0, g, lower=1, a=self.entries.T, overwrite_a=1)

    def add_diagonal(self, number):
        """Add ``number`` times I."""
        own = diagonal(self.entries)
        own += number

    def fill_empty(self):
        """Put ones on the diagonal where nothing was written.

        Raises LinAlgError if a diagonal entry is negative or no number.
        """
        fill_empty(self.entries)

    def copy(self):
        """Another one with the same entries."""
        return Dense(self.entries.copy())

    def whole(self):
        """The (k, k) array with both triangles."""
        return np.triu(self.entries) + np.triu(self.entries, 1).T

    def factor(self, ridge):
        """A function that solves H d = g, or None where there is no factor.

        The factor takes the matrix's place. The diagonal grows by ``ridge``, a
        fraction.
        """
        own = diagonal(self.entries)
        own *= 1 + ridge
        factor = cholesky(self.entries)
        if factor is None:
            return None
        return lambda g, tolerance=None: dpotrs(factor, g, lower=1)[0]


def diagonal(matrix):
    """The diagonal of a square ``matrix``, to be written to."""
    return np.einsum("ii->i", matrix)


def fill_empty(matrix):
    """Put ones where a ``matrix`` has zeros on its diagonal; all must be positive."""
    own = diagonal(matrix)
    own[own == 0] = 1.0  # variables that no block depends on
    if not own.min(initial=1.0) > 0:
        raise np.linalg.LinAlgError("the Hessian isn't positive definite")


def cholesky(matrix):
    """The lower factor of a ``matrix``, or None.

    The triangle above the diagonal is read, and the factor takes its place: as
    LAPACK reads columns, it is below the diagonal there.
    """
    factor, failed = dpotrf(matrix.T, lower=1, clean=0, overwrite_a=1)
    return None if failed else factor
