"""Interior point: phase one, the analytic centre, linear objectives.

Newton's method, its steps bent or else with an exact line search, minimises the
barrier -sum log det G_k(x) of blocks that are affine in x. The numbers of sections are
those of Boyd and Vandenberghe (2004), where each step is derived.
"""

from functools import partial

import numpy as np

from ..runtime.threads import one_thread
from .barrier import MOST_LOST, Barrier, barrier_of, is_lost
from .blocks import Blocks
from .newton import newton_of
from .phase_one import LONGEST_SOLUTION, Phase, phase_one, refine
from .primal_dual import FARTHEST_POINT, minimize_linear, near_centre, towards_centre

__all__ = [
    "LONGEST_SOLUTION",
    "Blocks",
    "Phase",
    "Unbounded",
    "centre",
    "lower_on_ray",
    "margin",
    "minimize",
    "phase_one",
    "refine",
]

STEPS_TO_PATH = 8  # of the barrier method, before the primal-dual one
STEPS_ALONE = 15  # of Newton's method, before multipliers help it to a centre
STEPS_OF_BOTH = 4  # primal-dual ones with conjugate gradients; few need thrice as many
LAST_STEP_BELOW = 3e-3  # a decrement whose square is enough
ENOUGH_LEFT = 1e-5  # of the decrement, by conjugate gradients
STEPS_TO_RAYS = 6  # of Newton's method; few sets that have a centre need more
FAR_STEP = 3.0  # times as far from 0 as before: sooner than that rays are looked at

#: A decrement below it is small enough for further steps with the same matrix.
SETTLES_BELOW = 0.3
ENDLESS = "no analytic centre was found: the set seems to be unbounded"
NO_LEAST = "no minimum was found: perhaps it isn't attained"


class Unbounded(ValueError):
    """Raised where no analytic centre or no minimum is found: there may be none.

    Parameters
    ----------
    message : str
        What wasn't found.
    x : array, optional
        The best point that was: strictly feasible, not optimal. None where a
        direction is known in which the set has no end.
    """

    def __init__(self, message, x=None):
        super().__init__(message)
        self.x = x


@one_thread
def centre(blocks, x, watch=None, enough=None, rays=None, elsewhere=None):
    """The analytic centre, which maximises sum log det G_k (section 8.5.3).

    Parameters
    ----------
    blocks : Blocks
        The blocks G_k.
    x : (k,) array
        A strictly feasible point to start from.
    watch : callable, optional
        Called after each Newton step with a dict: step, x, decrement and
        the iterations of conjugate gradients. Steps that keep the matrix
        belong to the one before.
    enough : float, optional
        Stop at a smaller decrement than this.
    rays : callable, optional
        Without arguments: directions, (k,) arrays, in which the set may be
        unbounded. They are looked at where a centre is slow to show itself.
    elsewhere : callable, optional
        From x to another strictly feasible point, or to None. It is asked for where
        Newton's method creeps.

    Returns
    -------
    (k,) array
        The centre.

    Raises
    ------
    Unbounded
        If no centre is found: an unbounded set has none.
    """
    barrier = barrier_of(blocks)
    newton = barrier.newton
    if newton.iterative:
        x = _approached(newton, x, rays)
    zero, decrement, left, lost, alone = np.zeros(len(x)), 1.0, 1.0, 0, 0
    ways = [elsewhere, partial(near_centre, newton)]
    ways = [] if newton.iterative else [way for way in ways if way is not None]
    enough = enough or 1e-4  # a step leaves its cube or less
    for count in range(200):
        before, behind = decrement, x
        last = left < LAST_STEP_BELOW  # where one more step is enough
        tolerance = ENOUGH_LEFT / (2 * left) if last else min(0.1, decrement)
        x, decrement = barrier.step(x, zero, tolerance)
        left = decrement * max(decrement, tolerance)  # of conjugate gradients
        lost += is_lost(before, decrement)
        settled = decrement < enough or (newton.iterative and left < ENOUGH_LEFT)
        if not settled and decrement < SETTLES_BELOW and not newton.iterative:
            x, settled = barrier.settle(x, zero)
        if watch is not None:
            watch(
                dict(
                    step=count + 1,
                    x=x,
                    decrement=decrement,
                    iterations=newton.iterations[-1:],
                )
            )
        if settled:
            return x
        if x @ x > 1e16 or lost > MOST_LOST:
            break
        # below one there is a centre (section 9.6.4)
        far = x @ x > FAR_STEP**2 * (behind @ behind)
        if rays is not None and decrement >= 1 and (far or count + 1 == STEPS_TO_RAYS):
            if barrier.recedes(x, rays()):
                raise Unbounded(ENDLESS)
            rays = None
        alone += 1
        if alone == STEPS_ALONE and decrement >= 1 and ways:
            near = None
            while near is None and ways:
                near = ways.pop(0)(x)
            if near is None:
                break
            x, alone = near, 0
    raise Unbounded(ENDLESS, x)


