"""Decay of a large sparse plant by its energy, in floats whose rounding is bounded."""

import numpy as np
from scipy.sparse import block_array, csc_array, diags_array, issparse

from ..plants.sparse import sparse_factor
from ..runtime.time_limit import check_time

SHIFT = 1e-9  # of a matrix whose diagonal is about one: what the factor has to spare
EPS = 2.0**-52  # twice the rounding of one operation, and that of reading a decimal
INFLATED = 1.0 + 1e-6  # for sums of bounds, which are rounded, too


def least_eigenvalue(x, error):
    """A proven lower bound of the least eigenvalue of a scaled sparse matrix.

    ``x``, (n, n) sparse array: a symmetric matrix in floats; ``error``, (n, n) sparse
    array: how far at most each entry of the matrix that is meant is from it. Returns
    float: for the matrix with its diagonal scaled to about one: positive where x is
    positive definite; -inf where that isn't shown.

    With float factors L and d > 0 of x - c I the matrix L d L' is positive
    semidefinite whatever they are, so the least eigenvalue is at least c less the
    norm of the residual, of which the largest row sum is a bound. Its own rounding
    is bounded by that of sums of products. Source: S. M. Rump, BIT 46, 2006.

    >>> one, none = (csc_array(c * np.eye(3)) for c in (2.0, 0.0))
    >>> bool(least_eigenvalue(one, none) > 0), least_eigenvalue(-one, none)
    (True, -inf)
    """
    check_time()
    n, diagonal = x.shape[0], x.diagonal()
    if not (np.isfinite(x.data).all() and (diagonal > 0).all()):
        return -np.inf
    scale = diags_array(np.exp2(-np.round(np.log2(diagonal) / 2)))  # exact
    x, error = (csc_array(scale @ y @ scale) for y in (x, error))
    shifted = csc_array(x - SHIFT * diags_array(np.ones(n)))
    factor = sparse_factor(shifted)
    if factor is None or (factor.perm_r != factor.perm_c).any():
        return -np.inf
    d, L = factor.U.diagonal(), csc_array(factor.L)
    if not (d > 0).all():
        return -np.inf
    order = np.argsort(factor.perm_c)
    residual = shifted[order][:, order] - (L @ diags_array(d)) @ L.T
    terms = int(np.diff(csc_array(L.T).indptr).max()) + 4
    ones = np.ones(n)
    rounded = abs(L) @ (d * (abs(L).T @ ones)) + abs(x)[order] @ ones + SHIFT
    rows = abs(residual) @ ones + terms * EPS * rounded + error[order] @ ones
    return float(SHIFT - INFLATED * rows.max())


def energy_forms(plant, K, sigma, epsilon):
    """What must be positive definite so that an energy decays as exp(-2 sigma t).

    ``plant``: dense or sparse; ``K``, (m, 2n): the gain; ``sigma``, ``epsilon``: the
    decay, and the weight of z' M z' in the energy; in rad/s. Returns dict or None: from
    a name to a symmetric sparse matrix and a bound of its entries' errors; None where M
    isn't symmetric.

    With the symmetric and skew parts of S - B K_P = S_s + H and D - B K_D = D_s + G,
    V = z'(S_s + e D_s) z + 2 e z' M z' + z'' M z' has the derivative -2 W with the
    block W = [e S_s, (e G - H)/2; ., D_s - e M].
    """
    n, B = plant.n, csc_array(plant.B)
    K_P, K_D = csc_array(K[:, :n]), csc_array(K[:, n:])
    terms = (plant.m + 4) * EPS

    def closed(x, gain):
        x = x if issparse(x) else csc_array(x)
        return x - B @ gain, terms * (abs(x) + abs(B) @ abs(gain))

    (S, S_off), (D, D_off) = closed(plant.S, K_P), closed(plant.D, K_D)
    M = plant.M if issparse(plant.M) else csc_array(plant.M)
    if abs(M - M.T).max():
        return None
    M_off = EPS * abs(M)

    def halves(x):
        return (x + x.T) / 2, (x - x.T) / 2

    (S_s, H), (D_s, G) = halves(S), halves(D)
    S_off, D_off = ((x + x.T) / 2 for x in (S_off, D_off))
    e, s = epsilon, sigma
    corner = (e * G - H) / 2 - s * e * M
    blocks = [[(e - s) * S_s - s * e * D_s, corner], [corner.T, D_s - (e + s) * M]]
    off = e * D_off + S_off + s * e * M_off
    errors = [
        [e * S_off + s * S_off + s * e * D_off, off],
        [off.T, D_off + (e + s) * M_off],
    ]
    whole = csc_array(block_array(blocks))
    energy = S_s + e * D_s - e * e * M
    energy_off = S_off + e * D_off + e * e * M_off
    sizes = [
        [(e + s) * abs(S_s) + s * e * abs(D_s), abs(corner)],
        [abs(corner).T, abs(D_s) + (e + s) * abs(M)],
    ]
    size = abs(S_s) + e * abs(D_s) + e * e * abs(M)
    errors = csc_array(block_array(errors) + 8 * EPS * block_array(sizes))
    forms = {
        "mass": (M, M_off),
        "energy": (energy, energy_off + 8 * EPS * size),
        "decay": (whole, errors),
    }
    return {name: ((x + x.T) / 2, csc_array(off)) for name, (x, off) in forms.items()}
