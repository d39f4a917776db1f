"""The goal of a search of gains: violations, a norm, and the limits of gains."""

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from ...requirements.lmi_region import LMIRegion
from ...requirements.vocabulary import SIGMA
from . import slopes

DECAY = SIGMA.key  # the goal of the fastest decay
LEAST_DECAY = 1e-3  # of the rate, of each loop: a norm alone ends at an axis
PENALTY = 20.0  # of a violation, in units of the logarithm of a norm
MARGIN = 1e-3  # by which constraints are kept, so that their proof has room
EASE = 0.01  # of a sought norm's logarithm, for a number as large as LARGEST
SURE = 1e-4  # of a norm's logarithm, by which a peak on a grid is above a level
EXPONENT = 700.0  # the largest whose exponential is a float
WALL = 30.0  # of a gain's excess over its limit, as a fraction


@dataclass(frozen=True, eq=False)
class Task:
    """The task of a search over some loops: their poles in ``regions``, requirements
    ``bounded`` otherwise, and a ``goal`` that shall be as good as can be, None where
    all shall be kept. ``rate`` is the loop's, in rad/s, ``ends``, (2, k), are the least
    and the largest of each free number, ``m`` is the number of inputs u, and ``step``
    the tick of a plant of discrete time.
    """

    regions: tuple
    bounded: tuple
    goal: Any
    rate: float
    ends: np.ndarray
    m: int
    step: float | None = None

    @property
    def limits(self):
        """The largest size of each free number, (k,)."""
        return np.abs(self.ends).max(axis=0)

    def inside(self, kappa, unit=1.0):
        """The nearest free numbers to ``kappa`` that are allowed, in a ``unit``."""
        return np.clip(kappa, *(self.ends / unit))

    @classmethod
    def of(cls, request, loops, goal):
        """The task of a ``request`` for its ``loops``; the ``goal``'s bound is open."""
        asked = [r for r in request.requirements if r is not goal]
        if goal == DECAY:  # a number stands in
            asked = [r for r in asked if r.parameter is not SIGMA]
        regions = [r for r in asked if r.pole_matrices() is not None]
        bounded = [r for r in asked if r not in regions]
        slow, fast = loops.rates
        own = float(np.sqrt(slow * fast)) * (FASTER if goal == DECAY else 1.0)
        rate = _asked_rate(asked) or own
        largest = LARGEST * np.max([loops.units(s) for s in (slow, rate, fast)], axis=0)
        ends = loops.form.within(largest)
        some = tuple(regions), tuple(bounded)
        return cls(*some, goal, rate, ends, request.plant.m, request.step)

    @property
    def least_decay(self):
        """In 1/s, of every loop that is taken: no more than is asked."""
        if self.step is not None:
            return min(LEAST_DECAY * self.rate, LEAST_DECAY / self.step)
        asked = [r.bound for r in self.regions if r.parameter is SIGMA and r.bound > 0]
        return min([LEAST_DECAY * self.rate, *asked])

    @cached_property
    def stable(self):
        """The region of the loops that decay so: of ticks a disk of z."""
        if self.step is None:
            return LMIRegion.half_plane(self.least_decay)
        return LMIRegion.disk(1 - self.step * self.least_decay).stepped(self.step)


FASTER = 4.0  # than its own rates a plant shall be, where a decay is sought
LARGEST = 100.0  # units of a free number, where its author sets no limit


def _asked_rate(asked):
    rates = [r.rate() for r in asked if r.rate()]
    return min(rates)[1] if rates and min(rates)[0] < 2 else None


