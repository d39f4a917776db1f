"""From a request with a delay to a point inside its LMIs, or to a refusal."""

from dataclasses import replace
from functools import partial

import numpy as np

from ..exact.definite import round_digits
from ..lmi.trusted import TrustedProblem
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, check_time, checked_seconds
from ..runtime.time_limit import time_limit as limited
from ..solver.bounded import bounded, unpacked
from ..solver.centre import Unbounded, centre
from ..solver.deepest import ZERO_DEPTH, deepest
from .certificates import prove_delay
from .design import DelayDesign
from .refutation import refuted

__all__ = [
    "ALPHA_RATIOS",
    "alphas",
    "centred_design",
    "first_design",
    "solve_delay",
    "without_alpha",
]

# alpha in units of tau, in the order of trial
ALPHA_RATIOS = (2.0, 1.0, 4.0, 0.5, 8.0, 0.25, 16.0)

# how accurately the depth is known where any solution will do
ROUGHLY = 100.0

# of the unknowns where the centre is looked for: inside the lid, which is 16, and
# near it, for the many blocks of a cone push the centre there
START_SIZE = 14.0

OF_BOUND = (
    "Every multiple of a solution is one, so that none is their analytic centre: K is "
    "the centre of those below a bound, whichever it is."
)
OF_SOME = "K is that of some solution, not of a centre."


@one_thread
def solve_delay(request, refuse=True, time_limit=None, centred=True, progress=False):
    """The `DelayDesign` of a request with all its scalars.

    Parameters
    ----------
    request : DelayRequest
        What is asked of the plant.
    refuse : bool
        Look for an exact proof that there is no solution where none is
        found; that takes longer, and only with it the status can be
        "infeasible".
    time_limit : float, optional
        In seconds. Whatever isn't finished then is "undecided".
    centred : bool
        Without it any solution will do.
    progress : bool
        Show a bar of the seconds that have passed.

    Returns
    -------
    DelayDesign
        The analytic centre of the LMIs under a lid, for they are a cone.
    """
    work = partial(_solved, request, refuse, centred)
    return within(time_limit, request, work, progress)


def within(seconds, request, work, progress=False):
    """What ``work()`` returns for a request, "undecided" after some ``seconds``.

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
    problem, blocks = _problem(request)
    check_time()
    for accuracy in (ROUGHLY, 1.0):
        deep = deepest(blocks, accuracy)
        if deep.depth <= 0:
            break
        design = _best(request, problem, blocks, deep.x, centred)
        if design is not None:
            return design
    refused = DelayDesign(request, "undecided", request.gain, reason=_reason(deep))
    if not refuse or deep.depth > 0 or deep.Z is None:
        return refused
    proof = refuted(request, deep.Z)
    if proof is None:
        return refused
    return replace(refused, status="infeasible", reason="", infeasibility=proof)


def _problem(request):
    problem = TrustedProblem(request.blocks, request.unknowns())
    return problem, problem.compiled


def centred_design(design):
    """The centre of a request's LMIs, from a `DelayDesign` of any point inside.

    Parameters
    ----------
    design : DelayDesign
        A feasible one, of `solve_delay` with ``centred=False``.

    Returns
    -------
    DelayDesign
        The same as `solve_delay` finds; the given one where it finds none.
    """
    problem, blocks = _problem(design.request)
    x = np.concatenate([u.pack(design.values[u.name]) for u in problem.unknowns])
    return _best(design.request, problem, blocks, x, True) or design


def _best(request, problem, blocks, x, centred):
    """The first design of the `_candidates`, or None."""
    designs = (
        _at(request, problem, *candidate)
        for candidate in _candidates(blocks, problem.unknowns, x, centred)
    )
    return next((design for design in designs if design is not None), None)


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


def _candidates(blocks, unknowns, x, centred):
    """The centre under a lid, then the deepest point; and which of them it is."""
    if centred:
        try:
            yield centre(*bounded(blocks, unknowns, x, size=START_SIZE)), OF_BOUND
        except (Unbounded, np.linalg.LinAlgError):
            yield deepest(blocks, accuracy=1e-6).x, OF_SOME
            return
        except OutOfTime:  # a point is known: better than none
            pass
    size = max(
        np.linalg.norm(np.atleast_2d(v), 2) for v in unpacked(unknowns, x).values()
    )
    yield x * (START_SIZE / size), OF_SOME  # for the LMIs are a cone


def _at(request, problem, x, which):
    """The design at a point, or None where its blocks aren't positive.

    ``which`` of the points it is, in words.
    """
    values = unpacked(problem.unknowns, x)
    margins = problem.margins(values)
    if min(margins.values()) <= 0:
        return None
    K, frame, said = request.gain, request.frame, {}
    if K is None:
        said = {"central": False, "reason": which}
        try:
            K = np.linalg.solve(values["F"], values["X"].T).T
        except np.linalg.LinAlgError:
            return None
        K = frame.scale * np.linalg.solve(frame.T.T, K.T).T
    design = DelayDesign(request, "feasible", K, values, margins, **said)
    if min(margins.values()) > 1e-9 or prove_delay(design, 17).proven:
        return design
    return None


def first_design(request, refuse=True, time_limit=None, centred=True, progress=False):
    """`solve_delay`, with the first alpha of a search if none is given.

    Parameters
    ----------
    request : DelayRequest
        What is asked of the plant.
    refuse, time_limit, centred, progress
        As in `solve_delay`. A search of alpha can't exclude a solution.

    Returns
    -------
    DelayDesign
        The first that is feasible, or one that says why there is none.
    """
    if request.alpha is not None or not request.needs_alpha:
        return solve_delay(request, refuse, time_limit, centred, progress)
    work = partial(_first_alpha, request, centred)
    return within(time_limit, request, work, progress)


def _first_alpha(request, centred):
    for alpha in alphas(request):
        design = solve_delay(request.at(alpha=alpha), False, centred=centred)
        if design.status == "feasible":
            return design
    return without_alpha(request)


def alphas(request):
    """The alphas that a search tries for a request, in this order."""
    if request.alpha is not None or not request.needs_alpha:
        return [request.alpha]
    return [float(round_digits(request.tau * ratio, 2)) for ratio in ALPHA_RATIOS]


def without_alpha(request):
    """The "undecided" `DelayDesign` of a request for which no alpha was found."""
    reason = (
        "no solution was found for alpha = "
        + ", ".join(f"{alpha:g}" for alpha in alphas(request))
        + " s; other values of alpha aren't excluded"
    )
    return DelayDesign(request, "undecided", reason=reason)
