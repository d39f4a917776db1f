"""Checks of numbers and matrices that callers give."""

import numpy as np

__all__ = ["matrix", "number", "positive", "rank_deficient"]


def number(name, value):
    """A finite float, or a ValueError that names it."""
    real = isinstance(value, (int, float, np.integer, np.floating))
    if not real or not np.isfinite(value):
        raise ValueError(f"{name} must be a finite number, got {value!r}")
    return float(value)


def positive(name, value):
    """A positive float, or a ValueError that names it."""
    if number(name, value) <= 0:
        raise ValueError(f"{name} must be positive, got {value!r}")
    return float(value)


def matrix(name, value, shape=None):
    """A read-only float matrix, or a ValueError that names it."""
    try:
        if np.iscomplexobj(value):
            raise TypeError("it has complex entries")
        array = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} must be a real matrix: {error}") from None
    if array.ndim != 2:
        raise ValueError(
            f"{name} must be a matrix (two dimensions), got {array.ndim}"
        )
    if not np.isfinite(array).all():
        raise ValueError(f"{name} has NaN or infinite entries")
    for axis, word in enumerate(("rows", "columns")):
        wanted = None if shape is None else shape[axis]
        if wanted is not None and array.shape[axis] != wanted:
            raise ValueError(
                f"{name} has {array.shape[axis]} {word}, needs {wanted}"
            )
    array.flags.writeable = False
    return array


def rank_deficient(M, tolerance=1e-10):
    """Rank test after scaling rows and columns to unit length.

    Repeated until the units of rows and columns don't matter.
    """
    for axis in 20 * (1, 0):
        size = np.sqrt((abs(M) ** 2).sum(axis=axis, keepdims=True))
        size[size == 0] = 1.0
        M = M / size
        if axis == 0 and abs(size - 1).max() < 0.1:
            break
    return np.linalg.matrix_rank(M, tol=tolerance) < M.shape[0]
