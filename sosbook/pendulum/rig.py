"""A simulated rig for the thesis's two experiments, with real sensors.

``python -m sosbook.pendulum.rig`` writes the logs that the package ships.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..deprecation import renamed
from ..plants.checks import positive
from .experiments import chirp, motion
from .log import Log
from .model import R_G, Mip

__all__ = ["COUNTS_PER_TURN", "DATA", "Rig", "shipped"]

__getattr__ = renamed(__name__, COUNTS="COUNTS_PER_TURN")

DATA = Path(__file__).parent / "data"
COUNTS_PER_TURN = 60 * R_G  # of a wheel: 60 a turn of the motor
GYRO_STEP = np.deg2rad(2000 / 2**15)  # rad/s: 16 bits over +-2000 deg/s
STEPS_PER_SAMPLE = 10  # of Runge and Kutta's method


@dataclass(frozen=True)
class Rig:
    """A robot in its two experiments.

    Parameters
    ----------
    mip : Mip
        The truth. It needs its ``I_w``.
    noise : float
        Standard deviation of the gyro's noise, in rad/s.
    offset : float
        What the gyro says at rest, in rad/s.
    friction : float
        Coulomb friction in the gearboxes: the voltage that just
        overcomes it, in V.
    second : (float, float)
        The second wheel's e and f, relative to the first one's. The
        default is the thesis's: (4.24) over (4.23).
    amplitude : float
        The amplitude of the chirps, in V.
    ideal : bool
        The sensors say the truth: no noise, offset or rounding.
    seed : int
        The seed of the noise.

    Raises
    ------
    ValueError
        If ``mip`` has no ``I_w``, or a number is negative.

    Notes
    -----
    Source: thesis sections 4.2.1, 4.2.2. The sensors are those of a
    small robot of this kind, for the thesis doesn't print its own: a
    gyro of 16 bits over +-2000 deg/s, with 0.1 deg/s of noise and half
    a degree per second at rest; 60 counts per turn of the motor.

    Examples
    --------
    >>> log = Rig().body()
    >>> len(log.t), log.T
    (6000, 0.01)
    """

    mip: Mip = field(default_factory=Mip.printed)
    noise: float = np.deg2rad(0.1)
    offset: float = np.deg2rad(0.5)
    friction: float = 0.0
    second: tuple = (208.5 / 208.8, 33.32 / 33.02)
    amplitude: float = 1.85
    ideal: bool = False
    seed: int = 2023

    def __post_init__(self):
        if self.mip.I_w is None:
            raise ValueError(
                "mip has no I_w: the wheels' experiment measures e / (2 I_w)"
            )
        for name in ("noise", "friction"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name} can't be negative")
        positive("amplitude", self.amplitude)

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

        Returns
        -------
        Log
            A log with t, V and gyro.
        """
        t, V = chirp(1, 20, amplitude=self.amplitude)
        x = self.ratios
        _, gyro = motion(
            -x["e_c"], x["f_c"], x["d_c"], V, t[1], self.friction, STEPS_PER_SAMPLE
        )
        if not self.ideal:
            random = np.random.default_rng(self.seed)
            gyro = gyro + self.noise * random.standard_normal(len(t))
            gyro += self.offset
            gyro = GYRO_STEP * np.round(gyro / GYRO_STEP)
        return Log(t, V, gyro=gyro)

    def wheels(self):
        """The log of section 4.2.2: on its back on the table.

        Returns
        -------
        Log
            A log with t, V, encoder1 and encoder2.
        """
        t, V = chirp(0.3, 30, amplitude=self.amplitude)
        x, random = self.ratios, np.random.default_rng(self.seed + 1)
        counts = []
        for e, f in ((1.0, 1.0), self.second):
            angle, _ = motion(
                e * x["e_a"],
                f * x["f_a"],
                0.0,
                V,
                t[1],
                self.friction,
                STEPS_PER_SAMPLE,
            )
            count = angle * COUNTS_PER_TURN / (2 * np.pi)
            if not self.ideal:  # it starts somewhere between two counts
                count = np.floor(count + random.random()) + 0.0
            counts.append(count)
        return Log(t, V, encoder1=counts[0], encoder2=counts[1])


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
