"""A question's blocks as the sparse data that conic solvers take.

The cost of this step is part of a peer's "end to end" time, so it is done
well: every product L X R becomes a sparse Kronecker product.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse


@dataclass(frozen=True, eq=False)
class Cones:
    """Blocks G_k(x) = reshape(c_k + A_k x), symmetric.

    Parameters
    ----------
    constants : list of (q * q,) arrays
    matrices : list of (q * q, k) arrays, sparse where they are large
    """

    constants: list
    matrices: list

    @property
    def sizes(self):
        return [int(np.sqrt(len(c))) for c in self.constants]

    @property
    def variables(self):
        return self.matrices[0].shape[1]

    def diagonals(self):
        """Of each block, the typical size of its diagonal entries."""
        found = []
        for c, A, q in zip(self.constants, self.matrices, self.sizes):
            on = np.arange(q) * (q + 1)
            size = np.abs(c[on]) + np.sqrt((A[on] ** 2).sum(axis=1))
            found.append(np.where(size == 0, 1.0, size))
        return found

    def scaled(self):
        """The same blocks with diagonals near one."""
        constants, matrices = [], []
        for c, A, d in zip(self.constants, self.matrices, self.diagonals()):
            scale = 2.0 ** np.round(-np.log2(d) / 2)
            scale = np.outer(scale, scale).ravel()
            constants.append(scale * c)
            dense = isinstance(A, np.ndarray)
            matrices.append(
                scale[:, None] * A if dense else sparse.diags_array(scale) @ A
            )
        return Cones(constants, matrices)

    def lifted(self):
        """With one more variable t: 1 - t, then each G_k(x) - t I."""
        k = self.variables
        matrices = [np.append(np.zeros(k), -1.0)[None]]
        for A, q in zip(self.matrices, self.sizes):
            last = -np.eye(q).reshape(-1, 1)
            matrices.append(
                np.hstack([A, last])
                if isinstance(A, np.ndarray)
                else sparse.hstack([A, sparse.csr_array(last)], format="csr")
            )
        return Cones([np.ones(1), *self.constants], matrices)

    def stacked(self, pick):
        """Right side and sparse matrix of all blocks, one on the other.

        Parameters
        ----------
        pick : callable
            From a block's size q to rows of its q * q, and their weights.
        """
        right, parts = [], []
        for c, A, q in zip(self.constants, self.matrices, self.sizes):
            rows, weights = pick(q)
            right.append(weights * c[rows])
            part = A[rows]
            parts.append(
                weights[:, None] * part
                if isinstance(part, np.ndarray)
                else sparse.diags_array(weights) @ part
            )
        if all(isinstance(A, np.ndarray) for A in parts):
            matrix = sparse.csc_matrix(np.vstack(parts))
        else:
            matrix = sparse.csc_matrix(
                sparse.vstack([sparse.csr_array(A) for A in parts])
            )
        return np.concatenate(right), matrix


def compiled(expressions, unknowns):
    """`Cones` of `Affine` expressions in the given unknowns."""
    spreads = [_spread(u) for u in unknowns]
    entries = sum(np.prod(u.shape) for u in unknowns)
    constants, matrices = [], []
    for g in expressions:
        if entries * np.prod(g.shape) < SMALL:
            flat = [g.jacobian(u).reshape(u.size, -1) for u in unknowns]
            matrix = np.vstack(flat).T.astype(float)
        else:
            matrix = sparse.hstack(
                [_slope(g, u) @ s for u, s in zip(unknowns, spreads)], format="csr"
            )
        constants.append(np.asarray(g.constant, float).ravel())
        matrices.append(matrix)
    return Cones(constants, matrices)


SMALL = 200_000  # entries up to which a dense derivative is the quicker way


def _slope(g, unknown):
    """The matrix that takes the entries of X, by rows, to those of g."""
    rows, cols = unknown.shape
    total = sparse.csr_array((g.shape[0] * g.shape[1], rows * cols))
    for t in g.terms:
        if t.unknown is not unknown:
            continue
        left, right = map(sparse.csr_array, (t.left, t.right.T))
        product = sparse.kron(left, right, format="csr")
        if t.transposed:
            swap = np.arange(rows * cols).reshape(cols, rows).T.ravel()
            # the product acts on X.T by rows
            product = product[:, swap]
        total = total + product
    return total


def _spread(unknown):
    """The matrix that takes the free entries to all entries, by rows."""
    rows, cols = unknown.shape
    if not unknown.symmetric:
        return sparse.eye_array(rows * cols, format="csr")
    i, j = np.tril_indices(rows)
    k, off = np.arange(len(i)), i != j
    return sparse.csr_array(
        (
            np.ones(len(i) + off.sum()),
            (np.append(i * cols + j, j[off] * cols + i[off]), np.append(k, k[off])),
        ),
        shape=(rows * cols, len(i)),
    )
