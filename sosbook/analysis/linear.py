"""Poles, norms and peaks of a closed loop, without LMIs."""

import numpy as np
from scipy.linalg import matrix_balance

from ..runtime.time_limit import check_time, check_time_of_eigenvalues

MOST_ENTRIES = 2**19  # of the matrices that are solved at once


def loop_matrix(d, K):
    """E^-1 (A + B_u K) of one vertex d."""
    return np.linalg.solve(d.E, d.A + d.Bu @ K)


def balancing(A):
    """Units of the states, powers of two: ``A / units[:, None] * units`` has rows like
    its columns, and hardly depends on the units in which A was given.

    Source: B. N. Parlett and C. Reinsch, Numer. Math. 13, 1969.
    """
    with np.errstate(all="ignore"):
        _, (units, _) = matrix_balance(A, permute=False, separate=True)
    return units


def poles(d, K):
    """Closed-loop poles of one vertex d under u = K x, in rad/s, sorted.

    They come from rational arithmetic where floats are too coarse: see
    `sensitive`.
    """
    from ..plants.response import sort_poles
    from .precise import ExactLoop, in_rationals

    if in_rationals(d, K):
        return sort_poles(ExactLoop(d, K).poles())
    check_time_of_eigenvalues(len(d.E))
    return sort_poles(np.linalg.eigvals(loop_matrix(d, K)))


def open_loop(d):
    """The plant d with its integrators as python-control's StateSpace, thesis (2.8):
    inputs u, w and r, outputs x = [z; z'; x3], so that u = K (x - [r; 0; 0]) closes the
    loop; x3 is + the integral of U e.
    """
    from ..runtime.libraries import library

    n, N = len(d.C), len(d.E)
    A, B, Bw = d.state_space()
    m, p = B.shape[1], Bw.shape[1]
    names = {"inputs": _named(u=m, w=p, r=n), "outputs": _named(x=N)}
    B, D = np.hstack([B, Bw, _set_point(d)]), np.zeros((N, m + p + n))
    return library("control").ss(A, B, np.eye(N), D, **names)


def _named(**counts):
    """The signals of some letters: u1, u2, ..., w1, ..."""
    return [f"{x}{k + 1}" for x, count in counts.items() for k in range(count)]


def _set_point(d):
    """How a constant r enters x': only through the integrators."""
    n, N = len(d.C), len(d.E)
    entry = np.zeros((N, n))
    entry[2 * n :] = -d.A[2 * n :, :n]
    return entry


def closed_loop(d, K):
    """The loop of d under u = K x as python-control's StateSpace, thesis (2.8): inputs
    w, then r; outputs z, then u = K_P e + K_D e' + K_I x3 for r constant (r' = 0); x3
    is + the integral of U e. An acceleration term K_A e'' is in the loop but not in
    this u.
    """
    from ..runtime.libraries import library

    n = len(d.C)
    _, B, Bw = d.state_space()
    A = loop_matrix(d, K)
    K_P = K[:, :n]
    D = np.zeros((n + len(K), d.Bw.shape[1] + n))
    D[n:, d.Bw.shape[1] :] = -K_P
    names = {"inputs": _named(w=Bw.shape[1], r=n), "outputs": _named(z=n, u=len(K))}
    B, C = np.hstack([Bw, _set_point(d) - B @ K_P]), np.vstack([d.C, K])
    return library("control").ss(A, B, C, D, **names)


def unstable(A, step=None):
    """True if x' = ``A`` x doesn't die out; with a ``step`` x' is (x(k+1) - x(k)) /
    step, and x(k) is meant.
    """
    poles = np.linalg.eigvals(A)
    if step is not None:
        return np.abs(1 + step * poles).max() >= 1
    return poles.real.max() >= 0


def gramian(A, weight, step):
    """X with A X + X A' + step A X A' + ``weight`` = 0: where x(k+1) = (I + step A)
    x(k) + w and w has the covariance step times the weight, that of x is X.
    """
    from scipy.linalg import solve_discrete_lyapunov

    return solve_discrete_lyapunov(np.eye(len(A)) + step * A, step * weight)


