"""A law: sensors, memory and free gains, as u = K y with numbers K.

With its own states x_c a law sees y = S y_m + R x_c, where y_m are the sensors, and
sets u and, where its dynamics are free, x_c' too: [u; v] = K y. So whatever a law is,
its gain is a static one of the plant that x_c is joined to.
"""

from abc import ABC, abstractmethod
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..exact.rational import exact, inverse
from ..plants.checks import matrix, positive
from ..plants.descriptor import Descriptor, descriptors
from ..plants.descriptor_system import DescriptorSystem
from ..plants.outputs import Output
from ..plants.sensed import Readings, corners, kept, sensed
from ..runtime.read_only import ReadOnly, put
from .applied import Applied
from .structure import Structure

__all__ = ["Law", "Parts", "Structure"]


@dataclass(frozen=True, eq=False)
class Parts(ReadOnly):
    """The matrices that a law joins to a plant E x' = A x + B u + B_w w, in rationals.

    Parameters
    ----------
    rows : (s, N) array
        The sensors: y_m = rows x + noise w.
    noise : (s, p) array
        How the disturbance enters them.
    E, A, B : arrays
        The law's own states: E x_c' = A x_c + B y_m, and v in the last ``free`` rows.
    of_sensors, of_states : (q, s) and (q, c) arrays
        What the gain multiplies: y = of_sensors y_m + of_states x_c.
    free : int
        How many rows v of x_c' the gain has.
    sensors, states, signals : tuple of str
        Names of y_m, x_c and y.
    integrals : int
        How many of the first x_c are integrals.
    """

    rows: np.ndarray
    noise: np.ndarray
    E: np.ndarray
    A: np.ndarray
    B: np.ndarray
    of_sensors: np.ndarray
    of_states: np.ndarray
    free: int
    sensors: tuple
    states: tuple
    signals: tuple
    integrals: int = 0

    @cached_property
    def rest(self):
        """The matrix from x(0) to [x(0); x_c(0)]: integrals are zero, a filter has long
        stood at what is measured, and free dynamics begin at zero.
        """
        N, a, c = self.rows.shape[1], self.integrals, len(self.states)
        whole = exact(np.eye(N + c, N))
        if c > a and not self.free and not (self.A[a:, :a] != 0).any():
            whole[N + a :] = -inverse(self.A[a:, a:]) @ self.B[a:] @ self.rows
        return whole

    @cached_property
    def measured(self):
        """The matrix from [x; x_c] to y."""
        return np.hstack([self.of_sensors @ self.rows, self.of_states])

    @cached_property
    def noisy(self):
        """The matrix from w to y."""
        return self.of_sensors @ self.noise

    @cached_property
    def entry(self):
        """The matrix from v to E x_c'."""
        return exact(np.eye(len(self.states), self.free, self.free - len(self.states)))

    def joined(self, d):
        """The plant d, in rationals, with x_c and without the gain: inputs [u; v]."""
        N, c = len(d.E), len(self.states)
        m, p, k = d.Bu.shape[1], d.Bw.shape[1], self.free

        def zero(*shape):
            return exact(np.zeros(shape))

        return replace(
            d,
            E=corners(d.E, zero(N, c), zero(c, N), self.E),
            A=corners(d.A, zero(N, c), self.B @ self.rows, self.A),
            Bu=corners(d.Bu, zero(N, k), zero(c, m), self.entry),
            Bw=np.vstack([d.Bw, self.B @ self.noise if c else zero(0, p)]),
            C=np.hstack([d.C, zero(len(d.C), c)]),
            Du=None if d.Du is None else np.hstack([d.Du, zero(len(d.Du), k)]),
            Ca=None if d.Ca is None else np.hstack([d.Ca, zero(len(d.Ca), c)]),
            a=self.integrals,
        )

    def looped(self, d, K):
        """The plant d with x_c, whose dynamics are closed, and u left open.

        With the gain of `state_gain` it is the loop.

        Parameters
        ----------
        d : Descriptor
            In rationals.
        K : (m + free, q) array
            The gain, in rationals.
        """
        whole, m = self.joined(d), d.Bu.shape[1]
        pushed, through = whole.Bu[:, m:] @ K[m:], K[:m] @ self.noisy
        noise = pushed @ self.noisy + whole.Bu[:, :m] @ through
        Dw, Uw = d.Dw, through if (through != 0).any() else None
        if d.Du is not None and Uw is not None:
            Dw = d.Du @ through if Dw is None else Dw + d.Du @ through
        A, Bw = whole.A + pushed @ self.measured, whole.Bw + noise
        Bu = whole.Bu[:, :m]
        return replace(whole, A=A, Bu=Bu, Bw=Bw, Du=d.Du, Dw=Dw, Uw=Uw)

    def state_gain(self, K):
        """The gain of u = K' [x; x_c], from the law's K, both in rationals."""
        return K[: len(K) - self.free] @ self.measured

    def vertices(self, plant, K, K_A=None):
        """The `Descriptor` of each vertex of a plant as `looped` makes it, of floats.

        Parameters
        ----------
        plant : Polytope, SecondOrderSystem, DescriptorSystem or Descriptor
            The plant, or another one of its shapes.
        K : (m + free, q) array
            The gain, of floats; they are read as decimals.
        K_A : (m, n) array, optional
            Acceleration gain.
        """
        return tuple(kept(self.looped(d, exact(K))) for d in plain(plant, K_A))

    def controller(self, K):
        """A, B, C, D from y_m to u, in rationals, for the gain K in rationals."""
        m = len(K) - self.free
        C, D = K[:m] @ self.of_states, K[:m] @ self.of_sensors
        if not len(self.E):
            return self.E, exact(np.zeros((0, len(self.rows)))), C, D
        back = inverse(self.E)
        push = back @ self.entry @ K[m:]
        A = back @ self.A + push @ self.of_states
        return A, back @ self.B + push @ self.of_sensors, C, D


