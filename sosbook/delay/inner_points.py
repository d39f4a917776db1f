"""Points inside the LMIs of a request with a delay, and their gains."""

import numpy as np

from ..exact.definite import round_digits
from ..lmi.problem import LMIProblem
from ..lmi.text import LMIText
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, check_time
from ..solver.bounded import bounded, unpacked
from ..solver.deepest import deepest
from ..solver.loop import Unbounded, centre
from .proofs import prove_delay

# alpha in units of tau, in the order of trial
ALPHA_RATIOS = (2.0, 1.0, 4.0, 0.5, 8.0, 0.25, 16.0)

# how accurately the depth is known where any solution will do
ROUGHLY = 100.0

# of the unknowns where the centre is looked for: inside their bound, which is 16, and
# near it, for the many blocks of a cone push the centre there
START_SIZE = 14.0

OF_BOUND = (
    "Every multiple of a solution is one, so that none is their analytic centre: K is "
    "the centre of those below a bound, whichever it is."
)
OF_SOME = "K is that of some solution, not of a centre."


def problem_of(request):
    """The `LMIProblem` of a ``request``, and its blocks."""
    problem = LMIProblem(LMIText(request.blocks, request.unknowns()))
    return problem, problem.compiled


def deep_points(request):
    """The problem of a ``request``, its blocks and a `Deepest`, twice if it may be."""
    problem, blocks = problem_of(request)
    check_time()
    for accuracy in (ROUGHLY, 1.0):
        deep = deepest(blocks, accuracy)
        yield problem, blocks, deep
        if deep.depth <= 0:
            return


@one_thread
def solvable(request):
    """True if a point is found inside the LMIs of a request, for some alpha."""
    return any(
        deep.depth > 0
        and first_gain(request.at(alpha=alpha), problem, blocks, deep.x, False)
        for alpha in alphas(request)
        for problem, blocks, deep in deep_points(request.at(alpha=alpha))
    )


def first_gain(request, problem, blocks, x, centred):
    """Fields of a `DelayDesign` for a point inside the LMIs of a ``request``, or None.

    ``problem``, ``blocks``: of `problem_of`; x is inside, as floats see it;
    ``centred``: begin with the centre, else any point will do.
    """
    fields = (
        _at(request, problem, *candidate)
        for candidate in _candidates(blocks, problem.unknowns, x, centred)
    )
    return next((known for known in fields if known is not None), None)


def _candidates(blocks, unknowns, x, centred):
    """The centre of a bounded part, then the deepest point; and which of them it is."""
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
    """Fields of the design at a point, ``which`` in words; None if it isn't inside."""
    values = unpacked(problem.unknowns, x)
    margins = problem.text.margins(values)
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
    if min(margins.values()) > 1e-9 or prove_delay(request, K, values, 17).proven:
        return dict(K=K, values=values, margins=margins, **said)
    return None


def alphas(request):
    """The alphas that a search tries for a request, in this order."""
    if request.alpha is not None or not request.needs_alpha:
        return [request.alpha]
    return [float(round_digits(request.tau * ratio, 2)) for ratio in ALPHA_RATIOS]
