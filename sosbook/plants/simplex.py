"""Weights of a polytope's vertices, and simplices of them."""

import numpy as np

from .checks import count as whole
from .checks import numbers


def checked_weights(weights, vertices):
    """Convex weights, one for each of so many vertices, or a ValueError.

    Examples
    --------
    >>> checked_weights([0.25, 0.75], 2)
    array([0.25, 0.75])
    """
    given = numbers("weights", weights)
    good = given.shape == (vertices,) and np.isfinite(given).all()
    if not good or (given < 0).any() or abs(given.sum() - 1) > 1e-9:
        raise ValueError(f"weights must be {vertices} non-negative numbers of sum 1")
    return given


def random_weights(vertices, count, seed):
    """``count`` sets of convex weights of so many vertices, one a row.

    They are uniform over the simplex; ``seed`` is that of numpy's generator.
    """
    rng = np.random.default_rng(whole("seed", seed))
    return rng.dirichlet(np.ones(vertices), size=whole("count", count))


def halves(weights, far):
    """Cut a simplex in the middle of its longest edge.

    ``weights``, (N, k): its corners, one a row: weights of a polytope's vertices;
    ``far``, (N, N): distances between the corners, in whatever measure. Returns the
    corners of both halves.

    >>> first, second = halves(np.eye(2), np.array([[0, 1], [1, 0]]))
    >>> first
    array([[0.5, 0.5],
           [0. , 1. ]])
    """
    i, j = np.unravel_index(np.argmax(far), np.shape(far))
    first, second = weights.copy(), weights.copy()
    first[i] = second[j] = (weights[i] + weights[j]) / 2
    return [first, second]
