"""Large sparse matrices, and what is asked of the mass of any plant."""

import numpy as np

from ..runtime.sparse import issparse
from .checks import check_rank, matrix
from .massless import massless_cure

MOST_DENSE = 1000  # displacements; no LMI of so many is solved, dense or not
ORDERS = "COLAMD", "MMD_AT_PLUS_A"  # of SuperLU's columns: that of A' A, of A + A'
NO_RANK = (
    "[M B] lacks full row rank: no acceleration feedback can make M - B K_A "
    "nonsingular, for a row (or a mixture of rows) has neither mass nor input"
)
FIRST_ORDER = (
    ". Where it has damping it is of first order: write a DescriptorSystem without "
    "that velocity. Where it has none, solve it for its displacement and put that into "
    "the other rows"
)


def reader(*given):
    """The reader of ``given`` M, D and S: `matrix`, or one that keeps them sparse."""
    large = any(issparse(x) and max(x.shape) > MOST_DENSE for x in given)
    return _sparse if large else matrix


def _sparse(name, value, shape=None):
    """A csc_array that can't be written to, checked as `matrix` does."""
    from scipy.sparse import csc_array

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


def check_mass(given):
    """Raise where [M B] of ``given`` M, D, S, B and F lacks full row rank."""
    M, B = given["M"], given["B"]
    try:
        if not issparse(M):
            check_rank(np.hstack([M, B]), NO_RANK, 1e-14)
        elif sparse_factor(M) is None:
            raise ValueError(NO_RANK)
    except ValueError as fault:
        raise ValueError(f"{fault}{massless_cure(given) or FIRST_ORDER}") from None


def check_small(v):
    """Raise where a second-order plant ``v`` is large and its matrices are sparse."""
    if issparse(v.M):
        raise ValueError(
            f"the plant has {v.n} displacements in sparse matrices, too many for an "
            "LMI: design for plant.reduce(modes=...), then look at the whole by "
            "design.check_on(plant)"
        )


def least_filled(x):
    """The one of `ORDERS` that fills the factors of a sparse ``x`` least: the second
    fills plates and frames half as much, and slender lattices seven times as much.
    """
    from scipy.sparse import diags_array

    x = abs(x)
    x = x + diags_array(x.sum(axis=0) + x.sum(axis=1))  # never singular
    return min(ORDERS, key=lambda order: sparse_factor(x, order).nnz)


def sparse_factor(x, order=ORDERS[0]):
    """SuperLU's factors of a sparse ``x`` without exchanges of rows, or None: of a
    symmetric matrix their diagonal has the signs of its eigenvalues. ``order``: that of
    the columns.
    """
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    options = dict(permc_spec=order, diag_pivot_thresh=0.0)
    try:
        return splu(csc_array(x), options=dict(SymmetricMode=True), **options)
    except RuntimeError:
        return None


def same_matrix(a, b):
    """True if the matrices ``a`` and ``b`` are equal, dense or sparse."""
    if issparse(a) and issparse(b):
        return a.shape == b.shape and (a != b).nnz == 0
    return not issparse(a) and not issparse(b) and np.array_equal(a, b)
