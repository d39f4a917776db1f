"""The scalar of the slack LMIs: its line search."""

from dataclasses import replace
from functools import partial

import numpy as np

from ..exact.checker.families import given_vertices
from ..exact.definite import round_digits
from ..runtime.time_limit import (
    LONGEST,
    OutOfTime,
    check_time,
    check_time_of_eigenvalues,
    time_left,
    time_limit,
)
from .feasibility import answer, follow, guarded, refused_alone, search, weights
from .objectives import WORTH, Unattained, at_optimum, optimum, value
from .scaled_lmis import ScaledLMIs
from .scaling import Frame
from .solution import Solution
from .steps import without_lmis

ADVICE = 60.0  # seconds for each requirement that is left out on trial

# epsilon in units of 1 / (typical rate), in the order of trial
STEPS = (1 / 4, 1 / 2, 1 / 8, 1, 1 / 16, 2, 1 / 64, 4, 1 / 256)

# by which the best of them is moved then, one after the other
FINER = (1.4, 1.2, 1.1)

LIGHT = 0.01  # of the heaviest multiplier; a vertex with less refuses little
FAR = 4.0  # times a rate; nearer ones share most of their steps

OWN_P = (
    "No one P for all plants was found in this form of the rows: each vertex has its "
    'own (coupling="slack"), for plants that don\'t change with time.'
)
LOWER = (
    "The bound is lower than with one P for all plants: each vertex has its own "
    '(coupling="slack"), for plants that don\'t change with time.'
)
NO_ONE_P = (
    "One P for all plants has no such LMIs where an acceleration of an uncertain mass "
    'is weighed: each vertex has its own (coupling="slack"), for plants that don\'t '
    "change with time."
)
NEITHER = (
    "Nothing was found with a P for each vertex, either. What is refused is these LMIs "
    "of the family, not every gain: analyse_pid may prove one that you have."
)
SHARE = 0.5  # of the time that is left, for a P for each vertex
LATE = (
    "A P for each vertex isn't decided within {:g} s, half of the time that was left: "
    "raise time_limit."
)

GAP = 1e-3  # relative accuracy of the optima that are compared
CLEARLY = 0.002  # a fraction by which another scalar has to be better


def with_slack(request, objective=None, refuse=False):
    """The ``request`` with a slack scalar where it needs one; None if none is found.
    With an ``objective``, as in `optimum`, a scalar is only tried to the end if some
    point has bounds clearly below the best ones so far. To ``refuse`` the others as
    well takes thrice as long, and may come upon a point where looking finds none.
    """
    if not request.coupling.open:
        return request
    if not objective:
        first = point_with_slack(request)
        return None if first is None else first.problem.request
    best = _Best(objective)
    try:
        for place, trial in enumerate(_trials(request)):
            if best.request is not None and place >= len(STEPS):
                break  # another rate, if one is needed
            best.look_at(trial, refuse)
        for ratio in FINER if best.request is not None else ():
            for step in (ratio, 1 / ratio):
                slack = best.request.coupling.slack * step
                best.look_at(request.with_slack(float(round_digits(slack, 3))))
    except OutOfTime:
        if best.request is None:
            raise
    return best.request


class _Best:
    """The best request so far, its bounds and their weighted sum."""

    def __init__(self, objective):
        self.objective = objective
        self.request = self.bounds = self.sum = None

    def look_at(self, trial, refuse=False):
        """Take a request, if some point has bounds clearly below the best ones.

        ``refuse`` is as for `find`.
        """
        check_time()
        if self.bounds is not None and not _lower(trial, self.bounds):
            return
        try:
            bounds = optimum(trial, self.objective, GAP, refuse)[0]
        except Unattained as missed:
            bounds = missed.bounds
        if bounds is None:
            return
        total = sum(
            weight * bounds[name] ** trial.owner(name).parameter.power
            for name, weight in self.objective.items()
        )
        if self.sum is None or total < self.sum:
            self.request, self.bounds, self.sum = trial, bounds, total


