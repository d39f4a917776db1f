"""Unknowns and expressions as a reader writes them, whose decimals stay exact."""

from numbers import Integral

import numpy as np

from ..exact.rational import exact
from ..language.expression import Affine, Unknown
from ..runtime.names import sane_name

__all__ = ["matrix", "pairs", "symmetric"]


def floats(x):
    """Data x for blocks, in floats."""
    return np.asarray(x, float) if isinstance(x, (list, tuple)) else x


class Expression(Affine):
    """An `Affine` expression that reads each float it meets as the decimal it prints.

    So its blocks are exact, and what is proven of them is about the written numbers.
    Products of data that are formed before they meet an unknown are numpy's, rounded.

    >>> 0.1 * matrix("K", 1, 2) @ [[0.3], [2]]
    <Expression: 1 x 1 in K>
    """

    decimals = True

    def __repr__(self):
        names = ", ".join(dict.fromkeys(t.unknown.name for t in self.terms))
        return f"<Expression: {self.shape[0]} x {self.shape[1]} in {names or 'none'}>"

    def _of(self, constant, terms=()):
        return Expression(constant, terms)

    def _data(self, x):
        if isinstance(x, Affine):
            raise TypeError("a quotient or product of two unknowns isn't affine")
        x = np.asarray(super()._data(x))
        if x.dtype.kind not in "iufO":
            raise ValueError(f"data must be real numbers, got an array of {x.dtype}")
        if x.ndim == 1:
            raise ValueError(
                f"data must be a matrix or a number, got {x.shape}: give "
                "a vector as a row or a column"
            )
        if x.dtype.kind in "iu":
            return x if x.ndim else int(x)
        return exact(x) if x.ndim else exact(x.item())

    def _read(self, x):
        if isinstance(x, Affine) and not x.decimals:
            terms = [t.map(self._data) for t in x.terms]
            return Expression(self._data(x.constant), terms)
        if np.ndim(x) == 0 and not isinstance(x, Affine):  # as J - 0.3 of one entry
            x = [[x]]
        return super()._read(x)

    def __truediv__(self, divisor):  # of integers it would be a float
        divisor = self._data(divisor)
        if np.any(divisor == 0):
            raise ValueError(f"{self!r} can't be divided by zero")
        return self * (1 / exact(divisor))

    def __matmul__(self, matrix):
        if not isinstance(matrix, Affine):
            _fits(self.shape, np.shape(matrix))
        return super().__matmul__(matrix)

    def __rmatmul__(self, matrix):
        _fits(np.shape(matrix), self.shape)
        return super().__rmatmul__(matrix)

    def _compared(self, other):
        raise TypeError(
            "an inequality is a block that is positive definite: P > Q is written as "
            'LMIProblem({"a name": P - Q})'
        )

    __gt__ = __ge__ = __lt__ = __le__ = _compared

    def in_floats(self):
        """The same `Affine` expression in floats."""
        as_floats = [t.map(_in_floats) for t in self.terms]
        return Affine(_in_floats(self.constant), as_floats)


def _in_floats(x):
    return np.asarray(x, float)


def _fits(left, right):
    if len(left) == len(right) == 2 and left[1] != right[0]:
        raise ValueError(f"a product of shapes {left} and {right} doesn't fit")


def _unknown(name, rows, cols, symmetric, call):
    """An unknown as an expression; a ValueError shows how it is ``call``ed."""
    whole = isinstance(rows, Integral) and isinstance(cols, Integral)
    if not whole or bool in map(type, (rows, cols)) or min(rows, cols) < 1:
        raise ValueError(
            f"{name!r} needs whole numbers of rows and columns, as in {call}; got "
            f"{rows!r}" + ("" if symmetric else f" and {cols!r}")
        )
    unknown = Unknown(sane_name(name), int(rows), int(cols), symmetric=symmetric)
    return Expression(unknown.constant, unknown.terms)


def symmetric(name, size):
    """A symmetric unknown matrix, of a ``name`` and so many rows.

    Raises
    ------
    ValueError
        If ``size`` is no whole number above zero, or the name isn't one line of words.

    Examples
    --------
    >>> P = symmetric("P", 2)
    >>> P.shape
    (2, 2)
    """
    return _unknown(name, size, size, True, 'symmetric("P", 6)')


def matrix(name, rows, cols=None):
    """An unknown matrix of a ``name`` and a shape.

    Raises
    ------
    ValueError
        If ``rows`` or ``cols`` is no whole number above zero, or the name isn't one
        line of words.

    Examples
    --------
    >>> Y = matrix("Y", 1, 2)
    >>> (Y @ [[0.3], [9.81]]).shape
    (1, 1)
    """
    return _unknown(name, rows, cols, False, 'matrix("Y", 2, 6)')


def pairs(name, block, vertices):
    """The blocks at all vertices and all pairs of them, by name.

    If they are positive definite, so is the block at every plant between.

    Parameters
    ----------
    name : str
        What they are called, before the numbers of their vertices.
    block : callable
        ``block(i, j)``: a theorem with some of the data of vertex i, and with those
        that multiply them of vertex j.
    vertices : sequence
        What ``block`` takes.

    Returns
    -------
    dict
        ``block(i, i)`` of each vertex, ``block(i, j) + block(j, i)`` of each pair.

    Examples
    --------
    >>> P = symmetric("P", 1)
    >>> list(pairs("rate", lambda i, j: i @ P @ j.T, [np.eye(1), 2 * np.eye(1)]))
    ['rate 1', 'rate 1, 2', 'rate 2']
    """
    blocks, vertices = {}, list(vertices)
    for k, i in enumerate(vertices, 1):
        blocks[f"{name} {k}"] = block(i, i)
        for n, j in enumerate(vertices[k:], k + 1):
            blocks[f"{name} {k}, {n}"] = block(i, j) + block(j, i)
    return blocks
