"""Controllers of the plant's order from two Riccati equations: for an H-infinity norm.

Source: K. Zhou, J. C. Doyle and K. Glover, Robust and optimal control, 1996, chapter
16: the central controller below a level. Without a level it is that of LQG.
"""

import numpy as np

from ...analysis.riccati import lyapunov, riccati

SLOWER = 1e-3  # of the rate: a mode on the axis that nothing moves is no obstacle
RIDGE = 1e-9  # of what is near one, where a matrix is singular
SMALL = 1e-6  # weight and noise that are added: a norm may have none of its own
HALVINGS = 12  # of the logarithm of a level, between
LEVELS = 1e-4, 1e4  # of what is near one
AT_ONCE = 30.0  # times what is near one: a rate that is as good as infinite


def near_least(room, *data):
    """The result of `central` for ``room`` times the least level, of its first seven
    arguments, ``data``; raises numpy.linalg.LinAlgError where there is no level.
    """
    low, high = LEVELS
    for _ in range(HALVINGS):
        middle = (low * high) ** 0.5
        try:
            central(*data, SMALL, middle)
            high = middle
        except np.linalg.LinAlgError:
            low = middle
    return central(*data, SMALL, room * high)


def central(A, B, C, W, Z, D, V, more, level=np.inf):
    """Feedback F, correction L and matrix of xc' = (...) xc - L y, u = F xc, for x' =
    ``A`` x + ``B`` u + ``W`` w, y = ``C`` x + ``V`` w and z = ``Z`` x + ``D`` u, with
    ``more`` weight of u and noise of y, and a norm from w to z below ``level``. Raises
    numpy.linalg.LinAlgError where there is none.
    """
    X, F = _side(slower(A), B, Z, D, W, more, level)
    Y, L = _side(slower(A.T), C.T, W.T, V.T, Z.T, more, level)
    share = level**-2
    if share * np.abs(np.linalg.eigvals(X @ Y)).max() >= 1:
        raise np.linalg.LinAlgError("X and Y don't fit together")
    L = np.linalg.solve(np.eye(len(A)) - share * Y @ X, L.T)
    worst = share * W.T @ X
    return F, L, A + W @ worst + B @ F + L @ (C + V @ worst)


def late(A, B, C, W, Z, through):
    """A, B, C, W and Z of the plant whose output sees ``through`` w a moment later:
    the equations know no D_w. What is near one is ``A``'s rate.
    """
    p, N = through.shape[1], len(A)
    more = AT_ONCE * np.eye(p)
    A = np.block([[A, np.zeros((N, p))], [np.zeros((p, N)), -more]])
    B, C = (
        np.vstack([B, np.zeros((p, B.shape[1]))]),
        np.hstack([C, np.zeros((len(C), p))]),
    )
    return A, B, C, np.vstack([W, more]), np.hstack([Z, through])


def _side(A, B, Z, D, W, more, level):
    """X > 0 of one of both equations, and the gain that belongs to it."""
    R = D.T @ D + more * np.eye(B.shape[1])
    own = np.linalg.solve(R, D.T @ Z)
    push, weights = B, R
    if np.isfinite(level):
        push, p = np.hstack([B, W]), W.shape[1]
        weights = np.diag(np.r_[np.zeros(len(R)), -(level**2) * np.ones(p)])
        weights[: len(R), : len(R)] = R
    X = riccati(
        A - B @ own, push, Z.T @ (Z - D @ own) + RIDGE * np.eye(len(A)), weights
    )
    if np.linalg.eigvalsh(X)[0] <= 0:
        raise np.linalg.LinAlgError("X isn't positive definite")
    return X, -own - np.linalg.solve(R, B.T @ X)


def slower(A, more=SLOWER):
    """``A``, shifted by ``more``: it needn't be stabilised on the axis."""
    return A - more * np.eye(len(A))


def balanced(A, B, C):
    """Coordinates in which what ``B`` moves is as large as what ``C`` sees, the largest
    first, of the motion of ``A``, with a shift where it isn't stable.
    """
    N = len(A)
    A = slower(A, max(np.linalg.eigvals(A).real.max(), 0) + 0.1)
    reach, seen = lyapunov(A, -B @ B.T), lyapunov(A.T, -C.T @ C)
    reach += 1e-6 * np.trace(reach) / N * np.eye(N)
    seen += 1e-6 * np.trace(seen) / N * np.eye(N)
    L = np.linalg.cholesky(reach)
    U, s, _ = np.linalg.svd(L.T @ seen @ L)
    return L @ U * s**-0.25 if s.all() else L  # an output without x
