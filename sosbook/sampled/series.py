"""Power series of matrices of balls in several unknowns, up to a degree.

A series is {exponents: `flint.arb_mat`}; what isn't in it is zero. If the terms at zero
are those of a function's derivatives somewhere, so are the products' and the others'.
"""

from itertools import combinations_with_replacement as choices
from itertools import product as cartesian
from math import factorial

import numpy as np
from flint import arb, arb_mat

from .balls import entries, hull

__all__ = ["exponential", "exponents", "moved", "parts", "quotient", "times"]

TERMS = 20  # of the exponential of what is shorter than a half


def exponents(axes, degree):
    """Of all monomials of ``axes`` unknowns up to a ``degree``, by degree: tuples."""
    several = [some for d in range(degree + 1) for some in choices(range(axes), d)]
    return [tuple(map(some.count, range(axes))) for some in several]


def parts(corners, box, whole):
    """The series of what is affine in each unknown, from its ``corners``, (k, ., .) of
    balls: around the middle of their cell, or (``whole``) around all of its points.

    Of a ``box`` the unknowns are from -1 to 1, the last one moves fastest; of a simplex
    they are the weights of all corners but the last, less their means.
    """
    found, axes = {}, (len(corners) - 1).bit_length() if box else len(corners) - 1
    for e in cartesian((0, 1), repeat=axes) if box else exponents(axes, 1):
        several = np.array(corners)
        if box:
            stack = several.reshape((2,) * axes + several.shape[1:])
            for k in np.flatnonzero(e)[::-1]:
                low, high = np.moveaxis(stack, k, 0)
                stack = (high - low) / 2
            several = stack.reshape(-1, *several.shape[1:])
        elif sum(e):
            several = several[[e.index(1)]] - several[-1]
        some = hull(several) if whole else sum(several) / len(several)
        found[e] = arb_mat(*some.shape, some.ravel().tolist())
    return found


def times(x, y, degree):
    """The product of two series x and y, up to a ``degree``."""
    found = {}
    for (a, left), (b, right) in cartesian(x.items(), y.items()):
        if sum(a) + sum(b) <= degree:
            e = tuple(map(sum, zip(a, b)))
            both = left * right
            found[e] = found[e] + both if e in found else both
    return found


def quotient(E, A, degree, first=None):
    """The series X with E X = A up to a ``degree``, whose ``first`` term is known or
    not.
    """
    zero, *others = exponents(len(next(iter(E))), degree)
    found = {zero: E[zero].solve(A[zero]) if first is None else first}
    for e in others:
        right = A.get(e, 0 * A[zero])
        for b, matrix in E.items():
            rest = tuple(x - y for x, y in zip(e, b))
            if sum(b) and min(rest) >= 0:
                right = right - matrix * found[rest]
        found[e] = E[zero].solve(right)
    return found


def moved(x, _):
    """One more than a series x of square matrices: what a plant of discrete time has
    in the place of its exponential.
    """
    zero = min(x, key=sum)
    return x | {zero: x[zero] + arb_mat(x[zero].nrows(), x[zero].nrows(), 1)}


def exponential(x, degree):
    """The exponential of a series x of square matrices, up to a ``degree``: the square
    of the square ... of Taylor's sum for a part of x.

    The sum s of the terms' norms is that of an algebra, so what comes after n terms is
    less than 2 s^n / n! where s is at most a half.
    """
    size = sum((_norm(matrix) for matrix in x.values()), arb(0)).upper()
    halvings = 0
    if not size.is_finite():
        raise ZeroDivisionError("a hull so wide that nothing is known in it")
    while not size < 0.5:
        size, halvings = size / 2, halvings + 1
    x = {e: matrix * arb(2) ** -halvings for e, matrix in x.items()}
    (zero, *_), first = exponents(len(next(iter(x))), 0), next(iter(x.values()))
    one = arb_mat(first.nrows(), first.nrows(), 1)
    term, total = {zero: one}, {zero: one}
    for n in range(1, TERMS):
        term = {e: y / n for e, y in times(term, x, degree).items()}
        total = {e: total[e] + y if e in total else y for e, y in term.items()}
    late = 2 * size**TERMS / factorial(TERMS)
    ball = arb(0, late.upper())
    late = arb_mat(one.nrows(), one.nrows(), [ball] * one.nrows() ** 2)
    total = {e: y + late for e, y in total.items()}
    for _ in range(halvings):
        total = times(total, total, degree)
    return total


def _norm(x):
    """The largest row sum of sizes."""
    sizes = abs(entries(x)).sum(axis=1)
    return max((one.upper() for one in sizes), default=arb(0))
