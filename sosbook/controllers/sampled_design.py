"""Gains of a law that are searched on its sampled loop, and proven there."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import expm

from ..display.card import card
from ..exact.definite import round_digits
from ..exact.proof import Unproven
from ..laws import Law
from ..plants.checks import count, positive
from ..plants.gain import Gain
from ..plants.kinds import Plant
from ..plants.simplex import random_weights
from ..requirements.pole_region import LMIRegion
from ..requirements.vocabulary import SIGMA
from ..runtime.read_only import ReadOnly
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, time_limit
from ..sampled.certificate import SampledCertificate
from ..sampled.discretize import SampleTiming, input_vertices
from ..synthesis.request import Request
from ..synthesis.structured.design import AGAIN, DIGITS, FEW, Searched, record
from ..synthesis.structured.loops import corners_of, loops_of
from ..synthesis.structured.objective import DECAY, Objective, Task
from ..synthesis.structured.search import search, starting_points
from ..synthesis.structured.slopes import Poles
from .controller import Controller, checked_delay
from .of_design import check_rate, controller_of, mixed
from .of_law import Ticks

CIRCLE = (-np.eye(2), np.array([[0.0, 1.0], [0.0, 0.0]]), 1.0)  # |z| - 1 is its level
FLOOR = 0.05  # of the spectral radius: nothing is asked to die out faster
EASIER = 1, 3, 10  # times the backoff, until a proof is found
WORSE = 0.01  # of what is left to one: so much a plant between may be slower
BETWEEN = 50  # random plants between several vertices that a gain is tried with
RATE_DIGITS = 6
EDGE = 1e-9  # of the circle, that floats don't see
STOPPED = " The time was over before."


@dataclass(frozen=True, eq=False, repr=False)
class SampledDesign(ReadOnly):
    """The gains of a law for one clock, and what is known of their sampled loop.

    Parameters
    ----------
    request : Request
        The plant and the law.
    T, delay : float
        Time between samples, and from a sample to the actuator, in s.
    status : {"feasible", "undecided"}
        "feasible": the decay is proven for every plant.
    K : (m + free, q) array or None
        The gain of the law's signals, as it was proven.
    sigma : float
        The decay in 1/s that is proven, or that was asked.
    proof : SampledCertificate or None
        Of the controller's loop.
    reason : str
        What was reached, where nothing is proven.
    searched : Searched or None
        How the gain was searched.
    """

    request: Request
    T: float
    delay: float
    status: str
    K: np.ndarray | None
    sigma: float
    proof: Any = None
    reason: str = ""
    searched: Searched | None = None

    at_ticks = True

    def __repr__(self):
        return f"<SampledDesign: {self.status}, {self.words}>"

    def _repr_html_(self):
        found = self.K is not None
        return card(
            "SampledDesign",
            self.status,
            np.atleast_2d(self.poles()) if found else (),
            self._region(),
            tuple(self.gains.items()) if found else (),
            None,
            (self.reason, self.advice),
            "poles, from tick to tick",
        )

    @property
    def _law(self):
        return self.request.law

    @property
    def advice(self) -> str:
        """What to change, in words; empty if feasible."""
        if self.status == "feasible":
            return ""
        return "Sample faster, act earlier, measure more, or ask for less."

    @property
    def words(self) -> str:
        """What is asked of the loop."""
        return f"every motion decays at least as e^(-{self.sigma:.4g} t) at the ticks"

    @property
    def gain(self) -> Gain:
        """K with the names of what it multiplies."""
        K = self._found()
        return Gain(K[: self.request.plant.m], self.request.law_parts.signals)

    @property
    def gains(self) -> dict[str, np.ndarray]:
        """The parts of K by name; those of a `DynamicLaw` are from tick to tick."""
        return self._law.structure(self.request.plant).named(self._found())

    def _found(self):
        if self.K is None:
            raise ValueError(
                f"the design is {self.status}: there is no gain; see its reason"
            )
        return self.K

    def _region(self):
        return LMIRegion.disk(np.exp(-self.sigma * self.T), name="decay")

    def controller(
        self,
        *,
        units: dict[str, str] | None = None,
        counts: float | dict[str, float] | None = None,
    ) -> Controller:
        """The controller that is proven, with units and encoders.

        ``units``, ``counts`` : as in `Gains.controller`.
        """
        self._found()
        asked = dict(T=self.T, delay=self.delay, units=units, counts=counts)
        return controller_of(self, **asked)

    def certify(self, time_limit: Any = None) -> SampledCertificate | Unproven:
        """The proof of the decay, which was found with the gain."""
        if self.proof is None:
            return Unproven(f"the design is {self.status}. {self.reason}")
        return self.proof

    def poles(self) -> np.ndarray:
        """Eigenvalues of the loop from tick to tick, of each vertex.

        Returns
        -------
        (N,) array, or (vertices, N) for a polytope
        """
        return self.request.plant.per_vertex(
            np.array([np.linalg.eigvals(loop.F) for loop in self.controller().loops])
        )

    def report(self, folder: Any, *, controller: Any = None, **asked: Any) -> Any:
        """One page of the controller, its proof and its program; see `Gains.report`."""
        from .report import write_report

        return write_report(self, controller or self.controller(), folder, **asked)


@one_thread
def design_sampled(
    plant: Plant,
    law: Law,
    T: float,
    delay: float = 0.0,
    *,
    sigma: float | None = None,
    backoff: float = 0.01,
    starts: int = 8,
    seed: int = 0,
    cells: int = 64,
    time_limit: float = 300.0,
) -> SampledDesign:
    """Search the gains of a law on its sampled loop, and prove its decay.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope, Uncertain or DescriptorSystem
        With a regular mass.
    law : PIDLaw or DynamicLaw
        What is measured, and which gains are free. Filters are sampled as
        `Gains.controller` samples them; the matrices of a `DynamicLaw` are those from
        one tick to the next, x_c(k+1) = A_c x_c(k) + B_c y(k).
    T, delay : float
        Time between samples, and from a sample to the actuator, in s.
    sigma : float, optional
        The decay in 1/s: at the ticks every motion decays at least as e^(-sigma t).
        Without it the fastest one that the search finds, backed off.
    backoff : float
        Which share of the fastest decay is given away for the proof; up to ten times
        as much, where plants between the vertices need it.
    starts, seed, time_limit
        As in `design_pid`.
    cells : int
        As in `certify_sampled`, which makes the proof.

    Returns
    -------
    SampledDesign
        Its ``controller()`` is what was proven. What the search doesn't find, or isn't
        proven, is "undecided", and ``reason`` has what was reached: that nobody can do
        it isn't said.

    Raises
    ------
    ValueError
        On bad input, or at a clock at which an unstable plant leaves every controller
        a poor loop.

    Notes
    -----
    The plant is held exactly between the ticks, by one exponential of a matrix; what
    follows is affine in the gain. The largest modulus of an eigenvalue at all vertices
    is made small from several starts, as `design_pid` does it in continuous time.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(1, 0, 0, 1)
    >>> law = sos.PIDLaw(position=[[1]], filter=0.5)
    >>> design = sos.design_sampled(cart, law, T=0.5, delay=0.5, sigma=0.2)
    >>> print(design.certify())
    proven:
    - the sampled loop of the plant is stable: every motion decays at least as \
