"""The battery and the gears of a simulated robot."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..plants.checks import finite, positive

__all__ = ["Drivetrain"]


@dataclass(frozen=True, eq=False)
class Drivetrain:
    """The battery and the gears between a command and the wheels.

    Parameters
    ----------
    friction : float
        Coulomb friction in the gears, in V.
    backlash : float
        Play between the wheels and the motors, whose rotors and encoders turn on in
        it: in rad of a wheel, from one end to the other.
    battery : float or callable, optional
        Its voltage under load, in V, or a function of t that gives it. The
        motors get no more, whatever is asked for.
    nominal : float, optional
        A program that doesn't measure its battery takes it for this, in V: the
        motors get battery / nominal of what is asked for. Without it the
        battery is measured.

    Raises
    ------
    ValueError
        On negative friction or play, or a ``nominal`` without a battery.

    Examples
    --------
    >>> Drivetrain(battery=6.0).gives(np.array([2.0, -9.0]), 0.0)
    array([ 2., -6.])
    """

    friction: float = 0.0
    backlash: float = 0.0
    battery: Any = None
    nominal: float | None = None

    def __post_init__(self):
        """Check the numbers."""
        for name in ("friction", "backlash"):
            value = getattr(self, name)
            if finite(name, value) < 0:
                raise ValueError(f"{name} must be 0 or more, got {value!r}")
        if self.nominal is not None:
            if self.battery is None:
                raise ValueError("nominal is what a battery is taken for: give battery")
            positive("nominal", self.nominal)

    def gives(self, V, t):
        """The voltages (runs,) in V that the motors get at the time ``t``, in s."""
        if self.battery is None:
            return V
        there = self.battery(t) if callable(self.battery) else self.battery
        there = positive("battery", there)
        scale = 1.0 if self.nominal is None else there / self.nominal
        return np.clip(scale * V, -there, there)
