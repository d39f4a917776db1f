"""Matrix-affine expressions: a constant plus terms ``L X R``.

A theorem is a function of matrix-like things that know ``@ + - .T`` and
scalars. It is written once and read with

* `Unknown` (this module): gives the structure that the solver uses; with `Matrices`
  of data that of many pairs of vertices at once;
* float arrays: gives the numbers that are checked;
* `Matrices` of floats: gives those of many pairs of vertices at once;
* arrays of exact rationals (``dtype=object``): gives what is proven;
* `Traced` symbols: gives its text, which proof files hold and three readers evaluate;
* cvxpy variables: gives constraints for the ecosystem's solvers.

`block`, `he`, `eye`, `kron` and `tr` are the only other words a theorem needs.
"""

from functools import lru_cache
from numbers import Integral

import numpy as np

from .matrices import Symbols, array_of

__all__ = ["Affine", "Unknown", "eye", "he"]

PRODUCT = (
    "a product of two unknowns isn't affine: make the product an unknown of its own, "
    "as Y for K P"
)


class Term:
    """The product ``left @ X @ right``, with ``X`` transposed if asked."""

    __slots__ = "left", "right", "transposed", "unknown"

    def __init__(self, left, unknown, transposed, right):
        self.left, self.unknown = left, unknown
        self.transposed, self.right = transposed, right

    def map(self, function):
        """Apply a function to both factors (change of arithmetic)."""
        left, right = function(self.left), function(self.right)
        return Term(left, self.unknown, self.transposed, right)

    @property
    def T(self):
        flip = not self.transposed and not self.unknown.symmetric
        return Term(self.right.mT, self.unknown, flip, self.left.mT)


class Affine:
    """A matrix ``constant + sum of L X R`` in unknown matrices ``X``.

    Parameters
    ----------
    constant : (r, c) array
        The value where all unknowns are zero.
    terms : iterable of Term
        The products in the unknowns.

    Notes
    -----
    Constants and factors may be arrays (k, r, c): then this is k expressions, which
    `each` tells apart.
    """

    whole = None  # the expressions that this is one of, and its place among them

    decimals = False  # floats that it meets are read as decimals: what it joins, too

    __array_ufunc__ = None  # numpy hands its operators over to this class

    def __init__(self, constant, terms=()):
        self.constant = np.asarray(constant)
        self.terms = tuple(terms)

    def _of(self, constant, terms=()):
        """An expression of the same kind."""
        return Affine(constant, terms)

    def _data(self, x):
        """Data ``x`` in this expression's arithmetic."""
        return array_of(x)

    def _read(self, x):
        """Data or an expression, ``x``, as an expression of this kind."""
        return x if isinstance(x, Affine) else self._of(self._data(x))

    @property
    def shape(self):
        """The number of rows and of columns."""
        return self.constant.shape[-2:]

    @property
    def T(self):
        """The transpose."""
        return self._of(self.constant.mT, [t.T for t in self.terms])

    def each(self, count):
        """The expressions that constants and factors with one more axis hold.

        Parameters
        ----------
        count : int
            How many they are.
        """

        def one(x, k):
            return x if x.ndim == 2 else x[k]

        expressions = []
        for k in range(count):
            terms = [t.map(lambda x, k=k: one(x, k)) for t in self.terms]
            expressions.append(Affine(one(self.constant, k), terms))
            expressions[-1].whole = self, k
        return expressions

    def __neg__(self):
        return self * -1

    def __add__(self, other):
        if is_zero(other):  # where sum() begins
            return self
        other = self._read(other)
        if other.shape != self.shape:
            raise ValueError(
                f"shapes {self.shape} and {other.shape} don't add up: a sum needs "
                "equal shapes, and a number is written 2 * eye(n)"
            )
        if other.decimals and not self.decimals:
            self = other._read(self)
        return self._of(self.constant + other.constant, self.terms + other.terms)

    __radd__ = __add__

    def __sub__(self, other):
        return self + (-self._read(other))

    def __rsub__(self, other):
        return self._read(other) - self

    def __mul__(self, factor):
        if isinstance(factor, Affine):
            raise TypeError(PRODUCT)
        factor = self._data(factor)
        if np.ndim(factor) >= 2:  # a 1 x 1 expression times a matrix
            return self._times_matrix(np.asarray(factor))
        if np.ndim(factor) == 0 and factor == 0:
            return self._of(factor * self.constant)
        terms = [
            Term(factor * t.left, t.unknown, t.transposed, t.right) for t in self.terms
        ]
        return self._of(factor * self.constant, terms)

    __rmul__ = __mul__

    def __truediv__(self, divisor):
        divisor = self._data(divisor)
        terms = [
            Term(t.left / divisor, t.unknown, t.transposed, t.right) for t in self.terms
        ]
        return self._of(self.constant / divisor, terms)

    def __matmul__(self, matrix):
        if isinstance(matrix, Affine):
            raise TypeError(PRODUCT)
        matrix = np.asarray(self._data(matrix))
        # A product over no columns is zero. numpy would write it with plain
        # integers, and half of one is a float, which no rational goes with.
        terms = self.terms if matrix.shape[-2] else ()
        terms = [Term(t.left, t.unknown, t.transposed, t.right @ matrix) for t in terms]
        return self._of(self.constant @ matrix, terms)

    def __rmatmul__(self, matrix):
        return (self.T @ np.asarray(self._data(matrix)).mT).T

    def _times_matrix(self, matrix):
        if self.shape != (1, 1):
            raise ValueError(
                "only a 1 x 1 expression scales a matrix, and this one is "
                f"{self.shape[0]} x {self.shape[1]}: write a product of matrices with @"
            )
        identity = eye(matrix.shape[-1])
        total = self._of(self.constant[0, 0] * matrix)
        for j in np.flatnonzero((matrix != 0).any(axis=tuple(range(matrix.ndim - 1)))):
            column, row = matrix[..., j : j + 1], identity[j : j + 1]
            total = total + column @ self._of([[0]], self.terms) @ row
        return total

    def value(self, values):
        """The matrix for given unknowns.

        Parameters
        ----------
        values : dict
            The array of each `Unknown`.
        """
        total = self.constant
        for t in self.terms:
            x = values[t.unknown]
            total = total + t.left @ (x.T if t.transposed else x) @ t.right
        return total

    def jacobian(self, unknown):
        """Derivatives by the free entries of one unknown.

        Returns
        -------
        (k, r, c) array
            One matrix for each of the ``k`` entries of ``unknown.pack``.
        """
        rows, cols = unknown.shape
        full = np.zeros((rows, cols) + self.shape, self.constant.dtype)
        for t in self.terms:
            if t.unknown is unknown:
                axes = (1, 2, 0, 3) if not t.transposed else (2, 1, 0, 3)
                outer = np.multiply.outer(t.left, t.right)
                full = full + outer.transpose(axes)
        if not unknown.symmetric:
            return full.reshape((rows * cols,) + self.shape)
        i, j = lower_triangle(rows)
        off = (i != j).astype(int)[:, None, None]
        return full[i, j] + off * full[j, i]


