"""A controller as an object: its signals, its memory, its limits, its clock."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..exact.rational import round_digits
from ..plants.checks import matrix, positive
from ..plants.gain import Gain
from ..runtime.read_only import ReadOnly
from ..sampled.discretize import SampleTiming
from .answers import Answers
from .bounds import settled
from .clock import checked_slack
from .limits import Faults, Limits, per_signal
from .memory import DIGITS, ROUNDING, Estimate, assembled, forgetting, shifted
from .signals import NOTHING_TO_SET, signals_of

COARSE = 0.5  # of the limit, that steps of the sensors may ask by themselves


def _part(name: str, about: str) -> Any:
    """A property: the matrix of this name among a controller's parts."""

    def part(self):
        return self.parts[name]

    return property(part, doc=about)


@dataclass(frozen=True, eq=False, repr=False)
class Controller(Answers, ReadOnly):
    """A sampled controller that is made of a proven gain, and all that it needs.

    x(k+1) = A x + B y + B_r r + W (v - u), u = C x + D y + D_r r, where y is measured,
    r are the set points and v is what is left of u after the limits. `limit`,
    `set_point` and `watch` return another controller; none of them changes one.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
        What it controls.
    vertices : tuple of Descriptor
        The plant's, without integrators.
    gain : Gain
        The proven gain, in the decimals that were proven.
    U : (a, n) array or None
        What is integrated of the coordinates, or of a law's readings.
    sums : (a, q) array
        What is integrated, of what is measured.
    T, delay : float
        Time between samples, and from a sample to the actuator, in s.
    measured, outputs : tuple of Signal
        What goes in and what comes out.
    rows, noise_rows : (q, N) and (q, p_w) arrays
        What is measured: y = rows x + noise_rows w.
    steps : (q,) array
        How fine it is measured, in its unit; zero where nobody said.
    estimate : Estimate
        How the state is estimated.
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
    chosen : Chosen or None
        How the observer was found.
    clock : tuple or None
        The two ranges (low, high), of intervals and of delays in s, for which `certify`
        proves the loop; None where neither varies.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(1, 0, 0, 1, coordinates=["place"])
    >>> design = sos.design_pid(cart, region=sos.PoleRegion(1, rho=9))
    >>> controller = design.controller(
    ...     ["place"], T=0.01, delay=0.01, units={"place": "m"})
    >>> print(controller.measured[0], controller.order)
    place (m) 3
    >>> print(controller.radius < 1)
    True
    >>> controller.certify().proven
    True
    """

    plant: Any
    vertices: tuple
    gain: Gain
    U: Any
    sums: np.ndarray
    T: float
    delay: float
    measured: tuple
    outputs: tuple
    rows: np.ndarray
    noise_rows: np.ndarray
    steps: np.ndarray
    estimate: Estimate
    R: np.ndarray
    limits: Limits
    faults: Faults = field(default_factory=Faults)
    units: dict = field(default_factory=dict)
    certificate: Any = None
    chosen: Any = None
    clock: Any = None

    def __repr__(self):
        names = ", ".join(s.name for s in self.measured)
        given = ", ".join(s.name for s in self.outputs)
        return (
            f"<Controller: {given} of {names}, T = {self.T:g} s, order {self.order}, "
            f"{self.estimate.words}>"
        )

    # What it is made of

    @cached_property
    def timing(self) -> SampleTiming:
        """Its clock, in exact rationals."""
        return SampleTiming.of(self.T, self.delay)

    @property
    def K_x(self) -> np.ndarray:
        """The gain of what is estimated: the plant's state, or a law's signals."""
        return self.gain.K[:, : len(self.estimate.take)]

    @property
    def K_I(self) -> np.ndarray:
        """The gain of the integrals, (m, a)."""
        return self.gain.K[:, len(self.estimate.take) :]

    @cached_property
    def parts(self) -> dict:
        """Its matrices by name, in decimals."""
        return self._made[0]

    @property
    def states(self) -> tuple:
        """The name of each entry of the memory."""
        return (*self._made[1], *self.gain.signals[len(self.estimate.take) :])

    @cached_property
    def _made(self):
        """(matrices by name, names of the memory's states)."""
        K_P = self.K_x[:, : len(self.R)]
        K_r, size = -K_P @ self.R, abs(K_P) @ abs(self.R)
        K_r = np.where(abs(K_r) <= ROUNDING * size, 0.0, K_r) + 0.0
        gains = self.K_x, self.K_I, self.sums, self.T, K_r
        parts, words = assembled(self.estimate, self.timing, *gains)
        if self.estimate.errors:
            parts = shifted(parts, self.estimate.start, self.R)
        a = self.K_I.shape[1]
        W = parts["W"].copy()
        if a and self.limits.tracking_time:
            back = np.linalg.pinv(self.K_I) * (self.T / self.limits.tracking_time)
            W[len(W) - a :] = round_digits(back, DIGITS)
        elif self.estimate.winds_up and self.limits.tracking_time:
            share = np.exp(-self.T / self.limits.tracking_time)
            W = forgetting(parts["A"], parts["C"], share)
        return parts | {"W": W}, words

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

    @property
    def set_points(self) -> tuple:
        """A `Signal` for each set point."""
        if not self.R.shape[1]:
            return ()
        names = self.gain.signals[: len(self.R)]
        if self.U is not None and len(self.U):
            sums = self.gain.signals[len(self.estimate.take) :]
            names = tuple(name.removeprefix("integral of ") for name in sums)
        return signals_of([f"set point of {x}" for x in names], self.units)

    @property
    def followed(self) -> list:
        """For each set point the index of what is measured of it, or None."""
        named = {s.name: k for k, s in enumerate(self.measured)}
        return [
            named.get(s.name.removeprefix("set point of ")) for s in self.set_points
        ]

    @property
    def fastest(self) -> np.ndarray:
        """(q,): how fast each measured signal may move, per second."""
        return per_signal("fastest", self.faults.fastest, self.measured)

    @cached_property
    def start(self) -> np.ndarray:
        """(l, q): the memory at the start, of what is measured there.

        The machine is taken to be at rest, and the integrals so that it is asked
        nothing.
        """
        e, q = self.estimate, len(self.measured)
        found = np.zeros((len(self.A), q))
        found[: len(e.start)] = e.start
        a = self.K_I.shape[1]
        if a:
            r = np.zeros((len(self.set_points), q))
            for j, k in enumerate(self.followed):
                r[j, q if k is None else k :][:1] = 1
            asked = self.K_x @ (e.stay @ e.start + e.take) + self.D_r @ r
            found[len(found) - a :] = round_digits(
                -np.linalg.pinv(self.K_I) @ asked, DIGITS
            )
        return found + 0.0

    def set_point(self, r: Any = None, ramp: Any = None) -> "Controller":
        """Choose what a set point asks of all coordinates.

        Parameters
        ----------
        r : (n, p) array_like, optional
            The coordinates' set points for one unit of each set point, with U r = I.
            Without it K_P r asks nothing, or as little as can be: then a step moves
            the integral alone, and overshoots less.
        ramp : float or dict, optional
            How fast a set point is followed, per second, one number or by the name of
            the set point.

        Raises
        ------
        ValueError
            If U r isn't I, or the controller has no position to set.
        """
        n = len(self.R)
        if not n:
            raise ValueError(NOTHING_TO_SET)
        U = np.zeros((0, n)) if self.U is None else self.U
        if r is None:
            r = quiet_set_point(U, self.K_x[:, :n])
        else:
            r = matrix("r", r, (n, None))
            if len(U) and (
                r.shape[1] != len(U) or abs(U @ r - np.eye(len(U))).max() > 1e-9
            ):
                raise ValueError(
                    "r must have U r = I: one column for each integral, and its "
                    f"set point there; got U r = {(U @ r).tolist()}"
                )
        new = replace(self, R=r)
        if ramp is None:
            return new
        ramps = per_signal("ramp", ramp, new.set_points)
        return replace(new, limits=replace(new.limits, ramp=ramps))

    def limit(
        self,
        u_max: Any = None,
        slew: Any = None,
        tracking_time: float | None = None,
        *,
        anti_windup: bool = True,
        load: Any = None,
    ) -> "Controller":
        """Bound the outputs, and tell the integral what is withheld.

        So is a `DynamicLaw`'s memory told that doesn't forget by itself.

        Parameters
        ----------
        u_max, slew : float or dict, optional
            Largest output and its change per second, one number or by name.
        tracking_time : float, optional
            With which the integral follows what is withheld, in s; without it the
            geometric mean of T and the loop's slowest time constant.
        anti_windup : bool
            Whether it follows at all.
        load : (p_w,) array_like, optional
            A constant disturbance that must be held within the limit.

        Raises
        ------
        ValueError
            If the limit is below what the load needs at rest, or below twice what
            the sensors' steps alone can ask.
        """
        new = Limits(
            per_signal("u_max", u_max, self.outputs),
            per_signal("slew", slew, self.outputs),
            self.limits.ramp,
            None,
        )
        if load is not None:
            need = abs(self.static(w=load)[1]).max(axis=0)
            for k, signal in enumerate(self.outputs):
                if need[k] >= new.u_max[k]:
                    raise ValueError(
                        f"u_max = {new.u_max[k]:g} is below the static need: {signal} "
                        f"must be {need[k]:.6g} to hold the load {load!r}"
                    )
        self._not_too_coarse(new.u_max)
        if anti_windup and (self.K_I.size or self.estimate.winds_up):
            if tracking_time is None:
                slowest = -self.T / np.log(min(self.radius, 1 - 1e-12))
                tracking_time = float(f"{np.sqrt(self.T * slowest):.3g}")
            elif positive("tracking_time", tracking_time) < self.T:
                raise ValueError(
                    f"tracking_time = {tracking_time:g} s is below T = {self.T:g} s: "
                    "the integral would overshoot what is withheld"
                )
            new = replace(new, tracking_time=tracking_time)
        return replace(self, limits=new)

    def _not_too_coarse(self, u_max):
        """Raise where the steps of the sensors may ask half of the limit."""
        asked = np.zeros(len(u_max))
        for loop in self.loops:
            if loop.radius < 1 and self.steps.any() and np.isfinite(u_max).any():
                h = abs(loop.impulses(loop.noise, loop.direct, settled(loop)))
                asked = np.maximum(asked, h.sum(axis=0) @ self.steps / 2)
        for k, signal in enumerate(self.outputs):
            if asked[k] > COARSE * u_max[k]:
                one = abs(self.D[k]) @ self.steps
                raise ValueError(
                    "counts are too coarse for this law: their steps can move "
                    f"{signal} by {asked[k]:.3g}, one alone by {one:.3g} a count, and "
                    f"u_max is {u_max[k]:.3g}. Take more counts, a larger T, a quieter "
                    "observer (peak) or a softer gain"
                )

    def watch(self, **faults: Any) -> "Controller":
        """With other ``faults``, such as ``lost=0.01``, in seconds: see `Faults`.

        A ValueError says where ticks that are proven would be counted as faults.
        """
        watched = replace(self.faults, **faults)
        slack = checked_slack(watched.slack, self.T, self.clock)
        return replace(self, faults=replace(watched, slack=slack))


def quiet_set_point(U, K_P):
    """The least r with U r = I of which K_P r is least, (n, a); all of z without U."""
    a, n = U.shape
    if not a:
        return np.eye(n)
    base = np.linalg.pinv(U)
    free = np.linalg.svd(U)[2][a:].T
    if not free.shape[1]:
        return base
    return base - free @ (np.linalg.pinv(K_P @ free) @ (K_P @ base))
