"""SRIVC: a continuous-time model from samples, without a first guess.

Simplified refined instrumental variables. Output error (`fit`) is the
better estimate once it has a start, and this is the start.
"""

from functools import lru_cache

import numpy as np
from scipy.signal import cont2discrete, lfilter

__all__ = ["respond", "srivc"]


def respond(numerator, denominator, V, T):
    """A transfer function's exact response to a held voltage, from rest.

    ``numerator``, ``denominator``: coefficients, highest power of s first; ``V``, (...,
    N): the voltage, held from one sample to the next; or several; ``T``: sampling time
    in s. Returns (..., N): the output at the times of the samples.
    """
    return sampled(numerator, denominator, V, T, "zoh")


def sampled(numerator, denominator, signal, T, hold):
    """The response to a signal that is held ("zoh") or joined by lines ("foh")."""
    return lfilter(*_discrete(tuple(numerator), tuple(denominator), T, hold), signal)


@lru_cache(maxsize=16)
def _discrete(numerator, denominator, T, hold):
    """Numerator and denominator of the sampled transfer function."""
    a = np.asarray(denominator, dtype=float)
    a = a / a[0]
    b = np.zeros(len(a))
    b[len(a) - len(numerator) :] = numerator
    b = b / denominator[0]
    n = len(a) - 1
    A = np.vstack([-a[1:], np.eye(n)[:-1]])  # controller's companion form
    C, D = b[1:] - b[0] * a[1:], b[0]
    A, B, C, D, _ = cont2discrete((A, np.eye(n)[:, :1], C[None], [[D]]), T, hold)
    den = np.poly(A)
    return np.poly(A - B @ C) + (np.asarray(D)[0, 0] - 1) * den, den


def srivc(V, y, T, zeros, order, cutoff, rounds=20):
    """A transfer function B(s) / A(s), A monic, from samples.

    Each round filters by the last A, and uses the last model's output
    as the instrument: noise on y leaves no bias.

    ``V``, ``y``, (N,): voltage (held) and output; ``T``: sampling time in s; ``zeros``:
    the powers of s in B; ``order``: the order of A; ``cutoff``: a frequency in rad/s;
    the first filter is (s + cutoff)^-order; ``rounds``: how often the filter is made
    anew. Returns B: a coefficient for each of ``zeros``; A, (order,): the coefficients
    but the leading one, highest power first. Raises ValueError if V or y is zero.

    Source: Young and Jakeman (1980), in the form of Garnier and Wang
    (2008).
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
