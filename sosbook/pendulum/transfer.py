"""The body's transfer functions, from (4.19) to (4.20), and figure 4.4."""

import numpy as np

from .fit import output_error
from .srivc import respond, srivc

__all__ = ["bode_band", "constrained", "equal_peaks"]


def equal_peaks(numerator, denominator):
    """The gain k of k s / A(s) whose peak is that of B(s) / A(s).

    ``numerator``, (2,) sequence: B = [b1, b0], as in b1 s + b0; ``denominator``, (3,)
    sequence: A = [1, f, d]. Returns the gain, with b1's sign.

    Source: thesis, from (4.19) to (4.20).
    """
    b1, b0 = numerator
    one, f, d = denominator
    if one != 1 or not (f > 0 and d > 0):
        raise ValueError("denominator must be [1, f, d] with positive f, d")
    # |B|^2 / |A|^2 over x = w^2; its slope vanishes at the peak
    B = np.poly1d([b1**2, b0**2])
    A = np.poly1d([1, f**2 - 2 * d, d**2])
    x = (B.deriv() * A - B * A.deriv()).roots
    x = np.append(x[x.real > 0].real, 0.0)  # such roots aren't complex
    peak = np.sqrt((B(x) / A(x)).max())
    return float(np.copysign(peak * f, b1))  # k s / A peaks with |k| / f


def constrained(numerator, denominator, V, T):
    """The model (4.18) that answers most like another one.

    Instead of moving a zero and keeping the poles: all three ratios are
    fitted, in least squares, to the other model's answer to V.

    ``numerator``, ``denominator``: those of the other model, such as (4.19); ``V``,
    (N,): voltage, such as the experiment's; ``T``: sampling time in s. Returns Fit: its
    parameters are e_c, f_c and d_c.
    """
    y = respond(numerator, denominator, V, T)
    B, A = srivc(V, y, T, [1], 2, cutoff=10.0)
    start = dict(e_c=-B[0], f_c=A[0], d_c=A[1])
    return output_error(lambda e, f, d: respond([-e, 0.0], [1.0, f, d], V, T), y, start)


def bode_band(numerator, denominator, omega, spread=0.04):
    """Magnitudes of a transfer function whose gain is uncertain.

    ``numerator``, ``denominator``: coefficients, highest power of s first; ``omega``,
    (N,): angular frequencies, in rad/s; ``spread``: the relative uncertainty of the
    gain. Returns (3, N): magnitudes in dB, with the gain low, as given, and high.

    Source: thesis, figures 4.4 and 4.5.
    """
    s = 1j * np.asarray(omega, dtype=float)
    H = np.polyval(numerator, s) / np.polyval(denominator, s)
    gains = np.array([[1 - spread], [1.0], [1 + spread]])
    return 20 * np.log10(gains * abs(H))
