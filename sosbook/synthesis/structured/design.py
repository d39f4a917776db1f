"""A design by a law: searched, proven, refused by a door, or undecided."""

from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from ...exact.definite import round_digits
from ...exact.rational import exact
from ...requirements.known_gain import KnownLoop
from ...requirements.vocabulary import SIGMA
from ...runtime.read_only import ReadOnly, put
from ...runtime.time_limit import (
    LEAST_TIME,
    OutOfTime,
    check_time,
    time_left,
    time_limit,
)
from ..cells import Box
from ..known_gain import kept_or_broken
from ..ranges import Ranges, family
from ..solution import Solution
from . import slopes
from .continuation import Ended, at_limits, hasty, of_loops, why_ended
from .doors import refused_by_a_door, refused_by_mode, refused_by_sum
from .moving_gain import loops_of
from .objective import DECAY, Objective, Task
from .orders import from_lower_orders
from .search import search

AGAIN = 3  # searches, each with the worst plants between the vertices
MORE = 4  # times as many starts are the next that a search is worth
STARTS = 16  # of the first search
FEW = 3  # of the others; none where a goal's search goes on
DIGITS = 6, 10  # of the free numbers, in the order of trial
WORSE = 0.01  # a fraction by which a plant between is worse than all vertices
NEAR = 1e-9  # to a vertex: counted as that
SEARCH = 0.5  # of the time that is left, for a search; the rest is for the proof
STOPPED = (
    "The time was over before the search was: {} begun. A longer time_limit may find a "
    "better K."
)


@dataclass(frozen=True, eq=False)
class Searched(ReadOnly):
    """How a gain was searched.

    ``starts``, ``seed``: how many descents were begun, and the seed of their random
    numbers; ``limits``: the largest size of an entry, by the name of the gain;
    ``least_decay``: in 1/s, of every loop that the search took; None where poles alone
    are asked; ``between``: how many plants between the vertices joined.
    """

    starts: int
    seed: int
    limits: dict
    least_decay: float | None
    between: int = 0

    def __str__(self):
        limits = ", ".join(f"{name} up to {x:.3g}" for name, x in self.limits.items())
        starts = "1 start" if self.starts == 1 else f"{self.starts} starts"
        words = f"{starts} with the seed {self.seed}, {limits}"
        if self.least_decay:
            words += f", each loop with a decay of {self.least_decay:.3g} 1/s at least"
        if self.between:
            words += f", plants between the vertices: {self.between}"
        return words


