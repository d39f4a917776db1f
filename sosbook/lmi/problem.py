"""LMIs as such: write blocks, get a point, a proof or a refusal."""

from dataclasses import replace

import numpy as np

from ..exact.definite import round_digits
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, checked_seconds, time_limit
from ..solver.bounded import any_centre, bounded, unpacked
from ..solver.loop import Unbounded, centre, minimize, phase_one
from .solution import LMISolution
from .text import LMIText, rationals

__all__ = ["LMIProblem", "LMISolution", "TrustedProblem"]

FARTHEST_MINIMUM = 1e16  # largest unknown's size that may be a unit
FARTHEST_START = 1e6  # largest variable from which a minimisation starts


class LMIProblem(LMIText):
    """Blocks, affine in some unknowns, that shall be positive definite.

    Parameters
    ----------
    write : callable
        ``write(values, number)`` returns the blocks by name, for the unknowns' values
        by name. The values are unknowns, floats, rationals or cvxpy variables;
        ``number`` brings the data (floats, arrays, nested lists) into that arithmetic.
        Integers need no ``number``. Write `block`, `he` and `eye` as in a theorem.
    unknowns : sequence of Unknown
        What the blocks are affine in.
    time_limit : float, optional
        Seconds after which each of `find`, `solve`, `centre` and
        `minimize` stops. It is checked at every Newton step.
    settings : Settings, optional
        Numbers by which the solver chooses its ways and ends them.

    Raises
    ------
    ValueError
        If ``write`` can't be called or the unknowns are none or share a
        name; later, if a block isn't square, symmetric and finite.

    Examples
    --------
    A matrix A is stable if and only if some P > 0 has A P + P A' < 0:

    >>> from sosbook.lmi import LMIProblem, Unknown, he
    >>> def lyapunov(A):
    ...     def write(values, number):
    ...         P = values["P"]
    ...         return {"P": P, "decay": -he(number(A) @ P)}
    ...     return LMIProblem(write, [Unknown("P", 2, symmetric=True)])
    >>> stable = lyapunov([[0, 1], [-2, -3]]).solve()
    >>> print(stable.status, "|", stable.prove(("A is stable",)))
    feasible | proven of an author's LMIs:
    - these blocks are positive definite: P, decay
      which say, by their author's word alone: "A is stable"
    >>> unstable = lyapunov([[0, 1], [-2, 3]]).solve()
    >>> unstable.status, unstable.infeasibility.proven
    ('infeasible', True)

    Of a saddle the exact multipliers have irrational entries. What
    rationals prove is said:

    >>> saddle = lyapunov([[0, 1], [2, 3]]).solve()
    >>> saddle.status, saddle.excluded > 1e5
    ('undecided', True)
    """

    def __init__(self, write, unknowns, time_limit=None, settings=None):
        super().__init__(write, unknowns, settings)
        self.time_limit = checked_seconds(time_limit)

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
            x = self.packed(first.values)
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
    def minimize(self, weights, gap=1e-6, start=None):
        """A point inside, near the least sum of <weight, unknown>.

        Parameters
        ----------
        weights : dict
            For an unknown's name a matrix of its shape, or a number for an
            unknown of one entry.
        gap : float
            Relative accuracy of the sum.
        start : dict, optional
            A point inside, by name.

        Returns
        -------
        LMISolution
            Its ``bound`` is a lower bound of the sum.

        Raises
        ------
        Unbounded
            If no minimum is found: it may be zero, or not be attained.
        ValueError
            If a weight has no unknown or another shape, or if ``start`` isn't inside.
        """
        cost = self._cost(weights)
        if start is None:
            first = self.find()
            if first.values is None:
                return first
            x = self.packed(first.values)
        else:
            x = self._inside(start)
            first = LMISolution(self, start)

        def least():
            inside = x
            if start is None and np.abs(x).max() > FARTHEST_START:
                # a cone: begin near zero
                inside = bounded(self.compiled, self.unknowns, x)[1]
            try:
                return self._at(*minimize(self.compiled, cost, inside, gap))
            except Unbounded as missed:
                return self._least_in_units(cost, gap, missed)

        return self._limited(least, first)

    def _least_in_units(self, cost, gap, missed):
        """The minimum with each unknown in a unit of its size where a search ``missed``
        it; Unbounded names the largest one if there is none.
        """
        if missed.x is None:
            raise missed
        sizes = {
            name: 2.0 ** np.round(np.log2(np.abs(value).max() or 1.0))
            for name, value in unpacked(self.unknowns, missed.x).items()
        }

        def write(values, number):
            units = {n: number(np.array(s)).item() for n, s in sizes.items()}
            return self.write({n: x * units[n] for n, x in values.items()}, number)

        each = np.concatenate([np.full(u.size, sizes[u.name]) for u in self.unknowns])
        try:
            if each.max() > FARTHEST_MINIMUM:
                raise missed
            blocks = TrustedProblem(write, self.unknowns, settings=self.settings)
            x, bound = minimize(blocks.compiled, cost * each, missed.x / each, gap)
            if cost @ missed.x < bound:  # rounding errors, far away
                raise missed
        except Unbounded:
            name = max(sizes, key=sizes.get)
            raise Unbounded(
                f"{missed}; the search ended where {name} has entries of the size "
                f"{sizes[name]:.1e}",
                missed.x,
            ) from None
        return self._at(x * each, bound)

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
            If a block isn't exactly symmetric or holds a float that
            didn't pass ``number``, or if digits is below 1.
        """
        from ..exact.proof import PLACES
        from .proofs import LMIProof

        for u in self.unknowns:
            if u.name not in values or np.shape(values[u.name]) != u.shape:
                raise ValueError(f"values needs {u.name} of the shape {u.shape}")
        expressions = self.in_unknowns(rationals)
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

        expressions = self.in_unknowns(rationals)
        data = LMIRefusal.contents(expressions, self.unknowns)
        return LMIRefusal.mended(data, expressions, self.unknowns, Z, str)

    def excluded_radius(self, Z):
        """The length of the shortest point that inexact multipliers don't exclude.

        ``Z``: as in `refuse`. Returns float: see
        `sosbook.exact.refusal.excluded_radius`.
        """
        from ..exact.refusal import excluded_radius

        return excluded_radius(self.in_unknowns(rationals), self.unknowns, Z)

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
        from ..runtime.libraries import library

        cvxpy = library("cvxpy")
        variables = {
            u.name: cvxpy.Variable(u.shape, symmetric=u.symmetric)
            for u in self.unknowns
        }
        return [
            (g + g.T) / 2 >> margin * np.eye(g.shape[0])
            for g in self.blocks(variables).values()
        ], variables

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
        x = None if start is None else self.packed(start)
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
        x = self.packed(start)
        if self.compiled.newton.least(x).min() > 0:
            return x
        margins = self.margins(start)
        least = min(margins, key=margins.get)
        if margins[least] <= 0:
            raise ValueError(
                f"start isn't inside block {least!r}: its margin is "
                f"{margins[least]:.2g}"
            )
        return x

    def _cost(self, weights):
        """The gradient of the sum of <weight, unknown>."""
        names = {u.name for u in self.unknowns}
        if not weights or not set(weights) <= names:
            raise ValueError(
                f"weights must name some of {sorted(names)}, got {sorted(weights)}"
            )
        gradients = []
        for u in self.unknowns:
            weight = np.asarray(weights.get(u.name, np.zeros(u.shape)), float)
            if weight.shape != u.shape and not u.size == weight.size == 1:
                raise ValueError(
                    f"the weight of {u.name} has the shape {weight.shape}, "
                    f"needs {u.shape}"
                )
            gradients.append(u.gradient(weight.reshape(u.shape)))
        return np.concatenate(gradients)


class TrustedProblem(LMIProblem):
    """An `LMIProblem` whose blocks aren't checked, for this package wrote them.

    ``write``, ``unknowns``, ``time_limit``, ``settings``: as for `LMIProblem`.
    """

    trusted = True
