"""Lyapunov's and Riccati's equations."""

import numpy as np
from scipy.linalg import matrix_balance, schur, solve_continuous_are
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
    1979), in units of the states that balance the Hamiltonian, so that it doesn't
    depend on those in which A was given. `scipy.linalg.solve_continuous_are`, of a
    pencil, takes four times as long at N = 6; it has the word where the result doesn't
    solve the equation, or is so large that rounding moves the sum of its loop's
    eigenvalues by more than their distance from the axis.
    """
    N, H = len(A), _hamiltonian(A, B, Q, R)
    check_time_of_eigenvalues(N, SCHUR)
    units = _balancing(H)  # x = units xi
    both, squares = np.append(units, 1 / units), np.outer(units, units)
    H = H / both[:, None] * both
    A, push, Q = H[:N, :N], -H[:N, N:], -H[N:, :N]
    X, eigenvalues = _by_schur_vectors(H)
    if X is not None:
        XA, bent = X @ A, X @ push @ X
        size = max(np.abs(x).max() for x in (XA, bent, Q))
        solves = np.abs(XA + XA.T - bent + Q).max() < RESIDUAL * size
        error = abs(np.trace(A - push @ X) - eigenvalues.sum())
        if solves and error < -eigenvalues.max():
            return X / squares
    check_time_of_eigenvalues(N, PENCIL)
    try:
        return solve_continuous_are(A, B / units[:, None], Q, R) / squares
    except ValueError as error:  # the pencil's stable half can't be sorted out
        raise np.linalg.LinAlgError(str(error)) from None


def balanced_units(A, B, Q, R):
    """Units of x, (N,), powers of two, that balance the Hamiltonian of `riccati` for A,
    B, Q and R; numpy.linalg.LinAlgError where it isn't finite.
    """
    return _balancing(_hamiltonian(A, B, Q, R))


def _hamiltonian(A, B, Q, R):
    return np.block([[A, -B @ np.linalg.solve(R, B.T)], [-Q, -A.T]])


def _balancing(H):
    """Units of x, powers of two, that balance a Hamiltonian ``H`` of [x; p], where p
    has the inverse units.

    Source: P. Benner, Linear Algebra and its Applications 330, 2001.
    """
    if not np.isfinite(H).all():
        raise np.linalg.LinAlgError("the equation isn't finite")
    N = len(H) // 2
    with np.errstate(all="ignore"):
        _, (scale, _) = matrix_balance(np.abs(H), permute=False, separate=True)
    powers = np.log2(scale)
    return 2.0 ** np.round((powers[:N] - powers[N:]) / 2)


def _by_schur_vectors(H):
    """The symmetric X of a Hamiltonian H, unless its stable half is lost, and the real
    parts of its loop's eigenvalues.
    """
    N = len(H) // 2
    _, stable, real, _, U, _, failed = dgees(lambda re, im: re < 0, H, sort_t=1)
    if failed or stable != N:
        return None, real
    try:
        X = np.linalg.solve(U[:N, :N].T, U[N:, :N].T)
    except np.linalg.LinAlgError:
        return None, real
    return (X + X.T) / 2, real[:N]