0.904837^k
    >>> design.controller().radius < 0.905
    True
    """
    T, delay = checked_delay(T, delay)
    if not isinstance(law, Law):
        raise ValueError(
            f"law must be a PIDLaw or DynamicLaw, got {type(law).__name__}: for all "
            "states at once see design_sampled_lqr"
        )
    asked = 1.0 if sigma is None else positive(SIGMA.key, sigma)
    request = Request(plant, law=law, requirements=[LMIRegion.half_plane(asked)])
    timing = SampleTiming.of(T, delay)
    check_rate(input_vertices(request.plant, None), timing)
    work = _Work(request, T, delay, sigma, positive("backoff", backoff), cells)
    return work.done(count("starts", starts, 1), count("seed", seed), time_limit)


class _Work:
    """A search of gains at the ticks, and the proof of what it finds."""

    def __init__(self, request, T, delay, sigma, backoff, cells):
        self.request, self.T, self.delay, self.sigma = request, T, delay, sigma
        self.backoff, self.cells = backoff, cells
        self.asked = 1.0 if sigma is None else np.exp(-sigma * T)
        self.continuous = loops_of(request)
        goal = DECAY if sigma is None else None
        self.slow = Task.of(request, self.continuous, goal)
        self.ticks = Ticks(request.law.parts(request.plant), SampleTiming.of(T, delay))
        plants = [self.ticks.joined(d) for d in corners_of(request).values()]
        self.loops = self.ticks.loops(plants, self.continuous.form)
        rows = abs(self.loops.directions).sum(axis=2).argmax(axis=1)
        self.pace = np.where(rows < request.plant.m, 1.0, T)  # what moves in a tick
        self.task = replace(self.slow, limits=self.slow.limits * self.pace)

    def done(self, starts, seed, seconds):
        best, found, total, between, stopped = None, None, 0, 0, ""
        try:
            with time_limit(seconds):
                for again in range(AGAIN):
                    near = () if found is None else (found.kappa,)
                    found = search(
                        self.task, self.loops, FEW if again else starts, seed, near,
                        self._objective, self._begin,
                    )  # fmt: skip
                    total += found.starts
                    if not self._radius(found.kappa) < min(self.asked, 1 - EDGE):
                        break
                    worse = self._worse(found.kappa)
                    if worse is None:
                        best = self._proven(found.kappa)
                        break
                    self.loops, between = self.loops.with_more([worse]), between + 1
        except OutOfTime:
            stopped = STOPPED
        by = record(self.task, self.loops, total, seed, between)
        if best is None or best.status != "feasible":
            best = self._undecided(found, best, by, stopped)
        return replace(best, searched=by)

    def _objective(self, task, loops, unit, norms):
        radius = 0.0 if self.sigma is None else self.asked
        return _Radius(task, loops, unit, radius, min(1.0, task.rate * self.T))

    def _begin(self, task, loops, count, rng, near):
        """Those of the loop in continuous time, taken from tick to tick."""
        first = self.continuous.units(task.rate) * self.pace
        for kappa in near:
            yield first, kappa / first
        for unit, x in starting_points(self.slow, self.continuous, count, rng, ()):
            kappa, unit = self._held(unit * x), unit * self.pace
            yield unit, np.clip(kappa, -task.limits, task.limits) / unit

    def _held(self, kappa):
        """The free numbers of a memory whose inputs are held over a tick."""
        m, K = self.request.plant.m, self.continuous.K(kappa)
        if len(K) == m:
            return kappa
        c = len(K) - m
        whole = np.zeros((K.shape[1], K.shape[1]))
        whole[:c] = np.roll(K[m:], c, axis=1)  # what it remembers, then what it sees
        K = np.vstack([K[:m], np.roll(expm(whole * self.T)[:c], -c, axis=1)])
        M = self.continuous.directions.reshape(len(kappa), -1).T
        return np.linalg.lstsq(M, K.ravel(), rcond=None)[0]

    def _radius(self, kappa):
        if kappa is None:
            return np.inf
        return abs(Poles(self.loops, self.loops.K(kappa)).s).max()

    def _worse(self, kappa):
        """A plant between the vertices that breaks what all of these keep."""
        vertices, K = input_vertices(self.request.plant, None), self.loops.K(kappa)
        if len(vertices) == 1:
            return None
        weights = random_weights(len(vertices), BETWEEN, 0)
        plants = [self.ticks.joined(mixed(vertices, w)) for w in weights]
        some = self.ticks.loops(plants, self.loops.form)
        there = abs(Poles(some, K).s).max(axis=1)
        limit = self._radius(kappa) if self.sigma is None else self.asked
        k = int(there.argmax())
        return plants[k] if there[k] > limit + WORSE * (1 - limit) else None

    def _proven(self, kappa):
        """The design with the free numbers in few digits that is proven."""
        for digits in DIGITS:
            K = self.loops.K(round_digits(kappa, digits))
            fast = -np.log(abs(Poles(self.loops, K).s).max()) / self.T
            asked = [self.sigma]
            if self.sigma is None:
                asked = [fast * (1 - k * self.backoff) for k in EASIER]
            for sigma in asked:
                design = self._design(K, sigma)
                rate = _rate(sigma * self.T)
                proof = design.controller().certify(rate=rate, cells=self.cells)
                design = replace(design, proof=proof)
                if proof.proven:
                    return replace(design, status="feasible")
        return design

    def _design(self, K, sigma, **more):
        return SampledDesign(
            self.request, self.T, self.delay, "undecided", K, sigma, **more
        )

    def _undecided(self, found, best, by, stopped):
        words, sigma = f"No stable loop was found by {by}.", self.sigma or 0.0
        radius = np.inf if found is None else self._radius(found.kappa)
        if found is not None and found.stopped:
            stopped = STOPPED
        if radius < 1 - EDGE:
            words = (
                f"The nearest gain reaches a decay of {-np.log(radius) / self.T:.4g} "
                f"1/s at the vertices{f' (asked: {sigma:.4g})' * bool(sigma)}, found "
                f"by {by}."
            )
        if best is not None:
            words = f"{words} It isn't proven: {', '.join(best.proof.failed)}."
        return self._design(None, sigma, reason=words + stopped)


class _Radius(Objective):
    """The largest modulus of an eigenvalue less a radius, in units of a size."""

    def __init__(self, task, loops, unit, radius, size):
        super().__init__(task, loops, unit, False)
        self.radius, self.size = radius, size

    def _of(self, K):
        poles = Poles(self.loops, K)
        if not np.isfinite(poles.s).all():
            return np.inf, 0 * K
        level, *where = poles.worst([CIRCLE])
        if level + 1 < FLOOR:
            return (FLOOR - self.radius) / self.size, 0 * K
        return (level + 1 - self.radius) / self.size, poles.slope(*where) / self.size


def _rate(decay):
    """e^-decay, in a few digits and not above."""
    rate = np.exp(-decay)
    digits = float(f"{rate:.{RATE_DIGITS}g}")
    return digits if digits <= rate else float(f"{rate * (1 - 1e-5):.{RATE_DIGITS}g}")
