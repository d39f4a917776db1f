"""A robot that turns, too: own equations of six_robots' machines in the plane.

x = [theta, phi, psi, theta', phi', psi'], phi the mean of both wheels' angles
against the ground, psi the heading, positive to the left. The body's centre of
mass and its inertia about the vertical move as it tips; a wheel's motor may be
stronger than the other's.
"""

import ctypes
from dataclasses import dataclass
from math import cos, sin, tanh

import numpy as np

from tests.six_robots import SIX, Machine, advance

__all__ = ["Turner", "drive"]


@dataclass(frozen=True)
class Turner:
    """A machine with two motors, ``more`` and less strong, on a ``track``."""

    machine: Machine
    track: float
    upright: float  # the body's inertia about the vertical, upright
    more: float = 0.0  # of e at the right motor, over the mean
    brake: float = 0.0  # of f likewise

    def torques(self, volts, x):
        """Of the left and the right motor, both motors' e and f halved."""
        m, turns = self.machine, self._against_the_body(*x[3:])
        return [
            m.e / 2 * (1 + self.more * side) * (V - m.friction * tanh(turn / 0.05))
            - m.f / 2 * (1 + self.brake * side) * turn
            for side, V, turn in zip((-1, 1), volts, turns)
        ]

    def wheels(self, q):
        """Left and right against the body, of angles or of rates."""
        return np.array(self._against_the_body(*q))

    def _against_the_body(self, tip, roll, turn):
        half = self.track / 2 / self.machine.r * turn
        return roll - tip - half, roll - tip + half

    def inertia(self, theta):
        """About the vertical, wheels and rotors with it; and its slope."""
        m, lever = self.machine, self.track / 2
        wheels = 2 * m.M_w * lever**2 + (2 * m.I_w + m.J) * (lever / m.r) ** 2
        sine, cosine = sin(theta), cos(theta)
        return (
            self.upright * cosine**2 + m.I_o * sine**2 + wheels,
            2 * (m.I_o - self.upright) * sine * cosine,
        )

    def rate(self, x, volts):
        m, (theta, _, _, w, v, turn) = self.machine, x
        left, right = self.torques(volts, x)
        I, slope = self.inertia(theta)
        body, roll = m.I_o + m.J, m.rolling + m.J
        off, lean = m.lever * cos(theta) - m.J, m.lever * sin(theta)
        p = m.weight * sin(theta) + slope * turn**2 / 2 - (left + right)
        q = lean * (w**2 + turn**2) + (left + right)
        det = body * roll - off**2
        ddtheta, ddphi = (roll * p - off * q) / det, (body * q - off * p) / det
        yaw = self.track / 2 / m.r * (right - left)
        ddpsi = (yaw - slope * w * turn - lean * v * turn) / I
        return w, v, turn, ddtheta, ddphi, ddpsi

    def energy(self, x):
        m, (theta, w, v, turn) = self.machine, x[[0, 3, 4, 5]]
        return (
            m.I_o * w**2 / 2
            + m.rolling * v**2 / 2
            + m.lever * np.cos(theta) * w * v
            + m.J * (v - w) ** 2 / 2
            + self.inertia(theta)[0] * turn**2 / 2
            + m.weight * np.cos(theta)
        )


def drive(turner, volts_of, speed=0.0, turn=0.0, seconds=12.0, tilt=0.05, seed=0):
    """The path (k, 6) and the volts (k, 2) of a robot that is told to move.

    ``volts_of`` takes gyro, left, right, tilt and the set points of phi, phi',
    psi and psi', and gives the volts of both motors; the set points rise for
    two seconds.
    """
    m, random = turner.machine, np.random.default_rng(seed)
    x, volts, path, given = np.zeros(6), np.zeros(2), [], []
    x[0], points, now = tilt, np.zeros(4), 0.0
    count = 2 * np.pi / m.counts
    for k in range(round(seconds / m.T)):
        at = k * m.T
        x = advance(turner.rate, x, volts, at - now, 4)
        rise = min(at / 2, 1.0)
        points[1::2] = rise * speed, rise * turn
        points[0::2] += points[1::2] * m.T
        left, right = count * np.floor(turner.wheels(x[:3]) / count)
        gyro = x[3] + 0.002 * random.standard_normal()
        level = x[0] + 0.01 * random.standard_normal()
        now = at + m.delay * random.random()
        x = advance(turner.rate, x, volts, now - at, 2)
        volts = np.array(volts_of(gyro, left, right, level, *points))
        path.append(np.concatenate([x, points]))
        given.append(volts)
        if abs(x[0]) > 1.2:
            break
    return np.array(path), np.array(given)


def ramp(drive, wanted, T, count, start=(0.0, 0.0)):
    """Set points of phi and phi' for a speed that is wanted, tick by tick.

    Of a ``drive``'s speed and acceleration, as the programs shall compute it; ``start``
    has those before.
    """
    wanted = min(max(wanted, -drive.speed), drive.speed)
    (target, rate), step, points = start, drive.acceleration * T, []
    for _ in range(count):
        rate = rate + min(max(wanted - rate, -step), step)
        target = target + rate * T
        points.append((target, rate))
    return points


#: The first of the six, which has a track of 70 mm here.
TURNER = Turner(SIX[0], 0.07, 1.5e-4)


def steer_functions(library, real):
    """State, volts, start and step of a library of balance_steer.c in a precision."""
    fields = [*[(x, real) for x in ("turned", "zero", "sum")], ("lost", ctypes.c_int)]
    State = type("State", (ctypes.Structure,), {"_fields_": fields})
    start, step = library.balance_steer_start, library.balance_steer
    start.argtypes = [ctypes.POINTER(State), real, real]
    numbers = [*4 * [real], ctypes.POINTER(real)]
    step.argtypes = [ctypes.POINTER(State), ctypes.c_void_p, *numbers]
    start.restype = step.restype = None
    return State(), (real * 2)(), start, step
