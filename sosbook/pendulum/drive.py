"""How fast a robot may be told to roll, and how soon."""

from dataclasses import dataclass, fields, replace

from ..plants.checks import finite
from .turning import inertia_bounds

__all__ = ["Drive"]

RAMP_LEAN = 0.05  # rad, which the body leans while a ramp lasts
SPEED_SHARE = 0.4  # of the free speed: the rest of the voltage balances


@dataclass(frozen=True)
class Drive:
    """The limits of a set point that moves.

    A set point of the wheels' speed is followed on a ramp: a jump would
    ask for a voltage that the motors don't have.

    ``speed``: the largest speed phi' that is obeyed, in rad/s; zero stays in place;
    ``acceleration``: by which the set point of phi' moves, in rad/s^2; ``turn``: the
    fastest turn of the heading that is obeyed, in rad/s; ``turn_acceleration``: by
    which the set point of the turn rate moves, in rad/s^2. Raises ValueError if a
    number is negative or isn't finite.
    """

    speed: float = 0.0
    acceleration: float = 0.0
    turn: float = 0.0
    turn_acceleration: float = 0.0

    def __post_init__(self):
        for name in (x.name for x in fields(self)):
            if finite(name, getattr(self, name)) < 0:
                raise ValueError(f"{name} must be 0 or more, got {getattr(self, name)}")

    @classmethod
    def of(cls, mip, limit):
        """The limits of a pendulum and its motors.

        Both equations of motion added are free of the motors' torque: a
        steady acceleration of the wheels leans the body by
        (a + b - J) phi'' / d.

        ``mip``: the pendulum; ``limit``: the largest voltage, in V. Returns Drive: with
        a lean of 0.05 rad while the ramp lasts, and 40 % of the speed at which the
        limit just turns the motors.
        """
        return cls(
            speed=SPEED_SHARE * limit * mip.e / mip.f,
            acceleration=RAMP_LEAN * mip.d / (mip.a + mip.b - mip.J),
        )

    def turning(self, mip, robot):
        """The same, and how fast a robot may be told to turn.

        ``mip``: the pendulum; ``robot``: its track, wheels, and the share of the limit
        that steers. Returns Drive: 40 % of the turn rate that this share just holds,
        reached with half of the torque that it has.
        """
        per_radian = robot.track / robot.r
        volts = 2 * robot.steering * robot.limit  # on one side more than on the other
        inertia = max(inertia_bounds(mip, robot))
        return replace(
            self,
            turn=SPEED_SHARE * volts * mip.e / mip.f / per_radian,
            turn_acceleration=volts * mip.e / inertia / 2 / per_radian,
        )
