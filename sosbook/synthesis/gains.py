"""The gain of a design of u = K x, part by part, whatever the theorem."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..plants.gain import Gain, GainParts
from ..plants.second_order import Polytope, SecondOrderSystem
from ..runtime.later import later
from .result import Proven, Result

if TYPE_CHECKING:
    from .schedule import ScheduledGain

WHOLE = "This is said {}. What is left out may do anything: look at the whole plant."


class Gains(Result[Proven]):
    """K in parts, for results with a ``request``."""

    K: Any
    request: Any

    def __repr__(self):
        condition = "" if self.margins else getattr(self, "condition", "")
        return super().__repr__().replace(">", f" {condition}>" if condition else ">")

    def _next(self):
        part = getattr(self.request.plant, "reduction", None)
        said = "" if part is None else WHOLE.format(part.words[:-2])
        return (*super()._next(), said)

    @property
    def gain(self) -> Gain:
        """K with the names of what it multiplies.

        ``design.gain.but(design.certify().K)`` is the proven one.
        """
        return Gain(super()._gain(), self.request.applied.signals)

    def controller(
        self,
        measured: Sequence[str] | None = None,
        *,
        T: float | None = None,
        delay: float | tuple[float, float] = 0.0,
        jitter: float = 0.0,
        units: dict[str, str] | None = None,
        counts: float | dict[str, float] | None = None,
        memory: str | None = None,
        filter_time: float | None = None,
        peak: float = 2.0,
        time_limit: float | None = None,
    ) -> Any:
        """The gain as a sampled controller: what a computer does with it.

        A design with a ``law`` has its sensors and its memory from there, see
        `sosbook.controllers.of_law`: ``measured``, ``memory``, ``filter_time`` and
        ``peak`` are for designs without.

        Parameters
        ----------
        measured : sequence of str, optional
            Names of what is measured, of the plant's ``coordinates`` (z1, z2, ...
            without names) and their rates such as "z1'"; everything without it.
        T : float
            Time between samples, in s. Of a plant of discrete time its own ``dt``,
            also without it: u(k), computed after y(k) is measured, acts until k + 1, as
            in the plant's equations, which may have more delay in their states.
        delay : float or (low, high)
            From a sample to the actuator, in s. Of a range: the program is made for
            the latest, and proven for every sequence of them; over several ticks, too,
            where the actuator holds the newest command that has arrived.
        jitter : float
            By how much a tick may be early or late, in s: the loop is proven for
            every sequence of intervals from T - jitter to T + jitter, and the program
            takes such ticks without a fault.
        units : dict, optional
            Units of coordinates and inputs, by name.
        counts : float or dict, optional
            Of an encoder, a turn of an angle (in rad unless its unit is deg) or a unit.
        memory : {"observer", "filter"}, optional
            How what isn't measured is estimated. By default by an observer: the
            quietest Kalman filter whose loops with all plants keep their ``peak``.
        filter_time : float, optional
            Rates are differences of samples, filtered with this time constant, in s.
        peak : float
            How large the sensitivity at the plant's input may be, sampled.
        time_limit : float, optional
            Seconds for the proof of the gain.

        Returns
        -------
        sosbook.controllers.Controller
            With the certified gain; `Controller.certify` proves its sampled loop.

        Raises
        ------
        ValueError
            Where a name is none of the plant's, what is integrated or unstable isn't
            measured, or no controller, or none with this gain, can do it at T; or a
            law's filter is faster than T.
        """
        return later("controllers", "controller_of")(
            self,
            measured,
            T=T,
            delay=delay,
            jitter=jitter,
            units=units,
            counts=counts,
            memory=memory,
            filter_time=filter_time,
            peak=peak,
            time_limit=time_limit,
        )

    @property
    def gains(self) -> dict[str, np.ndarray]:
        """The parts of K by name: K_P, K_D, K_I, or those of the law; {} without K."""
        if self.K is None:
            return GainParts({})
        plain = self.request.law.whole and getattr(self.request, "K_A", None) is None
        return GainParts(self._matrices(), self.gain.signals if plain else ())

    @property
    def loop(self) -> Any:
        """The `Loop` of the plant under this gain."""
        plant, (law, K) = self.request.plant, self.its_law()
        known = getattr(plant, "sensed", None)
        return later("loops", "Loop")(known.bare if known else plant, law, K)

    @property
    def schedule(self) -> "ScheduledGain":
        """The gain as a function of what is measured, a ``ScheduledGain``."""
        from .schedule import ScheduledGain

        return ScheduledGain(self)

    def its_law(self) -> tuple:
        """The law and its numbers, by name where K is the gain of all states."""
        law = self.request.law
        return (law, self) if law.whole else (law.given or law, super()._gain())

    def _gain(self):
        """The gain from the state to u; with a law its K is another one."""
        K = super()._gain()
        return K if self.request.law.whole else self.request.state_gain

    def report(
        self,
        folder: Any,
        measured: Sequence[str] | None = None,
        *,
        name: str = "axis",
        replace: bool = False,
        controller: Any = None,
        pdf: bool = False,
        step: Any = None,
        **asked: Any,
    ) -> Any:
        """One page of all that is known of the controller, its proofs and its program.

        Parameters
        ----------
        folder : str or Path
            Where it goes; index.html needs no other file to be read.
        measured : sequence of str, optional
            As for `controller`.
        name : str
            Of the program.
        replace : bool
            Files that are there with another text are replaced.
        controller : Controller, optional
            With limits and more; in the place of ``measured`` and ``asked``.
        pdf : bool
            A Chromium prints the page as index.pdf, too.
        step : float or (p,) array_like, optional
            Of each set point, that is shown: see `Controller.to_c`.
        **asked
            As for `controller`.

        Returns
        -------
        Path
            Of index.html.

        Raises
        ------
        FileNotFoundError
            If ``pdf`` asks for a Chromium and none is on the PATH.
        """
        self._gain()
        made = controller or self.controller(measured, **asked)
        write = later("controllers", "write_report")
        return write(self, made, folder, name, replace, pdf, step)

    def statements(self) -> list[str]:
        """Each requirement in a sentence; a design without any asks for stability."""
        from ..exact.proof import NOTHING

        if getattr(self, "reason", "") == NOTHING:
            return [NOTHING]
        return [r.statement for r in self.request.requirements] or ["it is stable"]

    @property
    def K_P(self) -> np.ndarray:
        """Proportional gain, (m, n)."""
        return self._parts()[0]

    @property
    def K_D(self) -> np.ndarray:
        """Derivative gain, (m, n)."""
        return self._parts()[1]

    @property
    def K_I(self) -> np.ndarray:
        """Integral gain, (m, a)."""
        return self._parts()[2]

    def _matrices(self):
        return tuple(self.request.applied.named(self.K).items())

    def _parts(self):
        if not self.request.law.whole:
            raise ValueError("the gains of a law are gains[name], or K whole")
        self._second_order("K_P, K_D and K_I")
        return list(self.request.applied.named(self._gain()).values())

    def _second_order(self, wanted):
        """The plant, or a ValueError if it has no second-order form."""
        plant = self.request.plant
        if not isinstance(plant, (SecondOrderSystem, Polytope)):
            raise ValueError(
                f"a {type(plant).__name__} has no {wanted}: its state isn't "
                "[z; z'; x3]; use K and the matrices"
            )
        return plant