def by_law(request, objective, how):
    """The Solution of a design for a ``request`` with a law, and any gain of it;
    numbers stand in for an ``objective``, the parameter that shall be as good as can
    be, if any; ``how`` is the `Search`.
    """
    backoff, starts, seed = how.backoff, how.starts or STARTS, how.seed
    for r in request.requirements:
        if not (r.takes_multipliers and (r.parameter or r.pole_matrices())):
            raise ValueError(
                f"{r.words}: a law's gain is searched for poles, and for bounds that "
                "have LMIs with free multipliers: leave it out"
            )
    loops = loops_of(request)
    some = np.clip(np.ones(len(loops.directions)), *loops.form.ends)
    replace(request, gain=loops.K(some))  # raises where noise in u is infinite
    goal, owner = None, None
    if objective:
        owner = request.owner(next(iter(objective)))
        goal = DECAY if owner.parameter is SIGMA else owner
    refused = refused_by_sum(request, loops, owner) or refused_by_mode(request, owner)
    if refused is not None:
        return refused
    task = Task.of(request, loops, goal)
    bounded = goal == DECAY and task.bounded  # its search looks at poles alone
    best, near, count, between, stopped, ended = None, (), 0, 0, False, Ended()
    asked_doors = False
    try:
        for again in range(AGAIN):
            check_time()
            left = time_left()
            seconds = None if np.isinf(left) else max(SEARCH * left, LEAST_TIME)
            with time_limit(seconds):
                some = starts if not again else FEW if goal is None else 0
                found = search(task, loops, some, seed, near)
                if bounded and not _keeps(task, loops, found):
                    kept = replace(task, goal=None)
                    count += found.starts
                    found = search(kept, loops, some or FEW, seed, near)
                if not again and not found.stopped and not _kept(found, goal):
                    if goal is None:  # a refusal takes less than lower orders do
                        refused, asked_doors = _refused_in_time(request)
                        if refused is not None:
                            return refused
                    free = request.applied.parts.free
                    lower, more = from_lower_orders(task, loops, free, seed)
                    count += more
                    if lower:
                        other = search(task, loops, 0, seed, lower)
                        count += other.starts
                        found = min(other, found, key=lambda f: f.value)
                if goal is not None and found.value < (0 if bounded else np.inf):
                    found, ended = of_loops(task, loops, found, FEW, seed)
            count, near = count + found.starts, (found.kappa,)
            by = record(task, loops, count, seed, between)
            stopped = stopped or found.stopped
            if not found.value < (0 if goal is None or bounded else np.inf):
                break
            for digits in DIGITS:
                kappa = task.inside(round_digits(found.kappa, digits))
                known = replace(request, gain=loops.K(kappa))
                solution = kept_or_broken(known, objective, backoff)
                if solution.status == "feasible":
                    break
            solution = replace(solution, searched=by)
            if _better(solution, best, objective):
                best, ends = solution, (task, loops, found, ended)
            points = _worse(solution, task, loops, found, goal)
            if not points:
                break
            more = [_between(request, known, loops, p) for p in points]
            loops, between = loops.with_more(more), between + len(points)
    except OutOfTime:
        if best is None or best.status != "feasible":
            raise
        stopped = True
    if best is not None and best.status == "feasible":
        return replace(best, reason=_why(best, stopped, objective, *ends))
    return _undecided(request, task, loops, found, best, by, asked_doors)


def _refused_in_time(request):
    """The Solution of `refused_by_a_door`, or None, and whether all doors were asked
    before the time was over.
    """
    try:
        return refused_by_a_door(request), True
    except OutOfTime:
        return None, False


def _why(best, stopped, objective, task, loops, found, ended):
    """The reason that a search of ``objective`` ended at the ``best`` Solution."""
    if not objective:
        return best.reason
    shown = best.request.owner(next(iter(objective))).parameter.shown
    if stopped:
        begun = best.searched.starts
        return STOPPED.format("1 start was" if begun == 1 else f"{begun} starts were")
    blocks = loops.form.blocks
    words = why_ended(ended, shown, found.kappa, task.ends, blocks)
    if task.goal != DECAY:
        return words
    s = slopes.Poles(loops, loops.K(found.kappa)).s
    return f"{words} {hasty(s, getattr(best.request.law, 'filter', None))}".strip()


def _keeps(task, loops, found):
    """True if what was ``found`` keeps all that is asked beside a goal."""
    if found.kappa is None:
        return False
    unit = loops.units(task.rate)
    rest = Objective(replace(task, goal=None), loops, unit, True)
    return rest(found.kappa / unit)[0] < 0


def _kept(found, goal):
    """True if all is kept, and nothing shall be better."""
    return goal is None and found.value < 0


def _better(solution, best, objective):
    if best is None or best.status != "feasible":
        return True
    if solution.status != "feasible" or not objective:
        return False
    key = next(iter(objective))
    r, old = (s.request.owner(key) for s in (solution, best))
    return r.parameter.harder * (r.bound - old.bound) > 0


