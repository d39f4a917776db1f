"""Pendulums side by side, moved by Runge and Kutta."""

from dataclasses import dataclass

import numpy as np

from ..plants.checks import finite, positive
from .model import Mip

__all__ = ["Fleet", "Push"]

STICTION_SPEED = 0.1  # rad/s, below which Coulomb friction fades


@dataclass(frozen=True)
class Push:
    """Two constant torques for a while.

    Parameters
    ----------
    at, length : float
        When the torques begin and how long they last, in s.
    body, wheels : float
        The torques on the equations of theta and phi, in N m. A horizontal
        force F at the height h above the axle is body = h F cos(theta), wheels
        = r F, and makes theta and phi grow.

    Examples
    --------
    >>> Push(at=1.0, length=0.1, body=0.05).torques(1.05)
    (0.05, 0.0)
    """

    at: float
    length: float
    body: float = 0.0
    wheels: float = 0.0

    def __post_init__(self):
        positive("length", self.length)
        for name in ("at", "body", "wheels"):
            finite(name, getattr(self, name))

    def torques(self, t):
        """The torques on theta and phi at the time t."""
        on = self.at <= t < self.at + self.length
        return (self.body, self.wheels) if on else (0.0, 0.0)


class Fleet:
    """Nonlinear pendulums side by side.

    Parameters
    ----------
    robots : sequence of Mip
        One pendulum for all runs, or one for each.
    friction : float
        Coulomb friction in the gears: the voltage that just overcomes it.
    """

    def __init__(self, robots, friction=0.0):
        self.friction = friction
        for name in "abcdefJ":
            values = [getattr(robot, name) for robot in robots]
            setattr(self, name, np.array(values))

    def acceleration(self, x, V, torques=(0.0, 0.0)):
        """z'' at the states x, under the voltage V and torques on theta and phi."""
        if self.friction:
            V = V - self.friction * np.tanh((x[3] - x[2]) / STICTION_SPEED)
        ddz = Mip.acceleration(self, x[:2], x[2:], V)
        if not any(torques):
            return ddz
        both, (w1, w2) = self.b * np.cos(x[0]) - self.J, torques
        return ddz + np.array([self.a * w1 - both * w2, self.c * w2 - both * w1]) / (
            self.a * self.c - both**2
        )

    def advance(self, x, V, torques, time, steps):
        """The states x after some ``time`` under a constant V, in ``steps`` steps.

        The torques act on theta and phi. A robot that has tipped over stays on
        the ground.
        """
        h = time / steps

        def rate(x):
            return np.concatenate([x[2:], self.acceleration(x, V, torques)]) * up

        for _ in range(steps):
            up = np.abs(x[0]) < np.pi / 2
            k1 = rate(x)
            k2 = rate(x + h / 2 * k1)
            k3 = rate(x + h / 2 * k2)
            k4 = rate(x + h * k3)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            if (np.abs(x[0]) >= np.pi / 2).any():
                lies = np.abs(x[0]) >= np.pi / 2
                x[0] = np.clip(x[0], -np.pi / 2, np.pi / 2)
                x[2:, lies] = 0
        return x