class Law(ABC, ReadOnly):
    """A law: its sensors, its memory, and its free gains.

    A law of one's own has two methods: `parts` and `structure`. What it measures are
    the rows of ``sensors``, an `Output`, with a ``noise`` and a ``lag``, and those of
    ``rates``, which are velocities.
    """

    searched = True  # False where LMIs find the gain
    whole = False  # True where y is all of the state, so that u = K x
    U: Any = None  # (a, n), which errors are integrated beside it, if whole
    sensors: Any = None
    rates: Any = None
    noise: Any = None
    lag: Any = None
    places: Any = None  # which readings are of places; None: it is seen by the rows
    given: Any = None  # the law that `on` was asked of
    of_whole: Any = None  # the law on the whole plant, of one that `on_part` made

    def readings(self, plant: Any) -> Readings:
        """The readings of a ``plant``, those of ``sensors`` first."""
        if self.given is not None and getattr(plant, "sensed", None) is None:
            return self.given.readings(plant)
        seen = Readings.of(plant, self.sensors, self.rates)
        if self.lag is None and seen.late.any():
            raise ValueError(
                f"lag is missing: {seen.names[seen.late.argmax()]} jumps with u, and "
                "no sensor does; give the time constant of the sensor, or of the "
                "filter before the clock, in s"
            )
        if self.noise is None:
            return seen
        Dw = seen.Dw + 0.0
        Dw[: seen.first] += matrix("noise", self.noise, (seen.first, plant.p))
        return replace(seen, Dw=Dw)

    def on(self, plant: Any) -> tuple:
        """The ``plant`` with those sensors as states that are late, and the law of its
        readings; both as they are where none is.
        """
        seen, asked = self.readings(plant), self.given or self
        if not seen.late.any():
            return plant, self
        new, (first, rest) = copy(asked), seen.outputs()
        put(new, sensors=first, rates=rest, noise=None, lag=None)
        put(new, places=seen.places, given=asked)
        return sensed(plant, seen, asked.lag), new

    def on_part(self, basis: np.ndarray, halves: int) -> "Law":
        """The law on a part of a plant that measures the same, and knows the law that
        it was; ``basis`` and ``halves`` are as in `Output.through`.
        """
        new = copy(self)
        put(new, of_whole=self)
        if inner := getattr(self, "law", None):
            put(new, law=inner.on_part(basis, halves))
        for name in ("sensors", "rates"):
            seen = getattr(self, name)
            put(new, **{name: None if seen is None else seen.through(basis, halves)})
        return new

    def demands(self, plant: Any, asked: tuple) -> tuple:
        """The requirements on the loop of a ``plant`` that these ``asked`` make."""
        return asked

    def applied(self, plant: Any) -> Applied:
        """The law on a ``plant`` that `on` gave: what its numbers mean there."""
        return Applied(self, plant)

    @abstractmethod
    def parts(self, plant: Any) -> Parts:
        """The matrices that the law joins to a ``plant`` whose shapes are checked."""

    @abstractmethod
    def structure(self, plant: Any) -> Structure:
        """Its free gains, for a ``plant``."""

    @abstractmethod
    def words(self, plant: Any) -> str:
        """The law for a ``plant``, in words: "u depends on z1 alone: PID"."""


