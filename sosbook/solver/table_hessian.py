"""The dense Hessian of the barrier, from the table of all slopes.

For few variables it is faster than sums of Kronecker products, which take
several of numpy's calls for each two unknowns. With W = N' N the entries are
H_ab = sum_k <G_ka, W_k G_kb W_k> = sum_k <N_k G_ka N_k', N_k G_kb N_k'>: with
the matrices N G_a N' of all blocks as the columns of F, that is F' F.
"""

from functools import lru_cache

import numpy as np

from .dense import Dense

__all__ = ["TableHessian"]


class TableHessian:
    """The matrix H_ab = sum_k <G_ka, W_k G_kb W_k>.

    Parameters
    ----------
    stacked : Stacked
        The blocks, with a table of their slopes.

    Attributes
    ----------
    roots : list of stacks or None
        The N of the last matrix, whose N G_a N' are kept.
    """

    def __init__(self, stacked):
        self.variables, self.roots = stacked.variables, None
        self.stacks, self.tables = stacked.stacks, []
        for s, slopes in zip(stacked.stacks, stacked.slope_table()):
            b, q = s.constant.shape[:2]
            table = np.ascontiguousarray(slopes.transpose(1, 2, 3, 0))
            self.tables.append(table.reshape(b, q, -1))

    def __call__(self, roots):
        """The (k, k) matrix at W = N' N, for a list of stacks N, ``roots``."""
        self.roots, self._scaled = roots, []
        columns, k = [], self.variables
        for s, table, N in zip(self.stacks, self.tables, roots):
            b, q, _ = table.shape
            half = (N @ table).reshape(b, q, q, k)
            whole = (N.conj()[:, None] @ half).reshape(b, -1, k)
            self._scaled.append(whole.reshape(-1, k))
            places, weights = _lower(q, s.weight)
            lower = whole[:, places]
            lower *= weights
            if lower.dtype == complex:
                columns.append(lower.imag.reshape(-1, k))
                lower = lower.real
            columns.append(lower.reshape(-1, k))
        F = np.concatenate(columns)
        return F.T @ F

    def upper(self, roots):
        """The same for ``roots``, as a `Dense`: all of it takes no longer."""
        return Dense(self(roots))

    def scaled(self, direction):
        """N dG N' of all blocks along a ``direction``, with the N of the matrix."""
        return [
            (table @ direction).reshape(s.constant.shape)
            for s, table in zip(self.stacks, self._scaled)
        ]

    def scaled_adjoint(self, Z):
        """sum_k <N_k G_ka N_k', Z_k> for each variable a, for a list of stacks Z."""
        return sum(
            s.weight * (z.conj().ravel() @ table).real
            for s, table, z in zip(self.stacks, self._scaled, Z)
        )


@lru_cache(64)
def _lower(q, weight):
    """Places of the lower triangle, and the roots of the entries' weights."""
    i, j = np.tril_indices(q)
    return i * q + j, np.sqrt(weight * np.where(i == j, 1.0, 2.0))[:, None]
