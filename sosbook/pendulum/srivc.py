"""SRIVC: a continuous-time model from samples, without a first guess.

Simplified refined instrumental variables. Output error (`fit`) is the
better estimate once it has a start, and this is the start.
"""

from functools import lru_cache

import numpy as np
from scipy.linalg import expm
from scipy.signal import lfilter

__all__ = ["respond", "srivc"]


def respond(numerator, denominator, V, T):
    """A transfer function's exact response to a held voltage, from rest.

    Parameters
    ----------
    numerator, denominator : sequences
        Coefficients, highest power of s first.
    V : (..., N) array_like
        The voltage, held from one sample to the next; or several.
    T : float
        Sampling time in s.

    Returns
    -------
    (..., N) array
        The output at the times of the samples.

    Examples
    --------
    >>> y = respond([1.0], [1.0, 1.0], np.ones(101), 0.01)
    >>> bool(np.isclose(y[-1], 1 - np.exp(-1)))
    True
    """
    return sampled(numerator, denominator, V, T, "zoh")


def sampled(numerator, denominator, signal, T, hold):
    """The response to a signal that is held ("zoh") or joined by lines ("foh")."""
    a = np.asarray(denominator, dtype=float)
    b = np.zeros(len(a))
    b[len(a) - len(numerator) :] = numerator
    a, b = a / a[0], b / a[0]
    C, D = b[1:] - b[0] * a[1:], b[0]
    den, states, joining = _discrete(tuple(a[1:].tolist()), float(T))
    if hold == "foh":
        states, D = joining[:-1], D + C @ joining[-1]
    # the first answers to one sample, times the denominator
    num = np.convolve(den, [D, *(states @ C)])[: len(den)]
    return lfilter(num, den, signal)


@lru_cache(maxsize=16)
def _discrete(a, T):
    """A sampled chain of integrators with feedback ``a``: what no output changes.

    Its characteristic polynomial; its n states after one sample that is held,
    from the next one on; and those after one that is joined by lines, with what
    it does at once in the last row.
    """
    n = len(a)
    whole = np.zeros((n + 2, n + 2))  # controller's companion form, V and its slope
    whole[0, :n], whole[0, n] = np.negative(a), 1.0
    for k in range(1, n):
        whole[k, k - 1] = 1.0
    whole *= T
    whole[n, n + 1] = 1.0
    whole = expm(whole)
    F, held, ramp = whole[:n, :n], whole[:n, n], whole[:n, n + 1]
    power, den = F.copy(), []  # Faddeev and LeVerrier
    for k in range(1, n + 1):
        den.append(-power.trace() / k)
        power.flat[:: n + 1] += den[-1]
        power = F @ power
    states, joining = [held], [held - ramp + F @ ramp]
    for _ in range(n - 1):
        states.append(F @ states[-1])
        joining.append(F @ joining[-1])
    return np.array([1.0, *den]), np.array(states), np.array([*joining, ramp])


def srivc(V, y, T, zeros, order, cutoff, rounds=20):
    """A transfer function B(s) / A(s), A monic, from samples.

    Each round filters by the last A, and uses the last model's output
    as the instrument: noise on y leaves no bias.

    Parameters
    ----------
    V, y : (N,) array_like
        Voltage (held) and output.
    T : float
        Sampling time in s.
    zeros : sequence of int
        The powers of s in B.
    order : int
        The order of A.
    cutoff : float
        A frequency in rad/s; the first filter is (s + cutoff)^-order.
    rounds : int
        How often the filter is made anew.

    Returns
    -------
    B : array
        A coefficient for each of ``zeros``.
    A : (order,) array
        The coefficients but the leading one, highest power first.

    Raises
    ------
    ValueError
        If V or y is zero.

    Notes
    -----
    Source: Young and Jakeman (1980), in the form of Garnier and Wang
    (2008).

    Examples
    --------
    >>> V = np.sign(np.sin(np.arange(400) / 9))
    >>> y = respond([2.0], [1.0, 3.0], V, 0.01)
    >>> B, A = srivc(V, y, 0.01, zeros=[0], order=1, cutoff=5.0)
    >>> B.round(3), A.round(3)
    (array([2.]), array([3.]))
    """
    A = np.poly([-float(cutoff)] * order)
    B = x = None
    for _ in range(rounds):
        inputs = [_filtered(V, A, k, T, "zoh") for k in zeros]
        powers = range(order - 1, -1, -1)
        outputs = [-_filtered(y, A, k, T, "foh") for k in powers]
        instruments = (
            [-_filtered(x, A, k, T, "foh") for k in powers]
            if (x is not None)
            else outputs
        )
        target = _filtered(y, A, order, T, "foh")
        Z, W = np.array([*instruments, *inputs]), np.array([*outputs, *inputs])
        try:
            coefficients = np.linalg.solve(Z @ W.T, Z @ target)
        except np.linalg.LinAlgError:
            raise ValueError(
                "the log has no motion, or no voltage that excites one"
            ) from None
        new = _stable(np.append(1.0, coefficients[:order]))
        still = np.allclose(new, A, rtol=1e-9)
        A, B = new, coefficients[order:]
        if still:
            break
        x = sum(b * _filtered(V, A, k, T, "zoh") for b, k in zip(B, zeros))
    return B, A[1:]


def _filtered(signal, A, power, T, hold):
    """s^power / A(s) on a signal that is held (zoh) or joined (foh)."""
    numerator = np.zeros(len(A))
    numerator[len(A) - 1 - power] = 1.0
    return sampled(numerator, A, signal, T, hold)


def _stable(A):
    """The polynomial with its unstable roots mirrored."""
    roots = np.roots(A)
    return np.poly(-abs(roots.real) + 1j * roots.imag).real
