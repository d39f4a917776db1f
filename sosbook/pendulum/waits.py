"""What a description may leave out: how long a fault is borne, and the law."""

from .robot import WAITS

__all__ = ["fall_time", "timed"]

DEFAULT_LAW = "observer"  # quiet where gears have play and encoders are coarse

#: Fall times: the error of a bridged reading grows by half, one of a frozen gyro or a
#: late clock by e, before the motors go off; encoders that rest may be at a wall; and
#: a rescue from 98 % of the tilt that no law exceeds is at its limit for log 50 = 3.9.
FALLS = dict(zip(WAITS, (0.4, 1.0, 4.0, 2.0, 1.0)))
#: Ticks, at least: by chance a sensor is silent, or a gyro repeats itself, so often.
LEAST = {"missing": 5, "frozen": 12}


def fall_time(mip):
    """The time in s in which a ``mip`` without voltage falls e times as far."""
    return float(1 / mip.plant().poles().real.max())


def timed(robot, mip):
    """A ``robot`` with a law and every wait: those not given by a ``mip``'s fall."""
    fall, told = fall_time(mip), {} if robot.law else {"law": DEFAULT_LAW}
    for name, falls in FALLS.items():
        if getattr(robot, name) is None:
            told[name] = round(max(falls * fall, LEAST.get(name, 0) * robot.T), 3)
    return robot.but(**told) if told else robot
