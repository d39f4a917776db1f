"""What a request leaves open: objectives and line searches."""

from dataclasses import replace

import numpy as np

from ..lmi.centre import Blocks, Unbounded, minimize
from ..lmi.exact import round_digits
from .feasibility import Solution, answer, bounded, finish, follow, search, square
from .scaling import typical_rate

__all__ = ["feasible", "optimum", "solve", "with_slack"]

# epsilon in units of 1 / (typical rate), in the order of trial
SLACK_STEPS = (1 / 4, 1 / 2, 1 / 8, 1, 1 / 16, 2, 1 / 64, 4, 1 / 256)


def solve(request, objective=None, free_mu=False, backoff=0.01, start=None):
    """Solve a request; search what it leaves open.

    Parameters
    ----------
    request : Request
        With ``coupling="slack"`` and no ``slack`` the scalar is searched.
    objective : dict, optional
        Weights of gamma and u_max: their squares' weighted sum is
        minimised. Numbers stand in for them in the request.
    free_mu : bool
        Search mu.
    backoff : float
        What is added to the optimal bounds, as a fraction.
    start : Solution, optional
        Of a request of the same shape: where to start from.

    Returns
    -------
    Solution
    """
    if free_mu:
        request, found = _search_mu(request)
        if not found:
            return Solution(request, "undecided", request.gain)
    request, found = with_slack(request, objective)
    if not found:
        return Solution(request, "undecided", request.gain)
    if objective:
        return _at_optimum(request, objective, backoff)
    found = follow(request, start) or answer(request)
    if free_mu and found.status == "infeasible":  # for this mu only
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


def _bounds(request, values):
    """The request with other values of gamma and u_max."""
    if "u_max" in values:
        limit = replace(request.saturation, u_max=values["u_max"])
        request = replace(request, saturation=limit)
    if "gamma" in values:
        request = replace(request, gamma=values["gamma"])
    if "cost" in values:
        cost = replace(request.cost, bound=values["cost"])
        request = replace(request, cost=cost)
    return request


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
    probe = _bounds(request, dict.fromkeys(objective, 1.0))
    phase, frame, blocks, unknowns, units = search(probe, tuple(objective))
    if phase.x is None:
        return None, phase, frame
    cost = np.zeros(blocks.variables)
    cost[-len(objective):] = [
        objective[name] * units[name] for name in objective]
    cost /= cost.max()
    best = _minimize(blocks, unknowns, cost, phase.x, gap, objective)
    squares = best[-len(objective):] * list(units.values())
    values = {
        name: float(
            square * request.noise_unit(frame) ** 2
            if name == "cost" else np.sqrt(square))
        for name, square in zip(objective, squares)
    }
    return values, best[:-len(objective)], frame


def _smallest_gamma(request, gap):
    found = optimum(request, {"gamma": 1.0}, gap)[0]
    return np.inf if found is None else found["gamma"]


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
        return Solution(request, x.verdict, request.gain)
    request = _bounds(request, {
        name: _rounded_up(value * (1 + backoff))
        for name, value in values.items()
    })
    expressions, unknowns = request.in_unknowns(frame, square(request.gamma))
    blocks = Blocks.of(expressions.values(), unknowns)
    return finish(request, frame, blocks, unknowns, x)


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
                weight * found[name] ** (1 if name == "cost" else 2)
                for name, weight in objective.items())
    if not tried:
        return trial, False
    best = min(tried, key=tried.get)
    return replace(request, slack=best), True


def _search_mu(request):
    """The request with the mu of the smallest gamma, and whether any."""
    if request.coupling == "slack" and request.slack is None:
        raise ValueError(
            'mu="free" and a free slack are two searches at once: give '
            "slack a number"
        )
    known = {}

    def bound(mu):
        if mu not in known:
            known[mu] = _smallest_gamma(replace(request, mu=mu), 1e-2)
        return known[mu]

    mu = 1.0
    while bound(mu) == np.inf:  # a large mu asks nothing of w
        mu *= 256
        if mu > 1e24:
            return request, False
    for ratio in (16.0, 4.0, 1.6, 1.2):
        for step in (ratio, 1 / ratio):
            while bound(_near(mu * step)) < 0.99 * bound(mu):
                mu = _near(mu * step)
    return replace(request, mu=mu), True


def _near(mu):
    return float(round_digits(mu, 2))
