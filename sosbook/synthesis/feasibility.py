"""From a request to its analytic centre, or to why there is none."""

from dataclasses import replace
from time import monotonic

import numpy as np

from ..exact.definite import round_digits
from ..runtime.time_limit import (
    LONGEST,
    OutOfTime,
    check_time,
    checked_seconds,
    time_limit,
)
from ..solver.loop import LONGEST_SOLUTION
from .centre import centred, finish, too_many
from .cutting import Cuts, few_decide, few_refuse
from .payments import NOT_PAID
from .scaled_lmis import ScaledLMIs
from .scaling import Frame
from .solution import Solution

FROM_STATES = 40  # a smaller plant has its centre in less than a second
ROUNDING_MARGIN = 1e-6  # a margin below minus that is no rounding error
CENTRE_SECONDS = 5.0  # for a centre, where an equation has answered already
ODD_MASS = (
    "M isn't positive definite, so that some motion has a negative kinetic energy: is "
    "a sign wrong, or are rows and columns in another order?"
)
NO_LEAST = "No equation gave a point inside the blocks: K is found by a search."
MODES_FIRST_ABOVE_STATES = 20  # from here on, looking for fixed modes first is cheap


def guarded(request, seconds, work):
    """The Solution that ``work`` returns, without arguments, for a ``request``;
    undecided where numbers or so many ``seconds`` give out.
    """
    seconds, begun = checked_seconds(seconds, needed=True), monotonic()
    try:
        with time_limit(seconds), np.errstate(all="ignore"):
            return _cause_named(work())
    except OutOfTime as over:
        if over.end < begun + seconds:  # somebody else's limit
            raise
        reason = over.words(seconds)
    except MemoryError as error:
        reason = f"The request is too large: {error}."
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        certain = without_lmis(request)  # exact, whatever floats say
        if certain is not None:
            return certain
        reason = f"The numerics gave up ({error}): are the units far apart?"
    return _cause_named(Solution(request, "undecided", request.gain, reason=reason))


def _cause_named(solution):
    """The Solution, its reason with a word about M where that may be the cause, or
    about the pole that breaks what is asked of a given gain in floats.
    """
    if not isinstance(solution, Solution):  # a map's trial, or none
        return solution
    if solution.status != "undecided":
        return solution
    from .reasons import pole_named
    from .starting_points import odd_mass

    request, known = solution.request, "In floats a " in solution.reason
    pole = "" if known or request.law is not None else pole_named(request)
    mass = ODD_MASS if odd_mass(request) else ""
    reason = " ".join(filter(None, [solution.reason, pole, mass]))
    return replace(solution, reason=reason)


def search(request, free=(), whole=False):
    """The LMISolution of any point of a ``request``, in up to four frames, its problem
    the `ScaledLMIs` where it was found, or where the refusal reaches furthest. Numbers
    stand in for the bounds of the ``free`` requirements; ``whole`` is as for `find`.
    """
    names = tuple(r.parameter.key for r in free)
    lmis, tried = ScaledLMIs(request, Frame.of(request, names), free), []
    for _ in range(4):
        check_time()
        first = find(lmis, whole=whole)
        if first.values is not None:
            return first
        tried.append(first)
        if first.excluded_radius > LONGEST_SOLUTION:
            break
        lmis = ScaledLMIs(request, closer(lmis, first.last_iterate), free)
    refusals = [t for t in tried if t.verdict == "infeasible"] or tried
    best = min(max(t.excluded_radius for t in refusals), LONGEST_SOLUTION)
    # beyond that, rounding errors decide which frame reaches further
    return next(t for t in refusals if t.excluded_radius >= best / 10)


def find(lmis, start=None, refuse=True, whole=False):
    """A point of ``lmis``, which are `ScaledLMIs`, or the lack of one, as an
    LMISolution. With many pairs of vertices most blocks are only looked at, and a few
    exclude what they exclude; ``whole`` takes all of them. ``start`` and ``refuse`` are
    as for `LMIProblem.find`; without a start the frame guesses.
    """
    request, first = lmis.request, None
    if few_refuse(request) and not whole:
        if not few_decide(request):
            first = lmis.find(False, start or lmis.guess())
        if first is None or (first.values is None and refuse):
            first = Cuts(lmis).find(start or lmis.guess(), refuse)
        known = first.values is not None or first.verdict == "infeasible"
        if known or too_many(request) or not refuse:
            return first
    return lmis.find(refuse, start or lmis.guess())


