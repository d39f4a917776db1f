"""Blocks G_k(x) > 0 that are affine in a vector of variables."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from .barrier import Barrier
from .newton import Newton
from .settings import DEFAULTS
from .structure import structure

MOST_SLOPES = 2e7  # entries of all slopes that `refined` may make, thrice: 500 MB


class Blocks:
    """Symmetric blocks G_k(x) = G_k0 + sum_a x_a G_ka of `Affine` ``expressions`` in
    the free entries of the ``unknowns``; ``constants`` are the G_k0, (q, q).
    """

    settings = DEFAULTS

    def __init__(self, expressions, unknowns):
        self.expressions, self.unknowns = list(expressions), list(unknowns)
        self.constants = [g.constant for g in self.expressions]
        self.variables = sum(u.size for u in self.unknowns)

    @classmethod
    def compiled(cls, expressions, blocks, unknowns):
        """``expressions`` in ``unknowns`` whose structures, ``blocks``, are known."""
        self = cls(expressions, unknowns)
        layouts, scalars, _ = structure([], self.unknowns)
        self.structure = layouts, scalars, list(blocks)
        return self

    def joined(self, write):
        """These blocks and more, which ``write`` makes of a list of values."""
        more = Blocks(write(self.unknowns), self.unknowns)
        return Blocks.compiled(
            [*self.expressions, *more.expressions],
            [*self.structure[2], *more.structure[2]],
            self.unknowns,
        )

    @cached_property
    def slopes(self):
        """Derivatives of each block: a list of (k, q, q) arrays."""
        slopes = []
        for g in self.expressions:
            parts = (x for t in g.terms for x in (t.left, t.right))
            kind = np.result_type(g.constant, *parts)  # exact ones stay exact
            slopes.append(np.zeros((self.variables, *g.constant.shape), kind))
            held, start = {t.unknown for t in g.terms}, 0
            for u in self.unknowns:
                if u in held:
                    slopes[-1][start : start + u.size] = g.jacobian(u)
                start += u.size
        return slopes

    @cached_property
    def structure(self):
        """Layouts, indices of the scalars, blocks: see `structure`."""
        return structure(self.expressions, self.unknowns)

    @cached_property
    def newton(self):
        """The `Newton` of these blocks."""
        return Newton(self)

    @cached_property
    def barrier(self):
        """The `Barrier` of these blocks, without a ball."""
        return Barrier(self.newton)

    def adjoint(self, Z):
        """sum_k <G_ka, Z_k> for each variable a, of symmetric Z: a (k,) array."""
        gradients = {u: np.zeros(u.shape) for u in self.unknowns}
        for g, z in zip(self.expressions, Z):
            for t in g.terms:
                if t.unknown in gradients:
                    left, right = t.left.astype(float), t.right.astype(float)
                    of_X = left.T @ z @ right.T
                    gradients[t.unknown] += of_X.T if t.transposed else of_X
        return np.concatenate([u.gradient(X) for u, X in gradients.items()])

    def with_constants(self, constants):
        """Blocks with the same slopes and these constants."""
        changed = object.__new__(type(self))
        changed.__dict__.update(self.__dict__, constants=list(constants))
        layouts, scalars, blocks = self.structure
        for known in ("diagonal_scales", "barrier"):
            vars(changed).pop(known, None)
        changed.newton = self.newton.with_constants(changed.constants)
        blocks = [replace(b, constant=c) for b, c in zip(blocks, constants)]
        changed.structure = layouts, scalars, blocks
        return changed

    @cached_property
    def diagonal_scales(self):
        """Powers of two d for each block with d_i d_j G_ij near one; none rounds."""
        magnitudes = self.newton.diagonal_magnitudes()
        ends = np.cumsum([len(m) for m in magnitudes])
        flat = np.concatenate(magnitudes)
        flat[flat == 0] = 1
        flat = 2.0 ** np.round(-np.log2(flat) / 2)
        return [flat[end - len(m) : end] for end, m in zip(ends, magnitudes)]

    @property
    def degree(self):
        """Sum of the block sizes: the parameter nu of the barrier -log det."""
        return sum(len(c) for c in self.constants)

    def __call__(self, x):
        return [c + np.tensordot(x, s, 1) for c, s in zip(self.constants, self.slopes)]

    def contain(self, x):
        """True if all blocks are positive definite at a (k,) array x."""
        return all(np.linalg.eigvalsh(g)[0] > 0 for g in self(x))

    def value(self, Z):
        """The number sum_k <G_k0, Z_k> for a list Z of one matrix a block."""
        return sum((c * z).sum() for c, z in zip(self.constants, Z))


def excluded_radius(blocks, Z):
    """A 2-norm that every feasible x of ``blocks`` exceeds, by multipliers Z > 0.

    It has 0 <= sum <G_k(x), Z_k> = value + residual.x.
    """
    value, residual = blocks.value(Z), blocks.adjoint(Z)
    norm = np.linalg.norm(residual)
    return 0.0 if value >= 0 else (-value / norm if norm else np.inf)


def refined(blocks, Z):
    """Multipliers Z of ``blocks`` that satisfy sum <G_ka, Z_k> = 0 more closely: Z_k =
    L L' becomes L (I + X_k) L' with the X_k of least 2-norm, if that is definite.
    """
    if blocks.variables * sum(z.size for z in Z) > MOST_SLOPES:
        return Z
    slopes = [s.astype(float) for s in blocks.slopes]
    try:
        factors = [np.linalg.cholesky(z) for z in Z]
    except np.linalg.LinAlgError:
        return Z
    rows = np.hstack([_vectors(L.T @ s @ L) for L, s in zip(factors, slopes)])
    norms = np.linalg.norm(rows, axis=1)
    rows = rows[norms > 0] / norms[norms > 0, None]  # others occur in no block
    ones = np.concatenate([_vectors(np.eye(len(L))[None])[0] for L in factors])
    X = -np.linalg.lstsq(rows, rows @ ones, rcond=1e-12)[0]
    ends = np.cumsum([len(L) * (len(L) + 1) // 2 for L in factors])[:-1]
    changes = [_symmetric(x, len(L)) for L, x in zip(factors, np.split(X, ends))]
    if min(np.linalg.eigvalsh(x)[0] for x in changes) <= -1:
        return Z
    return [L @ (np.eye(len(L)) + x) @ L.T for L, x in zip(factors, changes)]


def _vectors(matrices):
    """Symmetric matrices, (k, q, q), as the rows of an array, of the same norms."""
    i, j = np.tril_indices(matrices.shape[-1])
    return matrices[:, i, j] * np.where(i == j, 1.0, np.sqrt(2))


def _symmetric(vector, q):
    """The symmetric (q, q) matrix of a vector, see `_vectors`."""
    i, j = np.tril_indices(q)
    matrix = np.zeros((q, q))
    matrix[i, j] = matrix[j, i] = vector / np.where(i == j, 1.0, np.sqrt(2))
    return matrix
