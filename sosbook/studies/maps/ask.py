"""A request in which any bound can be moved, and the ways to answer it."""

from ...requirements.shorthand import KEYWORDS, bounds, collected, contradictory, moved
from ...synthesis.design import Design
from ...synthesis.feasibility import answer, find, finish, guarded, refused
from ...synthesis.pid import TIME_LIMIT, design_pid
from ...synthesis.pole_proof import of_poles_alone
from ...synthesis.problem import Request
from ...synthesis.scaled_lmis import ScaledLMIs
from ...synthesis.scaling import Frame
from ...synthesis.solution import Solution

__all__ = ["Ask", "again"]


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

    @property
    def has_glimpses(self):
        """Whether a glimpse saves something: not with a slack matrix."""
        slack = self.options.get("coupling") == "slack"
        return not (slack or self.options.keys() - {"K_A", "coupling", "mu"})

    def glimpse(self, near=None, closely=False, /, **values):
        """A Design for these ``values``, or None where none is seen.

        A bisection needs no more at most of its places: no refusal is proven, and
        the design is some point inside. It is looked for in one frame only, that
        of a design ``near`` if there is one. Where it looks ``closely`` it tries
        several, and the design is the centre.
        """
        if self.empty(values):
            return None
        request = self.at(**values).request()

        def work():
            if closely or of_poles_alone(request):
                return answer(request, refuse=False)
            lmis, start = _coordinates(request, near)
            first = find(lmis, start, refute=False)
            if first.values is None:
                return Solution(request, "undecided", request.gain)
            return lmis.solution(first.values)

        design = Design(**vars(guarded(request, TIME_LIMIT, work)))
        return design if design.status == "feasible" else None

    def solve(self, near=None, start=None, /, **values):
        """A Design for these ``values``, or None where they exclude each other.

        With a design ``near``, in coordinates in which its P is I: close
        to the edge they are the better ones. ``start`` is as in `design_pid`.
        """
        if self.empty(values):
            return None
        if near is not None and self.options.get("coupling") != "slack":
            return again(near.request.with_bounds(self.known | values), near)
        return design_pid(
            self.plant,
            self.U,
            **({} if start is None else {"start": start}),
            **self.options,
            requirements=moved(self.requirements, values),
        )


def again(request, near):
    """Solve a request in coordinates in which the P of a design ``near`` is I."""
    lmis, start = _coordinates(request, near)
    first = lmis.find(start=start)
    if first.values is None:
        return Design(**vars(refused(first)))
    return Design(**vars(finish(lmis, first.values)))


def _coordinates(request, near):
    """The `ScaledLMIs` of a request near a design, and where to start in them.

    The request's own without a design ``near``.
    """
    if near is None:
        return ScaledLMIs(request, Frame.of(request)), None
    lmis = ScaledLMIs(request, Frame.of_solution(request, near))
    return lmis, lmis.point(near)