def closer(lmis, near):
    """A frame in which the P ``near``, where the search in ``lmis`` ended, is the
    identity: a solution of bad condition in the first frame may be plain there.
    """
    request, frame = lmis.request, lmis.frame
    P = sum(near[name] for name in request.lyapunov)
    sizes, directions = np.linalg.eigh(P)
    if sizes[-1] <= 0:  # no direction is better than another
        return frame
    top = sizes.max()
    sizes = np.sqrt(np.maximum(sizes / top, 1e-6))
    units = {}
    for name, unit in frame.sizes.items():
        size = np.clip(near[name].item() / top, 1e-6, 1e6)
        units[name] = float(round_digits(unit / np.sqrt(size), 2))
    return Frame.at(
        request, frame.T @ (directions * sizes), frame.scale, None, lmis.units, units
    )


def answer(request, refuse=True, first=None, prefer=None):
    """The Solution of a ``request`` that leaves nothing open. Without ``refuse`` it is
    undecided where floats find no point: what excludes every point isn't looked for.
    ``first`` is what `search` has found, if known, and ``prefer`` which gain, in
    `design_pid`'s words.
    """
    found = None
    if prefer == "least" or (first is None and request.order >= FROM_STATES):
        from .starting_points import point

        found = point(request)
    if found is None:
        solution = _searched(request, refuse, first)
        if prefer == "least" and solution.status == "feasible":
            return replace(solution, reason=f"{NO_LEAST} {solution.reason}".strip())
        return solution
    poles_alone = all(r.pole_matrices() is not None for r in request.requirements)
    alone = request.gain is not None or prefer == "least"
    if alone or (poles_alone and prefer is None):
        return found
    seconds = CENTRE_SECONDS if prefer is None else LONGEST
    try:
        centre = guarded(request, seconds, lambda: follow(request, found) or found)
    except OutOfTime:  # of the whole request, which has its answer
        return found
    return centre if centre.status == "feasible" else found


def _searched(request, refuse, first):
    """The Solution that a search finds, or a refusal; see `answer`."""
    # where the poles of a given gain seem to lie right, their exact places take long
    K, large = request.gain, request.order > MODES_FIRST_ABOVE_STATES
    placed = large and K is not None and request.kept_by(K, request.of_poles)
    if large and not placed:  # sooner known than phase one begins
        solution = _by_mode(request)
        if solution is not None:
            return solution
    first = first or search(request)
    if first.values is None:
        if not refuse:
            text = (
                "The numerics found no point; a proof that there is none isn't asked."
            )
            return Solution(request, "undecided", request.gain, reason=text)
        solution = refused(first)
        few = first.problem.pairs is not None
        if solution.status != "undecided" or not few or too_many(request):
            return solution
        first = search(request, whole=True)  # all pairs may exclude what few don't
        if first.values is None:
            return refused(first)
    try:
        solution = finish(first.problem, first.values)
    except OutOfTime:
        solution = first.problem.solution(first.values)
        text = "Stopped on the way to the centre: this is some point inside."
        return replace(solution, reason=text)
    if solution.status == "feasible":
        return solution
    mode = _by_mode(request)
    if mode is not None:
        return mode
    least = min(solution.margins, key=solution.margins.get)
    reason = (
        f"The numerics found a point whose margin, {solution.margins[least]:.1g} of "
        f"the block {str(least)!r}, is below what floats can tell from zero; exact "
        "arithmetic doesn't confirm it."
    )
    reason = reason if request.near is None else NOT_PAID
    if solution.margins[least] < -ROUNDING_MARGIN:  # no point at all
        return Solution(request, "undecided", request.gain, reason=reason)
    return replace(solution, reason=reason)


