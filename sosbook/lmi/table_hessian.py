"""The dense Hessian of the barrier, from the table of all slopes.

For few variables it is faster than sums of Kronecker products, which take
several of numpy's calls for each two unknowns. With W = N' N the entries are
H_ab = sum_k <G_ka, W_k G_kb W_k> = sum_k <N_k G_ka N_k', N_k G_kb N_k'>: with
the matrices N G_a N' of all blocks as the columns of F, that is F' F.
"""

from functools import lru_cache

import numpy as np

from .stacks import transposed

__all__ = ["TableHessian"]


class TableHessian:
    """The matrix H_ab = sum_k <G_ka, W_k G_kb W_k>.

    Parameters
    ----------
    stacked : Stacked
        The blocks, with a table of their slopes.
    """

    def __init__(self, stacked):
        self.parts = []
        k = stacked.variables
        for s, slopes in zip(stacked.stacks, stacked.slope_table()):
            b, q = s.constant.shape[:2]
            wide = slopes.transpose(1, 2, 0, 3).reshape(b, q, k * q)
            self.parts.append((np.ascontiguousarray(wide), *_lower(q, s.weight)))
        self.variables = k

    def __call__(self, roots):
        """The (k, k) matrix at W = N' N, for a list of stacks N, ``roots``."""
        columns, k = [], self.variables
        for (wide, i, j, weights), N in zip(self.parts, roots):
            b, q, _ = wide.shape
            half = (N @ wide).reshape(b, q * k, q)
            whole = (half @ transposed(N)).reshape(b, q, k, q)
            lower = whole[:, i, :, j] * weights
            if lower.dtype == complex:
                columns.append(lower.imag.reshape(-1, k))
                lower = lower.real
            columns.append(lower.reshape(-1, k))
        F = np.concatenate(columns)
        return F.T @ F

    upper = __call__  # the whole matrix takes no longer


@lru_cache(64)
def _lower(q, weight):
    """Indices of the lower triangle, and the roots of the entries' weights."""
    i, j = np.tril_indices(q)
    return i, j, np.sqrt(weight * np.where(i == j, 1.0, 2.0))[:, None, None]
