"""The deepest ray of a cone: phase one where every block is homogeneous.

Blocks G_k(x) without constant terms hold on a cone. Phase one that reads
"positive definite" as "larger than the identity" has to walk along the
cone until it finds room, and a narrow cone has room far away only. Here
the size is fixed instead: with the blocks in units D_k in which their
diagonals are near one,

    maximise t  subject to  G_k(x) >= t D_k,  sum <G_k(x), inv(D_k)> <= degree.

The depth t lies between 0 and 1. It is positive exactly if the LMIs have
a solution, and the point that is found fits into floats however narrow
the cone is. Where the depth is zero the dual point tends to multipliers
that exclude every solution.
"""

from dataclasses import dataclass

import numpy as np

from .newton import newton_of
from .primal_dual import interior_steps

__all__ = ["Deepest", "deepest"]

ZERO_DEPTH = 1e-13  # a smallest eigenvalue that floats can't tell from zero
MOST_STEPS = 80  # of the interior-point method, which takes about twenty


@dataclass(frozen=True, eq=False)
class Deepest:
    """How deep a cone of LMIs is.

    Parameters
    ----------
    x : (k,) array
        The best point, in the normalisation of the module's head.
    depth : float
        The t of the module's head. Where it is positive, x satisfies all
        blocks.
    gap : float
        No point is deeper than depth + gap, up to rounding errors.
    Z : list of arrays
        The dual point: multipliers of the blocks.
    """

    x: np.ndarray
    depth: float
    gap: float
    Z: list


def deepest(blocks, accuracy=1.0, watch=None):
    """The deepest point of homogeneous blocks.

    Parameters
    ----------
    blocks : Blocks
        Made by `Blocks.of`, with constants zero.
    accuracy : float
        Stop when the depth is known to this relative accuracy.
    watch : callable, optional
        Called after each step with a dict (step, x, t, gap, ...); it may
        raise an exception to stop the search.

    Returns
    -------
    Deepest
        The point, its depth and the multipliers.

    Raises
    ------
    ValueError
        If a block has a constant term.
    """
    if any(c.any() for c in blocks.constants):
        raise ValueError("blocks must be homogeneous: a constant isn't zero")
    units = [np.diag(1 / d**2) for d in blocks.diagonal_scales]
    size = blocks.adjoint([np.diag(d**2) for d in blocks.diagonal_scales])
    roof = float(blocks.degree), -size
    newton = newton_of(blocks).joined([-d for d in units], roof)
    x, cost = np.zeros(newton.variables), np.zeros(newton.variables)
    x[-1] = cost[-1] = -1.0
    state = dict(x=x, gap=np.inf, Z=None)
    for state in interior_steps(newton, x, cost, newton.degree, MOST_STEPS):
        depth = state["x"][-1]
        if watch is not None:
            watch(state | {"t": depth})
        if state["gap"] < max(accuracy * depth, ZERO_DEPTH):
            break
    Z = None if state["Z"] is None else newton.unstacked(state["Z"])[:-1]
    return Deepest(state["x"][:-1], state["x"][-1], state["gap"], Z)
