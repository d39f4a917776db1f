"""From a request to its analytic centre, or to why there is none."""

from collections import Counter
from dataclasses import replace
from functools import partial
from time import monotonic

import numpy as np

from ..exact.definite import exact, round_digits
from ..plants.as_data import vertex_place
from ..plants.descriptor import twins
from ..plants.descriptor_system import DescriptorSystem
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
from .scaled_lmis import ScaledLMIs
from .scaling import Frame
from .solution import Solution
from .steps import (
    AT_FIRST_SIGHT,
    MODE,
    WITHOUT_LMIS,
    Case,
    Step,
    by_mode,
    by_multipliers,
    taken,
    without_lmis,
)

FROM_STATES = 40  # a smaller plant has its centre in less than a second
CENTRE_SECONDS = 5.0  # for a centre, where an equation has answered already
ODD_MASS = (
    "M isn't positive definite, so that some motion has a negative kinetic energy: is "
    "a sign wrong, or are rows and columns in another order?"
)
STOPPED = "Stopped on the way to the centre: this is some point inside."
NO_LEAST = "No equation gave a point inside the blocks: K is found by a search."


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
    pole = "" if known or not request.law.whole else pole_named(request)
    mass = ODD_MASS if odd_mass(request) else ""
    reason = " ".join(filter(None, [solution.reason, pole, mass]))
    return replace(solution, reason=reason)


def search(request, free=(), whole=False, pairs=None, refuse=True):
    """The LMISolution of any point of a ``request``, in up to four frames, its problem
    the `ScaledLMIs` where it was found, or where the refusal reaches furthest. Numbers
    stand in for the bounds of the ``free`` requirements; ``whole`` and ``refuse`` are
    as for `find`, and the other vertices than those of ``pairs`` are left out, if these
    are given.
    """
    names = tuple(r.parameter.key for r in free)
    frame, tried = Frame.of(request, names), []
    for _ in range(4):
        check_time()
        lmis = ScaledLMIs(request, frame, free, pairs=pairs)
        first = find(lmis, refuse=refuse, whole=whole)
        if first.values is not None:
            return first
        tried.append(first)
        if first.excluded_radius > LONGEST_SOLUTION:
            break
        frame = closer(lmis, first.last_iterate)
    refusals = [t for t in tried if t.verdict == "infeasible"] or tried
    best = min(max(t.excluded_radius for t in refusals), LONGEST_SOLUTION)
    # beyond that, rounding errors decide which frame reaches further
    return next(t for t in refusals if t.excluded_radius >= best / 10)


def find(lmis, start=None, refuse=True, whole=False):
    """A point of `ScaledLMIs`, ``lmis``, or the lack of one, as an LMISolution. Of many
    pairs a few decide, unless ``whole``, or a bound is free and each vertex has its P.
    ``start``, else the frame's guess, and ``refuse`` are as for `LMIProblem.find`.
    """
    request, first = lmis.request, None
    own = bool(lmis.free) and request.coupling.own_P
    if lmis.pairs is None and few_refuse(request) and not whole and not own:
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
    """The Solution of a ``request`` that leaves nothing open, by the first of the
    `STEPS` that has one. Without ``refuse`` it is undecided where floats find no point:
    what excludes every point isn't looked for. ``first`` is what `search` has found, if
    known, and ``prefer`` which gain, in `design_pid`'s words.
    """
    return taken(STEPS, Case(request, refuse, first, prefer))


def refused(first):
    """The Solution of a request for which `search` found no point but ``first``, by the
    `REFUSALS`: "infeasible" with an exact proof, or undecided.
    """
    return taken(REFUSALS, Case(first.problem.request, first=first))


def _by_equation(case):
    """The gain of an equation, or the centre where there is time for it."""
    from .moved_part import is_of_parts, point_of_part
    from .starting_points import point

    request, prefer = case.request, case.prefer
    found = point(request)
    if found is None and request.order >= FROM_STATES:
        found = point_of_part(request, partial(answer, refuse=False))
    if found is None or found.status != "feasible":
        case.part = found
        return None
    alone = request.gain is not None or prefer == "least"
    if alone or (prefer is None and is_of_parts(request)):
        return found
    seconds = CENTRE_SECONDS if prefer is None else LONGEST
    try:
        centre = guarded(request, seconds, lambda: follow(request, found) or found)
    except OutOfTime:  # of the whole request, which has its answer
        return found
    return centre if centre.status == "feasible" else found


def _by_part(case):
    return case.left(case.part.reason)  # what the part lacks, the whole does


def _by_search(case):
    case.first = search(case.request)


