"""Multipliers in floats: what they exclude, and how they come nearer to exact ones."""

import numpy as np

MOST_SLOPES = 2e7  # entries of all slopes that `refined` may make, thrice: 500 MB


def excluded_radius(blocks, Z):
    """A 2-norm that every feasible x of ``blocks`` exceeds, by multipliers Z > 0.

    It has 0 <= sum <G_k(x), Z_k> = value + residual.x.
    """
    value, residual = blocks.value(Z), blocks.adjoint(Z)
    norm = np.linalg.norm(residual)
    return 0.0 if value >= 0 else (-value / norm if norm else np.inf)


def refined(blocks, Z):
    """Multipliers Z of ``blocks`` that satisfy sum <G_ka, Z_k> = 0 more closely.

    Each Z_k = L L' becomes L (I + X_k) L' with X_k of the least 2-norm, which spares
    small eigenvalues; Z itself where that isn't positive definite, or slopes are too
    many.
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
