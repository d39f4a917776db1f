"""A simulated rig for the thesis's two experiments, with real sensors.

``python -m sosbook.pendulum.rig`` writes the logs that the package ships.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..plants.checks import positive
from ..runtime.reading import read_toml
from .experiments import chirp, motion
from .log import Log
from .model import R_G, Mip

__all__ = ["COUNTS_PER_TURN", "DATA", "Rig", "gear_motors", "shipped"]

DATA = Path(__file__).parent / "data"
COUNTS_PER_TURN = 60 * R_G  # of a wheel: 60 a turn of the motor
GYRO_STEP = np.deg2rad(2000 / 2**15)  # rad/s: 16 bits over +-2000 deg/s
STEPS_PER_SAMPLE = 10  # of Runge and Kutta's method

#: One gear motor of the robot in ``gearmotors.toml``, and where it stands.
STALL_TORQUE, STALL_VOLTS, FREE_SPEED = 0.5, 12.0, 21.0  # N m, V, rad/s at the wheel
GEARS, ROTOR = 34.0, 4e-7  # turns of the rotor a turn, its inertia in kg m^2
GRAVITY = 9.81  # m/s^2


@dataclass(frozen=True)
class Rig:
    """A robot in the two experiments of sections 4.2.1 and 4.2.2.

    ``mip``: the truth, with its I_w; ``noise``: standard deviation of the gyro's, in
    rad/s; ``offset``: what the gyro says at rest, in rad/s; ``friction``: Coulomb's, in
    the gearboxes, in V; ``second``: the second wheel's e and f over the first one's, by
    default (4.24) over (4.23); ``amplitude``, ``rate``, ``seconds``: of the chirps: V,
    samples per second, and how long one sweeps, either way; ``counts``: an encoder's,
    per turn of a wheel; ``gyro_step``: of the gyro's 16 bits, in rad/s; ``ideal``: no
    noise, offset or rounding; ``seed``: of the noise. The sensors are those of a small
    robot of this kind, for the thesis doesn't print its own.
    """

    mip: Mip = field(default_factory=Mip.printed)
    noise: float = np.deg2rad(0.1)
    offset: float = np.deg2rad(0.5)
    friction: float = 0.0
    second: tuple = (208.5 / 208.8, 33.32 / 33.02)
    amplitude: float = 1.85
    rate: float = 100.0
    seconds: float = 30.0
    counts: float = COUNTS_PER_TURN
    gyro_step: float = GYRO_STEP
    ideal: bool = False
    seed: int = 2023

    def __post_init__(self):
        if self.mip.I_w is None:
            raise ValueError(
                "mip has no I_w: the wheels' experiment measures e / (2 I_w); give "
                "the inertia of a wheel with its gears, as Mip.printed() has it"
            )
        for name in ("noise", "friction"):
            if not getattr(self, name) >= 0:
                raise ValueError(
                    f"{name} can't be negative, got {getattr(self, name)!r}"
                )
        for name in ("amplitude", "rate", "seconds", "counts", "gyro_step"):
            positive(name, getattr(self, name))

    @classmethod
    def of(cls, robot, mip, **changes):
        """The rig of a described ``robot`` with equal wheels; ``mip`` is the truth.

        The chirps have a quarter of its limit, as the thesis's have of 7.4 V;
        ``**changes``: other parameters of `Rig`.
        """
        own = dict(
            second=(1.0, 1.0),
            amplitude=robot.limit / 4,
            rate=1 / robot.T,
            counts=robot.counts,
            gyro_step=robot.gyro_range / 2**15,
        )
        return cls(mip, **(own | changes))

    def _chirp(self, first, last):
        """The `chirp` between two frequencies in Hz, with this rig's clock."""
        return chirp(first, last, self.seconds, self.rate, self.amplitude)

    @property
    def ratios(self):
        """The truth as a dict: e_c, f_c, d_c, e_a, f_a of wheel 1."""
        x = self.mip
        return {
            "e_c": x.e / x.c,
            "f_c": x.f / x.c,
            "d_c": x.d / x.c,
            "e_a": x.e / (2 * x.I_w),
            "f_a": x.f / (2 * x.I_w),
        }

    def body(self):
        """The log of section 4.2.1: held by the wheels, upside down.

        Returns a log with t, V and gyro.
        """
        t, V = self._chirp(1, 20)
        x = self.ratios
        how = V, t[1], self.friction, STEPS_PER_SAMPLE
        _, gyro = motion(-x["e_c"], x["f_c"], x["d_c"], *how)
        if not self.ideal:
            random = np.random.default_rng(self.seed)
            gyro = gyro + self.noise * random.standard_normal(len(t))
            gyro += self.offset
            gyro = self.gyro_step * np.round(gyro / self.gyro_step)
        return Log(t, V, gyro=gyro)

    def wheels(self):
        """The log of section 4.2.2: on its back on the table.

        Returns a log with t, V, encoder1 and encoder2.
        """
        t, V = self._chirp(0.3, 30)
        x, random = self.ratios, np.random.default_rng(self.seed + 1)
        counts = []
        for e, f in ((1.0, 1.0), self.second):
            how = V, t[1], self.friction, STEPS_PER_SAMPLE
            angle, _ = motion(e * x["e_a"], f * x["f_a"], 0.0, *how)
            count = angle * self.counts / (2 * np.pi)
            if not self.ideal:  # it starts somewhere between two counts
                count = np.floor(count + random.random()) + 0.0
            counts.append(count)
        return Log(t, V, encoder1=counts[0], encoder2=counts[1])


def gear_motors():
    """The robot that ``gearmotors.toml`` describes, as its parts make it: a `Mip`.

    Two 12 V motors with gears of 1:34 that stall at 0.5 N m and turn freely with 21
    rad/s, disc wheels, and a body whose inertia about the axle is 1.4 M_b l^2.
    """
    robot = read_toml(DATA / "gearmotors.toml")
    M_b, l, r, M_w = (robot[x] for x in ("M_b", "l", "r", "M_w"))
    J = 2 * GEARS**2 * ROTOR
    double = M_w * r**2 + J  # 2 I_w: two discs and two rotors
    a, b, c = r**2 * (M_b + 2 * M_w) + double, M_b * l * r, 1.4 * M_b * l**2 + J
    e, f = 2 * STALL_TORQUE / STALL_VOLTS, 2 * STALL_TORQUE / FREE_SPEED
    return Mip(a, b, c, M_b * GRAVITY * l, e, f, I_w=double / 2, J=J)


def shipped(name):
    """A log that the package ships.

    Parameters
    ----------
    name : {"body", "wheels"}

    Returns
    -------
    Log
        The log of that experiment.

    Examples
    --------
    >>> shipped("wheels").encoder2[:3]
    array([0., 0., 0.])
    """
    if name not in ("body", "wheels"):
        raise ValueError(f"name must be 'body' or 'wheels', got {name!r}")
    return Log.read(DATA / f"{name}.csv")


def main(folder=DATA):
    """Write the shipped logs."""
    rig = Rig()
    rig.body().write(Path(folder) / "body.csv")
    rig.wheels().write(Path(folder) / "wheels.csv")


if __name__ == "__main__":
    main()
