"""A request in which any bound can be moved, and the ways to answer it."""

from functools import cached_property, partial

from ...lmi.solution import LMISolution
from ...requirements.shorthand import KEYWORDS, bounds, collected, contradictory, moved
from ...synthesis.centre import centred, finish
from ...synthesis.design import Design
from ...synthesis.feasibility import find, guarded, refused
from ...synthesis.pid import TIME_LIMIT, design_pid
from ...synthesis.request import Request
from ...synthesis.scaled_lmis import ScaledLMIs
from ...synthesis.scaling import Frame
from ...synthesis.solution import Solution

__all__ = ["Ask", "again", "point", "seen"]


class Ask:
    """A request in which any bound can be moved.

    Parameters
    ----------
    plant, U
        As in `design_pid`.
    asked : dict
        Keywords of `design_pid` that ask something.
    options : dict
        Its other keywords; those that ask something are found here too.
    """

    def __init__(self, plant, U, asked, options):
        if options.get("law") is not None:
            raise ValueError(
                "law: a gain of a law is searched and has no edge; give U, or ask for "
                "single designs by sosbook.maps.designs"
            )
        self.plant, self.U, self.options = plant, U, dict(options)
        asked = asked | {
            name: self.options.pop(name)
            for name in options
            if name in KEYWORDS and name != "mu"
        }
        if not isinstance(options.get("mu"), str):  # for what joins later too
            asked["mu"] = options.get("mu")
        self.requirements = collected(
            **{name: value for name, value in asked.items() if value is not None}
        )

    @property
    def known(self):
        """What is asked, by the parameters' names."""
        return bounds(self.requirements)

    def at(self, **values):
        """The same with other ``values`` of its parameters."""
        ask = object.__new__(Ask)
        ask.__dict__.update(
            self.__dict__, requirements=moved(self.requirements, values)
        )
        return ask

    def request(self):
        """The `Request` of it all."""
        fixed = {k: v for k, v in self.options.items() if k in ("K_A", "coupling")}
        return Request(self.plant, self.U, requirements=self.requirements, **fixed)

    def empty(self, values):
        """Whether two requirements exclude each other at sight, at these ``values``."""
        return contradictory(moved(self.requirements, values))

    @cached_property
    def has_trials(self):
        """Whether a trial saves something; not with a slack matrix."""
        plain = not self.options.keys() - {"K_A", "coupling", "mu"}
        return plain and self.options.get("coupling") != "slack"

    def trial(self, near=None, /, **values):
        """What phase one finds for these ``values`` in one frame: an `LMISolution`.

        A bisection needs no more at most of its places: no multipliers are looked
        for. The frame is that of a design or trial ``near`` if there is one. None
        where nothing can be said so soon.
        """
        if self.empty(values):
            return None
        request = self.at(**values).request()

        def work():
            lmis, start = _coordinates(request, near)
            return find(lmis, start, refuse=False)

        first = guarded(request, TIME_LIMIT, work)
        return first if isinstance(first, LMISolution) else None

    def finished(self, first, /, **values):
        """What `solve` returns for these ``values``.

        It is there sooner where ``first``, a trial of them, has found a point.
        """
        if seen(first) and first.problem.pairs is None:
            request = first.problem.request
            work = partial(centred, first.problem, first.values)
            solution = guarded(request, TIME_LIMIT, work)
            if solution is not None and solution.status == "feasible":
                return Design(**vars(solution))
        return self.solve(**values)

    def solve(self, near=None, /, **values):
        """A Design for these ``values``, or None where they exclude each other.

        With a design ``near``, in coordinates in which its P is I: close
        to the edge they are the better ones.
        """
        if self.empty(values):
            return None
        if near is not None and self.options.get("coupling") != "slack":
            return again(near.request.with_bounds(self.known | values), near)
        return design_pid(
            self.plant,
            self.U,
            **{"coupling": "pairs"} | self.options,
            requirements=moved(self.requirements, values),
        )


def again(request, near):
    """Solve a request in coordinates in which the P of a design ``near`` is I."""
    lmis, start = _coordinates(request, near)
    first = lmis.find(start=start)
    if first.values is None:
        return Design(**vars(refused(first)))
    return Design(**vars(finish(lmis, first.values)))


def seen(first):
    """Whether a trial ``first``, or None, has found a point inside."""
    return first is not None and first.values is not None


def point(first):
    """The point inside that a trial ``first`` has found, as a Design."""
    return Design(**vars(first.problem.solution(first.values)))


def _coordinates(request, near):
    """The `ScaledLMIs` of a request near a design, and where to start in them.

    Near a point that a trial has found, too; the request's own with None.
    """
    if near is None:
        return ScaledLMIs(request, Frame.of(request)), None
    if isinstance(near, LMISolution):
        natural = near.problem.in_plant_units(near.values)
        near = Solution(near.problem.request, "feasible", **natural)
    lmis = ScaledLMIs(request, Frame.of_solution(request, near))
    return lmis, lmis.point(near)
