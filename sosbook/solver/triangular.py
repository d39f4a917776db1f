"""Inverses of many triangular matrices, which numpy inverts as if they were full."""

import numpy as np

__all__ = ["inverse_of_lower"]

LARGEST_LEAF = 10  # rows of a matrix that LAPACK inverts as fast


def inverse_of_lower(L):
    """The inverses of lower triangular matrices.

    Parameters
    ----------
    L : (..., q, q) array
        Regular and zero above the diagonal.

    Returns
    -------
    (..., q, q) array
        Zero above the diagonal, up to rounding.

    Notes
    -----
    That of [[A, 0], [B, C]] is [[inv(A), 0], [-inv(C) B inv(A), inv(C)]]: most of
    the work becomes products of matrices (Higham 2002, section 14.2).

    Examples
    --------
    >>> inverse_of_lower(np.array([[2.0, 0.0], [1.0, 1.0]]))
    array([[ 0.5,  0. ],
           [-0.5,  1. ]])
    """
    q = L.shape[-1]
    if q <= LARGEST_LEAF:
        return np.linalg.inv(L)
    h, inverse = q // 2, np.zeros_like(L)
    first = inverse_of_lower(L[..., :h, :h])
    second = inverse_of_lower(L[..., h:, h:])
    inverse[..., :h, :h], inverse[..., h:, h:] = first, second
    inverse[..., h:, :h] = -second @ (L[..., h:, :h] @ first)
    return inverse
