"""The deepest ray of a cone: phase one where every block is homogeneous.

Blocks G_k(x) without constant terms hold on a cone. Phase one that reads "positive
definite" as "larger than the identity" has to walk along the cone until it finds room,
and a narrow cone has room far away only. Here the size is fixed instead: with the
blocks in units D_k in which their diagonals are near one,

    maximise t  subject to  G_k(x) >= t D_k,  sum <G_k(x), inv(D_k)> <= degree.

The depth t lies between 0 and 1. It is positive exactly if the LMIs have a solution,
and the point that is found fits into floats however narrow the cone is. Where the depth
is zero the dual point tends to multipliers that exclude every solution. With z that of
the last constraint and Z_k those of the blocks the dual equations are

    sum <G_ka, Z_k - z inv(D_k)> = 0 for each variable a,  sum <D_k, Z_k> = 1.

All multiples of inv(D_k), with the same z, solve the first of them: there the
search begins. It ends where all Z_k - z inv(D_k) are positive definite.
"""

from dataclasses import dataclass

import numpy as np

from .primal_dual import FARTHEST_POINT, interior_steps, positive

ZERO_DEPTH = 1e-13  # a smallest eigenvalue that floats can't tell from zero
MOST_STEPS = 80  # of points and multipliers; usually some twenty are taken
STALLED = 0.5  # the gap by minus the depth: it is one or more, but for rounding


@dataclass(frozen=True, eq=False)
class Deepest:
    """The best point ``x`` of a cone of LMIs, at the ``depth`` t, positive where x
    satisfies all blocks; none is deeper than depth + ``gap``. ``Z``: multipliers.
    """

    x: np.ndarray
    depth: float
    gap: float
    Z: list


def deepest(blocks, accuracy=1.0, watch=None):
    """The `Deepest` point of homogeneous ``blocks``, a ValueError of others, to a
    relative ``accuracy`` of the depth; ``watch`` gets a dict after each step and may
    raise.
    """
    if any(c.any() for c in blocks.constants):
        raise ValueError("blocks must be homogeneous: a constant isn't zero")
    units = [np.diag(1 / d**2) for d in blocks.diagonal_scales]
    size = blocks.adjoint([np.diag(d**2) for d in blocks.diagonal_scales])
    size_bound = float(blocks.degree), -size
    newton = blocks.newton.joined([-d for d in units], size_bound)
    x, cost = np.zeros(newton.variables), np.zeros(newton.variables)
    x[-1] = cost[-1] = -1.0
    multipliers = _Multipliers(newton, blocks)
    state = dict(x=x, gap=np.inf, Z=None)
    Z = multipliers.first()
    for state in interior_steps(newton, x, cost, newton.degree, MOST_STEPS, Z=Z):
        depth, gap = state["x"][-1], state["gap"]
        if watch is not None:
            watch(state | {"t": depth})
        if gap < max(accuracy * depth, -STALLED * depth, ZERO_DEPTH):
            break
        Z = multipliers.excluding(state["Z"]) if depth < 0 else None
        if Z is not None:  # no point is deeper than 0
            return Deepest(0 * x[:-1], 0.0, 0.0, Z)
    Z = None if state["Z"] is None else newton.unstacked(state["Z"])[:-1]
    return Deepest(state["x"][:-1], state["x"][-1], state["gap"], Z)


class _Multipliers:
    """The Z_k and z of the module's head, as a list of stacks with z the last."""

    def __init__(self, newton, blocks):
        self.newton, self.degree = newton, blocks.degree
        scales = [*blocks.diagonal_scales, np.ones(1)]
        self.scales = newton.stacked_diagonals(scales)
        padded = newton.stacked_diagonals([np.zeros(len(d)) for d in scales])
        self.inverses = [
            (d**2 * (1 - p))[..., None] * np.eye(d.shape[1])
            for d, p in zip(self.scales, padded)
        ]

    def first(self):
        """Multiples of inv(D_k) that solve the dual equations."""
        return [
            d[..., None] ** 2 * np.eye(d.shape[1]) / self.degree for d in self.scales
        ]

    def excluding(self, Z):
        """Multipliers that exclude every solution, or None.

        With positive definite Y_k = Z_k - z inv(D_k) the sum of all <G_k(x), Y_k>
        would be positive at a solution x, while it is zero for every x.
        """
        z = Z[-1].item()
        Y = [Z_k - z * inverse for Z_k, inverse in zip(Z[:-1], self.inverses)]
        if not positive(Y):
            return None
        scaled = [y / (d[..., None] * d[:, None, :]) for y, d in zip(Y, self.scales)]
        least = min(np.linalg.eigvalsh(y).min() for y in scaled)
        # in the normalisation the sum is at least least * degree; rounding left
        # the gradient, so that only points far away could reach that
        left = self.newton.adjoint([*Y, 0 * Z[-1]])[:-1]
        if least * self.degree < FARTHEST_POINT * np.linalg.norm(left):
            return None
        return self.newton.unstacked([*Y, Z[-1]])[:-1]
