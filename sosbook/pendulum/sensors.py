"""A robot's gyro, encoders and accelerometers."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..plants.checks import finite, positive
from .rig import COUNTS_PER_TURN, GYRO_STEP

__all__ = ["Readings", "Sensors"]

READINGS_AT_REST = 100  # of the gyro, whose mean is taken for its offset


@dataclass(frozen=True, eq=False)
class Sensors:
    """The readings of the robot's sensors: steps, noise and offsets.

    Parameters
    ----------
    noise : float
        Standard deviation of the gyro's noise, in rad/s.
    offset : float or (runs,) array_like
        What the gyro says at rest, in rad/s.
    counts : float
        The encoders' counts per turn of a wheel against the body.
    gyro_step : float
        The step of the gyro's 16 bits, in rad/s.
    tilt_error : float or (runs,) array_like
        The error of the tilt at the start, in rad.
    accelerometer : float, optional
        Standard deviation of each accelerometer's noise, in m/s^2.
        Without it there are none.
    height, r, g : float
        The height of the accelerometers above the axle and the wheels' radius,
        in m; gravity, in m/s^2.
    ideal : bool
        The sensors say the truth: no noise, offset, rounding or error. The
        accelerometers still feel how the robot accelerates.
    bias : float or (runs,) array_like, optional
        The gyro's offset that the controller is told, in rad/s; the mean of 100
        readings at rest without it.
    dropouts : (k,) or (runs, k) array_like of bool, or callable, optional
        The ticks at which no sensor can be read; a function is given the tick.

    Notes
    -----
    About upright, accelerometers at the height r (b + c) / (a + b), 51 mm for
    the thesis's robot, don't feel the motors: there the accelerations of the
    axle and of the turning body cancel.

    Examples
    --------
    >>> Sensors().wheels(np.array([0.01]), part=0.0).round(5)
    array([0.00888])
    """

    noise: float = np.deg2rad(0.1)
    offset: float = np.deg2rad(0.5)
    counts: float = COUNTS_PER_TURN
    gyro_step: float = GYRO_STEP
    tilt_error: float = 0.0
    accelerometer: float | None = None
    height: float = 0.05
    r: float = 0.032
    g: float = 9.8
    ideal: bool = False
    bias: Any = None
    dropouts: Any = None

    def __post_init__(self):
        for name in ("counts", "gyro_step", "r", "g"):
            positive(name, getattr(self, name))
        for name in ("noise", "accelerometer"):
            value = getattr(self, name)
            if value is not None and finite(name, value) < 0:
                raise ValueError(f"{name} can't be negative, got {value!r}")
        finite("height", self.height)
        for name in ("offset", "tilt_error"):
            value = np.array(getattr(self, name), float)
            if value.ndim > 1 or not np.isfinite(value).all():
                raise ValueError(f"{name} must be a finite number, or one for each run")
            object.__setattr__(self, name, value)

    def gyro(self, rate, noise=0.0):
        """The gyro's reading of a ``rate`` theta', in rad/s; noise has variance 1."""
        if self.ideal:
            return rate
        steps = np.rint((rate + self.offset + self.noise * noise) / self.gyro_step)
        return self.gyro_step * np.minimum(np.maximum(steps, -(2**15)), 2**15 - 1)

    def wheels(self, angle, part=0.0):
        """The encoders' reading of an ``angle`` phi - theta, in rad.

        It starts at a part, 0 to 1, of the way between two counts.
        """
        if self.ideal:
            return angle
        one = 2 * np.pi / self.counts
        return one * (np.floor(angle / one + part) + 0.0)

    def tilt(self, x, ddz, noise=(0.0, 0.0)):
        """The theta in rad that the accelerometers measure at ``x``, (4, runs).

        They feel the specific force at (-r phi - h sin theta, h cos theta), and don't
        know gravity from acceleration: atan2(g sin theta - r cos theta phi'' - h
        theta'', g cos theta + r sin theta phi'' - h theta'^2). ``ddz``, (2, runs):
        [theta''; phi'']; ``noise``, (2, runs): of variance 1.

        >>> float(Sensors().tilt([0.2, 5, 0, 0], [0, 0]).round(12))
        0.2
        """
        theta, _, dtheta, _ = x
        sin, cos = np.sin(theta), np.cos(theta)
        along = self.g * sin - self.r * cos * ddz[1] - self.height * ddz[0]
        up = self.g * cos + self.r * sin * ddz[1] - self.height * dtheta**2
        if not self.ideal:
            scale = self.accelerometer or 0.0
            along, up = along + scale * noise[0], up + scale * noise[1]
        return np.arctan2(along, up)


class Readings:
    """`Sensors` at work on runs side by side, tick by tick.

    ``sensors``: the sensors that each run has; ``runs``, ``count``: how many runs and
    ticks there are; ``seed``: run i draws from ``default_rng(seed + i)``, whatever runs
    beside it and for how long.
    """

    def __init__(self, sensors, runs, count, seed):
        random = [np.random.default_rng(seed + i) for i in range(runs)]
        self.sensors, self.zero = sensors, np.zeros(runs)
        self.part = np.array([r.random() for r in random])
        self.still = np.array([r.standard_normal(READINGS_AT_REST) for r in random]).T
        self.noise = np.array([r.standard_normal((count, 3)) for r in random]).T

    def bias(self):
        """The gyro's offset that a controller is told, in rad/s."""
        if self.sensors.bias is not None:
            return self.sensors.bias
        readings = [self.sensors.gyro(self.zero, noise) for noise in self.still]
        return np.mean(readings, axis=0)

    def first_tilt(self, theta):
        """theta as the controller is told it at the start, in rad."""
        ideal = self.sensors.ideal
        return theta if ideal else theta + self.sensors.tilt_error

    def gyro(self, x, k):
        """The gyro's readings of the states x at the tick k, in rad/s."""
        return self.sensors.gyro(x[2], self.noise[0, k])

    def wheels(self, x):
        """The encoders' angle of the wheels against the body, in rad, at states x."""
        return self.sensors.wheels(x[1] - x[0], self.part)

    def tilt(self, x, ddz, k):
        """The accelerometers' tilt at the tick k, in rad, from x and z'' (``ddz``)."""
        return self.sensors.tilt(x, ddz, self.noise[1:, k])

    def missed(self, k):
        """True, or (runs,) bool, where no sensor can be read at the tick k."""
        dropouts = self.sensors.dropouts
        if callable(dropouts):
            return dropouts(k)
        dropouts = np.asarray(dropouts, bool)
        if k >= dropouts.shape[-1]:
            raise ValueError(f"dropouts ends at tick {k}: give one for each")
        return dropouts[..., k]
