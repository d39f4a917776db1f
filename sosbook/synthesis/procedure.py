"""From the keywords of the design functions to a request, and to who solves it."""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..exact.definite import round_digits
from ..laws.taken import law_of
from ..plants.checks import is_word
from ..plants.coupling import coupling_of
from ..plants.descriptor_system import OF_TICKS
from ..requirements.pole_region import LMIRegion
from ..requirements.shorthand import asked_once, collected, moved
from ..requirements.vocabulary import SIGMA
from ..runtime.later import later
from ..runtime.time_limit import LONGEST, OutOfTime, check_time_of_eigenvalues
from .design import Design
from .feasibility import answer, guarded
from .objectives import objective_of
from .request import Request
from .scaled_lmis import ScaledLMIs
from .scaling import Frame
from .search import Search
from .slack import designed, or_with_slack, with_slack


def design_asked(
    plant, U, *, K_A, law, coupling, minimize, search,
    gain=None, maximize=None, **asked,
):  # fmt: skip
    """The Design of what `design_pid` and `analyse_pid` are asked; ``plant``, ``U``,
    ``K_A``, ``law``, ``coupling``, ``minimize``, ``search`` and ``maximize`` are as
    there, ``asked`` are requirements by keyword, and ``gain``, (m, N), is known.
    """
    law = law_of(U, law)
    if law.searched:
        search.taking("backoff starts seed time_limit", "the search of a law's gain")
        coupling = _of_a_law(coupling)
    elif maximize is not None:
        raise ValueError("maximize is given without law: give region=PoleRegion(sigma)")
    else:
        search.taking("backoff start prefer time_limit", "a design without a law")
    asked = law.demands(plant, asked_once(**given(**asked)))
    objective = objective_of(minimize, asked)
    if law.searched:
        objective, asked = _one_objective(objective, maximize, asked)
        for r in (r for r in asked if r.tied):
            raise ValueError(
                f"{r.tied} is given, but a law's loop is proven without: leave it out"
            )
    if objective:  # numbers stand in
        asked = moved(asked, dict.fromkeys(objective, 1.0))
    coupling = coupling_of(coupling)
    auto = coupling.chooses
    request = Request(
        plant, K_A=K_A, coupling=coupling, gain=gain, law=law, requirements=asked,
    )  # fmt: skip
    if request.step is not None and search.prefer == "least":
        raise ValueError(OF_TICKS.format('prefer="least"'))
    if request.step is not None and maximize is not None:
        raise ValueError(
            'maximize="sigma" is for plants of continuous time: of one with dt ask '
            "for region=LMIRegion.disk(rho) with smaller and smaller rho"
        )
    if search.start is not None:
        search = replace(search, start=_checked_start(search.start, request, auto))
    task = Task(request, gain, objective, auto, search)
    solution = guarded(request, search.time_limit, task.solution)
    shown = solution.status == "feasible" or solution.searched is not None
    if law.searched and gain is None and not shown:
        solution = replace(solution, K=None)
    return Design(**vars(solution))


@dataclass(frozen=True)
class Task:
    """The checked question of `design_pid` and `analyse_pid`: the ``request``, the
    ``gain`` that is known, the ``objective`` as in `optimum`, whether the coupling may
    be chosen, ``auto``; and how to ``search``.
    """

    request: Request
    gain: Any
    objective: dict
    auto: bool
    search: Search

    def solution(self):
        """The Solution: of a law, a minimum, given gains, or the centre."""
        request, objective, known = self.request, self.objective, self.gain is not None
        if request.law.searched and not known:
            by_law = later("synthesis.structured.design", "by_law")
            return by_law(request, objective, self.search)
        if request.law.searched:
            return self._of_given(request)
        free = request.coupling.free
        if objective:
            common = replace(request, coupling="pairs") if free else request
            idle = without_input(common, objective)
            if idle is not None:
                return idle
        if free:
            return self._of_given(request)
        if self.auto and known and _have_multipliers(request):
            one_P = not objective and all(
                r.fits_one_P(request) for r in request.demands
            )
            each = replace(request, coupling="multipliers")
            return self._of_given(each, request if one_P else None)
        if request.plant.family is None:
            found = self._searched(request)
        else:
            in_pieces = later("synthesis.families", "in_pieces")
            found = in_pieces(request, objective, self._searched)
        simple = self.auto and not known and not objective
        if simple and found.status == "undecided" and _have_multipliers(request):
            found = _or_simple(found, request)
        return found

    def _of_given(self, request, first=None):
        from .known_gain import kept_or_broken

        return kept_or_broken(
            request, self.objective, self.search.backoff, first, enough=True
        )

    def _searched(self, request):
        how, search = (self.objective, self.search.backoff), self.search
        found = designed(request, *how, search.start, search.prefer)
        settled = request.coupling.own_P and not self.request.coupling.own_P  # a cut's
        if self.auto and self.gain is None and not settled:
            return or_with_slack(found, request, *how, search.prefer)
        return found


