"""LMIs as such: write blocks, get a point, a proof or a refusal."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from ..exact.definite import round_digits
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, checked_seconds, time_limit
from ..solver.bounded import any_centre, bounded, unpacked
from ..solver.loop import Unbounded, centre, phase_one
from .solution import LMISolution
from .text import LMIText, WrittenText, rationals

__all__ = ["LMIProblem", "LMISolution"]


class LMIProblem:
    """Blocks, affine in some unknowns, that shall be positive definite.

    Parameters
    ----------
    blocks : dict
        From a name to a square, symmetric expression in the unknowns, which are made
        by `symmetric` and `matrix`. Write `block`, `he` and `eye` as in a theorem.
    time_limit : float, optional
        Seconds after which each of `find`, `solve`, `centre` and
        `minimize` stops. It is checked at every Newton step.

    Raises
    ------
    ValueError
        If a block isn't square, symmetric and finite, if there is no unknown, or if
        two have one name.

    Examples
    --------
    A matrix A is stable if and only if some P > 0 has A P + P A' < 0:

    >>> from sosbook.lmi import LMIProblem, he, symmetric
    >>> P = symmetric("P", 2)
    >>> def lyapunov(A):
    ...     return LMIProblem({"P": P, "decay": -he(np.array(A) @ P)})
    >>> stable = lyapunov([[0, 1], [-2, -3]]).solve()
    >>> print(stable.status, "|", stable.prove(("A is stable",)))
    feasible | proven of an author's LMIs:
    - these blocks are positive definite: P, decay
      which say, by their author's word alone: "A is stable"
    >>> stable[P].shape, stable[he(P)].shape
    ((2, 2), (2, 2))
    >>> unstable = lyapunov([[0, 1], [-2, 3]]).solve()
    >>> unstable.status, unstable.infeasibility.proven
    ('infeasible', True)

    Of a saddle the exact multipliers have irrational entries. What
    rationals prove is said:

    >>> saddle = lyapunov([[0, 1], [2, 3]]).solve()
    >>> saddle.status, saddle.excluded > 1e5
    ('undecided', True)
    """

    def __init__(self, blocks, time_limit=None):
        # The package's own blocks come as an `LMIText`, which isn't checked.
        self.text = blocks if isinstance(blocks, LMIText) else WrittenText(blocks)
        self.unknowns = self.text.unknowns
        self.time_limit = checked_seconds(time_limit)

    @cached_property
    def compiled(self):
        """The `Blocks` that the solver takes."""
        return self.text.compiled()

    @one_thread
    def find(self, refuse=True, start=None):
        """Any point inside, or multipliers that exclude every point.

        Parameters
        ----------
        refuse : bool
            Look for multipliers where there is no point; takes longer.
        start : dict, optional
            Values of the unknowns by name, which needn't lie inside: where
            the search begins. If they do, they are the answer.

        Returns
        -------
        LMISolution
            The point that was found, or the lack of one.
        """
        return self._limited(lambda: self._first(refuse, start))

    @one_thread
    def solve(self, refuse=True, within_bounds=False, start=None):
        """The analytic centre, or multipliers that exclude every point.

        Parameters
        ----------
        refuse : bool
            As in `find`.
        within_bounds : bool
            Bound the unknowns even where the set has a centre.
        start : dict, optional
            As in `find`.

        Returns
        -------
        LMISolution
            Where the set has no centre: that of a bounded part.
        """
        first = self.find(refuse, start)
        if first.values is None:
            return first

        def centred():
            x = self.text.packed(first.values)
            if not within_bounds:
                return self._at(any_centre(self.compiled, self.unknowns, x))
            try:
                return self._at(centre(*bounded(self.compiled, self.unknowns, x)))
            except Unbounded:  # a degenerate set: keep the feasible point
                return first

        return self._limited(centred, first)

    @one_thread
    def centre(self, start):
        """The analytic centre, from a point inside.

        Parameters
        ----------
        start : dict
            Values of the unknowns by name.

        Returns
        -------
        LMISolution
            The centre, and what is known of it.

        Raises
        ------
        Unbounded
            If the set is unbounded: it has no centre.
        ValueError
            If ``start`` isn't inside.
        """
        x = self._inside(start)
        return self._limited(lambda: self._at(centre(self.compiled, x)))

    @one_thread
    def minimize(self, expression, gap=1e-6, start=None):
        """A point inside, near the least trace of an expression in the unknowns.

        Parameters
        ----------
        expression : square expression
            Such as J or ``W @ P``; of one entry it is its own trace.
        gap : float
            Relative accuracy of the trace.
        start : dict, optional
            A point inside, by name.

        Returns
        -------
        LMISolution
            Its ``bound`` is a lower bound of the trace.

        Raises
        ------
        Unbounded
            If no minimum is found: it may be zero, or not be attained.
        ValueError
            If the expression isn't square or has other unknowns than the blocks, or
            if ``start`` isn't inside.
        """

        from .minimum import Minimum

        minimum = Minimum(self, expression, gap)
        if start is None:
            first = self.find()
            if first.values is None:
                return first
            x = self.text.packed(first.values)
        else:
            x, first = self._inside(start), LMISolution(self, start)
        return self._limited(lambda: self._at(*minimum.near(x, start is None)), first)

    def prove(self, values, claims=(), digits=None):
        """Prove in rational arithmetic that all blocks are positive definite.

        Parameters
        ----------
        values : dict
            A point by the unknowns' names, in floats; read as decimals.
        claims : sequence of str
            What that means, in words: the proof's ``statement``. They are yours,
            and nobody checks that the blocks say so.
        digits : int, optional
            Significant digits to which the values are rounded; without it 12,
            or 17 where 12 won't do.

        Returns
        -------
        LMIProof
            What was proven, and what failed.

        Raises
        ------
        ValueError
            If a block isn't exactly symmetric, or if digits is below 1.
        """
        from ..exact.proof import PLACES
        from .proofs import LMIProof

        for u in self.unknowns:
            if u.name not in values or np.shape(values[u.name]) != u.shape:
                raise ValueError(f"values needs {u.name} of the shape {u.shape}")
        expressions = self.text.in_unknowns(rationals)
        for places in PLACES if digits is None else (digits,):
            rounded = {n: round_digits(v, places) for n, v in values.items()}
            proof = LMIProof.of(
                LMIProof.contents(expressions, self.unknowns, rounded, places, claims)
            )
            if proof.proven:
                break
        return proof

    def refuse(self, Z):
        """Make float multipliers exact: they exclude every point.

        Parameters
        ----------
        Z : list of arrays
            One for each block, in the order of the blocks.

        Returns
        -------
        LMIRefusal or None
            The exact multipliers; None where those in floats can't be made exact.
        """
        from .proofs import LMIRefusal

        expressions = self.text.in_unknowns(rationals)
        data = LMIRefusal.contents(expressions, self.unknowns)
        return LMIRefusal.mended(data, expressions, self.unknowns, Z, str)

    def excluded_radius(self, Z):
        """The length of the shortest point that inexact multipliers don't exclude.

        ``Z``: as in `refuse`. Returns float: see
        `sosbook.exact.refusal.excluded_radius`.
        """
        from ..exact.refusal import excluded_radius

        return excluded_radius(self.text.in_unknowns(rationals), self.unknowns, Z)

    def to_cvxpy(self, margin=0.0):
        """The same blocks for other solvers.

        Parameters
        ----------
        margin : float
            Demands G >= margin * I of every block.

        Returns
        -------
        constraints : list
            The constraints, and the variables by name.
        variables : dict
            The ``cvxpy.Variable`` for each unknown's name.
        """
        from .cones import in_cvxpy

        constraints, variables = in_cvxpy(
            self.text.in_unknowns(), self.unknowns, margin
        )
        return constraints, {u.name: x for u, x in variables.items()}

    def _limited(self, work, first=None):
        """An LMISolution, or what is known when time or memory end."""
        try:
            with time_limit(self.time_limit):
                return work()
        except OutOfTime:
            if self.time_limit is None:  # somebody else's limit
                raise
            note = f"stopped after {self.time_limit:g} s"
        except MemoryError as error:
            note = str(error)
        return replace(first or LMISolution(self), note=note)

    def _first(self, refuse, start=None):
        x = None if start is None else self.text.packed(start)
        phase = phase_one(self.compiled, start=x, multipliers=refuse)
        if phase.x is not None:
            return self._at(phase.x)
        return LMISolution(
            self,
            multipliers=phase.Z,
            verdict=phase.verdict,
            last_iterate=unpacked(self.unknowns, phase.last_iterate),
            excluded_radius=phase.excluded_radius,
        )

    def _at(self, x, bound=None):
        return LMISolution(self, unpacked(self.unknowns, x), bound=bound)

    def _inside(self, start):
        x = self.text.packed(start)
        if self.compiled.newton.least(x).min() > 0:
            return x
        margins = self.text.margins(start)
        least = min(margins, key=margins.get)
        if margins[least] <= 0:
            raise ValueError(
                f"start isn't inside block {least!r}: its margin is "
                f"{margins[least]:.2g}. Leave start out, or give a point at which "
                "every block is positive definite"
            )
        return x
