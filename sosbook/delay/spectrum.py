"""Characteristic roots of loops with one delay.

Everything here is about x'(t) = A x(t) + A_d x(t - h) with a constant
delay h: what is true of the loop, to be held beside what an LMI proves.
Its roots are the zeros of det(s I - A - A_d e^(-s h)).
"""

import numpy as np
from scipy.optimize import minimize_scalar

from ..plants.checks import matrix, not_negative
from .collocation import balanced, rightmost_roots, root_radius


def delayed_loop(d, K):
    """A and A_d of the loop of a plant with a delayed input.

    Parameters
    ----------
    d : Descriptor
        E x' = A x + B_u u(t - h).
    K : (m, N) array_like
        The gain ``[K_P K_D K_I]`` in u = K x.

    Returns
    -------
    A, A_d : (N, N) arrays
        E^-1 A and E^-1 B_u K.

    Notes
    -----
    Source: thesis (2.10). K_A must be zero: an acceleration that is fed
    back late makes a neutral loop, which isn't of this form.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem
    >>> from sosbook.plants.descriptor import descriptors
    >>> d, = descriptors(SecondOrderSystem([[1]], [[0]], [[4]], [[2]]))
    >>> A, A_d = delayed_loop(d, [[-1, -3]])
    >>> A_d
    array([[ 0.,  0.], [-2., -6.]])
    """
    N, m = d.Bu.shape
    A, Bu, _ = d.state_space()
    return A, Bu @ matrix("K", K, (m, N))


def characteristic_roots(A, A_d, delay, count=10):
    """The rightmost roots of det(s I - A - A_d e^(-s delay)).

    Parameters
    ----------
    A, A_d : (N, N) array_like
        The matrices of x' = A x + A_d x(t - d).
    delay : float
        In seconds, 0 or more.
    count : int
        How many. There are N without delay, else mostly infinitely
        many. A conjugate pair isn't split, so one more may come.

    Returns
    -------
    (k,) complex array
        In rad/s, by falling real part, the upper root of a pair first; a multiple root
        as often as its multiplicity. No root right of the last one is missing. There
        are fewer than ``count`` where the loop has only finitely many, or where
        rounding errors in A_d decide about those further left; N where the delay is
        below 1e-8 of the loop's own times, and the others are far away.

    Raises
    ------
    ValueError
        On bad input, and if ``delay`` is so long that the roots would
        need a discretisation with more than 1000 unknowns.

    Notes
    -----
    Chebyshev collocation of the infinitesimal generator (Breda, Maset, Vermiglio, SIAM
    J. Sci. Comput. 27, 2005), of the delayed signals only: A_d of rank r gives an
    eigenvalue problem of order N + r k, with k nodes. Roots right of c lie in the disk
    whose radius is the largest spectral radius of A + A_d e^(-c delay + j theta); k is
    raised until that disk is resolved, for c of the last root found (Wu and Michiels,
    J. Comput. Appl. Math. 236, 2012). Newton's method on the smallest singular value of
    the characteristic matrix polishes each root; what it leaves with a residual is
    dropped. Entries of A_d below rounding of its largest singular value count as zero.

    Examples
    --------
    >>> characteristic_roots([[0]], [[-1]], delay=1, count=2).round(6)
    array([-0.318132+1.337236j, -0.318132-1.337236j])
    """
    A, A_d = checked_pair(A, A_d)
    delay = not_negative("delay", delay)
    whole = isinstance(count, (int, np.integer))
    if not whole or isinstance(count, bool) or count < 1:
        raise ValueError(f"count must be a positive integer, got {count!r}")
    return rightmost_roots(A, A_d, delay, int(count))


def spectral_abscissa(A, A_d, delay):
    """Real part of the rightmost root of x' = A x + A_d x(t - delay), in 1/s.

    Minus this number is the loop's exponential decay rate under that constant delay.
    Parameters, errors and method as in `characteristic_roots`.

    Examples
    --------
    >>> round(spectral_abscissa([[-1]], [[0.5]], 0), 9)
    -0.5
    """
    A, A_d = checked_pair(A, A_d)
    delay = not_negative("delay", delay)
    return rightmost_real(A, A_d, delay)


def slowest_decay(A, A_d, low, high):
    """The slowest decay over all constant delays of an interval.

    Parameters
    ----------
    A, A_d : (N, N) array_like
        The matrices of x' = A x + A_d x(t - d).
    low, high : float
        Ends of the interval, in seconds; 0 <= low <= high.

    Returns
    -------
    rate : float
        The smallest decay rate, in 1/s; negative if a delay is unstable.
    delay : float
        Where.

    Notes
    -----
    A grid with 16 steps to a period of the fastest root that can be the rightmost (32
    to 2000 steps in all), then Brent's method around each local minimum of the grid.
    The rate is attained at ``delay``, so the true minimum is no greater. That it is no
    smaller holds as far as the grid sees each dip; it isn't proven.

    Examples
    --------
    >>> rate, delay = slowest_decay([[0]], [[-1]], 0.1, 1)
    >>> round(rate, 6), delay
    (0.318132, 1.0)
    """
    A, A_d = checked_pair(A, A_d)
    low, high = not_negative("low", low), not_negative("high", high)
    if low > high:
        raise ValueError(f"low must not exceed high, got {low} > {high}")

    def rate(h):
        return -rightmost_real(A, A_d, h)

    if low == high:
        return rate(low), low
    slowest = min(rate(low), rate(high))
    turns = root_radius(A * high, A_d * high, -slowest * high) / (2 * np.pi)
    steps = np.clip(16 * turns * (1 - low / high), 32, 2000)
    grid = np.linspace(low, high, int(np.ceil(steps)) + 1)
    rates = np.array([rate(h) for h in grid])
    best = [(float(rates.min()), float(grid[rates.argmin()]))]
    inner = (rates[1:-1] <= rates[:-2]) & (rates[1:-1] <= rates[2:])
    for i in np.flatnonzero(inner) + 1:
        optimum = minimize_scalar(
            rate,
            bounds=(grid[i - 1], grid[i + 1]),
            method="bounded",
            options={"xatol": 1e-9 * high},
        )
        best.append((float(optimum.fun), float(optimum.x)))
    return min(best)


def checked_pair(A, A_d):
    """A and A_d, checked and balanced: a diagonal similarity keeps every root."""
    A = matrix("A", A)
    if A.shape[0] == 0:
        raise ValueError("A is empty: a loop has at least one state")
    A = matrix("A", A, (len(A), len(A)))
    A_d = matrix("A_d", A_d, A.shape)
    return balanced(A, A_d)


def rightmost_real(A, A_d, delay):
    """The real part of the rightmost root of A and A_d with a constant ``delay``."""
    return float(rightmost_roots(A, A_d, delay, 1)[0].real)


def decays(A, A_d, delay):
    """Whether the loop of A and A_d decays for a ``delay``, by more than rounding."""
    size = np.linalg.norm(A) + np.linalg.norm(A_d)
    return rightmost_real(A, A_d, delay) < -1e-12 * size
