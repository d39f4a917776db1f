"""Lyapunov's and Riccati's equations."""

import numpy as np
from scipy.linalg import schur, solve_continuous_are
from scipy.linalg.lapack import dgees, dtrsyl

from ..runtime.time_limit import check_time_of_eigenvalues


def lyapunov(A, Q):
    """The X of A X + X A' = Q, real. Where two eigenvalues of A sum to zero, to
    rounding, A is moved a little, without the warning of
    `scipy.linalg.solve_continuous_lyapunov`.

    Source: R. H. Bartels and G. W. Stewart, Comm. ACM 15, 1972, 820-826.
    """
    check_time_of_eigenvalues(len(A))
    T, U = schur(A, output="real")
    X, scale, _ = dtrsyl(T, T, U.T @ (np.asarray_chkfinite(Q) @ U), tranb="T")
    return U @ (X * scale) @ U.T


SCHUR, PENCIL = 4.0, 12.0  # times as long as eigenvalues of A
RESIDUAL = 1e-10  # relative; what leaves more is solved by scipy


def riccati(A, B, Q, R):
    """The stabilising X of A' X + X A - X B R^-1 B' X + Q = 0, R positive definite;
    numpy.linalg.LinAlgError if there is none, to rounding.

    X maps the first half of the Hamiltonian's stable Schur vectors to the second (Laub
    1979). `scipy.linalg.solve_continuous_are`, which balances a pencil, takes four
    times as long at N = 6; it has the word where the result doesn't solve the equation.
    """
    N, push = len(A), B @ np.linalg.solve(R, B.T)
    check_time_of_eigenvalues(N, SCHUR)
    H = np.empty((2 * N, 2 * N))
    H[:N, :N], H[:N, N:], H[N:, :N], H[N:, N:] = A, -push, -Q, -A.T
    X = _by_schur_vectors(H) if np.isfinite(H).all() else None
    if X is not None:
        XA, bent = X @ A, X @ push @ X
        size = max(np.abs(x).max() for x in (XA, bent, Q))
        if np.abs(XA + XA.T - bent + Q).max() < RESIDUAL * size:
            return X
    check_time_of_eigenvalues(N, PENCIL)
    try:
        return solve_continuous_are(A, B, Q, R)
    except ValueError as error:  # the pencil's stable half can't be sorted out
        raise np.linalg.LinAlgError(str(error)) from None


def _by_schur_vectors(H):
    """The symmetric X of a Hamiltonian H, unless its stable half is lost."""
    N = len(H) // 2
    _, stable, _, _, U, _, failed = dgees(lambda re, im: re < 0, H, sort_t=1)
    if failed or stable != N:
        return None
    try:
        X = np.linalg.solve(U[:N, :N].T, U[N:, :N].T)
    except np.linalg.LinAlgError:
        return None
    return (X + X.T) / 2
