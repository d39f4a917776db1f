"""What a request leaves open: objectives and line searches."""

from dataclasses import replace

import numpy as np

from ..lmi.centre import Blocks, Unbounded, minimize
from ..lmi.exact import round_digits
from ..lmi.problem import bounded
from ..requirements.shorthand import bounds
from .feasibility import Solution, answer, finish, follow, search
from .scaling import typical_rate

__all__ = ["feasible", "optimum", "solve", "with_slack"]

# epsilon in units of 1 / (typical rate), in the order of trial
SLACK_STEPS = (1 / 4, 1 / 2, 1 / 8, 1, 1 / 16, 2, 1 / 64, 4, 1 / 256)


def solve(request, objective=None, tune=None, backoff=0.01, start=None):
    """Solve a request; search what it leaves open.

    Parameters
    ----------
    request : Request
        With ``coupling="slack"`` and no ``slack`` the scalar is searched.
    objective : dict, optional
        Weights by the names of parameters: the weighted sum of their
        levels (see `Parameter`) is minimised. Numbers stand in for them
        in the request.
    tune : str, optional
        Parameter of the requirement whose free scalar is searched.
    backoff : float
        What is added to the optimal bounds, as a fraction.
    start : Solution, optional
        Of a request of the same shape: where to start from.

    Returns
    -------
    Solution
    """
    if tune is not None:
        request, found = _tuned(request, tune)
        if not found:
            return Solution(request, "undecided", request.gain)
    request, found = with_slack(request, objective)
    if not found:
        return Solution(request, "undecided", request.gain)
    if objective:
        return _at_optimum(request, objective, backoff)
    found = follow(request, start) or answer(request)
    if tune and found.status == "infeasible":  # for this scalar only
        return replace(found, status="undecided")
    return found


def with_slack(request, objective=None):
    """The request with a slack scalar where it needs one, and success."""
    if request.coupling == "slack" and request.slack is None:
        return _search_slack(request, objective)
    return request, True


def feasible(request):
    """Whether phase one finds a solution of this very request."""
    if request.coupling == "slack" and request.slack is None:
        return _search_slack(request, None)[1]
    return search(request)[0].x is not None


def optimum(request, objective, gap):
    """The optimal bounds (None without any), their point, the frame.

    Without any, phase one's outcome instead of the point.

    Parameters
    ----------
    request : Request
    objective : dict
        As in `solve`.
    gap : float
        Relative accuracy of the weighted sum.
    """
    probe = request.with_bounds(dict.fromkeys(objective, 1.0))
    free = tuple(_owner(probe, name) for name in objective)
    phase, frame, blocks, unknowns, units = search(probe, free)
    if phase.x is None:
        return None, phase, frame
    cost = np.zeros(blocks.variables)
    cost[-len(objective):] = [
        objective[name] * units[name] for name in objective]
    cost /= cost.max()
    best = _minimize(blocks, unknowns, cost, phase.x, gap, objective)
    levels = best[-len(objective):] * list(units.values())
    values = {r.parameter.key: r.parameter.bound(level)
              for r, level in zip(free, levels)}
    return values, best[:-len(objective)], frame


def _owner(request, name):
    """The requirement that a parameter belongs to."""
    return next(r for r in request.requirements
                if r.parameter is not None and r.parameter.key == name)


def _tuned(request, name):
    """The request with the best free scalar of a theorem, and whether any."""
    request = request.with_bounds({name: 1.0}) if (
        name not in bounds(request.requirements)) else request
    owner = _owner(request, name)

    def changed(other):
        return replace(request, requirements=tuple(
            other if r is owner else r for r in request.requirements))

    def smallest(other):
        found = optimum(changed(other), {name: 1.0}, 1e-2)[0]
        return np.inf if found is None else found[name]

    best = owner.tuned(smallest)
    return (request, False) if best is None else (changed(best), True)


def _minimize(blocks, unknowns, cost, x, gap, objective):
    """The minimum, if need be with bounded unknowns."""
    try:
        return minimize(blocks, cost, x, gap)[0]
    except Unbounded:  # perhaps in a direction that costs nothing
        limits = 1e5, 1e7
    try:
        near, far = (
            minimize(joined, cost, inside, gap)[0]
            for joined, inside in (
                bounded(blocks, unknowns, x, r) for r in limits)
        )
    except Unbounded:
        far = None
    if far is None or cost @ far < 0.99 * (cost @ near):
        names = " and ".join(objective)
        raise ValueError(
            f"minimize: {names} has no minimum: the bound goes to zero or "
            "is reached by infinite gains only; limit them with saturation "
            "or a disk (rho)"
        )
    return near


def _at_optimum(request, objective, backoff):
    values, x, frame = optimum(request, objective, 1e-5)
    if values is None:
        return Solution(_opened(request, objective), x.verdict, request.gain)
    request = request.with_bounds({
        name: _rounded_up(value * (1 + backoff))
        for name, value in values.items()
    })
    expressions, unknowns = request.in_unknowns(frame)
    blocks = Blocks.of(expressions.values(), unknowns)
    return finish(request, frame, blocks, unknowns, x)


def _opened(request, objective):
    """The request less the requirements that an objective alone has made."""
    for name in objective:
        owner = _owner(request, name)
        if not owner.parameter.open:
            request = request.without(owner)
    return request


def _rounded_up(value):
    """To three significant digits."""
    digits = 2 - int(np.floor(np.log10(value)))
    return float(np.round(
        np.ceil(value * 10.0**digits) / 10.0**digits, max(digits, 0)))


def _search_slack(request, objective):
    """The request with a slack scalar, and whether one was found."""
    unit = 1 / typical_rate(request)
    tried = {}
    for step in SLACK_STEPS:
        slack = float(round_digits(unit * step, 2))
        trial = replace(request, slack=slack)
        if not objective:
            if feasible(trial):
                return trial, True
            continue
        found = optimum(trial, objective, 1e-3)[0]
        if found is not None:
            tried[slack] = sum(
                weight * found[name] ** _owner(request, name).parameter.power
                for name, weight in objective.items())
    if not tried:
        return trial, False
    best = min(tried, key=tried.get)
    return replace(request, slack=best), True