def plain(plant, K_A=None):
    """The vertices of a plant without a controller, as `Descriptor` in rationals."""
    if isinstance(plant, Descriptor):
        return (plant.map(exact),)
    vertices = plant.vertices
    if not isinstance(plant, DescriptorSystem):
        vertices = descriptors(plant, None, K_A)
    return tuple(d.map(exact) for d in vertices)


def checked_outputs(position, velocity, sensors, noise, lag):
    """The readings as `Law` keeps them: the `Output`s ``sensors`` and ``rates``, the
    ``noise`` and the ``lag``; a ValueError names what is wrong.
    """
    if sensors is not None and position is not None:
        raise ValueError(
            "position and sensors are given: put it into the Output, joined by &"
        )
    if position is None and velocity is None and sensors is None:
        raise ValueError(
            "position is missing: say what is measured, one row for each sensor"
        )
    for name, rows in (("position", position), ("velocity", velocity)):
        if rows is not None:
            found = Output(**{name: seeing_rows(name, rows)})
            position, velocity = (
                (found, velocity) if name == "position" else (position, found)
            )
    if sensors is not None and not isinstance(sensors, Output):
        raise ValueError(
            f"sensors must be an Output, such as Output(position=...) & "
            f"Output(acceleration=...), got {type(sensors).__name__}"
        )
    for part in () if sensors is None else sensors.parts:
        rows = [x for k, x in part.given.items() if np.ndim(x) and k != "disturbance"]
        if len(rows) == len(part.given):
            seeing_rows("sensors", np.hstack(rows))
    if lag is not None:
        lag = positive("lag", lag)
    return dict(
        sensors=position if sensors is None else sensors,
        rates=velocity,
        noise=None if noise is None else matrix("noise", noise),
        lag=lag,
    )


def seeing_rows(name, rows, columns=None):
    """The ``rows``, called ``name``, of what is seen, none of them zero."""
    rows = matrix(name, rows, (None, columns))
    if not len(rows):
        raise ValueError(f"{name} has no row: leave it out, or give a sensor")
    for k, row in enumerate(rows):
        if not row.any():
            raise ValueError(
                f"{name}: row {k + 1} is zero, a sensor that sees nothing: leave it out"
            )
    return rows


MODELS = "K_R"  # the gain of the models of a ShapedLaw


def checked_limits(limits, names):
    """The ``limits`` of gains as floats by name, or a ValueError."""
    if limits is None:
        return {}
    if not isinstance(limits, dict) or not set(limits) <= set(names):
        raise ValueError(
            f"limits must be a dict with some of {', '.join(names)}, got {limits!r}"
        )
    return {name: positive(f"limits[{name!r}]", x) for name, x in limits.items()}


def listed(words):
    """ "a, b and c"."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else f"{last} alone"
