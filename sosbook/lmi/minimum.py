"""The least trace of an expression in the unknowns of some LMIs."""

import numpy as np

from ..language.expression import Affine
from ..solver.bounded import bounded, unpacked
from ..solver.loop import Unbounded, minimize
from .text import LMIText

FARTHEST_MINIMUM = 1e16  # largest unknown's size that may be a unit
FARTHEST_START = 1e6  # largest variable from which a minimisation starts


class Minimum:
    """The search of the least trace of an ``expression`` over the blocks of a
    ``problem``, to the relative accuracy ``gap``.
    """

    def __init__(self, problem, expression, gap):
        self.problem, self.gap = problem, gap
        self.slope = gradient(expression, problem.text)
        self.constant = float(np.trace(expression.constant))

    def near(self, x, free):
        """(A point, a lower bound of the trace), from a point x inside; if ``free`` the
        search may begin elsewhere. Raises Unbounded if none is found.
        """
        problem = self.problem
        if free and np.abs(x).max() > FARTHEST_START:  # a cone: begin near zero
            x = bounded(problem.compiled, problem.unknowns, x)[1]
        try:
            x, bound = minimize(problem.compiled, self.slope, x, self.gap)
        except Unbounded as missed:
            x, bound = self._in_units(missed)
        return x, bound + self.constant

    def _in_units(self, missed):
        """The minimum with each unknown in a unit of its size where a search ``missed``
        it; Unbounded names the largest one if there is none.
        """
        if missed.x is None:
            raise missed
        text, unknowns = self.problem.text, self.problem.unknowns
        sizes = {
            name: 2.0 ** np.round(np.log2(np.abs(value).max() or 1.0))
            for name, value in unpacked(unknowns, missed.x).items()
        }

        def write(values, number):
            units = {n: number(np.array(s)).item() for n, s in sizes.items()}
            return text.blocks({n: x * units[n] for n, x in values.items()}, number)

        each = np.concatenate([np.full(u.size, sizes[u.name]) for u in unknowns])
        try:
            if each.max() > FARTHEST_MINIMUM:
                raise missed
            blocks = LMIText(write, unknowns).compiled()
            x, bound = minimize(blocks, self.slope * each, missed.x / each, self.gap)
            if self.slope @ missed.x < bound:  # rounding errors, far away
                raise missed
        except Unbounded:
            name = max(sizes, key=sizes.get)
            raise Unbounded(
                f"{missed}; the search ended where {name} has entries of the size "
                f"{sizes[name]:.1e}",
                missed.x,
            ) from None
        return x * each, bound


def gradient(expression, text):
    """Derivatives of an ``expression``'s trace by the free entries of the unknowns of a
    ``text``, an `LMIText`. Raises ValueError if it isn't a square expression in them.
    """
    if not isinstance(expression, Affine) or len(set(expression.shape)) > 1:
        raise ValueError(
            "minimize takes a square expression in the unknowns, as minimize(J), whose "
            f"trace it makes small; got {expression!r}"
        )
    text.held(expression)
    weights = {u: np.zeros(u.shape) for u in text.unknowns}
    for t in expression.terms:
        weight = np.asarray(t.right @ t.left, float)
        weights[t.unknown] += weight if t.transposed else weight.T
    return np.concatenate([u.gradient(w) for u, w in weights.items()])
