"""Gains of a law that are searched on its sampled loop, and proven there."""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import expm

from ..display.card import card
from ..exact.definite import round_digits
from ..exact.proof import Unproven
from ..laws import Law
from ..plants.checks import positive
from ..plants.gain import GainParts
from ..plants.kinds import Plant
from ..requirements.pole_region import LMIRegion
from ..requirements.vocabulary import SIGMA
from ..runtime.read_only import ReadOnly
from ..runtime.threads import one_thread
from ..runtime.time_limit import LONGEST, OutOfTime, time_left, time_limit
from ..sampled.discretize import SampleTiming, input_vertices
from ..sampled.proof_file import SampledProof
from ..synthesis.request import Request
from ..synthesis.search import USUAL, Search
from ..synthesis.structured.continuation import Ended, further, why_ended
from ..synthesis.structured.design import DIGITS, Searched, record
from ..synthesis.structured.moving_gain import corners_of, loops_of
from ..synthesis.structured.objective import DECAY, LARGEST, Task
from ..synthesis.structured.search import Found, search, starting_points
from .clock import checked_delay
from .controller import Controller
from .of_design import check_rate, controller_of
from .report import write_report
from .tick_loops import FLOOR, Radius, TickLoops

EASIER = 1, 3, 10, 50  # times the backoff, until a proof is found
STARTS = 8
EDGE = 1e-9  # of the circle, that floats don't see
SEARCH = 0.5  # of the time, for the search; the rest is for the proof
STOPPED = (
    " The time was over when {} starts had begun: a longer time_limit goes further."
)


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
    proof : SampledProof or None
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

    at_ticks = True  # what K multiplies

    def __repr__(self):
        return f"<SampledDesign: {self.status}, {self.words}>"

    def _repr_html_(self):
        found = self.K is not None
        poles = np.atleast_2d(self.poles()) if found else ()
        gains, axis = self.gains.items() if found else (), "poles, from tick to tick"
        about = self._region(), tuple(gains), None, (self.reason,), axis
        return card("SampledDesign", self.status, poles, *about)

    def _region(self):
        return LMIRegion.disk(np.exp(-self.sigma * self.T), name="decay")

    @property
    def words(self) -> str:
        """The demand on the loop, in words."""
        if not self.sigma:
            return "the fastest decay at the ticks"
        return f"every motion decays at least as e^(-{self.sigma:.4g} t) at the ticks"

    @property
    def gains(self) -> dict[str, np.ndarray]:
        """The parts of K by name, {} without K; a `DynamicLaw`'s from tick to tick."""
        named = self.request.applied.named
        return GainParts({} if self.K is None else named(self.K))

    def _found(self):
        if self.K is None:
            raise ValueError(
                f"the design is {self.status}: there is no gain to take; its reason "
                f"says why. {self.reason}"
            )
        return self.K

    def controller(self, **asked: Any) -> Controller:
        """The controller that is proven, with ``units`` and ``counts``.

        Parameters
        ----------
        **asked
            As in `Gains.controller`.
        """
        self._found()
        return controller_of(self, T=self.T, delay=self.delay, **asked)

    def certify(self, time_limit: Any = None) -> SampledProof | Unproven:
        """The proof, found with the gain; a ``time_limit`` has nothing to end."""
        if self.proof is None:
            return Unproven(f"the design is {self.status}. {self.reason}")
        return self.proof

    def poles(self) -> np.ndarray:
        """Eigenvalues of the loop from tick to tick: (N,), or one row for a vertex."""
        loops = [loop.F for loop in self.controller().loops]
        return self.request.plant.per_vertex(np.linalg.eigvals(loops))

    def report(self, folder: Any, *, controller: Any = None, **asked: Any) -> Any:
        """A page of a ``controller`` in a ``folder``; ``asked``: see `Gains.report`."""
        return write_report(self, controller or self.controller(), folder, **asked)