def _of_a_law(coupling):
    """The coupling of a loop with a law, or a ValueError for what it hasn't."""
    wanted = coupling_of(coupling)
    if wanted.slack is not None or not (wanted.chooses or wanted.free):
        raise ValueError(
            f"coupling={coupling!r}: a law's loop is proven by multipliers; leave it "
            "out"
        )
    return "multipliers"


def _one_objective(objective, maximize, asked):
    """The objective, and the requirements with a number in its place."""
    if maximize is None:
        if len(objective) > 1:
            raise ValueError("minimize: with a law one bound at a time")
        return objective, asked
    key = SIGMA.key
    if not is_word(maximize, (key,)):
        raise ValueError(f'maximize must be None or "{key}", got {maximize!r}')
    if objective:
        raise ValueError("minimize and maximize are given: leave one out")
    if any(r.parameter is SIGMA for r in asked):
        raise ValueError(f'give {key} or maximize="{key}", not both')
    fastest = LMIRegion.half_plane(1.0)
    return {key: 1.0}, collected(requirements=[*asked, fastest])


def _have_multipliers(request):
    """True if a known gain is asked of several vertices in a way that has such LMIs: a
    number for mu is about a common P.
    """
    takes = all(r.takes_multipliers for r in request.demands)
    return len(request.distinct) > 1 and takes and not request.sizes.ties


def given(**asked):
    """Those of the keywords that aren't None, ``asked`` by name."""
    return {name: value for name, value in asked.items() if value is not None}


def _checked_start(start, request, auto):
    """The start; None where "auto" has taken another coupling for it."""
    own = start.request.coupling.own_P, request.coupling.own_P
    if own == (True, False) and auto:
        return None
    sizes = [(r.order, r.plant.m, len(r.vertices)) for r in (start.request, request)]
    if sizes[0] != sizes[1] or own[0] != own[1]:
        raise ValueError(
            "start has other sizes, vertices or coupling than this "
            "request: leave it out"
        )
    return start


NEAR_ZERO = 1e-6  # of the unit in which a bound is sought


def without_input(request, objective):
    """The Solution of a ``request`` with K = 0, or its given gain, whose minimised
    bounds (the names in ``objective``) are zero; else None. A bound is positive, so
    what the request says then is a millionth of the unit in which it would be sought:
    any other number will do as well.
    """
    from .bracket import rounded_up

    K = request.gain
    if K is None:
        K = np.zeros((request.plant.m, request.order))
    free = tuple(request.owner(name) for name in objective)
    if not _meets(request, K, free):
        return None
    lmis = ScaledLMIs(request, Frame.of(request, tuple(objective)), free)
    bounds = {
        r.parameter.key: rounded_up(
            NEAR_ZERO * r.parameter.bound(lmis.units[r.parameter.key] or 1.0)
        )
        for r in free
    }
    given = with_slack(replace(request.with_bounds(bounds), gain=K))
    solution = given and answer(given, refuse=False)
    if solution is None or solution.status != "feasible":
        return None
    names = " and ".join(bounds)
    text = f"The least {names} is zero, any positive number will do"
    if request.gain is None:
        text = f"K = 0 keeps everything that is asked: {text[0].lower()}{text[1:]}"
    asked = replace(solution.request, gain=request.gain)
    return replace(solution, request=asked, reason=f"{text}.")


def _meets(request, K, free):
    """True if the true values are zero where they are free, and good elsewhere."""
    loops = request.vertices
    for d in loops:
        check_time_of_eigenvalues(len(d.E))
        poles = np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ K))
        if not poles.real.max() < 0:
            return False
    if any(r.truth(loops, K, request.K_A) != 0 for r in free):
        return False
    return request.kept_by(K, [r for r in request.demands if r not in free])


DIGITS = 6  # of the mean plant's gain
BY_ITSELF = (
    "No search found a gain, but {} keeps what is asked: each requirement is proven by "
    "itself, with multipliers."
)


def _or_simple(first, request):
    """The undecided ``first`` Solution of a ``request`` of several plants, or that of a
    simple gain, each requirement proven with multipliers.
    """
    from .known_gain import kept_or_broken

    try:
        for words, K in _gains(request):
            known = replace(request, gain=K, coupling="multipliers")
            if known.kept_by(K, known.demands):
                work = partial(kept_or_broken, known, enough=True)
                found = guarded(known, LONGEST, work)
                if found.status == "feasible":
                    return replace(found, central=False, reason=BY_ITSELF.format(words))
    except OutOfTime:  # what is known stays
        pass
    return first


def _gains(request):
    """(What it is, the gain) of each simple gain; the mean plant's takes a search."""
    yield "K = 0", np.zeros((request.plant.m, request.order))
    mean = getattr(request.plant, "mean", None)
    if hasattr(mean, "vertices"):
        middle = replace(request, plant=mean, coupling="pairs")
        found = guarded(middle, LONGEST, lambda: answer(middle, refuse=False))
        if found.status == "feasible":
            yield "the gain of the mean plant", round_digits(found.K, DIGITS)