def point_with_slack(request, minimized=()):
    """A point of a ``request`` with the first slack scalar that leaves one, as `search`
    gives it; or None. The vertices that refuse one scalar mostly refuse the next one,
    so they are asked alone first: fewer blocks, and where they have no point all have
    none. No scalar helps where one of them is refused by itself.
    """
    few = ()
    for trial in _trials(request):
        for pairs in (few, None) if few else (None,):
            check_time()
            look = partial(search, trial, minimized, pairs=pairs)
            first = _looked_for(trial, look)
            if pairs and first is not None and first.verdict == "infeasible":
                break
        else:
            if first is not None and first.values is not None:
                return first
            few = _heaviest(first)
            if any(refused_alone(request, i) is not None for i, _ in few):
                return None
    return None


def _heaviest(first):
    """The pairs of vertices on which the multipliers of ``first`` weigh most."""
    if first is None or first.multipliers is None:
        return ()
    found = weights(first)
    least = LIGHT * max(found.values())
    return tuple(pair for pair, weight in found.items() if weight >= least)


def _looked_for(request, work):
    """The find of ``work`` for a ``request`` within `ADVICE` seconds; None if it gives
    up.
    """
    found = []

    def looking():
        found.append(work())
        return Solution(request, "undecided")

    guarded(request, ADVICE, looking)
    return found[0] if found else None


def _trials(request):
    from .fixed_mode import refuse_by_mode

    if refuse_by_mode(request) is not None:  # no scalar helps; this is sooner known
        return
    for rate in _rates(request):
        for step in STEPS:
            yield request.with_slack(float(round_digits(step / rate, 2)))


def _rates(request):
    """The rates whose times are tried: what is asked, and the plant's own if far away,
    for a structure that is hardly damped swings fast and settles slowly.
    """
    asked = request.typical_rate
    A, _, _ = request.mean.state_space()
    check_time_of_eigenvalues(len(A))
    own = np.abs(np.linalg.eigvals(A)).max()
    return [asked, own] if not asked / FAR < own < asked * FAR and own else [asked]


def _lower(request, bounds):
    """True if bounds clearly below these leave a point. Of several bounds one may rise
    while the others fall: those aren't pruned.
    """
    if len(bounds) > 1:
        return True
    ((name, value),) = bounds.items()
    easing = 1 if request.owner(name).parameter.harder < 0 else -1
    request = request.with_bounds({name: value * (1 - easing * CLEARLY)})
    lmis = ScaledLMIs(request, Frame.of(request))
    return lmis.find(refuse=False).values is not None


def designed(request, objective, backoff, start, prefer, vertices=True):
    """The Solution of a ``request`` with one of the couplings of a design;
    ``objective`` as in `optimum`, ``backoff``, ``start`` and ``prefer`` as in
    `design_pid`. Without ``vertices`` none of them refuses the request by itself.
    """
    settled, first = request, None
    if objective:
        settled = with_slack(request, objective)
        if settled is None:  # a vertex alone is sooner refused than every scalar
            refused = without_slack(request, objective, vertices)
            if refused.status == "infeasible":
                return refused
            settled = with_slack(request, objective, refuse=True)
    elif request.coupling.open:
        first = point_with_slack(request)
        settled = first and first.problem.request
    if settled is None:
        return without_slack(request, objective, vertices)
    if objective:
        return at_optimum(settled, objective, backoff)
    solution = follow(settled, start) or answer(settled, True, first, prefer)
    if solution.status == "undecided" and settled.coupling.own_P:
        return refused_at_a_vertex(settled) or solution
    return solution


