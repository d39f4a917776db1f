"""A request in which any bound can be moved, and the ways to answer it."""

from copy import copy
from functools import cached_property, partial

from ...laws.taken import law_of
from ...lmi.solution import LMISolution
from ...plants.coupling import coupling_of
from ...requirements.shorthand import KEYWORDS, bounds, collected, contradictory, moved
from ...synthesis.centre import centred, finish
from ...synthesis.design import Design
from ...synthesis.feasibility import find, guarded, refused
from ...synthesis.pid import design_pid
from ...synthesis.request import Request
from ...synthesis.scaled_lmis import ScaledLMIs
from ...synthesis.scaling import Frame
from ...synthesis.search import USUAL
from ...synthesis.solution import Solution


class Ask:
    """A request in which any bound can be moved: ``plant``, ``U`` and keywords of
    `design_pid`: those that ask something, ``asked``, and ``options``.
    """

    def __init__(self, plant, U, asked, options):
        self.plant, self.options = plant, dict(options)
        self.law = law_of(U, self.options.pop("law", None))
        if self.law.whole:
            self.options.setdefault("coupling", "pairs")
        names = [name for name in options if name in KEYWORDS]
        asked = asked | {name: self.options.pop(name) for name in names}
        asked = {name: value for name, value in asked.items() if value is not None}
        self.requirements = collected(**asked)

    @property
    def known(self):
        """The bounds that are asked, by the parameters' names."""
        return bounds(self.requirements)

    def at(self, **values):
        """The same with other ``values`` of its parameters."""
        ask = copy(self)
        ask.requirements = moved(self.requirements, values)
        return ask

    def request(self):
        """The `Request` of it all."""
        fixed = {k: v for k, v in self.options.items() if k in ("K_A", "coupling")}
        if self.law.searched:
            fixed["coupling"] = "multipliers"
        return Request(
            self.plant, law=self.law, requirements=self.requirements, **fixed
        )

    @property
    def either(self):
        """True if a P for each vertex will do, where one for all isn't found."""
        return coupling_of(self.options.get("coupling", "pairs")).chooses

    def empty(self, values):
        """True if two requirements exclude each other at sight, at these ``values``."""
        return contradictory(moved(self.requirements, values))

    @cached_property
    def has_trials(self):
        """True if a trial saves something; not where it would be the whole work."""
        plain = not self.options.keys() - {"K_A", "coupling"}
        if self.law.searched or not plain:
            return False
        return coupling_of(self.options["coupling"]).one_P and not self.either

    def sharpens(self, near):
        """True if the coordinates of a design ``near`` are better than others."""
        return near is not None and near.P is not None and near.V is None

    def trial(self, near=None, /, **values):
        """The result of phase one for these ``values`` in the frame of a design or
        trial ``near``: an `LMISolution`, without multipliers; None where nothing can be
        said so soon. A bisection needs no more at most of its places.
        """
        if self.empty(values):
            return None
        request = self.at(**values).request()

        def work():
            lmis, start = _coordinates(request, near)
            return find(lmis, start, refuse=False)

        first = guarded(request, USUAL.time_limit, work)
        return first if isinstance(first, LMISolution) else None

    def finished(self, first, /, **values):
        """The result of `solve` at these ``values``, begun at a point of ``first``."""
        if seen(first) and first.problem.pairs is None:
            request = first.problem.request
            work = partial(centred, first.problem, first.values)
            solution = guarded(request, USUAL.time_limit, work)
            if solution is not None and solution.status == "feasible":
                return Design(**vars(solution))
        return self.solve(**values)

    def solve(self, near=None, /, **values):
        """A Design for these ``values``, or None where they exclude each other, in the
        coordinates in which the P of a design ``near`` is I: close to the edge they are
        the better ones. With ``coupling="auto"`` a refusal is one of both couplings: it
        holds at a vertex alone.
        """
        if self.empty(values):
            return None
        if self.sharpens(near):
            found = again(near.request.with_bounds(self.known | values), near)
            if not self.either or found.status == "feasible":
                return found

        def solved(**coupling):
            asked = moved(self.requirements, values)
            options = self.options | coupling
            return design_pid(self.plant, law=self.law, **options, requirements=asked)

        if not self.either:
            return solved()
        request = self.at(**values).request()
        first = solved(coupling=request.coupling)
        own = all(r.takes_slack for r in request.demands) and not request.sizes.ties
        if first.status == "feasible" or len(request.distinct) == 1 or not own:
            return first
        return solved(coupling="slack")


def again(request, near):
    """Solve a request in coordinates in which the P of a design ``near`` is I."""
    lmis, start = _coordinates(request, near)
    first = lmis.find(start=start)
    if first.values is None:
        return Design(**vars(refused(first)))
    return Design(**vars(finish(lmis, first.values)))


def seen(first):
    """True if a trial ``first``, or None, has found a point inside."""
    return first is not None and first.values is not None


def point(first):
    """The point inside that a trial ``first`` has found, as a Design."""
    return Design(**vars(first.problem.solution(first.values)))


def _coordinates(request, near):
    """The `ScaledLMIs` of a request near a design, or a trial's point, and where to
    start in them; the request's own with None.
    """
    if near is None:
        return ScaledLMIs(request, Frame.of(request)), None
    if isinstance(near, LMISolution):
        natural = near.problem.in_plant_units(near.values)
        near = Solution(near.problem.request, "feasible", **natural)
    lmis = ScaledLMIs(request, Frame.of_solution(request, near))
    return lmis, lmis.point(near)
