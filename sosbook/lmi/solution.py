"""The answer of an `LMIProblem`: a point or a refusal."""

from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from typing import Any

CLEAR_MARGIN = 1e-9  # smallest eigenvalue; rounding makes 1e-15 of unit blocks
NO_POINT = "the problem is {}: there is no point; its reason says why"


@dataclass(frozen=True, eq=False)
class LMISolution:
    """A point inside the blocks of an `LMIProblem`, or why there is none.

    Parameters
    ----------
    problem : LMIProblem
        What was solved.
    values : dict or None
        The unknowns by name.
    multipliers : list of arrays or None
        In floats, one for each block, where no point was found.
    verdict : str
        What the solver says in floats where it found no point.
    last_iterate : dict or None
        Where no point was found: where the search ended, by name.
    excluded_radius : float
        Where there is no point: in floats, none is shorter than this.
    bound : float or None
        The bound of a minimum: no point has a smaller sum (in floats).
    note : str
        What kept the solver from finishing; empty if nothing did.
    """

    problem: Any = field(repr=False)
    values: dict | None = None
    multipliers: list | None = None
    verdict: str = "undecided"
    last_iterate: dict | None = None
    excluded_radius: float = 0.0
    bound: float | None = None
    note: str = ""

    def __repr__(self):
        if self.values is None:
            return f"<LMISolution: {self.status}>"
        least = min(self.margins.values())
        return f"<LMISolution: {self.status}, smallest margin {least:.3g}>"

    def __getitem__(self, expression):
        """The value of an expression in the unknowns, an array in floats.

        Raises
        ------
        ValueError
            If there is no point, or the blocks don't have one of its unknowns.
        """
        if self.values is None:
            raise ValueError(NO_POINT.format(self.status))
        return self.problem.text.value(expression, self.values)

    @cached_property
    def margins(self):
        """The smallest eigenvalue of each block, its diagonal scaled to one.

        None where there is no point.
        """
        return None if self.values is None else self.problem.text.margins(self.values)

    @cached_property
    def infeasibility(self):
        """The `LMIRefusal`; None where no multipliers were found and made exact."""
        if self.multipliers is None:
            return None
        return self.problem.refuse(self.multipliers)

    @cached_property
    def excluded(self):
        """A length that no point falls below: see `LMIProblem.excluded_radius`.

        It is exact: infinite where there is a proof that no point exists, and
        0 where nothing is known.
        """
        if self.multipliers is None:
            return 0.0
        if self.infeasibility is not None:
            return inf
        return self.problem.excluded_radius(self.multipliers)

    @cached_property
    def status(self):
        """ "feasible", "infeasible" or "undecided".

        "feasible" takes positive margins; where floats can't tell them
        from zero, an exact proof of the point with all its digits.
        "infeasible" takes multipliers that are exact.
        """
        if self.values is None:
            refused = self.infeasibility
            return "infeasible" if refused and refused.proven else "undecided"
        if min(self.margins.values()) > CLEAR_MARGIN or self.prove(digits=17).proven:
            return "feasible"
        return "undecided"

    @property
    def reason(self):
        """Why the answer isn't finished, in words; empty if it is."""
        if self.note or self.status != "undecided":
            return self.note
        if self.values is not None:
            least = min(self.margins, key=self.margins.get)
            return f"block {least!r} has the margin {self.margins[least]:.1g}"
        if self.multipliers is None:
            return "neither a point nor multipliers were found"
        return (
            "multipliers that exclude every point couldn't be made exact; "
            f"they prove that none is shorter than {self.excluded:.1e}"
        )

    def prove(self, claims=(), digits=None):
        """The `LMIProof` of these values.

        Parameters
        ----------
        claims : sequence of str
            What that proves, in words: see `LMIProblem.prove`. Without
            them: that the blocks are positive definite.
        digits : int, optional
            Significant digits to which the values are rounded; without it 12,
            or 17 where 12 won't do.

        Raises
        ------
        ValueError
            If there is no point.
        """
        if self.values is None:
            raise ValueError(NO_POINT.format(self.status))
        return self.problem.prove(self.values, claims, digits)