def or_with_slack(first, request, objective, backoff, prefer):
    """The ``first`` Solution, with one P for all plants unless what is asked has no
    such LMIs, or one with a P for each vertex where it is none; ``request``,
    ``objective``, ``backoff`` and ``prefer`` are as for `designed`.
    """
    own = all(r.takes_slack for r in request.demands)
    if request.coupling.own_P:
        return replace(first, reason=f"{NO_ONE_P} {first.reason or ''}".strip())
    several = own and len(request.distinct) > 1 and not request.sizes.ties
    family = request.plant.family
    rivals = objective and family is not None and not family.straight
    if (first.status == "feasible" and not rivals) or not several:
        return first
    if _of_every_coupling(request, first.infeasibility):
        return first
    request, seconds = replace(request, coupling="slack"), SHARE * time_left()
    asked = request
    for name in objective:  # numbers stand in
        asked = asked.without(asked.owner(name))

    def work():
        if objective and refused_at_a_vertex(asked) is not None:
            return first
        return designed(request, objective, backoff, None, prefer, vertices=False)

    try:
        with time_limit(min(seconds, LONGEST)):
            second = guarded(request, LONGEST, work)
    except OutOfTime:  # what was found with one P stays
        late = LATE.format(float(round_digits(seconds, 2)))
        return replace(first, reason=f"{first.reason or ''} {late}".strip())
    if second is first:
        return first
    if second.status == "feasible" and value(second, objective) <= WORTH * value(
        first, objective
    ):
        text = LOWER if first.status == "feasible" else OWN_P
        return replace(second, reason=f"{text} {second.reason}".strip())
    if first.status == "feasible":
        return first
    return replace(first, reason=f"{first.reason} {NEITHER}".strip())


def _of_every_coupling(request, proof):
    """True if a refusal of a ``request`` is none of a common P: its own theorem's, or
    one plant's, whose multipliers weigh nothing else; see `refused_at_a_vertex`.
    """
    from ..exact.refusal import MultiplierRefusal

    if not isinstance(proof, MultiplierRefusal):
        return proof is not None
    if len(given_vertices(proof.data["plant"])) == 1:
        return True
    weighed = [name for name, Z in proof.multipliers.items() if Z.any()]
    own = {r.key for r in request.requirements if not r.of_package}
    return len({v for name in weighed for v in name.vertices}) == 1 and not own & {
        name.requirement for name in weighed
    }


def feasible(request, minimized=()):
    """True if phase one finds a solution of this very ``request``, the bounds of those
    that shall be ``minimized`` free.
    """
    find = point_with_slack if request.coupling.open else search
    first = _looked_for(request, lambda: find(request, minimized))
    return first is not None and first.values is not None


def without_slack(request, objective=(), vertices=True):
    """The Solution of a ``request`` for which no slack scalar was found; numbers stand
    in for what an ``objective`` was to minimise; ``vertices`` as in `designed`.
    """
    minimized = tuple(request.owner(name) for name in objective)
    for r in minimized:
        request = request.without(r)
    certain = refused_at_a_vertex(request) if vertices else None
    if certain is not None:
        return certain
    tried = ", ".join(f"{step:g}" for step in sorted(STEPS))
    text = (
        f"Nothing was found with the slack scalars that were tried: {tried} of the "
        "time constants of what is asked and of the plant."
    )
    solution = Solution(request, "undecided", request.gain, minimized=minimized)
    return replace(solution, reason=text)


def refused_at_a_vertex(request):
    """The Solution of a ``request`` that no slack scalar fulfils; None if unknown.

    Let the LMIs hold with P_i, V and Y = K V'. At vertex i, P = V' P_i^-1 V and Y = K P
    meet the LMIs without a slack matrix:

    - The blocks of the poles, the H-infinity norm and the decay of the cost
      are, after a congruence with V^-1, of the form Q + G N + N' G' with
      N [x; x'] = A x + B K x - E x'. Where N vanishes, the scalar and V are
      gone: what is left is the block without slack, with the Lyapunov
      matrix V^-1 P_i V'^-1, the inverse of that P.
    - V + V' - P_i <= V' P_i^-1 V, since (V - P_i)' P_i^-1 (V - P_i) >= 0: so the
      blocks "x0" and "cost", which hold it, hold with P as well.
    - By Schur's complement |K V' P_i^-1 V K'| < u_max^2.

    So a vertex whose own LMIs are refused refuses every scalar. (The other way round it
    isn't so: K is the same at all vertices.)
    """
    certain = without_lmis(request)
    if certain is not None:
        return certain
    alone = (refused_alone(request, k) for k in request.distinct)
    return next((found for found in alone if found is not None), None)
