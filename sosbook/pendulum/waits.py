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
    """The time in which a ``mip`` without voltage falls e times as far, in s.

    ``mip``: the pendulum. Returns float: that of its unstable pole.

    >>> from sosbook.pendulum import Mip
    >>> round(fall_time(Mip.printed()), 3)
    0.123
    """
    return float(1 / mip.plant().poles().real.max())


def timed(robot, mip):
    """The ``robot`` with a law and every wait: those not given are by its fall.

    Parameters
    ----------
    robot : Robot
        The description.
    mip : Mip
        The pendulum that falls.

    Returns
    -------
    Robot
        It bears each fault for a time that is given.
    """
    fall, told = fall_time(mip), {} if robot.law else {"law": DEFAULT_LAW}
    for name, falls in FALLS.items():
        if getattr(robot, name) is None:
            told[name] = round(max(falls * fall, LEAST.get(name, 0) * robot.T), 3)
    return robot.but(**told) if told else robot
