"""How quiet a program is at rest, with counts, play and friction: a simulation."""

from math import radians

from .firmware import Firmware
from .sensors import Sensors
from .simulator import simulate

__all__ = ["CHOSEN_SHARE", "QUIET_SHARE", "volts_at_rest"]

QUIET_SHARE = 0.1  # of the limit, rms: a program that takes more at rest is loud
#: Of that, what a weight is chosen for: a robot with friction, 8 bits of voltage and a
#: dead zone, which no description has, takes up to 1.7 times as much.
CHOSEN_SHARE = 0.6
START_TILT = 0.02  # rad, from which it comes to rest
ACCELEROMETER = 0.05  # m/s^2, their noise


def volts_at_rest(mip, law, robot, seconds):
    """The root mean square of a program's volts in a run's last two thirds.

    Encoders have their counts and the gears their play; the friction is what the
    program compensates, and the delay the largest.

    ``mip``: the pendulum; ``law``: the law; ``robot``: its description; ``seconds``:
    how long the run lasts. Returns float: in V; the limit, if the motors go off.
    """
    sensors = Sensors(
        counts=robot.counts,
        gyro_step=robot.gyro_range / 2**15,
        accelerometer=ACCELEROMETER,
        height=robot.l / 2,
        r=robot.r,
        g=robot.g,
    )
    run = simulate(
        mip,
        Firmware.of(law, robot),
        START_TILT,
        seconds,
        robot.delay,
        sensors,
        substeps=4,
        friction=robot.compensation,
        backlash=radians(robot.backlash_deg),
    )
    if run.fell[0]:
        return robot.limit
    return float((run.V[0, len(run.t) // 3 :] ** 2).mean() ** 0.5)