class Objective:
    """The function of a ``task`` for the ``loops`` of all plants that count, of x with
    kappa = ``unit`` x: value and slope, finite where the value is. With ``norms`` more
    than poles count, and unstable loops have no value. Has ``least``, ``at``: the least
    value so far, and where.
    """

    def __init__(self, task, loops, unit, norms):
        self.task, self.loops, self.unit, self.norms = task, loops, unit, norms
        self.least, self.at = np.inf, None
        parts = [(r.alpha, r.beta, _size(r) * task.rate) for r in task.regions]
        least = task.stable
        stable = (least.alpha, least.beta, _size(least) * task.rate)
        self.regions = parts if task.goal == DECAY else [*parts, stable]
        self.axis = [(np.zeros((1, 1)), np.eye(1), 2 * task.rate)]

    def __call__(self, x, most=np.inf):
        """(value, slope) at x; beyond the limits those of the nearest point within, and
        a charge for the way to it: what is below zero is so for a gain of the law. Of a
        value above ``most`` nobody asks the slope, which is None.
        """
        kappa = x * self.unit
        within = self.task.inside(kappa)
        low, high = self.task.ends
        off, half = kappa - (low + high) / 2, (high - low) / 2
        over = np.abs(off) / half - 1
        beyond = (over > 0).any()
        wall = WALL * over[over > 0].sum() if beyond else 0.0
        eased = self.norms and self.task.goal not in (None, DECAY)
        ease = EASE * (x @ x) / LARGEST**2 if eased else 0.0
        highest = max(most, self.least) - wall - ease
        value, turn = self._of(self.loops.K(within), highest)
        if not np.isfinite(value):
            return np.inf, np.zeros_like(x)
        value = value + wall + ease
        if value < self.least:
            self.least, self.at = value, x
        if value > most:
            return value, None
        slope = np.where(within == kappa, self.loops.slope(turn()) * self.unit, 0.0)
        if beyond:
            way = np.sign(off) * self.unit / half
            slope = slope + WALL * np.where(over > 0, way, 0.0)
        if eased:
            slope = slope + 2 * EASE * x / LARGEST**2
        if not np.isfinite(slope).all():  # nothing falls from here
            return np.inf, np.zeros_like(x)
        return value, slope

    def _of(self, K, most):
        """The value of the loops under K, and what gives its slope in K; of a value
        above ``most`` a number between them does.
        """
        task = self.task
        poles = slopes.Poles(self.loops, K)
        if not np.isfinite(poles.s).all():
            return np.inf, None
        value, *where = poles.worst(self.regions)
        S = partial(poles.slope, *where)
        if task.goal == DECAY:
            fast, *fastest = poles.worst(self.axis)
            T = partial(poles.slope, *fastest)
            if value <= -MARGIN:
                return fast, T
            return fast + PENALTY * (value + MARGIN), lambda: T() + PENALTY * S()
        if not self.norms:
            return value, S
        if task.stable.distance(poles.s).min() <= -task.least_decay * (task.step or 1):
            return np.inf, None
        highest = most if task.goal is None else np.inf
        for r in task.bounded:
            if value > highest:
                break
            level, T = self._level(r, K, poles, highest)
            if level > value:
                value, S = level, lambda T=T: T
        if task.goal is None:
            return value, S
        level, T = self._level(task.goal, K, poles, most)
        if value > -MARGIN:
            return level + PENALTY * (value + MARGIN), lambda: T + PENALTY * S()
        return level, lambda: T

    def _level(self, r, K, poles, most):
        """The logarithm of what is reached over the bound, and its slope, which is None
        where the first is seen to be above ``most``.
        """
        bound = 1.0 if r is self.task.goal else r.bound
        beyond = bound * np.exp(min(most + SURE, EXPONENT))
        reached, S = self._reached(r, K, poles, beyond)
        if not 0 < reached < np.inf:
            return (-np.inf if reached == 0 else np.inf), 0 * K
        sign = -r.parameter.harder
        slope = None if S is None else sign * S / reached
        return sign * float(np.log(reached / bound)), slope

    def _reached(self, r, K, poles, beyond):
        try:
            if r.bounds_response() is not None:
                return slopes.norm(self.loops, K, r, self.task.m, poles, beyond)
            return slopes.reached(self.loops, K, r, self.task.m, self.unit)
        except np.linalg.LinAlgError:  # a pole on the axis, to rounding
            return np.inf, 0 * K


def _size(r):
    """How large a region's form is for a pole one away from its boundary."""
    return 2 * abs(r.beta[0, 0]) if r.beta.shape == (1, 1) else 1.0
