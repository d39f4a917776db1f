"""From a request with a delay to a point inside its LMIs, or to a refusal."""

from dataclasses import replace
from functools import partial

import numpy as np

from ..requirements.lmi_region import LMIRegion
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, checked_seconds
from ..runtime.time_limit import time_limit as limited
from ..solver.deepest import ZERO_DEPTH
from ..synthesis.steps import Case, by_mode, seen_modes
from .design import DelayDesign
from .inner_points import alphas, deep_points, first_gain, problem_of
from .refusal import refusal_of
from .request import DelayedLoop


@one_thread
def solve_delay(request, refuse=True, time_limit=None, centred=True, progress=False):
    """The `DelayDesign` of a request with all its scalars.

    Parameters
    ----------
    request : DelayRequest
        What is asked of the plant.
    refuse : bool
        Look for an exact proof that there is no solution where none is found; that
        takes longer, and only with it the status can be "infeasible".
    time_limit : float, optional
        In seconds. Whatever isn't finished then is "undecided".
    centred : bool
        Without it any solution will do.
    progress : bool
        Show a bar of the seconds that have passed.

    Returns
    -------
    DelayDesign
        The analytic centre of a bounded part of the LMIs, for they are a cone.
    """
    work = partial(_solved, request, refuse, centred)
    return within(time_limit, request, work, progress)


def within(seconds, request, work, progress=False):
    """The result of ``work()`` for a ``request``, "undecided" after some ``seconds``.

    With ``progress`` a bar shows them.
    """
    seconds = checked_seconds(seconds)
    try:
        with limited(seconds, progress):
            return work()
    except OutOfTime as over:
        if seconds is None:  # somebody else's limit
            raise
        words = over.words(seconds).partition(":")[0]
        reason = words[0].lower() + words[1:]
        return DelayDesign(request, "undecided", request.gain, reason=reason)


def _solved(request, refuse, centred):
    """The `DelayDesign` of `solve_delay`, whatever time it takes."""
    if refuse and (unmoved := _unmoved(request)) is not None:
        return unmoved
    for problem, blocks, deep in deep_points(request):
        if deep.depth > 0:
            fields = first_gain(request, problem, blocks, deep.x, centred)
            if fields is not None:
                return DelayDesign(request, "feasible", **fields)
    refused = DelayDesign(request, "undecided", request.gain, reason=_reason(deep))
    if not refuse or deep.depth > 0 or deep.Z is None:
        return refused
    proof = refusal_of(request, deep.Z)
    if proof is None:
        return refused
    return replace(refused, status="infeasible", reason="", infeasibility=proof)


def _unmoved(request):
    """The refusal of a ``request`` by a mode slower than delta that floats see no input
    move: no delay, gain or alpha changes it. None without one.
    """
    if isinstance(request.plant, DelayedLoop) or request.misprints:
        return None
    rate = request.delta
    asked = [LMIRegion.half_plane(rate, name="the decay rate delta")] if rate else []
    plain = replace(request.free, requirements=asked)
    places = seen_modes(plain)
    found = by_mode(Case(plain), places) if places else None
    if found is None:
        return None
    how = dict(reason=found.reason, infeasibility=found.infeasibility)
    return DelayDesign(request, "infeasible", request.gain, **how)


def centred_design(design):
    """The centre of a request's LMIs from a feasible ``design``, or that one."""
    problem, blocks = problem_of(design.request)
    x = np.concatenate([u.pack(design.values[u.name]) for u in problem.unknowns])
    fields = first_gain(design.request, problem, blocks, x, True)
    return replace(design, **fields) if fields else design


def _reason(deep):
    """Why nothing is known, in words."""
    if deep.depth > 0:
        return (
            f"the LMIs hold by {deep.depth:.1g} of their size, which is too "
            "little to be proven"
        )
    if deep.gap < max(-deep.depth, 10 * ZERO_DEPTH):
        bound = 10.0 ** np.ceil(np.log10(max(deep.depth + deep.gap, 1e-12)))
        return (
            "no solution was found, and no exact proof that there is none: "
            f"in floats the LMIs can hold by {bound:.0e} of their size at most"
        )
    return "the search for a solution stopped before it was decided"


def first_design(request, refuse=True, time_limit=None, centred=True, progress=False):
    """`solve_delay` of a ``request``, with the first alpha that will do.

    A search of alpha can't exclude a solution. ``refuse``, ``time_limit``, ``centred``
    and ``progress`` as there. Returns the first that is feasible, or why there is none.
    """
    if request.alpha is not None or not request.needs_alpha:
        return solve_delay(request, refuse, time_limit, centred, progress)
    work = partial(_first_alpha, request, refuse, centred)
    return within(time_limit, request, work, progress)


def _first_alpha(request, refuse, centred):
    if refuse and (unmoved := _unmoved(request)) is not None:
        return unmoved
    for alpha in alphas(request):
        design = solve_delay(request.at(alpha=alpha), False, centred=centred)
        if design.status == "feasible":
            return design
    return without_alpha(request)


def without_alpha(request):
    """The "undecided" `DelayDesign` of a request for which no alpha was found."""
    reason = (
        "no solution was found for alpha = "
        + ", ".join(f"{alpha:g}" for alpha in alphas(request))
        + " s; other values of alpha aren't excluded"
    )
    return DelayDesign(request, "undecided", reason=reason)