class Unknown(Affine):
    """An unknown matrix, itself the simplest affine expression.

    Parameters
    ----------
    name : str
        What messages call it.
    rows, cols : int
        Its shape; it is square without ``cols``.
    symmetric : bool
        Whether only the lower triangle is free.

    Examples
    --------
    >>> P = Unknown("P", 2, symmetric=True)
    >>> A = np.array([[0, 1], [-2, -3]])
    >>> lyapunov = he(A @ P)
    >>> lyapunov.value({P: np.eye(2)})
    array([[ 0., -1.],
           [-1., -6.]])
    """

    def __init__(self, name, rows, cols=None, symmetric=False):
        """Check the shape, whose entries are all free, or a triangle."""
        self.name = name
        self.symmetric = symmetric
        cols = rows if cols is None else cols
        if not all(isinstance(n, Integral) and n >= 0 for n in (rows, cols)):
            raise ValueError(
                f"unknown {name}: rows and cols must be whole numbers, as in "
                f'Unknown("{name}", 2, 6); got {rows!r}, {cols!r}'
            )
        if symmetric and rows != cols:
            raise ValueError(f"{name}: symmetric but not square, {rows} x {cols}")
        term = Term(eye(rows), self, False, eye(cols))
        super().__init__(np.zeros((rows, cols), int), [term])

    @property
    def size(self):
        """Number of free entries."""
        rows, cols = self.shape
        return rows * (rows + 1) // 2 if self.symmetric else rows * cols

    def unpack(self, entries):
        """The matrix with the given free entries."""
        rows, cols = self.shape
        if not self.symmetric:
            return np.asarray(entries).reshape(rows, cols)
        matrix = np.zeros((rows, rows), np.asarray(entries).dtype)
        i, j = lower_triangle(rows)
        matrix[i, j] = matrix[j, i] = entries
        return matrix

    def gradient(self, matrix):
        """Derivatives by the free entries, of those by all entries, a ``matrix``."""
        return self.pack(matrix + np.tril(matrix.T, -1) if self.symmetric else matrix)

    def pack(self, matrix):
        """The free entries of a matrix."""
        matrix = np.asarray(matrix)
        if not self.symmetric:
            return matrix.ravel()
        return matrix[lower_triangle(self.shape[0])]


@lru_cache(64)
def lower_triangle(size):
    """Row and column indices of the entries on and below the diagonal."""
    return np.tril_indices(size)


def eye(size):
    """The identity with ``size`` rows, of integers: exact in every arithmetic.

    A ``size`` that is no whole number is a ValueError.
    """
    if isinstance(size, Symbols):
        return size.eye()
    if not isinstance(size, Integral) or size < 0:
        raise ValueError(f"eye takes a number of rows, as eye(2); got {size!r}")
    return np.eye(size, dtype=int)


def he(x):
    """``x + x.T``, the thesis's sm{x}; a ValueError where x isn't square."""
    try:
        return x + x.T
    except (AttributeError, ValueError):
        given = f"the shape {x.shape}" if hasattr(x, "shape") else repr(x)
        raise ValueError(
            f"he(X) is X + X' of a square array or expression; got {given}"
        ) from None


def is_zero(x):
    """True if ``x`` is the plain number 0."""
    return isinstance(x, int) and x == 0
