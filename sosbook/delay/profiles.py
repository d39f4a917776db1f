"""Delays d(t) of a control signal: the plant receives u(t - d(t)).

Every signal can be called with times t >= 0 in seconds and gives the delays there,
those after the jump where d jumps. ``low`` and ``high`` bound its values,
``jumps(end)`` are the times inside (0, end) at which d or its slope jumps, and ``rate``
is its fastest angular frequency between them, in rad/s. A new kind of delay needs no
more than these (no rate where it is zero).
"""

from dataclasses import dataclass

import numpy as np

from ..plants.checks import count, finite, not_negative, positive

MOST_JUMPS = 100_000  # of one delay signal


def _interval(low, high):
    if not_negative("low", low) > not_negative("high", high):
        raise ValueError(
            f"low must not exceed high, got {low!r} and {high!r}: swap them"
        )


def _tick(t, start, period):
    """How many periods are over at t, whatever the rounding of t."""
    t = np.asarray(t, float)
    rounding = 16 * np.finfo(float).eps * np.abs(t)
    return np.floor((t - start + rounding) / period)


def _ticks(start, period, end):
    """The times start + k period inside (0, end), k = 0, 1, ..."""
    ticks = max(0, int(np.ceil((end - start) / period)))
    if ticks > MOST_JUMPS:
        raise ValueError(
            f"the delay jumps {ticks} times in {end} s: end earlier, or "
            "let each value last longer"
        )
    times = start + period * np.arange(ticks)
    return times[(times > 0) & (times < end)]


class _Delay:
    """A delay without jumps or frequency, unless it says otherwise."""

    rate = 0.0

    def jumps(self, end):
        """No times: this delay has no jumps before ``end``, nor later."""
        return np.empty(0)


@dataclass(frozen=True)
class ConstantDelay(_Delay):
    """The same delay at all times.

    Parameters
    ----------
    value : float
        In seconds, >= 0.

    Raises
    ------
    ValueError
        If the value is negative or not finite.

    Examples
    --------
    >>> ConstantDelay(0.2)([0, 1])
    array([0.2, 0.2])
    """

    value: float

    def __post_init__(self):
        not_negative("value", self.value)

    @property
    def low(self):
        """The smallest delay."""
        return self.value

    @property
    def high(self):
        """The largest delay."""
        return self.value

    def __call__(self, t):
        """Delays at the times t."""
        return np.full(np.shape(t), float(self.value))


@dataclass(frozen=True)
class SineDelay(_Delay):
    """A delay that swings about the middle of [low, high].

    Parameters
    ----------
    low, high : float
        In seconds, 0 <= low <= high.
    omega : float
        In rad/s, > 0.
    phase : float
        In rad; with 0 the delay starts in the middle and grows.

    Examples
    --------
    >>> SineDelay(0.1, 0.3, omega=np.pi)([0, 0.5, 1.5])
    array([0.2, 0.3, 0.1])
    """

    low: float
    high: float
    omega: float
    phase: float = 0.0

    def __post_init__(self):
        _interval(self.low, self.high)
        positive("omega", self.omega)
        finite("phase", self.phase)

    @property
    def rate(self):
        """omega."""
        return self.omega

    def __call__(self, t):
        """Delays at the times t."""
        swing = np.sin(self.omega * np.asarray(t, float) + self.phase)
        middle = (self.low + self.high) / 2
        delay = middle + (self.high - self.low) / 2 * swing
        return np.clip(delay, self.low, self.high)  # of rounding alone


@dataclass(frozen=True)
class SawtoothDelay(_Delay):
    """Sample and hold, then a transport delay of ``low`` seconds.

    The controller's signal is sampled every T = high - low seconds from
    t = 0 on. A sample takes ``low`` seconds to the plant, which holds it
    for T seconds. So d rises from low to high with slope one and drops
    back at the times low + k T: t - d(t) = k T between two drops.

    Parameters
    ----------
    low, high : float
        In seconds, 0 <= low < high.

    Examples
    --------
    >>> sampled = SawtoothDelay(0.1, 0.4)
    >>> sampled([0.1, 0.3, 0.4]).round(3)
    array([0.1, 0.3, 0.1])
    >>> sampled.jumps(1.0).round(3)
    array([0.1, 0.4, 0.7])
    """

    low: float
    high: float

    def __post_init__(self):
        _interval(self.low, self.high)
        if self.low == self.high:
            raise ValueError(
                "high must exceed low by the sampling period; without one "
                "take ConstantDelay"
            )

    def __call__(self, t):
        """Delays at the times t."""
        t, period = np.asarray(t, float), self.high - self.low
        delay = t - period * _tick(t, self.low, period)
        return np.clip(delay, self.low, self.high)  # of rounding alone

    def jumps(self, end):
        """The times before ``end`` at which a new sample reaches the plant."""
        period = self.high - self.low
        return _ticks(self.low % period, period, end)


@dataclass(frozen=True)
class SwitchingDelay(_Delay):
    """A delay that jumps between two values, low first.

    Parameters
    ----------
    low, high : float
        In seconds, 0 <= low <= high.
    dwell : float
        How long each value lasts, in seconds, > 0.

    Examples
    --------
    >>> SwitchingDelay(0.1, 0.3, dwell=2)([0, 1.9, 2, 4])
    array([0.1, 0.1, 0.3, 0.1])
    """

    low: float
    high: float
    dwell: float

    def __post_init__(self):
        _interval(self.low, self.high)
        positive("dwell", self.dwell)

    def __call__(self, t):
        """Delays at the times t."""
        odd = _tick(t, 0.0, self.dwell) % 2
        return np.where(odd, float(self.high), float(self.low))

    def jumps(self, end):
        """Every multiple of the dwell time before ``end``."""
        return _ticks(0.0, self.dwell, end)


@dataclass(frozen=True)
class RandomDelay(SwitchingDelay):
    """A new delay every ``dwell`` seconds, uniform on [low, high].

    Parameters
    ----------
    low, high : float
        In seconds, 0 <= low <= high.
    dwell : float
        How long each value lasts, in seconds, > 0.
    seed : int
        Equal seeds give equal delays.

    Examples
    --------
    >>> delay = RandomDelay(0.1, 0.3, dwell=1, seed=0)
    >>> delay([0, 0.9, 1, 2]).round(3)
    array([0.227, 0.227, 0.154, 0.108])
    """

    seed: int

    def __post_init__(self):
        super().__post_init__()
        count("seed", self.seed)

    def __call__(self, t):
        """Delays at the times t."""
        now = np.maximum(_tick(t, 0.0, self.dwell), 0).astype(int)
        source = np.random.default_rng(self.seed)
        drawn = source.uniform(self.low, self.high, now.max(initial=0) + 1)
        return drawn[now]
