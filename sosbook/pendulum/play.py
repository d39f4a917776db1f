"""Pendulums whose gears have play: the motors' rotors are a body of their own.

Between the rotors, with the encoders, and the wheels lies a gap. In it the motors turn
nothing but themselves; at its ends the teeth push like a spring with a damper.
"""

import math

import numpy as np

from .fleet import STICTION_SPEED, UPSET, Fleet

__all__ = ["Geared"]

#: Of the rotors against the wheels through the teeth, in Hz, and its damping. Nobody
#: knows those of gears: these ring like steel on a plastic hub, and fade in a cycle.
TEETH_HERTZ, TEETH_DAMPING = 70.0, 0.3
LONGEST_STEP = 5e-4  # s: a thirtieth of their period
ROTORS_SHARE = 0.1  # of what rolls with the wheels, where the pendulum has no J


class Geared(Fleet):
    """A `Fleet` with play, whose robots are moved one by one.

    Parameters
    ----------
    robots : sequence of Mip
        One for all runs, or one for each.
    gap : float
        The play in rad of a wheel, from one end to the other.
    friction : float
        As in `Fleet`.
    runs : int
        How many runs there are.
    """

    def __init__(self, robots, gap, friction, runs):
        super().__init__(robots, friction)
        self.half, self.rotors = gap / 2, None
        self.robots = self.robots * (runs if len(self.robots) == 1 else 1)

    def seen(self, x):
        """The states x with the angle and the rate of the rotors for the wheels'."""
        if self.rotors is None:
            self.rotors = np.array(x[[1, 3]])
        return np.stack([x[0], self.rotors[0], x[2], self.rotors[1]])

    def acceleration(self, x, V, torques=(0.0, 0.0)):
        """z'' at the states x, under the voltage V and torques on theta and phi."""
        self.seen(x)
        volts = np.broadcast_to(V, x.shape[1])
        states = zip(self.robots, self._whole(x), volts.tolist())
        return np.array([self._rates(m, v, torques)(s)[3:5] for m, s, v in states]).T

    def advance(self, x, V, torques, time, steps):
        """The states x after a ``time`` under a constant V and torques.

        It takes at least so many ``steps``.
        """
        self.seen(x)
        steps = max(steps, math.ceil(time / LONGEST_STEP))
        volts = np.broadcast_to(V, x.shape[1]).tolist()
        ends = np.array(
            [
                _moved(state, self._rates(mip, volt, torques), time / steps, steps)
                for mip, state, volt in zip(self.robots, self._whole(x), volts)
            ]
        ).T
        self.rotors = ends[[2, 5]]
        return ends[[0, 1, 3, 4]]

    def _whole(self, x):
        """[theta, phi, rho, and their rates] of each robot, in plain numbers."""
        angle, rate = self.rotors
        return np.array([x[0], x[1], angle, x[2], x[3], rate]).T.tolist()

    def _rates(self, mip, V, torques):
        """The rates of a robot's states under a voltage and torques."""
        own = mip.J  # of the rotors, as far as the pendulum's equations have them
        J = own or ROTORS_SHARE * mip.a
        wheels, body = mip.a - J, mip.c - own
        both, half = J * wheels / (J + wheels), self.half
        k = both * (2 * math.pi * TEETH_HERTZ) ** 2
        damper = 2 * TEETH_DAMPING * math.sqrt(k * both)

        def rates(x):
            theta, phi, rho, w, v, n = x
            twist = rho - phi
            over = twist - math.copysign(half, twist) if abs(twist) > half else 0.0
            bite = k * over + damper * (n - v) if over else 0.0
            bite = bite if bite * over > 0 else 0.0  # teeth push and never pull
            volts = V - self.friction * math.tanh((n - w) / STICTION_SPEED)
            torque = mip.e * volts - mip.f * (n - w)
            sin, lean = math.sin(theta), mip.b * math.cos(theta)
            p = mip.d * sin - (bite if own else torque) + torques[0]
            q = mip.b * sin * w * w + bite + torques[1]
            size = body * wheels - lean * lean
            tips = (wheels * p - lean * q) / size
            spins = (torque - bite) / J + (tips if own else 0.0)
            return [w, v, n, tips, (body * q - lean * p) / size, spins]

        return rates


def _moved(x, rates, h, steps):
    """The state x after some steps of length h by Heun's method."""
    for _ in range(steps):
        if abs(x[0]) >= UPSET:
            return [math.copysign(UPSET, x[0]), x[1], x[2], 0.0, 0.0, 0.0]
        a = rates(x)
        b = rates([p + h * s for p, s in zip(x, a)])
        x = [p + h / 2 * (s + t) for p, s, t in zip(x, a, b)]
    return x
