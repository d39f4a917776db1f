"""Motions of loops that are too sensitive for floats: exact rates, then balls."""

import numpy as np
from flint import arb, arb_mat, ctx

from ..exact.definite import exact, inverse

BITS = 256, 1024, 4096  # of the balls, until they are small enough
SMALL = 1e-17  # radius of the balls, by the largest entry


def exact_forms(d, K):
    """A + B K, B and B_w of a loop x' = A x + B u + B_w w, u = K x, without a rounding
    error, of a ``Descriptor`` d in floats that are read as decimals.
    """
    d, K = d.map(exact), exact(K)
    back = inverse(d.E)
    return back @ (d.A + d.Bu @ K), back @ d.Bu, back @ d.Bw


def exact_flow(generator, span):
    """e^(generator span) of a rational ``generator``, ``span`` in s, in floats."""
    rows = (generator * exact(float(span))).tolist()
    for bits in BITS:
        with ctx.workprec(bits):
            power = arb_mat([[arb(e) for e in row] for row in rows]).exp().table()
            middle = np.array([[float(e.mid()) for e in row] for row in power])
            radius = max(float(e.rad()) for row in power for e in row)
        if radius <= SMALL * np.abs(middle).max():
            break
    return middle
