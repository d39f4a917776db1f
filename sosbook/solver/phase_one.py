"""Phase one: a point inside all blocks, or multipliers that exclude it.

The primal-dual method goes first. Where it can't decide, the barrier method
follows the central path inside a ball, which also yields multipliers that can
be made exact. The numbers of sections are those of Boyd and Vandenberghe (2004).
"""

from dataclasses import dataclass

import numpy as np

from ..runtime.threads import one_thread
from .barrier import Barrier
from .newton import newton_of
from .primal_dual import maximize_t, positive

__all__ = ["LONGEST_SOLUTION", "Phase", "phase_one", "refine"]

MOST_SLOPES = 2e7  # entries of all slopes that `refine` may make, thrice: 500 MB
LONGEST_SOLUTION = 1e9  # norm of x; a longer one is no solution in floats of 16 digits


@dataclass(frozen=True, eq=False)
class Phase:
    """Outcome of phase one.

    Parameters
    ----------
    verdict : {"feasible", "infeasible", "undecided"}
        What is known of the blocks.
    x : array or None
        A strictly feasible point.
    Z : list of arrays or None
        Multipliers of an infeasibility proof: Z_k > 0,
        sum <G_ka, Z_k> = 0 for all a, sum <G_k0, Z_k> <= 0.
    last_iterate : array or None
        The last iterate, where no feasible point was found.
    excluded_radius : float
        No feasible x has a smaller 2-norm than this.
    """

    verdict: str
    x: np.ndarray | None = None
    Z: list | None = None
    last_iterate: np.ndarray | None = None
    excluded_radius: float = 0.0


@one_thread
def phase_one(blocks, radius=1e4, wide=1e8, start=None, watch=None, multipliers=True):
    """Find x with all G_k(x) > 0, or multipliers that exclude it.

    It maximises t subject to G_k(x) > t I along the central path, inside
    the ball |x| < radius, and stops as soon as t is known to be positive or
    known to stay negative: phase one of section 11.4. Where all blocks are
    homogeneous the first one, X > 0, is read as X > I, which changes nothing
    but excludes x = 0. Where only the ball stands in the way, the larger
    ball ``wide`` is tried. "infeasible" says that no solution is shorter than
    ``excluded_radius``, half the radius or more, and that none was found beyond.

    Parameters
    ----------
    blocks : Blocks
        The blocks G_k, affine in x.
    radius, wide : float
        Radii of the two balls.
    start : array, optional
        Where to start from, if that is better than 0.
    watch : callable, optional
        Called after each step, as by `maximize_t`.
    multipliers : bool
        False saves their search: what isn't found feasible is "undecided".

    Returns
    -------
    Phase
        The verdict, with a point or with multipliers.
    """
    if start is not None and positive(newton_of(blocks).at(start)):
        return Phase("feasible", x=start)
    asked = blocks
    if not any(c.any() for c in blocks.constants):
        first = -np.eye(len(blocks.constants[0]))
        blocks = blocks.with_constants([first, *blocks.constants[1:]])
    # t is raised in units in which the blocks' diagonals are near one
    units = [np.diag(1 / d**2) for d in blocks.diagonal_scales]
    newton = newton_of(blocks).joined([-D for D in units])
    x = np.zeros(blocks.variables)
    scales = newton.stacked_diagonals(blocks.diagonal_scales)
    least, below = newton.least(np.append(x, 0.0), scales).min(), 1.0
    if start is not None:
        there = newton.least(np.append(start, 0.0), scales).min()
        size = max(np.abs(start).max(), 1.0)
        if there / size > least:  # far away blocks are larger
            x, least, below = start, there, max(abs(there), 0.1)
    x = np.append(x, min(least, 0) - below)
    verdict, last = maximize_t(newton, x, watch=watch)
    if verdict == "feasible":
        return Phase("feasible", x=last[:-1])
    if not multipliers:
        return Phase("undecided", last_iterate=last[:-1])
    weight = 1.0
    if verdict == "infeasible":
        last[-1] *= 2
        if Barrier(newton).factors(last) is not None:
            x = last
            while 8 * weight < -2 * blocks.degree / x[-1]:
                weight *= 8  # t < 0 can't be seen with so little
    return _central_path(asked, blocks, newton, x, weight, radius, wide)


def _central_path(asked, blocks, newton, x, weight, radius, wide):
    """Phase one inside a ball, until t is positive or stays negative.

    This is the barrier method (section 11.3): centres for growing weights of
    the cost -t, each of them with a dual point inv(G) / weight.
    """
    radius = max(radius, 10 * np.linalg.norm(x))  # the ball holds the start
    barrier = Barrier(newton, radius)
    cost = np.zeros(len(x))
    cost[-1] = -1.0
    without_t = np.append(np.ones(len(x) - 1), 0.0)
    while weight < 1e13:
        for _ in range(300):
            x, decrement = barrier.step(x, weight * cost)
            if x[-1] > 0 and barrier.factors(x * without_t) is not None:
                return Phase("feasible", x=x[:-1])
            if decrement < 0.1:
                break
        else:
            return Phase("undecided", last_iterate=x[:-1])
        # at a centre, t* <= t + (degree + ball) / weight
        if x[-1] + 2 * (blocks.degree + 1) / weight < 0:
            x = barrier.descend(x, weight * cost, 1e-9, 20)
            Z = [z / weight for z in barrier.multipliers(x)]
            excluded = _excluded_radius(blocks, Z)
            if excluded < LONGEST_SOLUTION:
                Z = refine(blocks, Z)
                excluded = _excluded_radius(blocks, Z)
            verdict = "infeasible" if excluded >= radius / 2 else "undecided"
            if excluded < wide / 2 and radius < wide:
                further = phase_one(asked, wide)
                if further.x is not None or verdict == "undecided":
                    return further
            return Phase(verdict, Z=Z, last_iterate=x[:-1], excluded_radius=excluded)
        weight *= 8
    return Phase("undecided", last_iterate=x[:-1])


def _excluded_radius(blocks, Z):
    """The 2-norm that every feasible x has at least, if all Z_k > 0.

    A feasible x has 0 <= sum <G_k(x), Z_k> = value + residual.x.
    """
    value, residual = blocks.value(Z), blocks.adjoint(Z)
    norm = np.linalg.norm(residual)
    return 0.0 if value >= 0 else (-value / norm if norm else np.inf)


@one_thread
def refine(blocks, Z):
    """Multipliers that satisfy sum <G_ka, Z_k> = 0 more closely.

    Each Z_k = L L' becomes L (I + X_k) L' with X_k of the least 2-norm, which
    spares the small eigenvalues of Z_k.

    Parameters
    ----------
    blocks : Blocks
        The blocks whose slopes are G_ka.
    Z : list of arrays
        The multipliers, one for each block.

    Returns
    -------
    list of arrays
        The refined ones; Z itself where they wouldn't be positive definite,
        or where there are too many slopes to hold them all.
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
