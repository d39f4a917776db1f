"""A request's blocks as the sparse data that conic solvers take.

The cost of this step is part of a peer's "end to end" time, so it is done
well: every product L X R becomes a sparse Kronecker product.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from sosbook.lmi import Unknown
from sosbook.lmi.centre import margin
from sosbook.synthesis.problem import Request
from sosbook.synthesis.scaling import Frame

__all__ = ["Cones", "Task", "compiled"]


@dataclass(frozen=True, eq=False)
class Task:
    """A request in given coordinates, with the way back from them.

    Parameters
    ----------
    request : Request
    frame : Frame or None
        The coordinates; None for the plant's own.
    """

    request: Request
    frame: Frame = None

    @classmethod
    def of(cls, plant, requirements, coordinates="raw"):
        request = Request(plant, **requirements)
        framed = coordinates == "frame"
        return cls(request, Frame.of(request) if framed else None)

    objective = None  # maximise the margin t

    @property
    def unknowns(self):
        N, m = self.request.order, self.request.plant.m
        return [Unknown("P", N, symmetric=True), Unknown("Y", m, N)]

    def blocks(self, P, Y, levels=()):
        """The request's blocks in these coordinates, in any arithmetic."""
        return self.request.blocks(P, Y, frame=self.frame, levels=levels)

    def expressions(self):
        """The blocks as `Affine` expressions, and the unknowns P and Y."""
        unknowns = self.unknowns
        return list(self.blocks(*unknowns).values()), unknowns

    def first(self, unknowns):
        """sosbook's first guess, a vector of variables."""
        return self.frame.guess(unknowns)

    def home(self, P, Y):
        """P and Y in the plant's own coordinates."""
        P = (P + P.T) / 2
        if self.frame is None:
            return P, Y
        T = self.frame.T
        return T @ P @ T.T, self.frame.scale * Y @ T.T

    def judge(self, P, Y):
        """Smallest eigenvalue of the blocks, in the plant's coordinates.

        Each block's diagonal is scaled to one. Positive means right.
        """
        blocks = self.request.blocks(*self.home(P, Y))
        return dict(margin=min(margin(g) for g in blocks.values()))

    def gain(self, P, Y):
        """K = Y P^-1, the end of "end to end"."""
        P, Y = self.home(P, Y)
        return np.linalg.solve(P, Y.T).T


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
