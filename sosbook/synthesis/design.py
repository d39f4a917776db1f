"""A controller and what is known about its loop."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from ..analysis import linear
from ..analysis.margins import DiskMargin, disk_margin, sensitivity_peak
from ..lmi.proof import Stopped, proven_within
from ..lmi.refutation import InfeasibilityCertificate
from ..plants.checks import count, finite
from ..plants.descriptor import descriptors
from ..plants.response import Response, simulate, vector
from ..plants.second_order import Polytope
from ..plants.signals import Sine, Step, Steps
from ..requirements.cost import QuadraticCost
from ..requirements.pole_region import LMIRegion, PoleRegion
from .certificates import Certificate, prove, prove_infeasible
from .exclusion import FixedModeCertificate
from .gains import Gains
from .pole_proof import prove_poles
from .slack import feasible
from .solution import Solution

__all__ = ["Design"]


@dataclass(frozen=True, eq=False, repr=False)
class Design(Gains, Solution):
    """A controller and everything that is known about its loop.

    Parameters
    ----------
    request : Request
        The plant and what was asked.
    status : {"feasible", "infeasible", "undecided"}
        "feasible": all blocks are positive definite, by a clear margin
        or by an exact proof. "infeasible": exact arithmetic excludes
        every solution, see `infeasibility`. Anything else is
        "undecided". A solver's word decides nothing.
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
        what was merely not found. Empty for a feasible design.
    exclusion : InfeasibilityCertificate, FixedModeCertificate or None
        The exact proof of "infeasible".
    """

    @property
    def K_A(self) -> np.ndarray:
        """Acceleration gain, (m, n), as given."""
        plant = self.request.plant
        if self.request.K_A is None:
            return np.zeros((plant.m, plant.n))
        return np.asarray(self.request.K_A, float)

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
        return self.request.slack

    @overload
    def certify(
        self, digits: int | None = None, *, progress: bool = False
    ) -> Certificate: ...

    @overload
    def certify(
        self,
        digits: int | None = None,
        time_limit: float | None = None,
        progress: bool = False,
    ) -> Certificate | Stopped: ...

    def certify(
        self,
        digits: int | None = None,
        time_limit: float | None = None,
        progress: bool = False,
    ) -> Certificate | Stopped:
        """Prove the design in exact arithmetic.

        Floats, the plant's too, are read as decimals: 0.1 is 1/10.

        Parameters
        ----------
        digits : int, optional
            K is rounded to so many significant digits first: the proof
            is about the gain as it is printed. Without it 6, 8, 10, 12
            and 17 are tried, and the certificate says which; a gain that
            was given to `analyse_pid` isn't rounded.
        time_limit : float, optional
            Seconds after which nothing is proven, and the answer says so.
        progress : bool
            Show a bar of the seconds that have passed.

        Returns
        -------
        Certificate
            What was proven, and what failed.
            Of its own ``K``, the rounded one: use that one where a gain
            leaves the program. ``save`` makes it a file.
        """
        if self.P is None:
            raise ValueError(
                f"the design is {self.status}: there is nothing to "
                "certify; see its advice and infeasibility"
            )

        def proven():
            proof = prove(self.request, self.K, self.P, digits, self.V, self.own)
            if not proof.proven:  # floats may be too short for P
                proof = prove_poles(self.request, self.K, digits) or proof
            return proof

        return proven_within(time_limit, proven, progress)

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

        return cvxpy_constraints(self.request, margin)

    @cached_property
    def infeasibility(self) -> InfeasibilityCertificate | None:
        """The exact proof of "infeasible".

        An `InfeasibilityCertificate`, or a `FixedModeCertificate` where
        a mode is out of reach. Of an undecided request what multipliers
        were found, not proven; else None.
        """
        if self.exclusion is not None:
            return self.exclusion
        if self.multipliers is None:
            return None
        return prove_infeasible(self.request, self.frame, self.multipliers)

    @cached_property
    def advice(self) -> str:
        """Which requirement to relax first; empty if feasible.

        Found by solving again with each requirement left out.
        """
        if self.status == "feasible":
            return ""
        if isinstance(self.exclusion, FixedModeCertificate):
            if self.request.gain is not None:
                return f"{self.reason} Change the gain, or ask for less."
            return f"{self.reason} Change B, or ask for less there."
        whole, free = self.asked, [r.key for r in self.minimized]

        def helps(request):
            return feasible(request, [r for r in request.requirements if r.key in free])

        if whole.ties and helps(whole.untied()):
            ties = " and ".join(whole.ties)
            return f"Leave out {ties} first: there is a design for another value."
        asked = self.request.requirements
        enough = [r for r in asked if helps(whole.without(r))]
        if not enough:
            if len(asked) < 2:
                return self.reason
            return (
                "Nothing was found with any single requirement left out, "
                "either: relax several of " + _words(asked) + "."
            )
        enough.sort(key=self._weight, reverse=True)
        text = f"Relax the {_words(enough[:1])} first"
        if enough[1:]:
            text += "; leaving out one of these would do as well: "
            text += _words(enough[1:])
        return text + "."

    def _weight(self, requirement):
        """Share of the multipliers that a requirement's blocks carry."""
        if self.multipliers is None:
            return 0.0
        expressions, _ = self.request.in_unknowns(self.frame)
        return sum(
            np.trace(z)
            for name, z in zip(expressions, self.multipliers)
            if name.requirement == requirement.key
        )

    def _matrices(self):
        parts = super()._matrices()
        return (*parts, ("K_A", self.K_A)) if self.request.K_A is not None else parts

    def _region(self):
        parts = [r for r in self.request.requirements if isinstance(r, LMIRegion)]
        return PoleRegion.of(parts) if parts else None

    def _each(self, function):
        plant = self.request.plant
        return plant.per_vertex([function(d) for d in self.request.vertices])

    def _loops(self, samples, seed):
        """Descriptors of the vertices and of random plants between."""
        vertices, plant = self.request.vertices, self.request.plant
        if not count("samples", samples):
            return vertices
        if not isinstance(plant, Polytope):
            raise ValueError("samples needs a Polytope; the plant is one")
        inside = Polytope(plant.sample(samples, seed))
        return vertices + descriptors(inside, self.request.U, self.request.K_A)

    def open_loop(self) -> Any:
        """control.StateSpace from (u, w, r) to x; a list per vertex."""
        self._second_order("set point")
        return self._each(linear.open_loop)

    def closed_loop(self) -> Any:
        """control.StateSpace from (w, r) to (z, u); a list per vertex."""
        K = self._gain()
        self._second_order("set point")
        return self._each(lambda d: linear.closed_loop(d, K))

    def poles(self, samples: int = 0, seed: int = 0) -> np.ndarray:
        """Closed-loop poles, in rad/s.

        Parameters
        ----------
        samples : int
            For a Polytope: how many random plants join the vertices.
        seed : int
            Of the random plants.

        Returns
        -------
        (N,) array, or (vertices + samples, N) for a polytope
            One row for each vertex or sample of a polytope.
        """
        K = self._gain()
        poles = [linear.poles(d, K) for d in self._loops(samples, seed)]
        return self.request.plant.per_vertex(np.array(poles))

    def hinf(self, samples: int = 0, seed: int = 0) -> float:
        """The largest true H-infinity norm from w to z.

        Over the vertices and random plants; ``samples`` and ``seed`` are as in
        `poles`.
        """
        K = self._gain()
        if self.request.plant.p == 0:
            raise ValueError("the plant has no F: there is no such norm")
        return max(linear.hinf_norm(d, K) for d in self._loops(samples, seed))

    def noise_cost(
        self, cost: QuadraticCost | None = None, samples: int = 0, seed: int = 0
    ) -> float:
        """The largest true quadratic cost under white noise.

        Parameters
        ----------
        cost : QuadraticCost, optional
            That of the request without it.
        samples, seed
            As in `poles`.
        """
        K, cost = self._gain(), cost or self.request.cost
        if cost is None:
            raise ValueError("cost is missing: the design was made without")
        return cost.truth(self._loops(samples, seed), K)

    def peak_input(self, samples: int = 0, seed: int = 0) -> float:
        """The largest signal that saturation bounds, from x0.

        That is |K x(t)|, or |K x + K_A z''| with ``acceleration``. Over
        the vertices and random plants; ``samples`` and ``seed`` are as in
        `poles`.
        """
        K = self._gain()
        saturation = self.request.saturation
        if saturation is None:
            raise ValueError("the design has no saturation, so no x0")
        return saturation.truth(self._loops(samples, seed), K, self.K_A)

    def peak_bound(self, x0: ArrayLike | None = None, energy: float = 0.0) -> float:
        """What P says of |K x(t)|: it stays below this from x0, with r = 0.

        Parameters
        ----------
        x0 : (N,) array_like, optional
            Initial state; that of the saturation without it.
        energy : float
            The integral of w'w, which a design with gamma bears too.

        Returns
        -------
        float
            ``sqrt(|K P K'| (x0' P^-1 x0 + mu energy))``, for all plants
            that the LMIs cover; with a slack matrix the largest factors of
            the vertices. `peak_input` is the truth without w, and smaller.

        Notes
        -----
        Source: thesis Lemma 2.2, Theorem 2.1: V(x) = x' P^-1 x rises by
        less than mu w'w a second, and |K x|^2 is at most |K P K'| V.
        K_A z'' isn't in it.
        """
        K = self._gain()
        if self.P is None:
            raise ValueError(f"the design is {self.status}: there is no P")
        if x0 is None:
            saturation = self.request.saturation
            if saturation is None:
                raise ValueError("x0 is missing: the design has no saturation")
            x0 = saturation.x0
        x0, energy = vector("x0", x0, K.shape[1]), finite("energy", energy)
        if energy < 0 or (energy and self.gamma is None):
            raise ValueError(
                "energy must not be negative, and only a design with gamma bears "
                f"any; got {energy!r}"
            )
        reach, height = [], []
        for P in [self.P] if self.V is None else self.P:
            spread = P if self.V is None else self.V @ np.linalg.solve(P, self.V.T)
            reach.append(np.linalg.norm(K @ spread @ K.T, 2))
            height.append(x0 @ np.linalg.solve(spread, x0))
        rise = self.mu * energy if energy else 0.0
        return float(np.sqrt(max(reach) * (max(height) + rise)))

    def sensitivity_peak(self, samples: int = 0, seed: int = 0) -> float:
        """The largest sensitivity at the plant's input.

        Over the vertices and random plants; ``samples`` and ``seed`` are as in
        `poles`.
        See `sosbook.analysis.margins.sensitivity_peak`.
        """
        K = self._gain()
        return max(sensitivity_peak(d, K) for d in self._loops(samples, seed))

    def disk_margin(self, samples: int = 0, seed: int = 0) -> DiskMargin:
        """The least `DiskMargin` at the plant's input.

        Over the vertices and random plants; ``samples`` and ``seed`` are as in
        `poles`.
        """
        K = self._gain()
        margins = [disk_margin(d, K) for d in self._loops(samples, seed)]
        return min(margins, key=lambda margin: margin.radius)

    def simulate(
        self,
        t: ArrayLike,
        r: ArrayLike | Step | Steps | None = None,
        w: Sine | Step | None = None,
        x0: ArrayLike | None = None,
    ) -> Response | list[Response]:
        """`Response` of the loop; a list of them per vertex.

        Parameters
        ----------
        t : (k,) array_like
            Increasing times in seconds, from 0.
        r : (n,) array_like, Step or Steps, optional
            Set point; an array holds from t = 0 on.
        w : Sine or Step, optional
            Disturbance.
        x0 : (N,) array_like, optional
            Initial state; zero without it.
        """
        K = self._gain()
        self._second_order("displacement z")
        return self._each(lambda d: simulate(d, K, t, r, w, x0, self.K_A))


def _words(requirements):
    return ", ".join(r.words for r in requirements)
