"""A controller and what is known about its loop."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..runtime.later import later
from ..runtime.time_limit import time_limit as limit_of_time
from .closed_loop import ClosedLoop
from .slack import feasible
from .solution import Solution

if TYPE_CHECKING:  # only what a few methods return
    from ..exact.proof import Unproven
    from ..exact.refusal import Refusal
    from .bounds import Bounds
    from .effort import Effort
    from .found import Found
    from .proofs import DesignProof


@dataclass(frozen=True, eq=False, repr=False)
class Design(ClosedLoop["DesignProof"], Solution):
    """A controller and everything that is known about its loop.

    Parameters
    ----------
    request : Request
        The plant and what was asked.
    status : {"feasible", "infeasible", "undecided"}
        "feasible": all blocks are positive definite, by a clear margin or by an exact
        proof. "infeasible": exact arithmetic excludes every solution, see
        `infeasibility`: of a family that of its LMIs, where ``reason`` names no mode,
        response or plant. Else "undecided": a solver's word decides nothing.
    K : (m, N) array or None
        ``[K_P K_D K_I]``, in ``u = K [z; z'; x3]``. A gain that was
        given to `analyse_pid` stays, whatever the status. All digits of
        the solver's: the proven gain is ``certify().K``.
    P, Y : (N, N) and (m, N) arrays, or None
        The solution of the LMIs; ``K = Y P^-1``. With a slack matrix P
        holds one for each vertex, and ``K = Y V'^-1``.
    V : (N, N) array or None
        The slack matrix, with ``coupling="slack"``.
    margins : dict
        From a block's name to its smallest eigenvalue, after scaling
        its diagonal to one; all positive for a feasible design.
    frame : Frame
        The coordinates in which the LMIs were solved.
    multipliers : list of arrays or None
        Of the blocks, in that frame, where there is no design.
    own : dict or None
        The requirements' own unknowns, such as J of Theorem 2.4, by name.
    minimized : tuple of Requirement
        Those whose least bounds were sought in vain, with numbers in the
        place of the bounds; the request is without them.
    reason : str
        Why there is no design: what is proven, or what was excluded and
        what was merely not found; or why a feasible one isn't all that was
        asked, such as the least bound, or isn't ``central``, and what would
        make it so. Otherwise empty.
    infeasibility : Refusal or None
        The exact proof of "infeasible"; a `FixedModeRefusal` where a mode is out of
        reach.
    central : bool or None
        Whether K is that of the analytic centre of all that was asked, which is
        unique. False where the solutions have no bound, or hardly one: K is that
        of a bounded part of them; and where time ended on the way. None where K is
        no centre's: it was given, or costs the least.
    parts : tuple of Kept
        With ``coupling="multipliers"`` what is known of each demand: see
        `sosbook.synthesis.known_gain.Kept`.
    searched : Searched or None
        How the gain of a ``law`` was searched: starts, seed, limits; prints a sentence.

    Examples
    --------
    >>> import sosbook as sos
    >>> mass = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]])
    >>> design = sos.design_pid(mass, region=sos.PoleRegion(sigma=1, rho=9))
    >>> design.central, design.reason[:29]
    (False, 'Every multiple of a solution ')
    >>> bounds = dict(region=sos.PoleRegion(1), saturation=sos.Saturation(9, [1, 0]))
    >>> sos.design_pid(mass, **bounds).central
    True
    """

    infeasibility: "Refusal | None" = None  # in Result it is abstract

    @property
    def K_A(self) -> np.ndarray:
        """Acceleration gain, (m, n), as given."""
        plant = self.request.plant
        if self.request.K_A is None:
            return np.zeros((plant.m, plant.n))
        return np.asarray(self.request.K_A, float)

    @property
    def sentence(self) -> str:
        """All that was asked, as a sentence for `read_wish`, and the status."""
        from ..requirements.wish import sentence_of

        return f"{sentence_of(self.request).removesuffix('.')}: {self.status}."

    @property
    def gamma(self) -> float | None:
        """The H-infinity bound that the design keeps, or None."""
        return self.request.gamma

    @property
    def mu(self) -> float:
        """The scalar of Theorem 2.1: its P is ``mu * P``."""
        return self.request.mu_of(self.own)

    @property
    def slack(self) -> float | None:
        """The scalar of the slack LMIs that was used, in seconds."""
        return self.request.coupling.slack

    @cached_property
    def effort(self) -> "Effort | None":
        """The effort of the gain: modes moved, force, whether K = 0 would do; see
        `Effort`.

        Examples
        --------
        >>> from sosbook import PoleRegion, Search, SecondOrderSystem, design_pid
        >>> mass = SecondOrderSystem([[1]], [[1]], [[1]], [[1]])
        >>> gentle = Search(prefer="least")
        >>> design = design_pid(mass, region=PoleRegion(0.1), search=gentle)
        >>> for words in str(design.effort).split("; "):
        ...     print(words)
        0 of 2 poles are moved
        K = 0 keeps all that is asked already
        the force at one unit is 0 of the stiffness's
        """
        if self.K is None or self._step or not self.request.law.whole:
            return None
        from .effort import effort_of

        return effort_of(self)

    def certify(
        self,
        digits: int | None = None,
        time_limit: float | None = None,
        progress: bool = False,
        on: Any = None,
    ) -> "DesignProof | Unproven":
        """Prove what was asked in exact arithmetic; see `Result.certify`.

        Parameters
        ----------
        digits, time_limit, progress
            As in `Result.certify`.
        on : SecondOrderSystem or DescriptorSystem, optional
            The whole plant, where the design is for a reduced one. What was asked of
            the poles is proven of the whole under the lifted gain; the proof's K is
            that one, rounded. What else was asked is about the part's coordinates:
            a warning says how to ask it of the whole. Of a design for another plant of
            the same size all is proven. Of a plant in sparse matrices nothing is, and
            the answer says so at once: `check_on` looks for its poles.

        Examples
        --------
        >>> from sosbook import PoleRegion, Search, SecondOrderSystem, design_pid
        >>> whole = SecondOrderSystem(np.eye(3), 0.1 * np.diag([1, 20, 30]),
        ...                           np.diag([1, 40, 90]), [[1], [1], [1]])
        >>> part = whole.reduce(modes=1)
        >>> gentle = Search(prefer="least")
        >>> design = design_pid(part, region=PoleRegion(0.5), search=gentle)
        >>> print(design.certify())
        proven:
        - of the reduced model (1 of 3): the plant, under u = K x, is stable
        - of the reduced model (1 of 3): its poles lie in the half-plane Re s < -0.5
        >>> print(design.certify(on=whole))
        proven:
        - the plant, under u = K x, is stable
        - its poles lie in the half-plane Re s < -0.5
        """
        if on is None or self.margins is None:
            return super().certify(digits, time_limit, progress)
        from ..exact.proof import proven_within
        from .reduced_model import proven_on

        return proven_within(time_limit, lambda: proven_on(self, on, digits), progress)

    def check_on(
        self, whole: Any, time_limit: float = 60.0, progress: bool = False
    ) -> "Found":
        """The worst pole that floats find of a larger plant under this gain.

        Parameters
        ----------
        whole : SecondOrderSystem, Polytope or DescriptorSystem
            The plant that was reduced, or one like it; for laws see `Reduction.law`.
        time_limit : float
            Seconds after which the search of a sparse plant ends with what is found.
            It ends at the first pole that breaks what is asked, too.
        progress : bool
            Show a bar of the places at which poles of a sparse plant were sought.

        Returns
        -------
        Found
            The rightmost pole that was found, refined until a residual says that it is
            one, and what it breaks. Of a polytope that of the worst vertex. No proof.

        Raises
        ------
        ValueError
            If the plant has another size, or doesn't know a sensor's place.
        OutOfTime
            If no pole is found in time; the error says how long a dense plant takes.

        Examples
        --------
        >>> from sosbook import PoleRegion, Search, SecondOrderSystem, design_pid
        >>> whole = SecondOrderSystem(np.eye(2), 0.2 * np.diag([1, 2]),
        ...                           np.diag([1, 400]), [[1], [1]])
        >>> design = design_pid(whole.reduce(modes=1), region=PoleRegion(0.5))
        >>> found = design.check_on(whole)
        >>> found.kept, found.broken
        (False, ('its poles lie in the half-plane Re s < -0.5',))
        """
        from .found import found_on

        with limit_of_time(time_limit):
            return found_on(self, whole, progress)

    def _prove(self, digits: int | None) -> "DesignProof":
        if self.parts:
            from .known_proof import known_proof

            return known_proof(self.request, self.parts, digits)
        from .proofs import prove

        return prove(self.request, self.K, self.P, digits, self.V, self.own)

    def bounds(self, time_limit: float = 60.0) -> "Bounds":
        """The bound of each requirement: asked, proven with a P of its own, and true.

        The LMIs of a design have one P for all that is asked, and so their bounds
        lie above what the loop does. Here each requirement is looked at alone.
        What is true is the worst that a search in floats has found: no proof, and a
        plant that it has missed may be worse, up to what is proven.

        Parameters
        ----------
        time_limit : float
            Seconds after which what isn't proven yet stays so. Then as many again may
            be taken to prove what was asked, as `certify` does.

        Returns
        -------
        Bounds
            A table when it is printed; ``bounds()["gamma"].proven`` is a number, or
            None, where the table may still say that what was asked is proven.

        Examples
        --------
        >>> import sosbook as sos
        >>> carts = sos.Polytope([
        ...     sos.SecondOrderSystem(m, 0.1, 1, 1) for m in (0.5, 2)])
        >>> design = sos.design_pid(carts, region=sos.PoleRegion(sigma=0.5),
        ...                         saturation=sos.Saturation(9, [1, 0]))
        >>> peak = design.bounds()["u_max"]
        >>> peak.true < peak.proven < peak.asked
        True
        """
        from .bounds import Bounds, bounds_of

        self._gain()
        table = vars(self).get("_bounds")
        if table is None or any(b.proven is None for b in table):
            table = bounds_of(self.request, self.K, time_limit)
            late = [b for b in table if b.proven is None]
            if late and self.certify(17, time_limit).proven:  # of K as it is
                rows = (replace(b, as_asked=b in late) for b in table)
                table = Bounds(rows)
            vars(self)["_bounds"] = table
        return table

    def _repr_html_(self):
        """The card, and the table of `bounds` where it is known."""
        table = vars(self).get("_bounds")
        return super()._repr_html_() + ("" if table is None else table._repr_html_())

    def to_cvxpy(self, margin: float = 0.0) -> tuple[list, Any, Any]:
        """The same LMIs as cvxpy constraints, for other solvers.

        Parameters
        ----------
        margin : float
            Demands G >= margin * I of each block G.

        Returns
        -------
        constraints : list
            The constraints.
        P, Y : cvxpy.Variable, or Y an expression where K is given
            The unknowns.

        Raises
        ------
        ValueError
            With ``coupling="multipliers"``: its LMIs are those of single requirements
            and parts of the polytope.

        Examples
        --------
        >>> import cvxpy
        >>> from sosbook import SecondOrderSystem, design_pid
        >>> plant = SecondOrderSystem([[1]], [[1]], [[1]], B=[[1]])
        >>> constraints, P, Y = design_pid(plant).to_cvxpy(margin=0.1)
        >>> problem = cvxpy.Problem(cvxpy.Minimize(0), constraints)
        >>> problem.solve(solver="CLARABEL")
        0.0
        """
        from ..lmi.cones import cvxpy_constraints

        if self.request.coupling.free:
            raise ValueError(
                'coupling="multipliers" has no LMIs of the whole polytope: take '
                'coupling="pairs" for those with one P'
            )
        return cvxpy_constraints(self.request, margin)

    @cached_property
    def advice(self) -> str:
        """Which requirement to relax first; empty if feasible.

        Found by solving again with each requirement left out.
        """
        from .bounds import neighbours
        from .fixed_mode import FixedModeRefusal
        from .growing import GrowingRefusal

        if self.status == "feasible":
            return ""
        if self.request.law.searched and (self.searched or self.K is None):
            advice = later("synthesis.structured.advice")
            more = "" if self.minimized else advice.with_memory(self.request)
            if self.status == "undecided":
                more = advice.with_one_relaxed(self.request) + more
            return f"{self.reason} {more}Measure more, or ask for less."
        if isinstance(self.infeasibility, (FixedModeRefusal, GrowingRefusal)):
            if self.request.gain is not None:
                what = "gain" if self.request.plant.m else "loop"
                return f"{self.reason} Change the {what}, or ask for less."
            return f"{self.reason} Change B, or ask for less there."
        if self.request.coupling.free:
            return f"{self.reason} Change the gain, or ask for less."
        whole, free = self.asked, [r.key for r in self.minimized]

        def helps(request):
            return feasible(request, [r for r in request.requirements if r.key in free])

        if whole.sizes.ties and helps(whole.untied()):
            ties = " and ".join(whole.sizes.ties)
            return f"Leave out {ties} first: there is a design for another value."
        asked = self.request.requirements
        enough = [r for r in asked if helps(whole.without(r))]
        if not enough:
            if len(asked) < 2:
                return self.reason
            text = "Nothing was found with any single requirement left out, either: "
            text += f"relax several of {_words(asked)}."
            return f"{text} {neighbours(whole, ())}".strip()
        enough.sort(key=lambda r: _weight(self, r), reverse=True)
        text = f"Relax the {_words(enough[:1])} first"
        if enough[1:]:
            text += "; leaving out one of these would do as well: "
            text += _words(enough[1:])
        return f"{text}. {neighbours(whole, enough)}".strip()

    def _matrices(self):
        parts = super()._matrices()
        return (*parts, ("K_A", self.K_A)) if self.request.K_A is not None else parts

    def _region(self):
        return self.request.region


def _words(requirements):
    return ", ".join(r.words for r in requirements)


def _weight(design, requirement):
    """Share of a design's multipliers that the blocks of a requirement carry."""
    if design.multipliers is None:
        return 0.0
    expressions, _ = design.request.in_unknowns(design.frame)
    return sum(
        np.trace(z)
        for name, z in zip(expressions, design.multipliers)
        if name.requirement == requirement.key
    )
