"""The scalar of the slack LMIs: its line search, and what is known without one."""

from dataclasses import replace

from ..lmi.exact import round_digits
from ..lmi.time_limit import OutOfTime, check_time
from .exclusion import excluding_mode
from .feasibility import guarded, refused_by, search
from .objectives import optimum
from .scaled_lmis import ScaledLMIs
from .scaling import Frame, typical_rate
from .solution import Solution

__all__ = ["feasible", "with_slack", "without_slack"]

ADVICE = 60.0  # seconds for each requirement that is left out on trial

# epsilon in units of 1 / (typical rate), in the order of trial
STEPS = (1 / 4, 1 / 2, 1 / 8, 1, 1 / 16, 2, 1 / 64, 4, 1 / 256)

GAP = 1e-3  # relative accuracy of the optima that are compared
CLEARLY = 0.002  # a fraction by which another scalar has to be better


def with_slack(request, objective=None):
    """The request with a slack scalar where it needs one; None if none is found.

    Parameters
    ----------
    request : Request
        What is asked of the plant.
    objective : dict, optional
        As in `optimum`. Then a scalar is only tried to the end if some
        point has bounds clearly below the best ones so far.
    """
    if request.coupling != "slack" or request.slack is not None:
        return request
    best = least = chosen = None
    for trial in _trials(request):
        check_time()
        if not objective:
            if feasible(trial):
                return trial
            continue
        if best is not None and not _lower(trial, best):
            continue
        try:
            bounds = optimum(trial, objective, GAP)[0]
        except OutOfTime:
            if best is None:
                raise
            break
        if bounds is None:
            continue
        value = sum(
            weight * bounds[name] ** request.owner(name).parameter.power
            for name, weight in objective.items()
        )
        if least is None or value < least:
            best, least, chosen = bounds, value, trial
    return chosen


def _trials(request):
    unit = 1 / typical_rate(request)
    for step in STEPS:
        yield replace(request, slack=float(round_digits(unit * step, 2)))


def _lower(request, bounds):
    """Whether bounds that are all clearly below these leave a point.

    Of several bounds one may rise while the others fall: those aren't
    pruned.
    """
    if len(bounds) > 1:
        return True
    ((name, value),) = bounds.items()
    easing = 1 if request.owner(name).parameter.harder < 0 else -1
    request = request.with_bounds({name: value * (1 - easing * CLEARLY)})
    lmis = ScaledLMIs(request, Frame.of(request))
    return lmis.find(refute=False).values is not None


def feasible(request):
    """Whether phase one finds a solution of this very request."""

    def work():
        trial = with_slack(request)
        found = trial is not None and (
            trial is not request or search(request).values is not None
        )
        return Solution(request, "feasible" if found else "undecided")

    return guarded(request, ADVICE, work).status == "feasible"


def without_slack(request):
    """The Solution of a request for which no slack scalar was found."""
    mode = excluding_mode(request)
    if mode is not None:
        return refused_by(request, mode)
    tried = ", ".join(f"{step:g}" for step in sorted(STEPS))
    return Solution(
        request,
        "undecided",
        request.gain,
        reason="Nothing was found with the slack scalars that were tried: "
        f"{tried} of the time constant.",
    )