@one_thread
def design_sampled(
    plant: Plant,
    law: Law,
    T: float,
    delay: float = 0.0,
    *,
    sigma: float | None = None,
    search: Search = USUAL,
    cells: int = 64,
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
        Without it the fastest one that the search finds, backed off; ``reason`` says
        what ended it.
    search : Search
        Its ``backoff`` is the share of the fastest decay that is given away for the
        proof; up to fifty times as much, where plants between the vertices need it.
    cells : int
        As in `certify_sampled`, which makes the proof.

    Returns
    -------
    SampledDesign
        Its ``controller()`` is what was proven. What isn't found, or isn't proven, is
        "undecided": ``reason`` has what was reached, and not that nobody can do it.

    Raises
    ------
    ValueError
        On bad input, or at a clock at which an unstable plant leaves every controller
        a poor loop.

    Notes
    -----
    The controller's loop is affine in the free numbers, and exact at the ticks. The
    largest modulus of its eigenvalues at all vertices is made small from several
    starts, as `design_pid` does it in continuous time.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(1, 0, 0, 1)
    >>> law = sos.PIDLaw(position=[[1]], filter=0.5)
    >>> design = sos.design_sampled(cart, law, T=0.5, delay=0.5, sigma=0.2)
    >>> print(design.certify())  # doctest: +NORMALIZE_WHITESPACE
    proven:
    - the sampled loop of the plant, with a tick every 0.5 s and a delay of 0.5 s,
      is stable: every motion decays at least as 0.904837418^k
    >>> design.controller().radius < 0.905
    True
    """
    T, delay = checked_delay(T, delay)
    if not (isinstance(law, Law) and law.searched):
        raise ValueError(
            f"law must be a PIDLaw or DynamicLaw, got {type(law).__name__}: for all "
            "states at once see design_sampled_lqr"
        )
    search.taking("backoff starts seed time_limit", "the search of a law's gain")
    if not search.backoff < 1:
        raise ValueError(f"backoff must be a share below 1, got {search.backoff!r}")
    asked = 1.0 if sigma is None else positive(SIGMA.key, sigma)
    request = Request(plant, law=law, requirements=[LMIRegion.half_plane(asked)])
    parts = request.applied.parts
    if parts.free not in (0, len(parts.states)):
        raise ValueError("law: of its own states all dynamics are free, or none")
    check_rate(input_vertices(request.plant, None), SampleTiming.of(T, delay))
    some = SampledDesign(request, T, delay, "undecided", None, sigma or 0.0)
    work = _Work(some, sigma, search.backoff, cells)
    return work.done(search.starts or STARTS, search.seed, search.time_limit)


class _Work:
    """A search of gains at the ticks, and the proof of what it finds, of a ``design``
    without a gain; ``sigma``, ``backoff``, ``cells``: as in `design_sampled`.
    """

    def __init__(self, design, sigma, backoff, cells):
        """Set the task of the search at the ticks: loops, limits, units."""
        self.design, self.sigma = design, sigma
        self.backoff, self.cells = backoff, cells
        request, goal = design.request, DECAY if sigma is None else None
        self.continuous = loops_of(request)
        self.slow, form = Task.of(request, self.continuous, goal), self.continuous.form
        rows = abs(form.directions).sum(axis=2).argmax(axis=1)
        self.pace = np.where(rows < request.plant.m, 1.0, design.T)  # of memory: a tick
        largest = LARGEST * self.continuous.units(1 / design.T)  # nothing is as fast
        ends = form.within(np.maximum(self.slow.limits, largest) * self.pace)
        self.task = replace(self.slow, ends=ends)
        limits = self.task.limits
        held = np.where(self.pace == 1, ends, [-limits, limits])  # of ticks, else
        self.slow = replace(self.slow, ends=held / self.pace)
        steps = limits / LARGEST
        gains = [self.continuous.K(x) for x in (0 * steps, *np.diag(steps))]
        made = [replace(design, K=K).controller() for K in gains]
        corners = corners_of(request).values()
        plants = [d.map(lambda x: x.astype(float)) for d in corners]
        self.loops = TickLoops(made, steps, form, plants)

    def done(self, starts, seed, seconds):
        """Search for some ``seconds``, and return the result with its proof."""
        best, found, stopped, ended = None, Found(None, np.inf, 0), "", Ended()
        self.kept = []  # (decay, numbers) of what was found on the way
        try:
            with time_limit(seconds):
                with time_limit(SEARCH * time_left()):
                    found = self._found(self.sigma, starts, seed)
                    if self.sigma is None and self._decay(found.kappa) > 0:
                        ask = partial(self._asked, starts, seed)
                        found, ended = further(found, self._decay, ask, 1)
                stopped = STOPPED.format(found.starts) * found.stopped
                if self._decay(found.kappa) > (self.sigma or 0):
                    self.kept.append((self._decay(found.kappa), found.kappa))
                    best = self._best()
        except OutOfTime:
            stopped = STOPPED.format(found.starts)
        by = record(self.task, self.loops, found.starts, seed, 0)
        if best is None or best.status != "feasible":
            words = f"{self._reason(found.kappa, best, by)}{stopped}"
            best = self.design
        else:
            ends, blocks = self.task.ends, self.continuous.form.blocks
            words = stopped or why_ended(ended, float, found.kappa, ends, blocks)
        return replace(best, reason=words.strip(), searched=by)

    def _found(self, sigma, starts, seed, near=()):
        """The result of a search for a decay of ``sigma``, or for the fastest."""
        rate = sigma or self.task.rate
        slow, task = (replace(t, rate=rate) for t in (self.slow, self.task))
        if sigma is not None:
            task = replace(task, goal=None)
        radius = 0.0 if sigma is None else np.exp(-sigma * self.design.T)
        size = min(1.0, rate * self.design.T)

        def objective(task, loops, unit, norms):
            return Radius(task, loops, unit, radius, size)

        ways = near, objective, partial(self._begin, slow)
        return search(task, self.loops, starts, seed, *ways)

    def _asked(self, starts, seed, sigma, kappa):
        found = self._found(sigma, starts, seed, (kappa,))
        if found.value < 0:
            self.kept.append((self._decay(found.kappa), found.kappa))
        return found

    def _begin(self, slow, task, loops, count, rng, near):
        """Those ``near``, and those of the loop in continuous time, a task ``slow``,
        taken from tick to tick.
        """
        unit = self.continuous.units(task.rate) * self.pace
        for kappa in near:
            yield unit, kappa / unit
        for unit, x in starting_points(slow, self.continuous, count, rng, ()):
            kappa, unit = self._held(unit * x), unit * self.pace
            yield unit, task.inside(kappa) / unit

    def _held(self, kappa):
        """The free numbers of a memory whose inputs are held over a tick."""
        K, c = self.continuous.K(kappa), self.design.request.applied.parts.free
        if not c:
            return kappa
        whole = np.zeros((K.shape[1],) * 2)
        whole[:c] = np.roll(K[-c:], c, axis=1)  # what it remembers, then what it sees
        K[-c:] = np.roll(expm(whole * self.design.T)[:c], -c, axis=1)
        M = self.continuous.directions.reshape(len(kappa), -1).T
        K = K - self.continuous.first
        return np.linalg.lstsq(M, K.ravel(), rcond=None)[0]

    def _decay(self, kappa):
        """In 1/s, at the vertices; not positive where floats see none."""
        if kappa is None:
            return -np.inf
        radius = abs(np.linalg.eigvals(self.loops.at(kappa))).max()
        return -np.log(max(radius + EDGE, FLOOR)) / self.design.T

    def _best(self):
        """The fastest design that is proven, of all numbers that were found: a gain
        that is fast at the vertices may not be so between; or the last that was tried.
        """
        best = None
        for decay, kappa in sorted(self.kept, key=lambda x: -x[0]):
            if best is not None and best.status == "feasible" and best.sigma >= decay:
                break
            design = self._proven(kappa)
            if best is None or (design and design.status == "feasible"):
                best = design
        if best is not None and best.status != "feasible":  # with more cells, in time
            best = self._with_proof(best, time_limit=min(time_left(), LONGEST))
        return best

    def _proven(self, kappa):
        """The design with the free numbers in few digits that is proven, else the last
        that was tried; None where each rounding is unstable.
        """
        design = None
        for digits in DIGITS:
            rounded = self.task.inside(round_digits(kappa, digits))
            asked = [self.sigma]
            if self.sigma is None:
                fast = self._decay(rounded)
                asked = [fast * (1 - k * self.backoff) for k in EASIER]
            for sigma in (x for x in asked if x > 0):
                K = self.continuous.K(rounded)
                design = self._with_proof(replace(self.design, K=K, sigma=sigma))
                if design.status == "feasible":
                    return design
        return design

    def _with_proof(self, design, **asked):
        rate = float(np.floor(np.exp(-design.sigma * design.T) * 1e9) / 1e9)
        proof = design.controller().certify(rate=rate, cells=self.cells, **asked)
        status = "feasible" if proof.proven else "undecided"
        return replace(design, proof=proof, status=status)

    def _reason(self, kappa, best, by):
        words, decay = f"No stable loop was found by {by}.", self._decay(kappa)
        if decay > 0:
            decay = f"{decay:.4g} 1/s at the vertices"
            asked = "" if self.sigma is None else f" (asked: {self.sigma:.4g})"
            words = (
                f"The nearest gain reaches a decay of {decay}{asked}, found by {by}."
            )
        if best is not None:
            words = f"{words} It isn't proven: {', '.join(best.proof.failed)}."
        return f"{words} Sample faster, act earlier, measure more, or ask for less."