def _approached(newton, x, rays):
    """A point nearer to the centre, by steps of x and of multipliers."""
    x, near = towards_centre(newton, x, STEPS_OF_BOTH)
    if near:
        return x
    if rays is not None and Barrier(newton).recedes(x, rays()):
        raise Unbounded(ENDLESS)
    return towards_centre(newton, x, 2 * STEPS_OF_BOTH)[0]


@one_thread
def lower_on_ray(blocks, x):
    """A point of ``blocks`` nearer to their centre than x, some multiple of x.

    See `Barrier.on_ray`; x is strictly feasible, and so is that point.
    """
    return barrier_of(blocks).on_ray(x)


@one_thread
def minimize(blocks, cost, x, gap=1e-6):
    """Minimise cost.x over the blocks, from a strictly feasible point.

    The primal-dual method goes first; where it doesn't reach the accuracy, the
    barrier method (section 11.3) does: at a centre the optimum is at least
    cost.x - nu / weight.

    Parameters
    ----------
    blocks : Blocks
        The blocks G_k.
    cost : (k,) array
        The linear objective.
    x : (k,) array
        A strictly feasible point to start from.
    gap : float
        Stop when the optimum is known to this relative accuracy.

    Returns
    -------
    x : array
        Strictly feasible, nearly optimal.
    bound : float
        A lower bound of the optimum.

    Raises
    ------
    Unbounded
        If no such point is found, with the last one; the infimum may be zero,
        or not be attained.
    """
    newton = newton_of(blocks)
    barrier = Barrier(newton)
    weight = blocks.degree / max(abs(cost @ x), 1e-12)
    try:  # the primal-dual method is slow from a point near the boundary
        near = barrier.descend(x, weight * cost, 1.0, STEPS_TO_PATH)
        x = near if np.abs(near).max() < FARTHEST_POINT else x
    except np.linalg.LinAlgError:
        pass
    optimum = minimize_linear(newton, x, cost, gap, weight)
    if optimum is not None:
        return optimum
    for _ in range(20):
        try:
            x = barrier.descend(x, weight * cost, 0.1)
        except np.linalg.LinAlgError:
            break
        if np.abs(x).max() > 1e100 or x @ x > 1e16:
            break
        uncertainty = 2 * blocks.degree / weight
        if uncertainty < gap * abs(cost @ x):
            return x, cost @ x - uncertainty
        weight *= 8
    raise Unbounded(NO_LEAST, x)


def margin(g):
    """The smallest eigenvalue of a symmetric g, its diagonal scaled to one."""
    diagonal = np.diag(g)
    if diagonal.min() <= 0:
        return float(diagonal.min())
    scale = 1 / np.sqrt(diagonal)
    return float(np.linalg.eigvalsh(g * np.outer(scale, scale))[0])
