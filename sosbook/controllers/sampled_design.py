"""Gains of a law that are searched on its sampled loop, and proven there."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..display.card import card
from ..exact.proof import Unproven
from ..laws import Law
from ..plants.checks import positive
from ..plants.gain import GainParts
from ..plants.kinds import Plant
from ..requirements.pole_region import LMIRegion
from ..requirements.vocabulary import SIGMA
from ..runtime.read_only import ReadOnly
from ..runtime.threads import one_thread
from ..sampled.discretize import SampleTiming, input_vertices
from ..sampled.proof_file import SampledProof
from ..synthesis.request import Request
from ..synthesis.search import USUAL, Search
from ..synthesis.structured.design import Searched
from .clock import checked_delay
from .controller import Controller
from .demands import checked, statement
from .of_design import check_rate, controller_of
from .report import write_report
from .sampled_search import SampledSearch

STARTS = 8


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
        "feasible": the decay, and what else was asked, is proven for every plant.
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
    requirements : tuple
        What else was asked at the ticks.
    kept : tuple
        The proof of each of them: a SampledProof, or the StepBounds of a step.
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
    requirements: tuple = ()
    kept: tuple = ()

    at_ticks = True  # what K multiplies
    pole_axis = "poles, from tick to tick"  # below the picture of its poles

    def __repr__(self):
        true = "" if self.K is None else f"; in floats {self.decay:.4g} 1/s"
        return f"<SampledDesign: {self.status}, {self.words}{true}>"

    def _repr_html_(self):
        found = self.K is not None
        poles = np.atleast_2d(self.poles()) if found else ()
        gains = tuple(self.gains.items()) if found else ()
        about = self._region(), gains, None, (self.reason,), self.pole_axis
        return card("SampledDesign", self.status, poles, *about)

    def _region(self):
        return LMIRegion.disk(np.exp(-self.sigma * self.T), name="decay")

    @property
    def words(self) -> str:
        """The demand on the loop, in words."""
        words = "the fastest decay at the ticks"
        if self.sigma:
            words = (
                f"every motion decays at least as e^(-{self.sigma:.4g} t) at the ticks"
            )
        return "; ".join([words, *map(statement, self.requirements)])

    def statements(self) -> list[str]:
        """The demand on the loop in a sentence."""
        return [self.words]

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

    @property
    def decay(self) -> float:
        """The slowest vertex's decay at the ticks, in 1/s and in floats; `sigma` was
        asked.
        """
        return float(-np.log(np.abs(self.poles()).max()) / self.T)

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
    requirements: Iterable = (),
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
    requirements : iterable, optional
        What else is asked at the ticks, and proven: an `HInfinity` of a channel, an
        `LMIRegion.disk` of z, a `StepLimits` of `sosbook.controllers`. Without
        ``sigma`` the decay is the fastest that keeps them.
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
    more = checked(requirements, request.plant)
    some = SampledDesign(
        request, T, delay, "undecided", None, sigma or 0.0, requirements=more
    )
    work = SampledSearch(some, sigma, search.backoff, cells)
    return work.done(search.starts or STARTS, search.seed, search.time_limit)
