"""Suspicions about a plant's matrices, which may be right all the same."""

import numpy as np

from ..runtime.sparse import issparse
from .massless import ROUNDED, light, light_cure
from .sparse import sparse_factor

LIGHT = (
    "a direction has next to no mass, {:.3g} of the others: ten digits don't tell it "
    "from none"
)


def suspicion(given):
    """A suspicion about ``given`` M, D, S, B and F, by name, in a sentence; else empty.

    >>> M, D, S = np.eye(3), np.eye(3), np.triu(np.ones((3, 3)))
    >>> suspicion(dict(M=M, D=D, S=S))[:49]
    'all entries of S beside its diagonal are above it'
    """
    fault = half_fault(given) or mass_fault(given["M"]) or _light(given)
    few = "sign" in fault and not issparse(given["M"]) and light_cure(given, True)
    return f"{fault[:-1]}, or are the digits of a file few{few}" if few else fault


def half_fault(given):
    """The words of `suspicion` where of ``given`` M, D and S one has entries in one
    triangle alone. Of two rows that takes two: one may couple in one direction.
    """
    sides = {name: side for name in "MDS" if (side := _side(given[name]))}
    if not sides or (given["M"].shape[0] == 2 and len(sides) < 2):
        return ""
    part = {"above": "triu({}, 1).T", "below": "tril({}, -1).T"}
    return "; ".join(
        f"all entries of {name} beside its diagonal are {side} it: is it half of a "
        f"symmetric matrix? The whole one is {name} + {part[side].format(name)}"
        for name, side in sides.items()
    )


def idle_inputs(B):
    """The columns of a B that are zero, in words; else empty.

    >>> idle_inputs(np.eye(2, 3))
    'column 2 of B is zero: that input pushes nothing'
    """
    idle = np.flatnonzero(~B.any(axis=0)).tolist()
    if not idle:
        return ""
    some = f"columns {', '.join(map(str, idle))} of B are" if idle[1:] else ""
    one = f"column {idle[0]} of B is"
    return f"{some or one} zero: that input pushes nothing"


def _side(x):
    """Where the entries beside the diagonal are, if all are on one side."""
    i, j = x.nonzero()
    above, below = (i < j).any(), (i > j).any()
    return "" if above == below else "above" if above else "below"


def mass_fault(M):
    """Why M is no mass matrix, in words; else empty."""
    largest = abs(M).max()
    skew = abs(M - M.T).max()
    if skew > ROUNDED * largest:
        return (
            f"M isn't symmetric: it differs from its transpose by {skew:.3g}. That is "
            "right where equations were divided or combined, and every theorem holds; "
            "Lagrange's equations have a symmetric M"
        )
    if issparse(M):
        least = sparse_factor(M).U.diagonal().min()
        which = "a negative eigenvalue"
    else:
        least = np.linalg.eigvalsh((M + M.T) / 2)[0]
        which = f"the negative eigenvalue {least:.3g}"
    if least < -ROUNDED * largest:
        return f"M has {which}, which no kinetic energy has: is a sign wrong?"
    return ""


def divided(M, S):
    """True if positive factors of the rows make both dense M and S symmetric, and M
    definite: they are Lagrange's equations, each divided by something.

    >>> divided(np.array([[3.0, 4], [1, 2]]), np.diag([0, 9.81]))
    True
    """
    M, S, factors = np.array(M, float), np.array(S, float), np.zeros(len(M))
    for start in range(len(M)):
        joined = [] if factors[start] else [start]
        factors[joined] = 1.0
        for i in joined:
            for j in np.flatnonzero(M[i] * M[:, i] > 0):
                if not factors[j]:
                    factors[j] = factors[i] * M[i, j] / M[j, i]
                    joined.append(j)
    both = [factors[:, None] * x for x in (M, S)]
    same = all(abs(x - x.T).max() <= ROUNDED * abs(x).max() for x in both)
    return bool(same and np.linalg.eigvalsh(both[0])[0] > 0)


def _light(given):
    """Masses that are lost in the digits with which they were printed."""
    M = given["M"]
    if issparse(M):
        return ""
    least = light((M + M.T) / 2)
    if least is None:
        return ""
    return LIGHT.format(least) + light_cure(given)
