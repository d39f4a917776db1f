"""Many matrices of one shape, read as one: a theorem for all pairs at once."""

import numpy as np


class Symbols:
    """Symbols of matrices, numbers and sizes: see `sosbook.language.traced`."""


class Matrices:
    """Arrays of one shape that take part in a theorem together.

    A plain matrix goes with all of them.

    ``array``, (k, r, c): the k matrices.

    >>> some = Matrices(np.array([[[1.0, 2.0]], [[3.0, 4.0]]]))
    >>> some.shape, (some @ np.ones((2, 1))).array.ravel()
    ((1, 2), array([3., 7.]))
    """

    __array_ufunc__ = None  # numpy hands its operators over to this class

    def __init__(self, array):
        self.array = array

    @property
    def shape(self):
        """The number of rows and of columns of each."""
        return self.array.shape[-2:]

    @property
    def T(self):
        """The transposes."""
        return type(self)(self.array.swapaxes(-1, -2))

    def __neg__(self):
        return type(self)(-self.array)

    def __add__(self, other):
        return self._of(self.array + array_of(other))

    __radd__ = __add__

    def __sub__(self, other):
        return self._of(self.array - array_of(other))

    def __rsub__(self, other):
        return self._of(array_of(other) - self.array)

    def __mul__(self, factor):
        return self._of(self.array * factor)

    __rmul__ = __mul__

    def __truediv__(self, divisor):
        return type(self)(self.array / divisor)

    def __matmul__(self, other):
        return self._of(self.array @ array_of(other))

    def __rmatmul__(self, other):
        return self._of(array_of(other) @ self.array)

    def _of(self, result):
        """Matrices again, unless unknowns took part, which made expressions of them."""
        return type(self)(result) if isinstance(result, np.ndarray) else result

    def write(self, part, entry):
        """Write an ``entry``, some matrices or a plain one, into their ``part``."""
        part[:] = array_of(entry)

    def block(self, entries, size):
        """The block matrices of this kind and ``size``; ``entries``: (place, entry)."""
        whole = np.zeros((len(self.array), *size))
        for (down, right), x in entries:
            self.write(whole[:, down, right], x)
        return type(self)(whole)


class Reaches(Matrices):
    """Bounds of the entries of a matrix, and of how far they may move, read as one.

    What is added or subtracted adds its bounds, so that no entry of an expression in
    matrices that move moves farther than its second part says. Plain matrices stay.

    >>> x = Reaches(np.array([[[3.0]], [[0.1]]]))
    >>> (x - 2 * x.T).array.ravel(), (np.array([[-2.0]]) @ x).array.ravel()
    (array([9. , 0.3]), array([6. , 0.2]))
    """

    def __neg__(self):
        return self

    def __add__(self, other):
        total = self.array.copy()
        if isinstance(other, Matrices):
            return Reaches(total + other.array)
        total[0] += np.abs(other)
        return Reaches(total)

    __radd__ = __sub__ = __rsub__ = __add__

    def __mul__(self, factor):
        return Reaches(self.array * np.abs(factor))

    __rmul__ = __mul__

    def __truediv__(self, divisor):
        return Reaches(self.array / np.abs(divisor))

    def __matmul__(self, other):
        if isinstance(other, Matrices):
            return NotImplemented
        return Reaches(self.array @ np.abs(other))

    def __rmatmul__(self, other):
        return Reaches(np.abs(other) @ self.array)

    def write(self, part, entry):
        if isinstance(entry, Matrices):
            part[:] = entry.array
        else:
            part[0] = np.abs(entry)


def array_of(x):
    """The array of some `Matrices`; a plain matrix x as it is."""
    return x.array if isinstance(x, Matrices) else x


def margins(array, below=np.inf):
    """The smallest eigenvalues of k symmetric matrices, their diagonals scaled to one.

    ``array``, (k, q, q): the matrices; ``below``: what is larger than this is reported
    as infinite, which is faster. Returns (k,): what `sosbook.solver.loop.margin` says
    of each: where a diagonal has an entry that isn't positive, the least one.

    >>> both = np.array([np.eye(2), [[4.0, 2.0], [2.0, 4.0]]])
    >>> margins(both), margins(both, below=0.6)
    (array([1. , 0.5]), array([inf, 0.5]))
    """
    diagonals = np.diagonal(array, axis1=-2, axis2=-1)
    least = diagonals.min(axis=-1)
    good = np.flatnonzero(least > 0)
    scale = 1 / np.sqrt(diagonals[good])
    scaled = array[good] * scale[:, :, None] * scale[:, None, :]
    least = least.copy()
    if below < np.inf:
        clear = _definite(scaled - below * np.eye(array.shape[-1]))
        least[good[clear]] = np.inf
        good, scaled = good[~clear], scaled[~clear]
    least[good] = np.linalg.eigvalsh(scaled)[:, 0]
    return least


def _definite(array):
    """Which of some symmetric matrices have positive pivots only."""
    try:
        np.linalg.cholesky(array)  # faster, but it doesn't tell which has none
        return np.ones(len(array), bool)
    except np.linalg.LinAlgError:
        pass
    a = np.ascontiguousarray(np.moveaxis(array, 0, -1))
    definite = np.ones(a.shape[-1], bool)
    for k in range(len(a)):
        pivot = a[k, k]
        definite &= pivot > 0
        factors = a[k + 1 :, k] / np.where(pivot > 0, pivot, 1.0)
        for i, factor in enumerate(factors, k + 1):
            a[i, k + 1 : i + 1] -= factor * a[k + 1 : i + 1, k]
    return definite
