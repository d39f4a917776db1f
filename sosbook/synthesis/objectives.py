"""The least bounds that a request allows: its optimum, and a design near it."""

from dataclasses import replace
from functools import partial

import numpy as np

from ..exact.definite import round_digits
from ..lmi.solution import LMISolution
from ..plants.checks import positive
from ..requirements.vocabulary import PARAMETERS
from ..runtime.time_limit import OutOfTime
from ..solver.bounded import any_minimum, unpacked
from ..solver.loop import Unbounded
from .centre import finish, nearer
from .cutting import Cuts, few_decide, holds
from .feasibility import FROM_STATES, answer, find, search
from .scaled_lmis import ScaledLMIs
from .solution import Solution
from .steps import AT_FIRST_SIGHT, without_lmis

#: Of the bound so far, that another way must reach to be worth its time.
WORTH = 0.95


def objective_of(minimize, asked):
    """Weights by name of what ``minimize`` names, from the requirements ``asked``."""
    if minimize is None:
        return {}
    own = {r.parameter.key: r.parameter for r in asked if r.parameter}
    known = {name: p for name, p in (PARAMETERS | own).items() if p.power}
    if isinstance(minimize, str) and minimize in known:
        minimize = {minimize: 1.0}
    if (
        not isinstance(minimize, dict)
        or not minimize
        or not set(minimize) <= known.keys()
    ):
        names = ", ".join(f'"{name}"' for name in known)
        raise ValueError(
            f"minimize must be None, {names} or a dict of their weights, "
            f"got {minimize!r}"
        )
    for name in minimize:
        _check_open(known[name], asked)
    return {
        name: positive(f"minimize[{name!r}]", weight)
        for name, weight in minimize.items()
    }


def value(solution, objective):
    """The value of ``objective`` at a ``solution``."""
    if solution.status != "feasible":
        return float("inf")
    owners = {name: solution.request.owner(name) for name in objective}
    return sum(
        weight * owners[name].bound ** owners[name].parameter.power
        for name, weight in objective.items()
    )


def _check_open(which, asked):
    """Raise if a bound that shall be minimised is given, or can't be."""
    owners = [r for r in asked if r.parameter == which]
    if which.open and (not owners):
        raise ValueError(f'minimize="{which.key}" needs {which.open}')
    if any(r.bound is not None for r in owners):
        raise ValueError(
            f'give {which.key} or minimize="{which.key}", not both'
            + (f": {which.open}" if which.open else "")
        )


def at_optimum(request, objective, backoff):
    """The Solution of a ``request`` whose bounds are the least for its ``objective``,
    as in `optimum`, and the fraction ``backoff`` more.
    """

    from .bracket import bracketed, rounded_up
    from .moved_part import point_of_part

    if request.order >= FROM_STATES:
        of = partial(at_optimum, objective=objective, backoff=backoff)
        found = point_of_part(request, of, objective)
        if found is not None and found.status == "feasible":
            return found

    def eased(bounds):
        return {name: rounded_up(b * (1 + backoff)) for name, b in bounds.items()}

    rest = request
    for name in objective:
        rest = rest.without(rest.owner(name))
    if (refusal := without_lmis(rest, AT_FIRST_SIGHT)) is not None:
        return refusal
    try:
        bounds, best = optimum(request, objective, 1e-5)
    except Unfinished as stopped:
        return stopped.solution(request)
    except Unattained as missed:
        bounds = eased(missed.bounds)
        return bracketed(request, bounds, _near(missed.point, request, bounds))
    if bounds is None:
        return without_optimum(best)
    bounds = eased(bounds)
    solution = _near(best, request, bounds)
    if solution.status == "feasible":
        return solution
    return bracketed(request, bounds, solution)


def _near(best, request, bounds):
    """The Solution of a request with some bounds, from a point that keeps them."""
    request = request.with_bounds(bounds)
    lmis, values = best.problem.led(best.values, request)
    if holds(lmis, values):
        try:
            return finish(lmis, values)
        except np.linalg.LinAlgError:
            pass
    return answer(request)  # the optimum lies too close to the boundary


def optimum(request, objective, gap, refuse=True):
    """The bounds by parameter's name of the least weighted sum of levels (see
    `Parameter`), and the point; None and the lack of a point where there is none with
    any bounds. The ``objective`` has weights by name, numbers stand in for its bounds
    in the ``request``, ``gap`` is the sum's relative accuracy, and ``refuse`` is as for
    `find`. Raises Unattained or Unfinished where no minimum is found, or not in time;
    they hold a point.

    A level times an unknown size isn't affine. The requirement whose level is minimised
    therefore leads (`Sizes.leader`): its P is the unknown P, and one semidefinite
    program finds the optimum and the sizes of the others. With two levels or more it
    finds whether there is anything at all; then the sizes are searched, one by one.
    """
    probe = request.with_bounds(dict.fromkeys(objective, 1.0))
    free = tuple(probe.owner(name) for name in objective)
    first = search(probe, free, refuse=refuse)
    if first.values is None:
        return None, first
    followers = probe.sizes.followers(probe.sizes.leader(objective))
    searched = [r.size_name for r in followers if r in free]
    try:
        if searched:
            return _with_sizes(first, searched, objective, gap)
        best = _least(first.problem, objective, first.values, gap)
    except OutOfTime:
        raise Unfinished(first) from None
    return best.problem.bounds(best.values), best


