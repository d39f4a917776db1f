"""The continuous Lyapunov equation."""

import numpy as np
from scipy.linalg import schur
from scipy.linalg.lapack import dtrsyl

from ..runtime.time_limit import check_time_of_eigenvalues


def lyapunov(A, Q):
    """The X of A X + X A' = Q.

    ``A``, ``Q``, (N, N): of real numbers. Returns (N, N): where two eigenvalues of A
    sum to zero, to rounding, A is moved a little, without the warning of
    `scipy.linalg.solve_continuous_lyapunov`.

    Source: R. H. Bartels and G. W. Stewart, Comm. ACM 15, 1972, 820-826.

    >>> lyapunov(np.array([[-0.5]]), np.array([[-3.0]]))
    array([[3.]])
    """
    check_time_of_eigenvalues(len(A))
    T, U = schur(A, output="real")
    X, scale, _ = dtrsyl(T, T, U.T @ (np.asarray_chkfinite(Q) @ U), tranb="T")
    return U @ (X * scale) @ U.T
