"""Into blocks of which a few are violated, from the centre of the others.

What is violated at x gets a shift, G_k(x) + s D_k > 0. Then s is lowered to zero
while x follows the centres of the shifted blocks. Where little is violated one step
or two lead inside, and near the centre of all: so a centre is restored after a cut.
"""

import numpy as np

from ..runtime.threads import one_thread
from .barrier import Barrier
from .curve import Curve
from .newton import newton_of
from .stacks import gram

__all__ = ["enter"]

SHIFT = 4.0  # times what the worst block lacks: so deep are shifted ones at first
LEAST_LACK = 1e-4  # of diagonals near one; x may lie on the edge
SMALL_TERM = 0.1  # of a curve, as far from the centre
SHORTEST = 0.5  # of the way to s = 0; where a step gets less far the way is long
MOST_STEPS = 8
FARTHEST = 100.0  # times as far from 0 as before: there may be no centre


@one_thread
def enter(blocks, x):
    """A point inside all blocks, or None where the way there is long.

    Parameters
    ----------
    blocks : Blocks
        The blocks G_k.
    x : (k,) array
        A point, best near the centre of those blocks that hold there.

    Returns
    -------
    (k,) array or None
        All blocks are positive definite there. None, too, where conjugate gradients
        solve Newton's equations.
    """
    newton = newton_of(blocks)
    if newton.iterative:
        return None
    scales = blocks.diagonal_scales
    least = newton.least(x, newton.stacked_diagonals(scales))
    if least.min() > 0:
        return x
    units = [np.diag((k <= 0) / d**2) for d, k in zip(scales, least)]
    barrier, farthest = Barrier(newton.joined(units)), FARTHEST * max(abs(x).max(), 1.0)
    x = np.append(x, SHIFT * max(-least.min(), LEAST_LACK))
    for _ in range(MOST_STEPS):
        try:
            curve = _lowering(barrier, x)
        except np.linalg.LinAlgError:
            return None
        t, moved = curve.end, curve(curve.end)
        moved[-1] = 0.0
        while barrier.factors(moved) is None:
            t /= 2
            if t < SHORTEST * curve.end:
                return None
            moved = curve(t)
        x = moved
        if not abs(x[:-1]).max() < farthest:
            return None
        if x[-1] == 0:
            return x[:-1]
    return None


def _lowering(barrier, x):
    """The curve of centres from a shifted x to a shift of zero.

    With u that solution of H u = e which raises the shift by one, d - d_s u solves
    Newton's equations of the other variables alone, for each solution d of all.
    """
    newton, roots = barrier.newton, barrier.roots(x)
    solve, one = newton.solver(roots, x), np.append(np.zeros(len(x) - 1), 1.0)
    up = solve(one)
    up /= up[-1]

    def unshifted(g):
        d = solve(g)
        return d - d[-1] * up

    direction = unshifted(newton.adjoint(gram(roots))) - x[-1] * up
    change = newton.scaled(roots, direction)
    return Curve(newton, roots, x, direction, change, unshifted, SMALL_TERM)
