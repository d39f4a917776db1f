"""Exact multipliers without full rank: of a mode that nothing moves, say."""

from fractions import Fraction

import numpy as np
from flint import fmpq
from scipy.linalg import qr

from ..solver.blocks import Blocks
from .adjoint import adjoint
from .definite import exact, in_floats, positive, semidefinite
from .rational import rational_matrix, round_digits
from .repair import repair_multipliers

SHORT = 9  # digits of multipliers that somebody has written
GAP = 0.05  # of two eigenvalues that follow each other, where a rank may end
DENOMINATORS = 12, 100, 10**4, 10**6  # of a range, in the order of trial
MOST_ROWS = 60  # of all blocks: beyond them it takes long


def singular_multipliers(expressions, unknowns, Z):
    """Exact Z_k >= 0 near floats ``Z`` that exclude every value of the ``unknowns`` in
    ``expressions``, as `repair_multipliers` makes them, where some are singular; None
    if none are found. What is written in few digits is taken as it is. Else each range
    is rounded to short fractions, and the multipliers inside it are repaired.
    """
    if sum(map(len, Z)) > MOST_ROWS:
        return None
    if all((round_digits(z, SHORT) == z).all() for z in Z):
        exactly = [exact((z + z.T) / 2) for z in Z]
        if _excludes(expressions, unknowns, exactly) and all(
            map(semidefinite, exactly)
        ):
            return exactly
    for most in DENOMINATORS:
        bases = [_range(z, most) for z in Z]
        kept = [k for k, V in enumerate(bases) if V.shape[1]]
        if not kept or all(V.shape[0] == V.shape[1] for V in bases):
            return None
        few = [bases[k].T @ expressions[k] @ bases[k] for k in kept]
        shares = [np.linalg.pinv(bases[k].astype(float)) for k in kept]
        S = [V @ Z[k] @ V.T for k, V in zip(kept, shares)]
        S = [exact(round_digits((s + s.T) / 2, SHORT)) for s in S]
        if not (_excludes(few, unknowns, S) and all(map(positive, S))):
            slopes = Blocks([in_floats(g) for g in few], unknowns).slopes
            if not any(x.any() for x in slopes):
                continue
            repaired = repair_multipliers(few, unknowns, [s.astype(float) for s in S])
            if repaired is None:
                continue
            S = repaired[0]
        found = [exact(np.zeros(z.shape)) for z in Z]
        for k, s in zip(kept, S):
            found[k] = bases[k] @ s @ bases[k].T
        return found
    return None


def _excludes(expressions, unknowns, Z):
    """True if the sums of exact multipliers vanish, and what is left isn't positive."""
    if (adjoint(expressions, unknowns, Z) != 0).any():
        return False
    return sum((g.constant * z).sum() for g, z in zip(expressions, Z)) <= 0


def _range(z, most):
    """A basis of the range of a float z, (n, r), in fractions with denominators up to
    ``most``; r is where the eigenvalues fall most.
    """
    sizes, V = np.linalg.eigh((z + z.T) / 2)
    sizes, V = sizes[::-1], V[:, ::-1]
    if not sizes[0] > 0:
        return exact(np.zeros((len(z), 0)))
    falls = np.maximum(sizes[1:], 0) / sizes[:-1]
    r = int(np.argmin(falls)) + 1 if len(falls) and falls.min() < GAP else len(z)
    rows = qr(V[:, :r].T, mode="r", pivoting=True)[1][:r]
    basis = V[:, :r] @ np.linalg.inv(V[rows, :r])
    short = [[Fraction(x).limit_denominator(most) for x in row] for row in basis]
    return rational_matrix(
        [[fmpq(x.numerator, x.denominator) for x in r] for r in short]
    )
