"""Weights of a polytope's vertices, and simplices of them."""

import numpy as np

from .checks import count as whole
from .checks import numbers


def checked_weights(weights, vertices):
    """The convex ``weights`` of so many ``vertices``, or a ValueError."""
    given = numbers("weights", weights)
    good = given.shape == (vertices,) and np.isfinite(given).all()
    if not good or (given < 0).any() or abs(given.sum() - 1) > 1e-9:
        raise ValueError(f"weights must be {vertices} non-negative numbers of sum 1")
    return given


def random_weights(vertices, count, seed):
    """``count`` uniform weights of so many ``vertices``, one a row, by ``seed``."""
    rng = np.random.default_rng(whole("seed", seed))
    return rng.dirichlet(np.ones(vertices), size=whole("count", count))


def halves(weights, far):
    """Both halves of a simplex of corners ``weights``, (N, k), cut in the middle of its
    longest edge by distances ``far``, (N, N).

    >>> first, second = halves(np.eye(2), np.array([[0, 1], [1, 0]]))
    >>> first.tolist()
    [[0.5, 0.5], [0.0, 1.0]]
    """
    i, j = np.unravel_index(np.argmax(far), np.shape(far))
    first, second = weights.copy(), weights.copy()
    first[i] = second[j] = (weights[i] + weights[j]) / 2
    return [first, second]