def refused_alone(request, k):
    """The Solution of a ``request`` that multipliers of the vertex ``k`` by itself
    refuse: whatever the plants share, P or a scalar, no gain keeps it there. None if
    unknown.
    """
    check_time()
    asked = tuple(r for r in request.requirements if r.of_package)
    plant = request.plant
    if isinstance(plant, DescriptorSystem):
        plant = plant.having([plant.vertices[k]])
    else:
        plant = plant.vertices[k]
    one = replace(request, plant=plant, requirements=asked, coupling="pairs")
    both = one.vertices[0].map(exact), request.vertices[k].map(exact)
    if len(set(twins(both))) > 1:  # a vertex of thirds is no plant of a file
        return None
    case = Case(one, first=search(one))
    if case.inside:
        return None
    found = by_multipliers(case) or (_by_input(case) if _of_input(case) else None)
    if found is None:
        return None
    so = ", and so for every slack scalar" if request.coupling.own_P else ""
    text = f"At {vertex_place(request.plant, k)} alone{so}: {found.reason}"
    return replace(found, request=request, frame=None, multipliers=None, reason=text)


def weights(first):
    """How much the multipliers of ``first`` weigh on each pair of vertices."""
    found = Counter()
    for name, Z in zip(first.problem.text.expressions, first.multipliers):
        if name.vertices:
            found[name.vertices[0], name.vertices[-1]] += np.trace(Z)
    return found


def _by_a_vertex(case):
    """Refuse a ``case`` by the vertex on which its search's multipliers weigh most."""
    alone = {i: x for (i, j), x in weights(case.first).items() if i == j}
    if not alone:  # of a few pairs of two plants each
        return None
    found = refused_alone(case.request, max(alone, key=alone.get))
    return found and case.left(found.reason, "infeasible", found.infeasibility)


def _of_a_vertex(case):
    if not case.excluded or case.first.multipliers is None:
        return False
    request = case.request
    sought = request.gain is None and request.law.whole
    if not sought or case.first.problem.free:  # numbers stand in for bounds
        return False
    common = not request.coupling.own_P and not request.sizes.ties
    return common and len(request.distinct) > 1


def _by_all_pairs(case):
    case.first, case.whole = search(case.request, whole=True), True


def _by_centre(case):
    """The analytic centre from the point that the search found."""
    lmis, values = case.first.problem, case.first.values
    try:
        found = finish(lmis, values)
    except OutOfTime:
        found = replace(lmis.solution(values), central=False, reason=STOPPED)
        if found.status != "feasible":
            return found
    if found.status != "feasible":
        case.poor = found
        return None
    least = NO_LEAST if case.prefer == "least" else ""
    return replace(found, reason=f"{least} {found.reason}".strip())


def _by_input(case):
    """Refuse a ``case`` whose input bound is too small for its slow modes."""
    from .reasons import listed
    from .small_input import input_bound, refuse_by_input

    request, proof = case.request, refuse_by_input(case.request, search)
    if proof is None:
        return None
    of = vertex_place(request.plant, proof.place)
    where = f" of {of}" if of else ""
    bound = input_bound(request)
    text = (
        f"By these LMIs {bound.parameter.key} = {bound.bound:g} is too small to move "
        f"the modes{where} at {listed(proof.modes)} rad/s from x0 to where they are "
        "asked: exact multipliers of their part of the plant exclude every solution."
    )
    return case.left(text, "infeasible", proof)


def _excluded(case):
    return case.excluded


def _of_input(case):
    if not case.excluded:
        return False
    from .small_input import input_bound

    return input_bound(case.request) is not None


#: What excludes every gain where `search` found no point, in this order.
REFUSALS = (
    *WITHOUT_LMIS,
    Step(
        "multipliers of a vertex",
        "a search for it alone, made exact; of several vertices",
        _of_a_vertex,
        _by_a_vertex,
    ),
    Step("multipliers", "the search's, made exact", _excluded, by_multipliers),
    Step("an input that is too small", "a search for slow modes", _of_input, _by_input),
)

#: What is tried for an answer, in this order; the first Solution is it.
STEPS = (
    Step(
        "an equation",
        "Riccati equations; of large plants, or for the least gain",
        lambda c: (
            c.prefer == "least" or (c.first is None and c.request.order >= FROM_STATES)
        ),
        _by_equation,
    ),
    Step(MODE, "exact poles; of large plants", lambda c: c.large, by_mode),
    Step(
        "an input that is too small",
        "a search for slow modes; of large plants",
        lambda c: c.first is None and c.request.order >= FROM_STATES and _of_input(c),
        _by_input,
    ),
    Step(
        "the modes that must move",
        "nothing; where they have no point, a search among all takes minutes",
        lambda c: c.part is not None,
        _by_part,
    ),
    *AT_FIRST_SIGHT,
    Step(
        "a search",
        "phase one in up to four frames",
        lambda c: c.first is None,
        _by_search,
    ),
    *REFUSALS,
    Step(
        "a search with all pairs",
        "phase one with every block; where few pairs left it open",
        lambda c: (
            c.excluded and c.first.problem.pairs is not None and not too_many(c.request)
        ),
        _by_all_pairs,
    ),
    Step(
        "multipliers of all pairs",
        "the search's, made exact",
        lambda c: c.excluded and c.whole,
        by_multipliers,
    ),
    Step("the centre", "Newton's steps", lambda c: c.inside, _by_centre),
    Step(MODE, "exact poles; at the edge", lambda c: c.poor is not None, by_mode),
)


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
