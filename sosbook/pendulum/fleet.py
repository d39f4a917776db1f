"""Pendulums side by side, moved by Runge and Kutta."""

import math
from dataclasses import dataclass

import numpy as np

from ..plants.checks import finite, positive
from .model import accelerated

__all__ = ["Fleet", "Push"]

STICTION_SPEED = 0.1  # rad/s, below which Coulomb friction fades
UPSET = math.pi / 2  # rad, at which a robot lies on the ground
FEW = 24  # robots that go faster one by one in plain numbers than side by side


@dataclass(frozen=True)
class Push:
    """Two constant torques for a while.

    ``at``, ``length``: when they begin and how long they last, in s; ``body``,
    ``wheels``: on the equations of theta and phi, in N m. A horizontal force F at the
    height h above the axle is body = h F cos(theta), wheels = r F, and makes theta and
    phi grow.
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

    ``robots``: one pendulum for all runs, or one for each; ``friction``: coulomb
    friction in the gears: the voltage that just overcomes it.
    """

    def __init__(self, robots, friction=0.0):
        self.friction, self.robots = friction, list(robots)
        for name in "abcdefJ":
            values = [getattr(robot, name) for robot in robots]
            setattr(self, name, np.array(values))

    def seen(self, x):
        """The states x as encoders at the motors follow them, without play."""
        return x

    def acceleration(self, x, V, torques=(0.0, 0.0)):
        """z'' at the states x, under the voltage V and torques on theta and phi."""
        return np.array(self._rate(self, np, V, torques)(x[0], x[2], x[3]))

    def advance(self, x, V, torques, time, steps):
        """The states x after some ``time`` under a constant V, in ``steps`` steps.

        The torques act on theta and phi. A robot that has tipped over stays on
        the ground.
        """
        h, runs = time / steps, x.shape[1]
        if runs > FEW:
            return self._together(x, self._rate(self, np, V, torques), h, steps)
        robots = self.robots * (runs if len(self.robots) == 1 else 1)
        ends = [
            _alone(state, self._rate(mip, math, volt, torques), h, steps)
            for mip, state, volt in zip(robots, x.T.tolist(), listed_for(x, V))
        ]
        return np.array(ends).T

    def _rate(self, mip, library, V, torques):
        """A function from theta, theta' and phi' to theta'' and phi''.

        They are numbers or arrays, of which the ``library`` has sin, cos and tanh.
        """

        def rate(theta, dtheta, dphi):
            volts = V
            if self.friction:
                slip = library.tanh((dphi - dtheta) / STICTION_SPEED)
                volts = V - self.friction * slip
            sin, cos = library.sin(theta), library.cos(theta)
            return accelerated(mip, sin, cos, dtheta, dphi, volts, torques)

        return rate

    @staticmethod
    def _together(x, rate, h, steps):
        """The states x after some steps of length h, in arrays."""
        for _ in range(steps):
            up = np.abs(x[0]) < UPSET
            x = np.where(up, _stepped(x, rate, h), x)
            lies = np.abs(x[0]) >= UPSET
            if lies.any():
                x[0] = np.clip(x[0], -UPSET, UPSET)
                x[2:, lies] = 0
        return x


def listed_for(x, V):
    """The voltages V, one or one for each run of x, as a list for each run."""
    V, runs = np.asarray(V, float), x.shape[1]
    return V.tolist() if V.shape == (runs,) else [V.item()] * runs


def _alone(state, rate, h, steps):
    """One robot's state after some steps of length h, in plain numbers."""
    for _ in range(steps):
        if abs(state[0]) >= UPSET:
            break
        try:
            state = _stepped(state, rate, h)
        except ValueError:  # there is no sine of infinity
            return [math.nan] * 4
    if abs(state[0]) >= UPSET:
        return [math.copysign(UPSET, state[0]), state[1], 0.0, 0.0]
    return state


def _stepped(state, rate, h):
    """[theta, phi, theta', phi'] a step of Runge and Kutta's later."""
    theta, phi, w1, p1 = state
    half, sixth = h / 2, h / 6
    a1, b1 = rate(theta, w1, p1)
    w2, p2 = w1 + half * a1, p1 + half * b1
    a2, b2 = rate(theta + half * w1, w2, p2)
    w3, p3 = w1 + half * a2, p1 + half * b2
    a3, b3 = rate(theta + half * w2, w3, p3)
    w4, p4 = w1 + h * a3, p1 + h * b3
    a4, b4 = rate(theta + h * w3, w4, p4)
    return [
        theta + sixth * (w1 + 2 * (w2 + w3) + w4),
        phi + sixth * (p1 + 2 * (p2 + p3) + p4),
        w1 + sixth * (a1 + 2 * (a2 + a3) + a4),
        p1 + sixth * (b1 + 2 * (b2 + b3) + b4),
    ]
