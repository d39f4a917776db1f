"""Simplices of weights: parts of a polytope."""

import numpy as np

__all__ = ["halves"]


def halves(weights, far):
    """Cut a simplex in the middle of its longest edge.

    Parameters
    ----------
    weights : (N, k) array
        Its corners, one a row: weights of a polytope's vertices.
    far : (N, N) array
        Distances between the corners, in whatever measure.

    Returns
    -------
    list of two (N, k) arrays
        The corners of both halves.

    Examples
    --------
    >>> first, second = halves(np.eye(2), np.array([[0, 1], [1, 0]]))
    >>> first
    array([[0.5, 0.5],
           [0. , 1. ]])
    """
    i, j = np.unravel_index(np.argmax(far), np.shape(far))
    first, second = weights.copy(), weights.copy()
    first[i] = second[j] = (weights[i] + weights[j]) / 2
    return [first, second]
