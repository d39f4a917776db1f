"""Unknowns and expressions as a reader writes them, whose decimals stay exact."""

import numpy as np

from ..exact.rational import exact
from ..language.expression import Affine, Unknown

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
        x = np.asarray(super()._data(x))
        if x.dtype.kind not in "iufO":
            raise ValueError(f"data must be real numbers, got an array of {x.dtype}")
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
        return self * (1 / exact(divisor))

    def in_floats(self):
        """The same `Affine` expression in floats."""
        as_floats = [t.map(_in_floats) for t in self.terms]
        return Affine(_in_floats(self.constant), as_floats)


def _in_floats(x):
    return np.asarray(x, float)


def symmetric(name, size):
    """A symmetric unknown matrix, of a ``name`` and so many rows.

    Raises
    ------
    ValueError
        If ``size`` is no whole number.

    Examples
    --------
    >>> P = symmetric("P", 2)
    >>> P.shape
    (2, 2)
    """
    unknown = Unknown(name, size, symmetric=True)
    return Expression(unknown.constant, unknown.terms)


def matrix(name, rows, cols):
    """An unknown matrix of a ``name`` and a shape.

    Raises
    ------
    ValueError
        If ``rows`` or ``cols`` is no whole number.

    Examples
    --------
    >>> Y = matrix("Y", 1, 2)
    >>> (Y @ [[0.3], [9.81]]).shape
    (1, 1)
    """
    unknown = Unknown(name, rows, cols)
    return Expression(unknown.constant, unknown.terms)


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
