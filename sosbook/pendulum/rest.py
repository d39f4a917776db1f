"""How quiet a program is at rest, with counts, play, friction and a bridge."""

from dataclasses import dataclass
from math import radians

import numpy as np

from .firmware import Firmware
from .sensors import Sensors
from .simulator import Drivetrain, simulate

__all__ = ["LOUDER", "QUIET_SHARE", "Gears", "volts_at_rest"]

QUIET_SHARE = 0.1  # of the limit, rms: a program that takes more at rest is loud
#: Robots of other formulas, whose gears stick and whose batteries sag, take up to so
#: many times the volts that are simulated here.
LOUDER = 1.35
BRIDGE_STEPS, DEAD_SHARE = 255, 0.02  # of the limit: below it the motors get nothing
START_TILT = 0.02  # rad, from which it comes to rest
ACCELEROMETER = 0.05  # m/s^2, their noise


@dataclass(frozen=True)
class Gears:
    """The play and friction of a robot's gears.

    ``frictions``: dry ones, in V; ``play``: by which a wheel turns while its motor
    rests, in rad.
    """

    frictions: tuple = (0.0,)
    play: float = 0.0

    @classmethod
    def of(cls, identified, robot):
        """By the fits of ``identified``, 1.96 standard deviations either way.

        Where no friction was fitted it is what the ``robot`` compensates; the play is
        no less than in its description.
        """
        fits = (identified.body, *identified.wheels) if identified else ()

        def ends(name):
            return [end for x in fits if name in x.names for end in x.interval(name)]

        rub = ends("friction") or [robot.compensation]
        play = max([radians(robot.backlash_deg), *ends("play")])
        return cls((max(min(rub), 0.0), max(*rub, 0.0)), float(play))


class Bridged:
    """A `Firmware` at work, whose volts go through a bridge to the motors.

    ``asked`` has those before it, tick by tick.
    """

    def __init__(self, firmware):
        self.firmware, self.asked = firmware, []
        self._controller = firmware.controller()
        self.start = self._controller.start

    @property
    def fault(self):
        return self._controller.fault

    def step(self, *seen):
        V, limit = self._controller.step(*seen), self.firmware.limit
        self.asked.append(float(V[0]))
        duty = np.rint(BRIDGE_STEPS * V / limit) / BRIDGE_STEPS
        return np.where(abs(duty) < DEAD_SHARE, 0.0, duty * limit)


def volts_at_rest(mip, law, robot, seconds, gears):
    """The root mean square of a program's volts in a run's last two thirds.

    Encoders have their counts, the gears their play, the motors a bridge with a dead
    zone; the delay is the largest. It is the worst of the frictions, times `LOUDER`.

    ``mip``: the pendulum; ``law``: the law; ``robot``: its description; ``seconds``:
    how long the run lasts; ``gears``: `Gears`. Returns float: in V; the limit, if the
    motors go off.
    """
    place = dict(height=robot.l / 2, r=robot.r, g=robot.g)
    seen = dict(counts=robot.counts, gyro_step=robot.gyro_range / 2**15)
    sensors = Sensors(accelerometer=ACCELEROMETER, **seen, **place)
    most = 0.0
    for friction in sorted(set(gears.frictions)):
        program = Bridged(Firmware.of(law, robot))
        how = dict(substeps=4, drivetrain=Drivetrain(friction, gears.play))
        run = simulate(mip, program, START_TILT, seconds, robot.delay, sensors, **how)
        if run.fell[0]:
            return robot.limit
        late = program.asked[len(run.t) // 3 :]
        most = max(most, float(np.mean(np.square(late)) ** 0.5))
    return min(LOUDER * most, robot.limit)