def refused(first):
    """The Solution of a request for which `search` found no point but ``first``:
    "infeasible" where a mode that no gain moves, or multipliers, exclude every point in
    exact arithmetic.
    """
    from .reasons import NO_COMMON_P, why_refused

    request, frame, Z = first.problem.request, first.problem.frame, first.multipliers
    if first.problem.pairs is not None:  # some blocks have none
        Z = None
    certain = without_lmis(request)
    if certain is not None:
        return replace(certain, frame=frame, multipliers=Z)
    refusal = Solution(request, "undecided", request.gain, frame=frame, multipliers=Z)
    proof = first.infeasibility
    if proof is not None:
        text = "Exact multipliers of the LMIs exclude every solution"
        text = f"{request.subject(text)}."
        if len(request.distinct) > 1 and len(request.lyapunov) == 1:
            text = f"{text} {NO_COMMON_P}"
        return replace(refusal, status="infeasible", reason=text, infeasibility=proof)
    return refused_by_input(request, refusal) or replace(
        refusal, reason=why_refused(first)
    )


def refused_by_input(request, refusal):
    """The Solution of a ``request`` whose input bound is provably too small, from an
    undecided one, ``refusal``; else None.
    """
    from .reasons import listed
    from .small_input import input_bound, refuse_by_input

    proof = refuse_by_input(request, search)
    if proof is None:
        return None
    modes, where = proof.modes, ""
    if len(request.vertices) > 1:
        where = f" of vertex {proof.place + 1}"
    bound = input_bound(request)
    text = (
        f"By these LMIs {bound.parameter.key} = {bound.bound:g} is too small to move "
        f"the modes{where} at {listed(modes)} rad/s from x0 to where they are asked: "
        "exact multipliers of their part of the plant exclude every solution."
    )
    return replace(refusal, status="infeasible", reason=text, infeasibility=proof)


def _by_mode(request):
    """The Solution of a ``request`` that some mode excludes, or None."""
    from .fixed_mode import refuse_by_mode

    mode = refuse_by_mode(request)
    return None if mode is None else refused_by(request, mode)


def without_lmis(request):
    """The refusal of a ``request`` by a mode, response or mass: a Solution or None."""
    from .at_once import refuse_at_once
    from .fixed_mode import refuse_by_mass
    from .unreached import refuse_by_response

    if request.law is not None:  # its gain isn't the state's
        return None
    mode = _by_mode(request)
    if mode is not None:
        return mode
    response = refuse_by_response(request)
    if response is not None:
        claim = response.claims[0]
        text = f"{claim[0].upper()}{claim[1:]}: no input reaches that response."
        return _infeasible(request, text, response)
    loud = refuse_at_once(request)
    if loud is not None:
        claim = loud.claims[0]
        text = f"{claim[0].upper()}{claim[1:]}: w is louder than that in y at once."
        return _infeasible(request, text, loud)
    mass = refuse_by_mass(request)
    if mass is None:
        return None
    i, j = (k + 1 for k in mass.vertices)
    text = f"Between the vertices {i} and {j} a plant has a singular mass matrix."
    return _infeasible(request, text, mass)


def _infeasible(request, text, proof):
    solution = Solution(request, "infeasible", request.gain, reason=text)
    return replace(solution, infeasibility=proof)


def refused_by(request, certificate):
    """The Solution of a request that a mode excludes, by a certificate."""
    mode = certificate.mode
    i, j = (k + 1 for k in certificate.place)
    where = (
        f" of vertex {i}" if i == j else f" halfway between the vertices {i} and {j}"
    )
    where = "" if len(request.vertices) == 1 else where
    whose = "This gain leaves" if request.plant.m else "This loop has"
    text = f"{whose} a pole{where} at {mode:.4g} rad/s"
    if request.gain is None:
        text = (
            f"No gain moves the mode{where} at {mode:.4g} rad/s: it is uncontrollable"
        )
    text = f"{text}, which violates {certificate.requirement}."
    return _infeasible(request, text, certificate)


def follow(request, start):
    """The Solution of a ``request`` near another one, ``start``, or None. What is
    infeasible or unbounded is left to the way that doesn't depend on the start, and so
    is a start whose gain was proven without a common P.
    """
    if start is None or start.status != "feasible" or start.frame is None:
        return None
    frame = Frame.at(request, start.frame.T, start.frame.scale)
    if start.frame.sizes.keys() == frame.sizes.keys():
        frame = replace(frame, sizes=start.frame.sizes)
    lmis = ScaledLMIs(request, frame)
    near = lmis.point(start)
    inside = None if near is None else find(lmis, near, refuse=False).values
    if inside is None:
        return None
    return centred(lmis, inside)
