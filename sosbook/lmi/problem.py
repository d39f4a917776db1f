"""LMIs as such: write blocks, get a point, a proof or a refusal."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .centre import Blocks, Unbounded, centre, margin, minimize, phase_one
from .exact import exact, round_digits
from .expression import block, eye
from .proof import Proof, refute

__all__ = ["LMIProblem", "LMISolution", "any_centre", "bounded", "unpacked"]

FAR = 1e6  # variables beyond it are a bad start of a minimisation


class LMIProblem:
    """Blocks, affine in some unknowns, that shall be positive definite.

    Parameters
    ----------
    write : callable
        ``write(values, number)``: the blocks by name, for the unknowns'
        values by name. These are unknowns, floats, rationals or cvxpy
        variables; ``number`` brings other matrices into that arithmetic.
    unknowns : sequence of Unknown

    Examples
    --------
    >>> from sosbook.lmi import Unknown, he
    >>> A = np.array([[0.0, 1.0], [-2.0, -3.0]])
    >>> def lyapunov(values, number):
    ...     P = values["P"]
    ...     return {"P": P, "decay": -he(number(A) @ P)}
    >>> problem = LMIProblem(lyapunov, [Unknown("P", 2, symmetric=True)])
    >>> found = problem.solve()
    >>> found.status, found.prove().proven
    ('feasible', True)
    >>> A = -A
    >>> problem.solve().infeasibility.proven
    True
    """

    def __init__(self, write, unknowns):
        self.write, self.unknowns = write, list(unknowns)

    def blocks(self, values, number=lambda x: x):
        """The blocks by name, for values of the unknowns by name."""
        return self.write(values, number)

    def in_unknowns(self, number=lambda x: x):
        """The blocks by name, as `Affine` expressions."""
        return self.blocks({u.name: u for u in self.unknowns}, number)

    def margins(self, values):
        """The smallest eigenvalue of each block, its diagonal scaled to one."""
        return {name: margin(g) for name, g in self.blocks(values).items()}

    def solve(self, refuse=True, lid=False):
        """The analytic centre, or multipliers that exclude every point.

        Parameters
        ----------
        refuse : bool
            Look for multipliers where there is no point; takes longer.
        lid : bool
            Bound the unknowns even where the set has a centre.

        Returns
        -------
        LMISolution
        """
        blocks = self._compiled()
        phase = phase_one(blocks, multipliers=refuse)
        if phase.x is None:
            return LMISolution(self, phase.verdict, multipliers=phase.Z)
        if not lid:
            return self._at(any_centre(blocks, self.unknowns, phase.x))
        try:
            joined, x = bounded(blocks, self.unknowns, phase.x)
            return self._at(centre(joined, x))
        except Unbounded:  # a degenerate set: keep the feasible point
            return self._at(phase.x)

    def minimize(self, weights, gap=1e-6, start=None):
        """A point inside, near the least sum of <weight, unknown>.

        Parameters
        ----------
        weights : dict
            From an unknown's name to a matrix of its shape.
        gap : float
            Relative accuracy of the sum.
        start : dict, optional
            A point inside, by name.

        Returns
        -------
        LMISolution

        Raises
        ------
        Unbounded
            If there is no minimum.
        """
        blocks = self._compiled()
        if start is None:
            phase = phase_one(blocks)
            if phase.x is None:
                return LMISolution(self, phase.verdict, multipliers=phase.Z)
            x = phase.x
            if np.abs(x).max() > FAR:  # a cone: start nearer to its tip
                x = bounded(blocks, self.unknowns, x)[1]
        else:
            x = np.concatenate([u.pack(start[u.name]) for u in self.unknowns])
        cost = np.concatenate([
            _gradient(u, weights[u.name]) if u.name in weights
            else np.zeros(u.size) for u in self.unknowns])
        return self._at(minimize(blocks, cost, x, gap)[0])

    def prove(self, values, claims=(), places=(12, 17)):
        """A `Proof` that all blocks are positive definite, in rationals.

        Parameters
        ----------
        values : dict
            Rounded to so many significant digits as ``places`` say: the
            first that succeeds.
        claims : tuple of str
            What that proves, in words.
        """
        for digits in places:
            found = Proof.of(self.blocks({
                name: exact(round_digits(value, digits))
                for name, value in values.items()}, exact), claims)
            if found["proven"]:
                break
        return Proof(**found)

    def refute(self, Z):
        """An `InfeasibilityCertificate` from float multipliers."""
        return refute(self.in_unknowns(exact), self.unknowns, Z)

    def to_cvxpy(self, margin=0.0):
        """Constraints, and the variables by name, for other solvers."""
        import cvxpy

        variables = {
            u.name: cvxpy.Variable(u.shape, symmetric=u.symmetric)
            for u in self.unknowns}
        return [
            (g + g.T) / 2 >> margin * np.eye(g.shape[0])
            for g in self.blocks(variables).values()], variables

    def _compiled(self):
        return Blocks.of(self.in_unknowns().values(), self.unknowns)

    def _at(self, x):
        values = unpacked(self.unknowns, x)
        margins = self.margins(values)
        status = "feasible" if min(margins.values()) > 0 else "undecided"
        return LMISolution(self, status, values, margins)


@dataclass(frozen=True, eq=False)
class LMISolution:
    """A point inside the blocks of an `LMIProblem`, or why there is none.

    Parameters
    ----------
    problem : LMIProblem
    status : {"feasible", "infeasible", "undecided"}
    values : dict or None
        The unknowns by name.
    margins : dict or None
        See `LMIProblem.margins`.
    multipliers : list of arrays or None
    """

    problem: LMIProblem
    status: str
    values: dict = None
    margins: dict = None
    multipliers: list = None

    def __repr__(self):
        return f"<LMISolution: {self.status}>"

    def prove(self, claims=()):
        """The `Proof` of these values."""
        if self.values is None:
            raise ValueError(f"the problem is {self.status}: there is no point")
        return self.problem.prove(self.values, claims)

    @cached_property
    def infeasibility(self):
        """`InfeasibilityCertificate` where one was found, else None."""
        if self.multipliers is None:
            return None
        return self.problem.refute(self.multipliers)


def _gradient(unknown, weight):
    """Of <weight, unknown> with respect to its variables."""
    basis = np.eye(unknown.size)
    return np.array([(weight * unknown.unpack(e)).sum() for e in basis])


def unpacked(unknowns, x):
    """Values by name, from a vector of variables."""
    ends = np.cumsum([u.size for u in unknowns])[:-1]
    return {u.name: u.unpack(part)
            for u, part in zip(unknowns, np.split(x, ends))}



def any_centre(blocks, unknowns, x, enough=None):
    """The analytic centre, of a bounded part if there is no other."""
    try:
        return centre(blocks, x, enough=enough)
    except Unbounded:
        pass
    try:
        return centre(*bounded(blocks, unknowns, x), enough=enough)
    except Unbounded:
        return x  # a degenerate set: keep the feasible point


def bounded(blocks, unknowns, x, r=16.0):
    """The blocks, joined by blocks "scale" that bound the unknowns.

    P is joined with Y in [[r I - P, Y'], [Y, r I]] > 0. Where every
    block is homogeneous the gain doesn't depend on r. It grows until
    there is a point inside, which is returned too: x if that will do.
    """
    P = [u for u in unknowns if u.symmetric]
    rest = [u for u in unknowns if not u.symmetric]
    lids = [block([[-p]]) for p in P]
    if len(P) == 1 and len(rest) == 1:
        (Y,), lids = rest, []
        rest = []
        lids = [block([[-P[0], Y.T], [Y, 0 * eye(Y.shape[0])]])]
    for X in rest:
        rows, cols = X.shape
        lids.append(block([[0 * eye(cols), X.T], [X, 0 * eye(rows)]]))
    while r < 1e16:
        roof = [g + r * eye(len(g.constant)) for g in lids]
        joined = Blocks.of([*blocks.expressions, *roof], blocks.unknowns)
        if Blocks.of(roof, blocks.unknowns).contain(x):
            return joined, x
        found = phase_one(joined).x
        if found is not None:
            return joined, found
        r *= 16
    raise Unbounded("no bound of the unknowns holds a feasible point")
