"""What a request leaves open: objectives and line searches."""

from dataclasses import replace

import numpy as np

from ..lmi.bounded import bounded, unpacked
from ..lmi.centre import Unbounded, minimize, phase_one
from ..lmi.exact import round_digits
from ..lmi.time_limit import OutOfTime, check_time
from .cutting import MANY, Cuts
from .exclusion import excluding_mode
from .feasibility import (
    Solution,
    answer,
    finish,
    follow,
    guarded,
    refused_by,
    search,
    solution_at,
    written,
)
from .scaling import Frame, led, typical_rate

__all__ = [
    "feasible",
    "optimum",
    "solve",
    "with_slack",
    "without_optimum",
    "without_slack",
]

ADVICE = 60.0  # seconds for each requirement that is left out on trial

# epsilon in units of 1 / (typical rate), in the order of trial
SLACK_STEPS = (1 / 4, 1 / 2, 1 / 8, 1, 1 / 16, 2, 1 / 64, 4, 1 / 256)

SLACK_GAP = 1e-3  # relative accuracy of the optima that are compared
CLEARLY = 0.002  # a fraction by which another scalar has to be better

NO_MINIMUM = (
    "minimize: {} has no minimum: the bound goes to zero or is reached by "
    "infinite gains only; limit them with saturation or a disk (rho)"
)


def solve(request, objective=None, backoff=0.01, start=None):
    """Solve a request; search what it leaves open.

    Parameters
    ----------
    request : Request
        With ``coupling="slack"`` and no ``slack`` the scalar is searched.
    objective : dict, optional
        Weights by the names of parameters: the weighted sum of their
        levels (see `Parameter`) is minimised. Numbers stand in for them
        in the request.
    backoff : float
        What is added to the optimal bounds, as a fraction.
    start : Solution, optional
        Of a request of the same shape: where to start from.

    Returns
    -------
    Solution
        The optimum, the centre, or why there is none.
    """
    request, found = with_slack(request, objective)
    if not found:
        return without_slack(request)
    if objective:
        return _at_optimum(request, objective, backoff)
    return follow(request, start) or answer(request)


def with_slack(request, objective=None):
    """The request with a slack scalar where it needs one, and success.

    The scalar is searched for the ``objective``, if there is one.
    """
    if request.coupling == "slack" and request.slack is None:
        return _search_slack(request, objective)
    return request, True


def without_slack(request):
    """The Solution of a request for which no slack scalar was found."""
    mode = excluding_mode(request)
    if mode is not None:
        return refused_by(request, mode)
    tried = ", ".join(f"{step:g}" for step in sorted(SLACK_STEPS))
    return Solution(
        request,
        "undecided",
        request.gain,
        reason="Nothing was found with the slack scalars that were tried: "
        f"{tried} of the time constant.",
    )


def feasible(request):
    """Whether phase one finds a solution of this very request."""

    def work():
        if request.coupling == "slack" and request.slack is None:
            found = _search_slack(request, None)[1]
        else:
            found = search(request)[0].x is not None
        return Solution(request, "feasible" if found else "undecided")

    return guarded(request, ADVICE, work).status == "feasible"


def optimum(request, objective, gap):
    """The optimal bounds (None without any), their point, the frame.

    Without any, phase one's outcome instead of the point.

    Parameters
    ----------
    request : Request
        What is asked of the plant.
    objective : dict
        As in `solve`.
    gap : float
        Relative accuracy of the weighted sum.

    Returns
    -------
    values : dict or None
        From a parameter's name to its bound.
    x : array or Phase
        Of the unknowns of the request with ``levels`` the objective's.
    frame : Frame
        The coordinates.

    Notes
    -----
    A level times an unknown size isn't affine. The requirement whose
    level is minimised therefore leads (`Request.leader`): its P is the
    unknown P, and one semidefinite program finds the optimum and the
    sizes of the others. With two levels or more it finds whether there
    is anything at all; then the sizes are searched, one by one.
    """
    probe = request.with_bounds(dict.fromkeys(objective, 1.0))
    free = tuple(_owner(probe, name) for name in objective)
    phase, frame, blocks, unknowns, units = search(probe, free)
    if phase.x is None:
        return None, phase, frame
    cost = np.zeros(blocks.variables)
    cost[-len(objective) :] = [objective[name] * units[name] for name in objective]
    cost /= cost.max()
    leader = probe.leader(objective)
    searched = [r for r in probe.followers(leader) if r in free]
    try:
        if searched:
            return _with_sizes(probe, free, searched, frame, phase.x, cost, gap)
        best = _cut_minimum(request, blocks, unknowns, cost, phase.x, gap, objective)
    except OutOfTime:
        x = _at_own_levels(probe, free, searched, phase.x)
        raise Unfinished(free, units, x, frame, unknowns) from None
    return _bounds(free, best, units), best[: -len(objective)], frame


