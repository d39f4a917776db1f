"""Mass matrices: large sparse ones, what is asked of any, and what is without mass."""

import numpy as np
from flint import fmpq, fmpq_mat, nmod_mat
from scipy.sparse import csc_array, issparse
from scipy.sparse.linalg import splu

from ..exact.rational import exact, null_basis
from .checks import check_rank, matrix

MOST_NAMED = 12  # rows in an error, which is one line
PRIME = 2**61 - 1  # a rank that is full modulo it is full
WEIGHT = fmpq(355, 113)  # of damping beside mass: of no round ratio


def massless(M, D):
    """The rows in which square M and D are zero, as in the columns of these numbers."""
    sums = [np.asarray((abs(M) + abs(D)).sum(axis=k)).ravel() for k in (0, 1)]
    return np.flatnonzero((sums[0] == 0) & (sums[1] == 0))


def massless_directions(M, D):
    """All z with M z = 0 and D z = 0, all y with y'M = 0 and y'D = 0, ``M`` and ``D``
    read as decimals: columns of fmpq, each one in a row of its own.
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
    """What to do about what is massless in M and D, for errors; empty where nothing is.

    >>> massless_cure(np.full((2, 2), 0.3), np.zeros((2, 2)))
    '; sosbook.plants.condense solves for the 1 direction without mass exactly'
    """
    rows = massless(M, D)
    if len(rows):
        more = ", ..." * (len(rows) > MOST_NAMED)
        named = ", ".join(map(str, rows[:MOST_NAMED])) + more
        return f"; sosbook.plants.condense solves for z[{named}] exactly"
    count = 0 if issparse(M) else massless_directions(M, D)[0].shape[1]
    if not count:
        return ""
    some = f"{count} direction" + "s" * (count > 1)
    return f"; sosbook.plants.condense solves for the {some} without mass exactly"


MOST_DENSE = 1000  # displacements; no LMI of so many is solved, dense or not
ROUNDING = 1e-9  # of the largest entry
NO_RANK = (
    "[M B] lacks full row rank: no acceleration feedback can make M - B K_A "
    "nonsingular, for a row (or a mixture of rows) has neither mass nor input. Where "
    "it has damping it is of first order: write a DescriptorSystem without that "
    "velocity. Where it has none, solve it for its displacement and put that into the "
    "other rows"
)


def reader(*given):
    """What reads the ``given`` M, D and S: `matrix`, or what keeps them sparse."""
    large = any(issparse(x) and max(x.shape) > MOST_DENSE for x in given)
    return _sparse if large else matrix


def _sparse(name, value, shape=None):
    """A csc_array that can't be written to, checked as `matrix` does."""
    if not issparse(value):
        value = matrix(name, value, shape)
    kept = csc_array(value, copy=True)
    kept.sum_duplicates()
    kept.eliminate_zeros()
    rows = kept.shape[0] if shape is None else shape[0]
    if kept.shape != (rows, rows):
        raise ValueError(f"{name} is {kept.shape}, needs {(rows, rows)}")
    kept.data = matrix(name, kept.data.reshape(1, -1))[0]
    for part in (kept.data, kept.indices, kept.indptr):
        part.flags.writeable = False
    return kept


def check_mass(M, D, B):
    """Raise where [``M`` ``B``] lacks full row rank; the cure looks at ``D``."""
    try:
        if not issparse(M):
            check_rank(np.hstack([M, B]), NO_RANK, 1e-14)
        elif sparse_factor(M) is None:
            raise ValueError(NO_RANK)
    except ValueError as fault:
        raise ValueError(f"{fault}{massless_cure(M, D)}") from None


def check_small(v):
    """Raise where a second-order plant ``v`` is large and its matrices are sparse."""
    if issparse(v.M):
        raise ValueError(
            f"the plant has {v.n} displacements in sparse matrices, too many for an "
            "LMI: design for plant.reduce(modes=...), then look at the whole by "
            "design.check_on(plant)"
        )


def sparse_factor(x):
    """SuperLU's factors of a sparse ``x`` without exchanges of rows, or None: of a
    symmetric matrix their diagonal has the signs of its eigenvalues.
    """
    options = dict(permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0)
    try:
        return splu(csc_array(x), options=dict(SymmetricMode=True), **options)
    except RuntimeError:
        return None


def mass_fault(M):
    """Why M is no mass matrix, in words; else empty."""
    largest = abs(M).max()
    skew = abs(M - M.T).max()
    if skew > ROUNDING * largest:
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
    if least < -ROUNDING * largest:
        return f"M has {which}, which no kinetic energy has: is a sign wrong?"
    return ""


def same_matrix(a, b):
    """Whether the matrices ``a`` and ``b`` are equal, dense or sparse."""
    if issparse(a) and issparse(b):
        return a.shape == b.shape and (a != b).nnz == 0
    return not issparse(a) and not issparse(b) and np.array_equal(a, b)
