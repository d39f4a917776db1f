"""The discrete Lyapunov equation, summed by doubling."""

import numpy as np

__all__ = ["discrete_lyapunov"]

MOST_DOUBLINGS = 64  # more than a radius below one in floats needs


def discrete_lyapunov(F, W):
    """The X of F' X F - X + W = 0: the sum of F'^k W F^k over k = 0, 1, ...

    ``F``, (N, N): with a spectral radius below one; ``W``, (N, N): symmetric, not
    negative. Returns (N, N): nothing cancels in the sum, so that the units of the
    states don't matter. All of it is infinite where floats don't hold the sum.

    Source: R. A. Smith, SIAM J. Appl. Math. 16, 1968, 198-201.

    >>> discrete_lyapunov(np.array([[0.5]]), np.array([[3.0]]))
    array([[4.]])
    """
    X = W
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(MOST_DOUBLINGS):
            more = X + F.T @ X @ F
            if (more == X).all():
                break
            if not np.isfinite(more).all():  # the radius is one, but for rounding
                return np.full(X.shape, np.inf)
            X, F = more, F @ F
    return (X + X.T) / 2
