"""Matrices over a box of two parameters, as the page proves what holds in it."""

import numpy as np

from ..page import significant


def ends_of(family, names):
    """Lows and highs of the two parameters of a family.

    ``family``: an `Uncertain`; ``names``: of the parameters. Raises ValueError if it
    has others, or powers of these.
    """
    if list(family.degree.items()) != [(name, 1) for name in names]:
        p, q = names
        raise ValueError(f"plants must have {p} and {q} without powers, got {family!r}")
    return [[float(x) for x in end] for end in (family.box.low, family.box.high)]


def bilinear(E, A, ends):
    """Of E(p, q) and A(p, q) the matrices X, P, Q, R of X + p P + q Q + p q R.

    ``E``, ``A``: their values where p and q are (low, low), (low, high), (high, low)
    and (high, high); ``ends``: the lows of p and q, and their highs. Raises ValueError
    if a parameter moves both, or E by a rank above one: the corners of a box wouldn't
    speak for it.

    >>> one = np.eye(2)
    >>> bilinear([one, one, 2 * one, 2 * one], [one] * 4, [[1, 1], [2, 2]])
    Traceback (most recent call last):
    ValueError: p and q must move E by a rank of one, or A alone
    """
    (p, q), (p1, q1) = ends
    found = []
    for a, b, c, d in (map(np.asarray, E), map(np.asarray, A)):
        R = (d - c - b + a) / ((p1 - p) * (q1 - q))
        P, Q = (c - a) / (p1 - p) - q * R, (b - a) / (q1 - q) - p * R
        found.append(
            [significant(x, 12) for x in (a - p * P - q * Q - p * q * R, P, Q, R)]
        )
    (_, *mass, both), (_, *rest, last) = (map(np.array, parts) for parts in found)
    for k, others in ((0, (q, q1, q + q1)), (1, (p, p1, p + p1))):
        rank = max(np.linalg.matrix_rank(mass[k] + x * both) for x in others)
        if rank > 1 or (rank and (rest[k].any() or last.any())):
            raise ValueError("p and q must move E by a rank of one, or A alone")
    return found