def _least(lmis, objective, values, gap):
    """Where the objective is least, as an LMISolution, from a point inside. Where the
    first coordinates don't do, those of the best point may: there all that is unknown
    is near one.
    """
    try:
        return _minimum(lmis, objective, lmis.text.packed(values), gap)
    except Unattained as missed:
        if lmis.sizes:  # numbers for these coordinates
            raise
        best = missed.point
    there, x = nearer(best.problem, best.problem.text.packed(best.values))
    if there is not best.problem:
        try:
            return _minimum(there, objective, x, gap)
        except Unattained:  # farther away, which helps nobody
            pass
    raise Unattained(best)


def _minimum(lmis, objective, x, gap):
    """The result of `_least` in these coordinates; of many pairs with some blocks."""
    cost = lmis.weights(objective)

    def work(blocks, x):
        return any_minimum(blocks, lmis.matrices, cost, x, gap)

    try:
        x = (
            Cuts(lmis).least(x, work)
            if few_decide(lmis.request)
            else work(lmis.compiled, x)
        )
    except Unbounded as missed:
        best = unpacked(lmis.unknowns, missed.x)
        raise Unattained(LMISolution(lmis, best)) from None
    return LMISolution(lmis, unpacked(lmis.unknowns, x))


def _with_sizes(first, searched, objective, gap):
    """`optimum` where sizes are searched, in shrinking steps while that helps."""
    lmis, known = first.problem, {}

    def best(sizes):
        key = tuple(sizes.items())
        if key not in known:
            known[key] = _at_sizes(lmis, sizes, objective, gap)
        return known[key]

    sizes = {name: float(first.values[name].item()) for name in searched}
    for ratio in (16.0, 4.0, 1.6, 1.2, 1.05):
        for name in sizes:
            for step in (ratio, 1 / ratio):
                while True:
                    moved = sizes | {name: float(round_digits(sizes[name] * step, 6))}
                    if not best(moved)[0] < best(sizes)[0]:
                        break
                    sizes = moved
    _, found, attained = best(sizes)
    if found is None:  # only the point that phase one found
        raise Unattained(first)
    whole = LMISolution(lmis, lmis.joined(found.values, sizes))
    if not attained:
        raise Unattained(whole)
    return found.problem.bounds(found.values), whole


def _at_sizes(lmis, sizes, objective, gap):
    """The least weighted sum of levels for given sizes, where, and if attained."""
    there, attained = ScaledLMIs(lmis.request, lmis.frame, lmis.free, sizes), True
    first = find(there, refuse=False)
    if first.values is None:
        return np.inf, None, False
    try:
        best = _least(there, objective, first.values, gap)
    except Unattained as missed:
        best, attained = missed.point, False
    value = there.weights(objective) @ there.text.packed(best.values)
    return value, best, attained


class Unattained(ValueError):
    """Raised where no minimum is found, which doesn't say that there is none; ``point``
    is the best of `ScaledLMIs` that was.
    """

    def __init__(self, point):
        super().__init__("no minimum was found")
        self.point = point

    @property
    def bounds(self):
        """Its bounds, by the parameters' names."""
        return self.point.problem.bounds(self.point.values)


class Unfinished(OutOfTime):
    """Raised where time ends before a minimum; ``first`` is a point inside."""

    def __init__(self, first):
        super().__init__("the time limit is over")
        self.first = first

    def solution(self, request):
        """The Solution of a request: a design that keeps larger bounds."""
        from .bracket import rounded_up

        lmis, values = self.first.problem, self.first.values
        bounds = {name: rounded_up(b) for name, b in lmis.bounds(values).items()}
        return replace(
            lmis.solution(values, request.with_bounds(bounds)),
            reason=f"Stopped before the least {' and '.join(bounds)} was found: this "
            "design keeps a larger one. Raise time_limit.",
        )


def without_optimum(first):
    """The Solution of a request for which no point has any bounds at all: "infeasible"
    where what is asked beside the objective is, or where exact multipliers exclude
    every bound. ``first`` is the lack of a point of `ScaledLMIs` with free levels.
    """
    request, minimized = first.problem.request, first.problem.free
    rest = request
    for r in minimized:
        rest = rest.without(r)
    solution = answer(rest)
    if solution.status != "feasible":
        return solution
    names = " and ".join(r.parameter.key for r in minimized)
    refusal = Solution(rest, "undecided", request.gain, minimized=minimized)
    proof = first.problem.limit().find().infeasibility
    if proof is not None:
        text = f"Exact multipliers of the LMIs exclude every {names}"
        text = f"{request.sizes.subject(text)}."
        return replace(refusal, status="infeasible", reason=text, infeasibility=proof)
    text = f"No point was found from where {names} could be minimised"
    return replace(refusal, reason=f"{request.sizes.subject(text)}.")
