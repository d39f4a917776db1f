"""A requirement of an author's own as text, which anybody's checker reads."""

import re

from ..exact.rational import decimal
from ..language.traced import Traced
from ..language.trees import scaled_constants


class TracedLoop:
    """A `PosedLoop` of symbols, for one ``requirement`` of a ``request``. What it knows
    is what an author's blocks may speak of: P, Y, V, the requirement's numbers and
    unknowns, whose names begin with ``own``, and a vertex or a pair.
    """

    def __init__(self, requirement, request, own):
        """Make the symbols of P, Y, V, the vertex and the own unknowns."""
        d, N, m = request.vertices[0], request.order, request.plant.m
        self.request, slack = request, request.coupling.own_P
        self.called = lambda name: own + re.sub(r"\W", "_", name, flags=re.ASCII)
        self.own = {
            u.name: Traced.matrix(self.called(u.name), *u.shape, symmetric=u.symmetric)
            for u in requirement.unknowns(request)
        }
        self.epsilon = Traced.number("epsilon") if slack else None
        square = {"Theta": 0, "EPE": 1, "EP": 0, "EVE": 0, "V": 0}
        for name, symmetric in square.items():
            setattr(self, name, Traced.matrix(name, N, symmetric=bool(symmetric)))
        self.P = Traced.matrix("P.i" if slack else "P", N, symmetric=True)
        self.Y, self.EY = Traced.matrix("Y", m, N), Traced.matrix("EY", N, m)
        self.unknowns = {*square, self.P.text, "Y", "EY"}  # own ones aren't P / s
        self.EV, self.Bw = self.EP, Traced.matrix("W", N, d.Bw.shape[1])
        self.EPC = self.EP @ Traced.matrix("C", len(d.C), N).T
        if d.Du is not None:
            self.EPC = self.EPC + self.EY @ Traced.matrix("D", len(d.C), m).T
        self.EVC, self.EVA, self.Dw = self.EPC, 0, 0

    def level(self, requirement):
        """The bound of the requirement, to its power."""
        parameter = requirement.parameter
        return Traced.number(self.called(parameter.key)) ** parameter.power

    def number(self, x):
        """Numbers, as a text holds them."""
        return Traced.of(x)

    scalar = state = row = number

    def near(self, P):
        """P itself."""
        return P


def theorem_data(requirement, request, place, sized=False):
    """The blocks of an author's ``requirement`` as text, and what a file says of it;
    None if it can't be traced. It is the one with the number ``place``, from one, in a
    ``request``; if it is ``sized``, its blocks are those of P / s, times the unknown s.
    Returns "numbers" by name, in decimals, "unknowns" by name, with what the file calls
    them and their shapes, and "blocks": (where, name, text) each, where a text may
    speak of the names that the text of a design defines.
    """
    own = f"own.{place}."
    loop, size = TracedLoop(requirement, request, own), Traced.number(own + "size")
    try:
        once = list(requirement.once(loop))
        pair = list(request.coupling.asked(requirement, loop, loop, 0))
        parts = [("once", name, g) for name, _, g in once]
        blocks = []
        for where, name, g in [*parts, *(("pair", *b) for b in pair)]:
            g = Traced.of(g)
            tree = (
                scaled_constants(g.tree, size.tree, loop.unknowns) if sized else g.tree
            )
            blocks.append([where, name, Traced(tree).text])
            if g.definitions or any(vertices for _, vertices, _ in once):
                return None  # a text of an author's is one matrix, and of all vertices
    except (TypeError, ValueError, AttributeError, LookupError, RecursionError):
        return None
    unknowns = {}
    for u in requirement.unknowns(request):
        even, (rows, cols) = u.symmetric, u.shape
        shape = f"symmetric {rows}" if even else f"{rows} x {cols}"
        unknowns[loop.called(u.name)] = [u.name, shape]
    numbers = {}
    if requirement.parameter is not None:
        numbers[loop.called(requirement.parameter.key)] = decimal(requirement.bound)
    return {"numbers": numbers, "unknowns": unknowns, "blocks": blocks}
