"""A controller as an object: its signals, its memory, its limits, its clock."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..loops.clock import Clock
from ..plants.gain import Gain, input_names
from ..sampled.discretize import SampleTiming
from ..sampled.system import SampledSystem
from ..sampled.ticks import Ticks
from .bounds import proven_decay
from .clock import checked_slack, timing_of, vertices_of
from .facts import facts_of
from .limits import Faults, Limits, limits_of
from .matrices import from_state, matrices_of, start_of, state_space
from .memory import Estimate
from .motions import Motions
from .output_bounds import OutputBounds
from .program import Code
from .questions import Questions
from .set_points import followed_of, set_points_of, with_set_point
from .signals import Readings, signals_of
from .step_bounds import described


def _part(name: str, about: str) -> Any:
    """A property: the matrix of this name among a controller's parts."""

    def part(self):
        return self.parts[name]

    return property(part, doc=about)


@dataclass(frozen=True, eq=False, repr=False)
class Controller(Questions):
    """A sampled controller that is made of a proven gain, and all that it needs.

    x(k+1) = A x + B y + B_r r + W (v - u), u = C x + D y + D_r r, where y is measured,
    r are the set points and v is what is left of u after the limits. `limit`,
    `set_point` and `watch` return another controller; none of them changes one.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
        What it controls.
    gain : Gain
        The proven gain, in the decimals that were proven.
    estimate : Estimate
        How the state is estimated.
    readings : Readings
        What is measured, and how fine.
    clock : Clock
        When it runs; where its times are ranges `certify` proves the loop for these.
    U : (a, n) array or None
        What is integrated of the coordinates, or of a law's readings.
    sums : (a, q) array
        What is integrated, of what is measured.
    R : (n, p) array
        Set points of the coordinates, or of a law's readings, for one unit of each.
    limits : Limits
        Of outputs and set points.
    faults : Faults
        When it gives up.
    units : dict
        Of coordinates and inputs, by name.
    certificate : object
        The proof of the gain, in continuous time; None without.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(1, 0, 0, 1, coordinates=["place"])
    >>> design = sos.design_pid(cart, region=sos.PoleRegion(1, rho=9))
    >>> controller = design.controller(
    ...     ["place"], T=0.01, delay=0.01, units={"place": "m"})
    >>> print(controller.readings.signals[0], controller.order)
    place (m) 3
    >>> print(controller.radius < 1)
    True
    >>> controller.certify().proven, controller.furthest(tolerance=0.1).proven
    (True, True)
    """

    plant: Any
    gain: Gain
    estimate: Estimate
    readings: Readings
    clock: Clock
    U: Any
    sums: np.ndarray
    R: np.ndarray
    limits: Limits
    faults: Faults = field(default_factory=Faults)
    units: dict = field(default_factory=dict)
    certificate: Any = None

    def __repr__(self):
        return described(self)

    @property
    def T(self) -> float:
        """The time between samples in s, as it is meant."""
        return self.clock.T

    @property
    def delay(self) -> float:
        """The latest time from a sample to the actuator, in s."""
        return self.clock.latest

    @cached_property
    def vertices(self) -> tuple:
        """The plant's, a `Descriptor` each, without integrators."""
        return tuple(vertices_of(self.plant))

    @cached_property
    def outputs(self) -> tuple:
        """The outputs, a `Signal` each."""
        return signals_of(input_names(self.vertices[0].Bu.shape[1]), self.units)

    @cached_property
    def timing(self) -> SampleTiming:
        """Its clock, in exact rationals."""
        return timing_of(self.plant, self.T, self.delay)

    @property
    def gains(self) -> tuple:
        """The gain of what is estimated, a state or signals, and of the integrals."""
        return tuple(np.split(self.gain.K, [len(self.estimate.take)], axis=1))

    @cached_property
    def parts(self) -> dict:
        """Its matrices by name, in decimals, and the ``states`` that it remembers."""
        return matrices_of(self)

    @property
    def states(self) -> tuple:
        """The name of each entry of the memory."""
        return (*self.parts["states"], *self.gain.signals[len(self.estimate.take) :])

    A = _part("A", "How the memory moves, (l, l).")
    B = _part("B", "How y acts on it, (l, q).")
    B_r = _part("B_r", "How r acts on it, (l, p).")
    C = _part("C", "How it acts on u, (m, l).")
    D = _part("D", "How y acts on u, (m, q).")
    D_r = _part("D_r", "How r acts on u, (m, p).")
    W = _part("W", "How v - u acts on it, (l, m).")

    @property
    def order(self) -> int:
        """How many numbers it remembers."""
        return len(self.A)

    @cached_property
    def set_points(self) -> tuple:
        """A `Signal` for each set point."""
        return set_points_of(self)

    @cached_property
    def followed(self) -> list:
        """For each set point the index of what is measured of it, or None."""
        return followed_of(self)

    @cached_property
    def start(self) -> np.ndarray:
        """(l, q): the memory at the start, of what is measured there. The machine is
        taken to be at rest, and the integrals so that it is asked nothing.
        """
        return start_of(self)

    def set_point(
        self, r: Any = None, ramp: Any = None, b: float = 1, profile: Any = None
    ) -> "Controller":
        """Choose what a set point asks of all coordinates.

        Parameters
        ----------
        r : (n, p) array_like, optional
            The coordinates' set points for one unit of each set point, with U r = I.
            Without it K_P r asks as little as can be: a step overshoots less.
        ramp : float or dict, optional
            How fast a set point is followed, per second, one number or by its name.
        b : float
            P sees y - b r, the integral y - r: see `OutputBounds.weights`.
        profile : Profile, optional
            Of the moves of the first set point, from `Motions` or its `Motions.move`:
            `to_c` writes their generator, <name>_move.h, and bounds all of them.

        Raises
        ------
        ValueError
            If U r isn't I, or nothing is there to be set, or integrated for a b; or the
            profile's T is another.
        """
        return with_set_point(self, r, ramp, b, profile)

    def limit(
        self,
        u_max: Any = None,
        slew: Any = None,
        tracking_time: float | None = None,
        *,
        anti_windup: bool = True,
        load: Any = None,
    ) -> "Controller":
        """Bound the outputs, and tell the integral what is withheld; or the memory of
        a `DynamicLaw` that doesn't forget by itself.

        Parameters
        ----------
        u_max, slew : float or dict, optional
            Largest output and its change per second, one number or by name.
        tracking_time : float, optional
            With which the integral follows, in s; without it the geometric mean of T
            and the loop's slowest time constant.
        anti_windup : bool
            Whether it follows at all.
        load : (p_w,) array_like, optional
            A constant disturbance that must be held within the limit.

        Raises
        ------
        ValueError
            If it is below what the load needs, or twice what sensors' steps can ask.
        """
        found = limits_of(self, u_max, slew, load, anti_windup, tracking_time)
        return replace(self, limits=found)

    def watch(self, **faults: Any) -> "Controller":
        """With other ``faults``, such as ``lost=0.01``, in seconds: see `Faults`. A
        ValueError says where ticks that are proven would be counted as faults.
        """
        watched = replace(self.faults, **faults)
        slack = checked_slack(watched.slack, self.clock)
        return replace(self, faults=replace(watched, slack=slack))

    @property
    def bounds(self) -> OutputBounds:
        """Proven bounds of what sensors and set points do to its outputs."""
        return OutputBounds(self)

    @property
    def motions(self) -> Motions:
        """Motions of its set points within velocity, acceleration and jerk."""
        return Motions(self)

    @cached_property
    def of_state(self) -> SampledSystem:
        """From the plant's state x, and from w by what is read, to u: see `certify`."""
        return from_state(self)

    def to_ss(self) -> Any:
        """python-control's StateSpace from [y; r] to u, with names, "_" for points."""
        return state_space(self)

    def loop(self, d: Any) -> Ticks:
        """The sampled loop with a plant d, a `Descriptor` without integrators."""
        rows, noise = self.readings.rows, self.readings.noise
        return Ticks.of(self.parts, rows, self.timing, d, noise)

    @cached_property
    def loops(self) -> list:
        """The sampled loops with the plant's vertices."""
        return [self.loop(d) for d in self.vertices]

    @cached_property
    def falling(self) -> Any:
        """How fast all motions are proven to fall: see `proven_decay`."""
        return proven_decay(self)

    def sensitivity_peak(self) -> float:
        """The largest sampled sensitivity at the plant's input, over the vertices."""
        return max(loop.sensitivity_peak for loop in self.loops)

    def to_c(
        self,
        name: str = "axis",
        precision: str = "double",
        time_limit: float = 60.0,
        step: Any = None,
    ) -> Code:
        """Its program in C99, with what is proven, bounded and simulated of it.

        Parameters
        ----------
        name : str
            Of the files, and in front of every identifier.
        precision : {"double", "single"}
            Of all arithmetic; single for boards without wide floats.
        time_limit : float
            Seconds for the proof of the sampled loop.
        step : float or (p,) array_like, optional
            Of each set point, that is bounded and simulated; without it the largest
            that is known to stay within the limits, and 1 without limits.

        Returns
        -------
        Code
            `Code.write` makes the files; `Code.texts` has them.
        """
        Code(self, name, precision)  # a bad name is said before anything is proven
        return Code(self, name, precision, *facts_of(self, time_limit, step))
