"""The loop: a point inside, the analytic centre, the minimum of a linear objective.

1. `phase_one` raises t until all blocks G_k(x) > t I hold with t = 0, by steps of
   points and multipliers (`maximize_t`). Where these can't decide, Newton's method
   follows the central path inside a ball, which yields multipliers, too.
2. `centre` minimises the barrier -sum log det G_k(x) by Newton's method, whose steps
   are bent (`Curve`) or searched along (`Barrier.step`).
3. `minimize` goes near the central path, takes steps of points and multipliers along
   it (`minimize_linear`), and where these don't end, follows it by Newton's method.

The numbers of sections are those of Boyd and Vandenberghe (2004), where each step is
derived.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from ..runtime.threads import one_thread
from .barrier import MOST_GROWTHS, Barrier, grows
from .blocks import excluded_radius, refined
from .primal_dual import (
    FARTHEST_POINT,
    maximize_t,
    minimize_linear,
    near_centre,
    positive,
)

LONGEST_SOLUTION = 1e9  # norm of x; a longer one is no solution in floats of 16 digits
ENDLESS = "no analytic centre was found: the set seems to be unbounded"
NO_LEAST = "no minimum was found: perhaps it isn't attained"
CENTRE_DECREMENT = 1e-4  # of the last step to a centre; a bent one leaves its cube
ITERATIVE_DECREMENT = 1e-5  # what conjugate gradients may leave of it
LAST_STEP_BELOW = 3e-3  # a decrement after which one step by these is enough
# what a step lowers by less isn't near, unless it is so much smaller than the last
# step's: a gain whose unit is 0.3 was 1e-5 off where the steps crept
SLOW_FALL = 0.1
# of Newton's method, before one of points and multipliers is tried: without these and
# without curves a set may be taken for one without a centre
STEPS_ALONE = 15
STEPS_BEFORE_DIRECTIONS = 6  # without an end; few sets with a centre need more
FAR_STEP = 3.0  # times as far from 0 as before: directions are looked for at once
BARRIER_STEPS = 8  # before points and multipliers find a minimum


class Unbounded(ValueError):
    """Raised with a ``message`` where no centre or minimum is found.

    ``x`` is the best point that was found; None where the set has no end for certain.
    """

    def __init__(self, message, x=None):
        super().__init__(message)
        self.x = x


@dataclass(frozen=True, eq=False)
class Phase:
    """Outcome of phase one: the ``verdict``, "feasible", "infeasible" or "undecided".

    ``x`` lies inside. Without it ``Z`` may hold multipliers that exclude it: Z_k > 0,
    sum <G_ka, Z_k> = 0, sum <G_k0, Z_k> <= 0; the search ended at ``last_iterate``, and
    no feasible point is shorter than ``excluded_radius``.
    """

    verdict: str
    x: np.ndarray | None = None
    Z: list | None = None
    last_iterate: np.ndarray | None = None
    excluded_radius: float = 0.0


@one_thread
def phase_one(blocks, radius=1e4, wide=1e8, start=None, watch=None, multipliers=True):
    """Find x with all G_k(x) > 0 in ``blocks``, or multipliers that exclude it.

    It maximises t subject to G_k(x) > t I along the central path, from ``start`` if
    that is better than 0, inside the ball |x| < radius, until t is known to be positive
    or to stay negative (section 11.4). Where all blocks are homogeneous the first one,
    X > 0, is read as X > I, which excludes x = 0 alone. Where only the ball stands in
    the way, that of radius ``wide`` is tried. "infeasible" says that no solution is
    shorter than ``excluded_radius``, half the ``radius`` or more, and that none was
    found beyond. ``watch`` as in `maximize_t`; without ``multipliers`` what isn't found
    feasible is "undecided".
    """
    if start is not None and positive(blocks.newton.at(start)):
        return Phase("feasible", x=start)
    asked = blocks
    if not any(c.any() for c in blocks.constants):
        first = -np.eye(len(blocks.constants[0]))
        blocks = blocks.with_constants([first, *blocks.constants[1:]])
    # t is raised in units in which the blocks' diagonals are near one
    units = [np.diag(1 / d**2) for d in blocks.diagonal_scales]
    newton = blocks.newton.joined([-D for D in units])
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
            excluded = excluded_radius(blocks, Z)
            if excluded < LONGEST_SOLUTION:
                Z = refined(blocks, Z)
                excluded = excluded_radius(blocks, Z)
            verdict = "infeasible" if excluded >= radius / 2 else "undecided"
            if excluded < wide / 2 and radius < wide:
                further = phase_one(asked, wide)
                if further.x is not None or verdict == "undecided":
                    return further
            return Phase(verdict, Z=Z, last_iterate=x[:-1], excluded_radius=excluded)
        weight *= 8
    return Phase("undecided", last_iterate=x[:-1])


@one_thread
def centre(blocks, x, watch=None, enough=None, directions=None, elsewhere=None):
    """The analytic centre of ``blocks``, from x: it maximises sum log det G_k.

    ``watch`` gets a dict after each step: step, x, decrement, iterations of conjugate
    gradients. A decrement below ``enough`` ends it. Where it is slow, ``directions()``
    are looked at, (k,) arrays in which the set may be unbounded, and ``elsewhere(x)``
    is asked for another point inside, or None. Raises Unbounded if no centre is found.
    """
    barrier = blocks.barrier
    newton = barrier.newton
    zero, decrement, left, growths, alone = np.zeros(len(x)), 1.0, 1.0, 0, 0
    ways = [elsewhere, partial(near_centre, newton)]
    ways = [] if newton.iterative else [way for way in ways if way is not None]
    enough, goal = enough or CENTRE_DECREMENT, ITERATIVE_DECREMENT
    for count in range(200):
        before, behind = decrement, x
        last = left < LAST_STEP_BELOW  # where one more step is enough
        tolerance = goal / (2 * left) if last else min(0.1, decrement)
        x, decrement = barrier.step(x, zero, tolerance)
        left = decrement * max(decrement, tolerance)  # of conjugate gradients
        growths += grows(before, decrement)
        if watch is not None:
            state = dict(step=count + 1, x=x, decrement=decrement)
            watch(state | dict(iterations=newton.iterations[-1:]))
        # where it falls slowly Newton's method isn't near yet, however small it is
        quick = decrement < SLOW_FALL * max(before, enough)
        if (decrement < enough and quick) or (newton.iterative and left < goal):
            return x
        if x @ x > 1e16 or growths > MOST_GROWTHS:
            break
        # below one there is a centre (section 9.6.4)
        far = x @ x > FAR_STEP**2 * (behind @ behind)
        far = far or count + 1 == STEPS_BEFORE_DIRECTIONS
        if directions is not None and decrement >= 1 and far:
            if barrier.recedes(x, directions()):
                raise Unbounded(ENDLESS)
            directions = None
        alone += 1
        if alone == STEPS_ALONE and decrement >= 1 and ways:
            near = None
            while near is None and ways:
                near = ways.pop(0)(x)
            if near is None:
                break
            x, alone = near, 0
    raise Unbounded(ENDLESS, x)


@one_thread
def minimize(blocks, cost, x, gap=1e-6):
    """Minimise cost.x over ``blocks``, from x, to the relative accuracy ``gap``.

    The primal-dual method goes first; where it doesn't reach that, the barrier method
    (section 11.3): at a centre the optimum is at least cost.x - nu / weight. Returns x
    and a lower bound of the optimum. Raises Unbounded, with the last point, if there is
    none: for a ``cost`` the infimum may be zero, or not be attained.
    """
    newton = blocks.newton
    barrier = Barrier(newton)
    weight = blocks.degree / max(abs(cost @ x), 1e-12)
    try:  # the primal-dual method is slow from a point near the boundary
        near = barrier.descend(x, weight * cost, 1.0, BARRIER_STEPS)
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
