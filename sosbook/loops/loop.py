"""One loop: a plant, a law with its numbers and, perhaps, the clock that runs it."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..analysis.margins import DiskMargin
from ..exact.checker.families import CONSTANT
from ..exact.proof import NOTHING
from ..exact.rational import exact
from ..laws import Law
from ..laws.taken import law_of, taken
from ..plants.checks import positive
from ..plants.descriptor_system import DescriptorSystem
from ..plants.gain import input_names, signals
from ..plants.joined import joined_family
from ..plants.kinds import checked_plant, every_plant
from ..plants.outputs import Output
from ..plants.response import Response, vector
from ..plants.sensed import asked_of, row_words
from ..requirements.base import Requirement
from ..requirements.shorthand import collected
from ..runtime.later import later
from ..runtime.libraries import library
from ..runtime.read_only import ReadOnly, frozen, put
from ..synthesis.design import Design
from ..synthesis.pid import analyse_pid
from ..synthesis.request import Request
from .as_data import loop_data, read_loop
from .clock import Clock, Late
from .signal import Signal, signals_of

MOMENTS = 1001  # of a simulation whose times nobody gave


@dataclass(frozen=True, eq=False, init=False)
class Loop(ReadOnly):
    """A plant, or every plant of a family, under a law with numbers.

    The same object answers in continuous time, with a clock, and with a late input:
    what the law measures, with what noise, and what it remembers stay the same.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope, Uncertain or DescriptorSystem
        Constant plants: a parameter doesn't move while the loop does.
    law : Law, optional
        What is measured and remembered; all of z and z' without it. A design, an
        `ObserverDesign`, a Controller or python-control's StateSpace, whose inputs and
        outputs are named, brings its law and its numbers along.
    gains : dict, array_like, Gain, design or StateSpace, optional
        The law's numbers, as in `analyse_pid`.
    clock : Clock or Late, optional
        See `at` and `late`; a Controller has its own.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(1, 0, 0, 1, F=[[1, 0]], coordinates=["place"])
    >>> law = sos.PIDLaw(position=[[1]], filter=0.02, noise=[[0, 1]])
    >>> loop = sos.Loop(cart, law, {"K_P": [[-1]], "K_D": [[-2]]})
    >>> [s.name for s in loop.signals if s.role == "memory"]
    ['filtered place']
    >>> noise = sos.Output(input=1), [1]
    >>> round(loop.norm(*noise)), round(loop.at(0.001).norm(*noise))
    (101, 101)
    >>> loop.at(0.01).prove().proven, loop.late(0.1).prove().proven
    (True, True)
    """

    plant: Any
    law: Any
    gains: Any
    clock: Clock | Late | None

    def __init__(
        self,
        plant: Any,
        law: Any = None,
        gains: Any = None,
        *,
        clock: Clock | Late | None = None,
    ) -> None:
        """Read the law, its numbers and the clock."""
        if gains is None and not isinstance(law, Law):
            law, gains = None, law
        if gains is None:
            raise ValueError("gains are missing: design_pid(plant, law=law) finds some")
        if hasattr(gains, "of_state"):  # a Controller
            if clock or law:
                raise ValueError("a Controller has a law and a clock: leave them out")
            clock = gains.clock
        else:
            law, gains = taken(checked_plant(plant), gains, law)
        if not isinstance(clock, (Clock, Late, type(None))):
            raise ValueError(f"clock must be a Clock or Late, got {clock!r}")
        law, gains = law_of(None, law), frozen(gains)
        put(self, plant=plant, law=law, gains=gains, clock=clock)

    def at(
        self, T: float, delay: float | tuple[float, float] = 0.0, jitter: float = 0.0
    ) -> "Loop":
        """The same law, run by a clock.

        Parameters
        ----------
        T, delay, jitter
            As in `Gains.controller`, in s.
        """
        return self._with(Clock(T, delay, jitter))

    def late(self, tau: float, mu: float = 0.0) -> "Loop":
        """The same law in continuous time, its input tau - mu to tau + mu s late."""
        return self._with(Late(tau, mu))

    def its_law(self) -> tuple:
        """The law and its numbers, for what takes any controller."""
        return self.law, self.gains

    def _with(self, clock):
        return Loop(self.plant, self.law, self.gains, clock=clock)

    # What it is made of

    @cached_property
    def design(self) -> Design:
        """The loop in continuous time as a `Design`, of which nothing is asked."""
        return Design(self.request, "undecided", self.request.gain, reason=NOTHING)

    @cached_property
    def request(self) -> Request:
        """The loop in continuous time as a `Request`, of which nothing is asked."""
        if hasattr(self.gains, "of_state"):
            raise ValueError(
                "a Controller has no loop of continuous time: take the design that it "
                "was made of, design.loop"
            )
        return Request(self.plant, gain=self.gains, law=self.law)

    @cached_property
    def controller(self) -> Any:
        """The `Controller` that its clock runs."""
        if hasattr(self.gains, "of_state"):
            return self.gains
        c = self.clock or (Clock(self.request.step) if self.request.step else None)
        if not isinstance(c, Clock):
            raise ValueError("this loop has no clock: take loop.at(T=...)")
        return self.design.controller(T=c.T, delay=c.delay, jitter=c.jitter)

    @property
    def ticks(self) -> list:
        """The loop from tick to tick of each vertex, `Ticks` in floats."""
        return self.controller.loops

    @property
    def open(self) -> DescriptorSystem:
        """The plant with the law's memory in it, and all its inputs [u; v] open."""
        return self._joined(self.request.applied.parts.joined)

    @cached_property
    def opened(self) -> tuple:
        """The loop where u enters the plant, (DescriptorSystem, K): with the memory
        closed in it, and the gain of u = K x that closes it. What takes a plant and a
        gain takes these two. Its numbers are the law's in decimals of 17 digits.
        """
        request = self.request
        parts, K = request.applied.parts, exact(request.gain)
        return self._joined(lambda d: parts.looped(d, K)), request.state_gain

    def _joined(self, function):
        """The plants under an affine ``function`` of each, in rationals."""
        plant = self.request.plant
        names = *signals(plant), *self.request.applied.parts.states
        known = dict(states=names, dt=getattr(plant, "dt", None))
        if plant.family is not None:
            return joined_family(plant.family, function, **known).polytope()
        several = [function(d.map(exact)) for d in Request(plant).vertices]
        several = [d.map(lambda x: x.astype(float)) for d in several]
        return DescriptorSystem.of(several, **known)

    @property
    def signals(self) -> tuple[Signal, ...]:
        """Every signal, by role, name and unit."""
        c = self.controller if isinstance(self.clock, Clock) else None
        return signals_of(checked_plant(self.plant), self.law, c)

    @property
    def scope(self) -> str:
        """Of which plants something is said that is proven."""
        return every_plant(checked_plant(self.plant), CONSTANT)

    # What is asked of it

    def prove(self, *requirements: Requirement, **how: Any) -> Any:
        """The proof of stability, and of the requirements.

        Parameters
        ----------
        *requirements : Requirement
            Any in continuous time; with a clock one bound of a norm; with a late input
            none, but ``delta`` for a decay.
        **how
            What `analyse_pid`, `certify_sampled` or `analyse_delay` take.
        """
        if self.clock is None:
            asked = dict(law=self.law, requirements=requirements)
            return analyse_pid(self.plant, self.gains, **asked, **how).certify()
        if isinstance(self.clock, Late):
            if requirements:
                raise ValueError(
                    "a loop whose input is late is proven to be stable, or to decay by "
                    "delta=...: no other requirement is proven there"
                )
            return self._analysed(**how).certify()
        if len(requirements) > 1:
            raise ValueError("at the ticks one norm is proven at a time: give one")
        return self.controller.certify(norm=(*requirements, None)[0], **how)

    def _analysed(self, **how):
        late = dict(tau=self.clock.tau, mu=self.clock.mu)
        return later("delay", "analyse_delay")(
            self.plant, self.gains, law=self.law, **late, **how
        )

    def poles(self) -> np.ndarray:
        """(vertices, N): poles in rad/s, or the eigenvalues from tick to tick; with a
        late input the rightmost characteristic roots.
        """
        if isinstance(self.clock, Clock):
            return np.array([np.linalg.eigvals(x.F) for x in self.ticks])
        design = self.design if self.clock is None else self._rooted
        return np.atleast_2d(design.poles())

    @cached_property
    def _rooted(self):
        """The loop with a late input, of which nothing is solved."""
        make, known = later("delay", "DelayDesign"), later("delay", "DelayRequest")
        plant, K = self.opened
        asked = known(plant, tau=self.clock.tau, mu=self.clock.mu, gain=K)
        return make(asked, "undecided", K)

    def norm(self, output: Output | None = None, inputs: Any = None) -> float:
        """The largest H-infinity norm over the vertices, in floats: no proof.

        Parameters
        ----------
        output : Output, optional
            As in `HInfinity`.
        inputs : sequence of int, optional
            Which disturbances. At the ticks w is held from one to the next.
        """
        (asked,) = collected(gamma=1.0)
        asked = replace(asked, outputs=output, inputs=inputs)
        if isinstance(self.clock, Clock):
            asked = asked_of(self.controller.plant, asked)
            pairs = zip(self.controller.vertices, self.ticks)
            return max(x.norm(asked.seen(d), inputs) for d, x in pairs)
        if self.clock is not None:
            raise ValueError(
                "the norm of a loop whose input is late isn't computed: take that of "
                "the loop at ticks, loop.at(T, delay).norm(...)"
            )
        request = self.request
        asked = request.applied.asked(asked).stepped(request.step)
        return asked.truth(request.vertices, request.state_gain)

    def static(self, r: Any = None, w: Any = None) -> tuple:
        """Where every vertex comes to rest: (x, u), (vertices, N) and (vertices, m).

        Parameters
        ----------
        r : (p,) array_like, optional
            Set points, of a loop with a clock.
        w : (p_w,) array_like, optional
            Constant disturbances.
        """
        if isinstance(self.clock, Clock):
            return self.controller.static(r, w)
        if r is not None:
            raise ValueError("r is for a loop with a clock: loop.at(T=...).static(r)")
        request, p = self.request, self.poles()
        if (abs(p).max() >= 1) if request.step else (p.real.max() >= 0):
            raise ValueError("this loop isn't stable: it comes to rest nowhere")
        K, N = request.state_gain, len(signals(request.plant))
        push = vector("w", None if w is None else np.atleast_1d(w), request.plant.p)
        V = request.vertices  # whose Bw has the noise
        x = np.array([-np.linalg.solve(d.A + d.Bu @ K, d.Bw @ push) for d in V])
        more = [0.0 if d.Uw is None else d.Uw @ push for d in V]
        return x[:, :N], np.array([K @ y + e for y, e in zip(x, more)])

    def simulate(self, t: Any, **more: Any) -> Response | Any:
        """The motion: `Design.simulate`, `Controller.simulate` or `simulate_delay`.

        Parameters
        ----------
        t : float or (k,) array_like
            For how many seconds, or the times; with a clock the ticks are the times.
        **more
            What these take.
        """
        if isinstance(self.clock, Clock):
            return self.controller.simulate(positive("t", t), **more)
        times = np.linspace(0, positive("t", t), MOMENTS) if np.ndim(t) == 0 else t
        design = self.design if self.clock is None else self._rooted
        return design.simulate(times, **more)

    def margins(self) -> DiskMargin:
        """The least `DiskMargin` at the plant's input, over the vertices.

        A memory goes on with the u that was meant. A gain of all states has margins
        that its observer may take away: Doyle, IEEE Trans. Automatic Control 23, 1978.
        """
        if isinstance(self.clock, Clock):
            peak = max(x.peak_of(0.5) for x in self.ticks)
            return DiskMargin(0.0 if peak == np.inf else float(1 / peak))
        if self.clock is not None:
            raise ValueError(
                "margins of a loop whose input is late aren't computed: take those of "
                "the loop at ticks, loop.at(T, delay).margins()"
            )
        return self.design.disk_margin()

    def largest(self, find: str, to: float | None = None, **how: Any) -> Any:
        """The largest T or delay up to ``to``, or the largest tau, mu or delta.

        Parameters
        ----------
        find : str
            "T" or "delay" of a loop with a clock, from its own on, or "tau", "mu",
            "delta" of one in continuous time.
        to : float, optional
            Where the search of T or the delay ends.
        **how
            What `furthest_sampled` or `delay.largest` take.
        """
        if find in ("T", "delay"):
            c = self.controller
            ends = dict(zip(("T", "delay"), c.clock.ranges))
            ends[find] = float(np.min(ends[find])), to
            furthest = later("sampled", "furthest_sampled")
            return furthest(c.plant, c, **ends, find=find, **how)
        if to is not None or isinstance(self.clock, Clock):
            raise ValueError("T and delay take a clock and to=; the rest takes neither")
        clock = self.clock or Late(1.0)
        start = dict(tau=clock.tau, mu=clock.mu) | how
        bare = Loop(self.plant, self.law, self.request.gain)
        return later("delay", "largest")(find, bare, **start)

    def to_c(self, name: str = "axis", **more: Any) -> Any:
        """Its program: see `Controller.to_c`, which takes ``name`` and ``more``."""
        return self.controller.to_c(name, **more)

    def data(self) -> dict:
        """All of it as JSON holds it: `read` makes the same loop of that."""
        plant = checked_plant(self.plant)
        return loop_data(plant, self.law, self.request.gain, self.clock)

    @classmethod
    def read(cls, data: dict) -> "Loop":
        """The loop of the ``data`` that `data` made; ValueError where they are bad."""
        plant, law, gains, clock = read_loop(data)
        return cls(plant, law, gains, clock=clock)

    def report(self, folder: Any, **more: Any) -> Any:
        """One page in a ``folder``: see `Gains.report`, which takes ``more``."""
        return self.design.report(folder, controller=self.controller, **more)

    def to_ss(self) -> Any:
        """The controller as python-control's StateSpace, with names.

        With a clock from [y; r] to u, see `Controller.to_ss`; else from what is
        measured to u, so that ``Loop(plant, loop.to_ss())`` is the same loop. A law's
        noise is no part of a controller: ``Loop(plant, law, loop.to_ss())`` has it.
        """
        if isinstance(self.clock, Clock):
            return self.controller.to_ss()
        request, plant = self.request, self.request.plant
        parts = request.applied.parts
        of_gain = parts.controller(exact(request.gain))
        A, B, C, D = (np.asarray(x, float) for x in of_gain)
        dt = request.step or 0
        if dt:  # the memory's change in a tick
            A, B = np.eye(len(A)) + dt * A, dt * B
        rows, names = parts.rows.astype(float).tolist(), signals(plant)
        inputs = [row_words(x, names, repr).replace(".", "_") for x in rows]
        outputs = list(input_names(plant.m))
        if len({*inputs}) < len(inputs):
            raise ValueError(f"two inputs would be called alike: {', '.join(inputs)}")
        return library("control").ss(A, B, C, D, inputs=inputs, outputs=outputs, dt=dt)


def opened(plant, K, U=None, law=None):
    """(plant, K, U) as what takes a gain of the state takes them, whatever the ``law``
    is, or K brings along: a law's loop is opened at u, and its memory is in the plant.
    """
    law, K = taken(plant, K, law, U)
    return (plant, K, law.U) if law.whole else (*Loop(plant, law, K).opened, None)
