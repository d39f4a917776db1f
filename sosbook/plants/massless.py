"""Displacements, and mixtures of them, that have neither mass nor damping."""

import numpy as np
from flint import fmpq, fmpq_mat, nmod_mat
from scipy.sparse import issparse

from ..exact.rational import exact, null_basis

MOST_NAMED = 12  # rows in an error, which is one line
PRIME = 2**61 - 1  # a rank that is full modulo it is full
WEIGHT = fmpq(355, 113)  # of damping beside mass: of no round ratio


def massless(M, D):
    """The rows in which square M and D are zero, as in the columns of these numbers.

    Examples
    --------
    >>> massless(np.diag([1.0, 0.0, 0.0]), np.diag([0.0, 0.0, 2.0]))
    array([1])
    """
    sums = [np.asarray((abs(M) + abs(D)).sum(axis=k)).ravel() for k in (0, 1)]
    return np.flatnonzero((sums[0] == 0) & (sums[1] == 0))


def massless_directions(M, D):
    """All z with M z = 0 and D z = 0, and all y with y' M = 0 and y' D = 0: exact.

    ``M``, ``D``, (n, n): read as decimals. Returns N, L, (n, k) of fmpq: columns span
    them; each is one in a row of its own, where the others are zero.

    >>> N, L = massless_directions(np.full((2, 2), 0.3), np.zeros((2, 2)))
    >>> N.tolist() == L.tolist() == [[-1], [1]]
    True
    """
    rows = massless(M, D)
    rest = np.setdiff1d(np.arange(len(M)), rows)
    if _full(*(exact(x[np.ix_(rest, rest)]) for x in (M, D))):
        units = exact(np.eye(len(M)))[:, rows]
        return units, units
    N = null_basis(np.vstack([M, D]))
    symmetric = (M == M.T).all() and (D == D.T).all()
    return N, N if symmetric else null_basis(np.vstack([M.T, D.T]))


def _full(M, D):
    """Whether a sum of two square matrices is regular modulo a prime: then it is."""
    if not len(M):
        return True
    whole = fmpq_mat(*M.shape, (M + D * WEIGHT).ravel().tolist()).numer_denom()[0]
    return nmod_mat(whole, PRIME).rank() == len(M)


def massless_cure(M, D):
    """What to do about what is massless, for errors; empty where nothing is.

    M and D are those of the plant.

    Examples
    --------
    >>> massless_cure(np.diag([1.0, 0.0]), np.eye(2))
    ''
    >>> massless_cure(np.full((2, 2), 0.3), np.zeros((2, 2)))
    '; sosbook.plants.condense solves for the 1 direction without mass exactly'
    """
    rows = massless(M, D)
    if len(rows):
        named = ", ".join(map(str, rows[:MOST_NAMED])) + ", ..." * (
            len(rows) > MOST_NAMED
        )
        return f"; sosbook.plants.condense solves for z[{named}] exactly"
    count = 0 if issparse(M) else massless_directions(M, D)[0].shape[1]
    if not count:
        return ""
    some = f"{count} direction" + "s" * (count > 1)
    return f"; sosbook.plants.condense solves for the {some} without mass exactly"