def hinf_norm(d, K, step=None):
    """H-infinity norm of d under u = K x, from w to y; infinite if it is unstable.

    With a ``step`` it is that of a plant of discrete time whose change is d: the
    bilinear z = (1 + step s / 2) / (1 - step s / 2) takes the circle to the axis.

    Notes
    -----
    Source: Bruinsma and Steinbuch (1990): a level that the largest
    singular value reaches shows as imaginary eigenvalues of a
    Hamiltonian matrix; between them lie better frequencies. A loop too
    sensitive for floats is left to `ExactLoop`.
    """
    from .precise import ExactLoop, in_rationals

    if step is not None:
        return _norm_of_ticks(d, K, step)
    if in_rationals(d, K):
        return ExactLoop(d, K).hinf_norm()
    _, _, B = d.state_space()
    d = d.explicit()
    D = 0.0 if d.Dw is None else d.Dw
    return peak_gain(loop_matrix(d, K), B, d.output(K), D)


def _norm_of_ticks(d, K, step):
    """`hinf_norm` of a plant of discrete time: its (z - 1) / step is s / (1 - step s /
    2) with such an s.
    """
    A, (_, _, B) = loop_matrix(d, K), d.state_space()
    if unstable(A, step):
        return np.inf
    middle = np.eye(len(A)) + step / 2 * A
    C = np.linalg.solve(middle.T, d.output(K).T).T
    D = (0.0 if d.Dw is None else d.Dw) - step / 2 * C @ B
    return peak_gain(*(np.linalg.solve(middle, x) for x in (A, B)), C, D)


def peak_gain(A, B, C, D=0.0):
    """The largest singular value of C (jw - A)^-1 B + D over all w (D may be 0), the
    H-infinity norm, as in `hinf_norm`; infinite where A isn't stable.

    >>> one = np.eye(1)
    >>> round(peak_gain(-one, one, one), 6), round(peak_gain(-one, one, -one, one), 6)
    (1.0, 1.0)
    """
    check_time_of_eigenvalues(len(A))
    poles = np.linalg.eigvals(A)
    if poles.real.max() >= 0:
        return np.inf
    D = np.broadcast_to(D, (len(C), B.shape[1]))
    unit = np.linalg.norm(B) * np.linalg.norm(C)
    if unit == 0:
        return float(np.linalg.norm(D, 2))
    B, C, D = B / np.linalg.norm(B), C / np.linalg.norm(C), D / unit
    at_once = max(1, MOST_ENTRIES // A.size)

    def gain(omega):
        some, most = np.ravel(omega), 0.0
        for k in range(0, len(some), at_once):
            check_time()
            pencil = 1j * some[k : k + at_once, None, None] * np.eye(len(A)) - A
            answers = C @ np.linalg.solve(pencil, B + 0j) + D
            most = max(most, np.linalg.norm(answers, 2, axis=(1, 2)).max())
        return most

    guesses = np.concatenate([[0.0], abs(poles), abs(poles.imag)])
    best = max(np.linalg.norm(D, 2), gain(guesses))
    for _ in range(50):
        level = best * (1 + 1e-9)
        if level == 0:
            break
        check_time_of_eigenvalues(2 * len(A))
        R = np.eye(D.shape[1]) - D.T @ D / level**2
        through = B @ np.linalg.solve(R, np.column_stack([D.T @ C / level**2, B.T]))
        F, BB = A + through[:, : len(A)], through[:, len(A) :]
        CC = C.T @ C + C.T @ D @ np.linalg.solve(R, D.T @ C) / level**2
        hamiltonian = np.block([[F, BB / level], [-CC / level, -F.T]])
        crossings = np.unique(abs(np.linalg.eigvals(hamiltonian).imag))
        between = (crossings[1:] + crossings[:-1]) / 2
        higher = gain(np.concatenate([[0.0], crossings, between]))
        if higher <= level:
            break
        best = higher
    return float(best * unit)


def peak_input(d, K, x0, K_A=None, inputs=None):
    """The largest |K x(t)| of the free response of d from x0, of some ``inputs``.

    With K_A the largest |K x(t) + K_A z''(t)|, the whole signal. It is
    infinite for an unstable loop. See `sosbook.analysis.peaks`; a loop too
    sensitive for floats is left to `ExactLoop`.
    """
    from .peaks import FreeMotion, largest_size
    from .precise import ExactLoop, in_rationals

    if K_A is None and in_rationals(d, K):
        peak = ExactLoop(d, K).peak_input(x0, inputs)
        if peak is not None:
            return peak
    A = loop_matrix(d, K)
    if np.linalg.eigvals(A).real.max() >= 0:
        return np.inf
    if K_A is not None:
        n = len(d.C)
        K = K + K_A @ A[n : 2 * n]
    K = K if inputs is None else K[list(inputs)]
    return largest_size(FreeMotion(A, K, x0))
