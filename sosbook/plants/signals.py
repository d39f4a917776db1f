"""Signals that act on a plant: disturbances, inputs, set points."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..runtime.array_like import ArrayLike
from ..runtime.read_only import frozen, put
from .checks import finite, matrix, numbers


class Signal:
    """amplitude sin(omega t) + offset for start <= t < stop, else 0."""

    def _check(self, *levels):
        for name in levels:
            if not np.isfinite(numbers(name, getattr(self, name))).all():
                raise ValueError(f"{name} must be finite, got {getattr(self, name)!r}")
            put(self, **{name: frozen(getattr(self, name))})
        for name in ("start", "stop"):
            when = getattr(self, name)
            if not (isinstance(when, (float, np.floating)) and np.isinf(when)):
                finite(name, when)
        if self.stop <= self.start:
            raise ValueError(
                f"stop = {self.stop:g} must be after start = {self.start:g}: else it "
                "never acts"
            )

    def __call__(self, t):
        """Values at the times t, one row for each channel."""
        t = np.asarray(t, float)
        on = (t >= self.start) & (t < self.stop)
        amplitude = np.atleast_1d(self.amplitude)[:, None]
        offset = np.atleast_1d(self.offset)[:, None]
        return on * (amplitude * np.sin(self.omega * t) + offset)


@dataclass(frozen=True)
class Sine(Signal):
    """amplitude sin(omega t) + offset for start <= t < stop, else 0.

    Parameters
    ----------
    amplitude : float or (p,) array_like
        One number acts on every channel.
    omega : float
        The angular frequency, in rad/s.
    offset : float or (p,) array_like
        A constant that is added, one number or one for each channel.
    start, stop : float
        When it begins and ends, in seconds.
    """

    amplitude: float
    omega: float
    offset: float = 0.0
    start: float = 0.0
    stop: float = np.inf

    def __post_init__(self):
        finite("omega", self.omega)
        self._check("amplitude", "offset")


@dataclass(frozen=True)
class Step(Signal):
    """height for start <= t < stop, else 0: a disturbance or a set point.

    Parameters
    ----------
    height : float or (p,) array_like
        One number acts on every channel.
    start, stop : float
        When it begins and ends, in seconds.

    Examples
    --------
    >>> Step(3.0, start=1.0)([0.0, 1.0, 2.0])
    array([[0., 3., 3.]])
    """

    height: float
    start: float = 0.0
    stop: float = np.inf

    amplitude = omega = 0.0

    def __post_init__(self):
        self._check("height")

    @property
    def offset(self) -> float:
        """The height, as a `Sine` calls it."""
        return self.height


@dataclass(frozen=True, eq=False)
class Steps:
    """A set point that is constant piece by piece.

    Parameters
    ----------
    times : (k,) array_like
        When each level begins, in seconds; increasing, the first is 0.
    levels : (k, n) array_like
        The set points, one a row.

    Examples
    --------
    >>> r = Steps([0, 2], [[1, 0], [3, 0]])
    >>> r([1.9, 2.0])
    array([[1., 3.],
           [0., 0.]])
    """

    times: np.ndarray
    levels: np.ndarray

    if TYPE_CHECKING:  # what the constructor takes

        def __init__(self, times: ArrayLike, levels: ArrayLike) -> None: ...

    def __post_init__(self):
        times = matrix("times", [self.times])[0]
        spans = np.diff(times)
        wrong = spans < 0 if isinstance(self, Ramps) else spans <= 0
        if len(times) == 0 or times[0] != 0 or wrong.any():
            raise ValueError("times must increase from 0")
        levels = matrix("levels", self.levels, (len(times), None))
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "levels", levels)

    def __call__(self, t):
        """The set point at the times t, one column each."""
        return self.within(self.index(t), t)

    def index(self, t: ArrayLike) -> np.ndarray:
        """Which piece holds at the times t."""
        return np.searchsorted(self.times, t, side="right") - 1

    def within(self, piece: ArrayLike, t: ArrayLike) -> np.ndarray:
        """Values at the times t of the ``piece`` of each, also where it ends."""
        piece = np.asarray(piece)
        return self.levels[piece].T + self.slopes[piece].T * (t - self.times[piece])

    @cached_property
    def slopes(self) -> np.ndarray:
        """(k, n) array: by how much each piece rises in a second."""
        return np.zeros_like(self.levels)

    def slope(self, t: ArrayLike) -> np.ndarray:
        """By how much it rises in a second, from each of the times t on."""
        return self.slopes[self.index(t)].T


@dataclass(frozen=True, eq=False)
class Ramps(Steps):
    """A signal that is linear between times: a ramp, or a record of a file.

    Before 0 it is zero, and from the last time on it stays where it is.

    Parameters
    ----------
    times : (k,) array_like
        Times, in seconds, from 0 on; where one stands twice, the signal jumps.
    levels : (k, n) array_like
        The values at these times, one a row.

    Examples
    --------
    >>> Ramps([0, 2, 2], [[0], [3], [1]])([1.0, 2.0, 5.0])
    array([[1.5, 1. , 1. ]])
    """

    @cached_property
    def slopes(self) -> np.ndarray:
        """(k, n) array: by how much each piece rises in a second."""
        spans = np.append(np.diff(self.times), 1.0)[:, None]
        rises = np.diff(self.levels, axis=0, append=self.levels[-1:])
        return np.divide(rises, spans, out=np.zeros_like(rises), where=spans > 0)


def steps(r, n, name="r"):
    """A signal r of n entries in pieces: a constant is one step, None is zero; its
    ``name`` is for a refusal.
    """
    if isinstance(r, Step):
        height = numbers("height", r.height)
        if height.shape not in ((), (1,), (n,)):
            raise ValueError(f"r: height must be one number or {n} of them")
        up, none = np.broadcast_to(height, (n,)), np.zeros(n)
        corners = [(0.0, none), (max(r.start, 0.0), up), (max(r.stop, 0.0), none)]
        levels = {time: level for time, level in corners if np.isfinite(time)}
        return Steps(sorted(levels), [levels[time] for time in sorted(levels)])
    if callable(r) and not isinstance(r, Steps):
        raise ValueError(
            f"{name} must be linear piece by piece: give the values of a function as "
            "Ramps(times, levels), with a row of levels for each time; between the "
            "times it is a straight line"
        )
    if not isinstance(r, Steps):
        r = np.zeros(n) if r is None else numbers("r", r)
        if r.shape != (n,) or not np.isfinite(r).all():
            raise ValueError(
                f"r must hold {n} finite numbers, or be a Step, Steps or Ramps"
            )
        return Steps([0.0], [r])
    if r.levels.shape[1] != n:
        raise ValueError(f"{name} has levels of {r.levels.shape[1]} numbers, needs {n}")
    return r


def signal_parts(name, signal, size, column):
    """Times on and off, amplitude and offset of a ``signal`` (None: zero) of so many
    channels, its ``size``, or the signal itself if it is `Steps`; errors have its
    ``name`` and ``column``.
    """
    if signal is None:
        return np.inf, np.inf, None, None, None
    if not isinstance(signal, (Signal, Steps)):
        raise ValueError(f"{name} must be a Sine, Step, Steps or Ramps (or None)")
    if size == 0:
        raise ValueError(f"{name} is given but the plant has no {column}")
    if isinstance(signal, Steps):
        return np.inf, np.inf, None, None, steps(signal, size, name)
    for part in ("amplitude", "offset"):
        if np.shape(getattr(signal, part)) not in ((), (1,), (size,)):
            raise ValueError(f"{name}: {part} must be one number or {size} of them")
    sine = np.broadcast_to(numbers("amplitude", signal.amplitude), (size,))
    level = np.broadcast_to(numbers("offset", signal.offset), (size,))
    return signal.start, signal.stop, sine, level, None
