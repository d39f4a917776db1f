"""Constant delays under which a loop decays: where roots cross the axis."""

import numpy as np
from scipy.linalg import eigvals

from ..plants.checks import not_negative
from .spectrum import EPS, checked_pair, decays, rank_factors


def stable_delays(A, A_d, longest):
    """The constant delays, up to ``longest``, under which a loop decays.

    Parameters
    ----------
    A, A_d : (N, N) array_like
        The matrices of x' = A x + A_d x(t - d).
    longest : float
        In seconds, 0 or more.

    Returns
    -------
    list of (float, float)
        Intervals (low, high) in [0, longest], in order, within which all roots have
        negative real part. At an end other than 0 and ``longest`` a root lies on the
        imaginary axis. Two intervals share an end where a root only touches the axis.

    Notes
    -----
    Delays with a root j w solve a problem without delay: A + A_d z has the eigenvalue j
    w for a z on the unit circle, and w is among the eigenvalues of a matrix of order 2
    N r, with r the rank of A_d (Louisell, IEEE Trans. Automat. Control 46, 2001; for r
    = 1 it is the Hamiltonian matrix of the transfer function that the delay closes).
    Then h = (-arg z + 2 pi k) / w. Between two such delays the number of unstable roots
    can't change, and the rightmost root in the middle decides. A root that stays at 0
    or on the axis for every delay (A + A_d singular, say) leaves no stable delay, nor
    does one within rounding of the axis. Where ``A_d`` is zero the answer is all or
    nothing.

    Examples
    --------
    x' = -x(t - h) decays until h = pi / 2; the second loop needs delay.

    >>> [(low, high)] = stable_delays([[0]], [[-1]], longest=10)
    >>> low, round(high, 9)
    (0.0, 1.570796327)
    >>> A, A_d = [[0, 1], [-2, 0.1]], [[0, 0], [1, 0]]
    >>> [(low, high)] = stable_delays(A, A_d, longest=5)
    >>> round(low, 5), round(high, 5)
    (0.10017, 1.71786)
    """
    A, A_d = checked_pair(A, A_d)
    longest = not_negative("longest", longest)
    ends = [0.0]
    for h in sorted(
        h
        for omega, phase in _crossings(A, A_d)
        for h in np.arange(phase, longest * omega, 2 * np.pi) / omega
    ):
        if h - ends[-1] > 1e-9 * h:  # not the same once more
            ends.append(float(h))
    if ends[-1] < longest or longest == 0:
        ends.append(longest)
    return [
        (low, high)
        for low, high in zip(ends, ends[1:])
        if decays(A, A_d, (low + high) / 2)
    ]


def delay_margin(A, A_d):
    """The first delay at which the loop without delay stops decaying.

    Parameters
    ----------
    A, A_d : (N, N) array_like
        The matrices of x' = A x + A_d x(t - d).

    Returns
    -------
    float
        In seconds: 0 if the loop is unstable without delay, infinite if
        it decays under every constant delay.

    Notes
    -----
    Method as in `stable_delays`, which also finds what lies beyond.

    Examples
    --------
    >>> round(delay_margin([[0]], [[-2]]), 9), delay_margin([[-3]], [[1]])
    (0.785398163, inf)
    """
    A, A_d = checked_pair(A, A_d)
    if not decays(A, A_d, 0.0):
        return 0.0
    return float(
        min((phase / omega for omega, phase in _crossings(A, A_d)), default=np.inf)
    )


def _crossings(A, A_d):
    """All (w, phase), w > 0, 0 <= phase < 2 pi, with a root j w at
    the delays (phase + 2 pi k) / w.

    If (j w - A - A_d z) v = 0 with |z| = 1 and A_d = left @ right, then
    X = v (right v)* and Y = z right v v* fulfil
        j w X = A X + left Y right',  j w Y = -Y A' - right X left'.
    """
    if not A_d.any():
        return []
    left, right = rank_factors(A_d)
    one = np.eye(len(right))
    s = eigvals(
        np.block(
            [
                [np.kron(A, one), np.kron(left, right)],
                [-np.kron(right, left), -np.kron(one, A)],
            ]
        )
    )
    size = np.linalg.norm(A) + np.linalg.norm(A_d)
    near = (abs(s.real) < 1e-4 * size) & (s.imag > 1e-10 * size)
    crossings = []
    for omega in s[near].imag:
        pencil = 1j * omega * np.eye(len(A)) - A, A_d.astype(complex)
        alpha, beta = eigvals(*pencil, homogeneous_eigvals=True)
        unit = abs(abs(alpha) - abs(beta)) < 0.1 * abs(beta)
        for z in alpha[unit] / beta[unit]:
            crossing = _refine(A, A_d, omega, -np.angle(z))
            if crossing is not None:
                crossings.append(crossing)
    return crossings


def _refine(A, A_d, omega, phase):
    """Newton's method for a root j omega at delay phase / omega."""
    one, start = np.eye(len(A)), omega
    size = np.linalg.norm(A) + np.linalg.norm(A_d)
    for _ in range(30):
        late = A_d * np.exp(-1j * phase)
        U, sigma, Vh = np.linalg.svd(1j * omega * one - A - late)
        u, v = U[:, -1].conj(), Vh[-1].conj()
        if sigma[-1] <= 4 * EPS * size:
            break
        slopes = np.array([1j * u @ v, 1j * u @ late @ v])
        rows = np.array([slopes.real, slopes.imag])
        step = np.linalg.lstsq(rows, [-sigma[-1], 0.0])[0]
        omega, phase = omega + step[0], phase + step[1]
        if not abs(omega - start) <= 0.01 * size:
            return None
    if sigma[-1] > 1e-13 * size or omega <= 1e-10 * size:
        return None
    return omega, phase % (2 * np.pi)