def _bounds(free, x, units):
    levels = x[-len(free) :] * list(units.values())
    return {r.parameter.key: r.parameter.bound(level) for r, level in zip(free, levels)}


def _at_own_levels(request, free, searched, x):
    """A point whose last entries are levels, not levels times sizes."""
    unknowns = request.unknowns(tuple(r.parameter.key for r in free))
    values = unpacked(unknowns, x[: -len(free)])
    levels = [
        level / values[r.size_name].item() if r in searched else level
        for r, level in zip(free, x[-len(free) :])
    ]
    return np.concatenate([x[: -len(free)], levels])


def _with_sizes(request, free, searched, frame, x, cost, gap):
    """`optimum` where the sizes of some requirements are searched.

    Each is moved in shrinking steps until that helps no more.
    """
    names = tuple(r.parameter.key for r in free)
    here = unpacked(request.unknowns(names), x[: -len(free)])
    known = {}

    def best(sizes):
        key = tuple(sizes.items())
        if key not in known:
            known[key] = _at_sizes(request, free, sizes, frame, cost, gap)
        return known[key]

    sizes = {r.size_name: float(here[r.size_name].item()) for r in searched}
    for ratio in (16.0, 4.0, 1.6, 1.2, 1.05):
        for name in sizes:
            for step in (ratio, 1 / ratio):
                while True:
                    moved = sizes | {name: float(round_digits(sizes[name] * step, 6))}
                    if not best(moved)[0] < best(sizes)[0]:
                        break
                    sizes = moved
    value, x, units = best(sizes)
    if not np.isfinite(value):  # only the point that phase one found
        raise ValueError(NO_MINIMUM.format(" and ".join(names)))
    return _bounds(free, x, units), _joined(request, names, sizes, x, len(free)), frame


def _at_sizes(request, free, sizes, frame, cost, gap):
    """The least weighted sum of levels for given sizes, its point, the units."""
    blocks, unknowns, units = written(request, frame, free, sizes)
    phase = phase_one(blocks, multipliers=False)
    if phase.x is None:
        return np.inf, None, units
    cost = np.append(np.zeros(blocks.variables - len(free)), cost[-len(free) :])
    try:
        x = _cut_minimum(request, blocks, unknowns, cost, phase.x, gap, units)
    except ValueError:
        return np.inf, None, units
    return cost @ x, x, units


def _joined(request, names, sizes, x, levels):
    """The unknowns with the sizes in their places.

    An own unknown of a requirement is multiplied by its size there.
    """
    every = request.unknowns(names)
    some = [u for u in every if u.name not in sizes]
    values = unpacked(some, x[:-levels])
    values |= {name: np.array([[s]]) for name, s in sizes.items()}
    for r in request.demands:
        for u in r.unknowns(request):
            values[u.name] = values[u.name] * sizes.get(r.size_name, 1.0)
    return np.concatenate([u.pack(values[u.name]) for u in every])


class Unfinished(OutOfTime):
    """Raised where time ends before a minimum is found; holds a point.

    Parameters
    ----------
    free : tuple of Requirement
        Those whose bounds were minimised.
    units : dict
        Of their levels.
    x : array
        A point inside; its last entries are the levels.
    frame, unknowns
        As in `search`.
    """

    def __init__(self, free, units, x, frame, unknowns):
        super().__init__("the time limit is over")
        levels = x[-len(units) :] * list(units.values())
        self.values = {
            r.parameter.key: _rounded_up(r.parameter.bound(level))
            for r, level in zip(free, levels)
        }
        self.point = x[: -len(units)], frame, unknowns

    def solution(self, request):
        """What is known: a design that keeps larger bounds."""
        x, frame, unknowns = self.point
        found = solution_at(request.with_bounds(self.values), frame, unknowns, x)
        names = " and ".join(self.values)
        return replace(
            found,
            status="undecided",
            reason=f"Stopped before the least {names} was found: this design "
            "keeps a larger one. Raise time_limit.",
        )