def _worse(solution, task, loops, found, goal):
    """Points between the vertices that a next search has to count."""
    points = []
    K = loops.K(found.kappa)
    for part in solution.parts:
        r, worst = part.requirement, part.worst
        inner = np.abs(worst.point - 0.5) < 0.5 - NEAR  # weights, or shares of ranges
        between = inner.any()
        if part.status != "feasible" and worst.kept <= 0 and between:
            points.append(worst.point)
        elif goal is not None and r.parameter is not None and between:
            seen = [loops.descriptor(i, K, task.m) for i in range(len(loops))]
            here = max(r.parameter.harder * -r.reached([d], g) for d, g in seen)
            there = r.parameter.harder * -worst.truth
            if there > here + WORSE * abs(here):
                points.append(worst.point)
    return points


def _between(request, known, loops, point):
    """The plant at a point of a gain's family, joined with the law's states."""
    plants = family(known)
    law = copy(request.law)
    put(law, form=None)  # zero is no gain of a law with fixed entries
    open_loop = replace(request, law=law, gain=0 * request.gain)
    if isinstance(plants, Ranges):
        d = family(open_loop).at(plants.exactly(point)).plant
    else:
        at = plants.exactly(point)
        weights = plants.weights(at) if isinstance(plants, Box) else at
        d = _mean(open_loop, weights)
    d = d.map(lambda x: x.astype(float))
    m = request.plant.m
    first = loops.plants[0]
    Du = None if first.Du is None else np.hstack([d.Du, first.Du[:, m:]])
    return replace(d, Bu=np.hstack([d.Bu, first.Bu[:, m:]]), Du=Du)


def _mean(request, weights):
    K = request.exact_gain
    vertices = request.vertices_in(exact, request.distinct)
    first, *others = (KnownLoop(d, K) for d in vertices)
    return first.mixed(others, weights).plant


def record(task, loops, count, seed, between):
    """The `Searched` of a search of a ``task`` over ``loops``, with ``count`` starts,
    the ``seed`` of the random ones, and so many plants ``between`` the vertices.
    """
    limits, start = {}, 0
    for b in loops.form.blocks:
        some = task.limits[start : start + len(b.shares)]
        start += len(b.shares)
        if len(some):
            limits[b.name] = float(some.max())
    poles = not task.bounded and task.goal in (None, DECAY)
    least = None if poles else task.least_decay
    return Searched(count, seed, limits, least, between)


def _undecided(request, task, loops, found, best, record, asked_doors):
    """Undecided, with what was reached; or "infeasible", by a door, unless no one of
    the doors, all asked before, has refused it.
    """
    if not asked_doors:
        goal = SIGMA if task.goal == DECAY else task.goal
        refused = refused_by_a_door(request, goal)
        if refused is not None:
            return refused
    by = f"{record}, stopped by the time" if found.stopped else f"{record}"
    if not np.isfinite(found.value):
        text = f"No stable loop of finite norms was found by {by}."
        text += f" Measure more, or take starts={MORE * record.starts}."
    else:
        text = f"Nothing that keeps all was found by {by}."
        text = f"{text} {_reached(request, task, loops, found)}".strip()
        text += f" Ask for less, measure more, or take starts={MORE * record.starts}."
    if best is not None:
        text = f"The best gain that was found isn't proven: {best.reason} ({by}.)"
    known = best is not None and best.status == "undecided"  # no plant breaks it
    K = best.K if known else None
    known = best.request if known else request
    return Solution(known, "undecided", K, reason=text, searched=record)


def _reached(request, task, loops, found):
    """The bounds that the best gain reaches at the plants of the search."""
    K = loops.K(found.kappa)
    seen = [loops.descriptor(i, K, task.m) for i in range(len(loops))]
    words = []
    for r in request.requirements:
        if r.parameter is None:
            continue
        level = r.parameter.harder * min(
            r.parameter.harder * r.reached([d], gain) for d, gain in seen
        )
        words.append(
            f"{r.words} {r.parameter.shown(level):.4g} (asked: "
            f"{r.parameter.shown(r.bound):.4g})"
        )
    full, moves = at_limits(found.kappa, task.ends, loops.form.blocks)
    at = f" There {full}; the law's {moves}= moves it." if full else ""
    return f"The nearest gain reaches {', '.join(words)}.{at}" if words else ""