def _owner(request, name):
    """The requirement that a parameter belongs to."""
    return next(
        r
        for r in request.requirements
        if r.parameter is not None and r.parameter.key == name
    )


def _cut_minimum(request, blocks, unknowns, cost, x, gap, objective):
    """`_minimize`, with some of the blocks where there are many pairs."""

    def work(some, x):
        return _minimize(some, unknowns, cost, x, gap, objective)

    if len(request.pairs) <= MANY:
        return work(blocks, x)
    return Cuts(blocks, blocks.names).solve(x, work)


def _minimize(blocks, unknowns, cost, x, gap, objective):
    """The minimum, if need be with bounded unknowns."""
    try:
        return minimize(blocks, cost, x, gap)[0]
    except Unbounded:  # perhaps in a direction that costs nothing
        limits = 1e5, 1e7
    try:
        near, far = (
            minimize(joined, cost, inside, gap)[0]
            for joined, inside in (bounded(blocks, unknowns, x, r) for r in limits)
        )
    except Unbounded:
        far = None
    if far is None or cost @ far < 0.99 * (cost @ near):
        raise ValueError(NO_MINIMUM.format(" and ".join(objective)))
    return near


def _at_optimum(request, objective, backoff):
    try:
        values, x, frame = optimum(request, objective, 1e-5)
    except Unfinished as stopped:
        return stopped.solution(request)
    if values is None:
        return without_optimum(request, objective)
    names = tuple(objective)
    request = request.with_bounds(
        {name: _rounded_up(value * (1 + backoff)) for name, value in values.items()}
    )
    frame, x = led(request, frame, names, x)
    blocks, unknowns, _ = written(request, frame)
    return finish(request, frame, blocks, unknowns, x)


def without_optimum(request, objective):
    """The Solution of a request where no point has any bounds at all.

    "infeasible" where what is asked beside the objective is.
    """
    for name in objective:
        request = request.without(_owner(request, name))
    found = answer(request)
    if found.status != "feasible":
        return found
    names = " and ".join(objective)
    return Solution(
        request,
        "undecided",
        request.gain,
        reason=f"No point was found from where {names} could be minimised.",
    )


def _rounded_up(value):
    """To three significant digits."""
    digits = 2 - int(np.floor(np.log10(value)))
    return float(np.round(np.ceil(value * 10.0**digits) / 10.0**digits, max(digits, 0)))


def _search_slack(request, objective):
    """The request with a slack scalar, and whether one was found.

    With an objective a scalar is only tried to the end if some point
    has bounds clearly below the best ones so far.
    """
    unit = 1 / typical_rate(request)
    best = least = None
    for step in SLACK_STEPS:
        check_time()
        slack = float(round_digits(unit * step, 2))
        trial = replace(request, slack=slack)
        if not objective:
            if feasible(trial):
                return trial, True
            continue
        if best is not None and not _lower(trial, best):
            continue
        try:
            found = optimum(trial, objective, SLACK_GAP)[0]
        except OutOfTime:
            if best is None:
                raise
            break
        if found is None:
            continue
        value = sum(
            weight * found[name] ** _owner(request, name).parameter.power
            for name, weight in objective.items()
        )
        if least is None or value < least:
            best, least, request = found, value, trial
    return (trial, False) if best is None else (request, True)


def _lower(request, values):
    """Whether bounds that are all clearly below these leave a point.

    Of several bounds one may rise while the others fall: those aren't
    pruned.
    """
    if len(values) > 1:
        return True
    ((name, value),) = values.items()
    easing = 1 if _owner(request, name).parameter.harder < 0 else -1
    request = request.with_bounds({name: value * (1 - easing * CLEARLY)})
    blocks, _, _ = written(request, Frame.of(request))
    return phase_one(blocks, multipliers=False).x is not None
