"""Robots as shops sell them: gears with play, coarse counts, sagging batteries.

Nothing here comes from the package. The motion is that of a chain: body,
motor's side of the gears, wheels, each with its momentum. Between the motor's
side and the wheels there is a gap; a spring and a damper push where it is
closed, and never pull. Friction is Coulomb's, dry: it takes from a speed what
it can and stops there.
"""

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

G = 9.81
CONTACT_HERTZ, CONTACT_DAMPING = 70.0, 0.3  # of the gears' teeth on the motor's side
STEP = 2.5e-4  # s, of the simulation


@dataclass(frozen=True)
class Geared:
    """A robot's parts in SI units; the motors' numbers are of both together.

    stall and free at V_n; the rotors' inertia at the wheels; play in degrees at
    the wheels; rub in V. What its electronics and its owner do wrong comes last.
    """

    name: str
    M_b: float
    l: float
    r: float
    M_w: float
    V_n: float
    stall: float
    free: float
    rotors: float
    gears: float
    counts: float
    T: float
    delay: float
    play: float = 0.0
    rub: float = 0.0
    shape: float = 1.35  # inertia about the axle over M_b l^2
    seen: str = "motor"  # the encoder's side of the gap
    dead: float = 0.02  # duty below which the bridge does nothing
    bits: int = 255  # steps of the duty
    sag: float = 0.03  # of the battery under the whole load
    gyro: float = 1.02  # what the gyro makes of one
    offset: float = 0.0105  # rad/s
    drift: float = 2e-5  # rad/s^2
    noise: float = 0.0017  # rad/s
    askew: float = 0.035  # rad, of the board about the axle
    jitter: float = 0.0005
    left: float = 1.0  # what the left motor does of its half; 0 if it is dead
    right: float = 1.0

    @property
    def e(self):
        return self.stall / self.V_n

    @property
    def f(self):
        return self.stall / self.free

    @property
    def I_o(self):
        return self.shape * self.M_b * self.l**2

    @property
    def disc(self):
        return self.M_w * self.r**2  # of both wheels

    @property
    def truth(self):
        """The five ratios, of the stiff robot."""
        c, a = self.I_o + self.rotors, self.disc + self.rotors
        d = self.M_b * G * self.l
        return dict(
            e_c=self.e / c, f_c=self.f / c, d_c=d / c, e_a=self.e / a, f_a=self.f / a
        )

    def bridge(self, V):
        """The volts at the motors where V is asked for."""
        duty = round(self.bits * max(-1.0, min(1.0, V / self.V_n))) / self.bits
        if abs(duty) < self.dead:
            return 0.0
        return duty * self.V_n * (1 - self.sag * abs(duty))


class Chain:
    """A robot in motion.

    ``held`` is "wheels" (upside down), "body" (on its back) or None (it stands).
    theta is from upright, from hanging where the wheels are held.
    """

    def __init__(self, robot, held=None, theta=0.0, slope=0.0):
        self.robot, self.held, self.slope = robot, held, slope
        self.theta, self.motor, self.wheel = theta, 0.0, -theta if not held else 0.0
        self.w = self.dm = self.dw = 0.0
        self.acceleration = 0.0, 0.0  # of theta and of the wheels against the ground
        x = robot
        parts = [x.rotors, {"wheels": x.I_o, "body": x.disc, None: x.disc}[held]]
        least = 1 / sum(1 / p for p in parts)
        self.stiff = (2 * pi * CONTACT_HERTZ) ** 2 * least
        self.damper = 2 * CONTACT_DAMPING * (2 * pi * CONTACT_HERTZ) * least
        self.half = np.radians(x.play) / 2

    def push(self):
        """The torque from the motor's side to the wheels."""
        apart, speed = self.motor - self.wheel, self.dm - self.dw
        if apart > self.half:
            return max(self.stiff * (apart - self.half) + self.damper * speed, 0.0)
        if apart < -self.half:
            return min(self.stiff * (apart + self.half) + self.damper * speed, 0.0)
        return 0.0

    def advance(self, volts, time, shove=0.0):
        """Go on for a ``time`` with ``volts`` at the motors (left, right)."""
        x, n = self.robot, max(round(time / STEP), 1)
        h, e, f, J = time / n, x.e, x.f, x.rotors
        drive = e * (x.left * volts[0] + x.right * volts[1]) / 2
        dry = e * x.rub
        weight, lever, I_o = x.M_b * G * x.l, x.M_b * x.l * x.r, x.I_o
        roll = x.r**2 * (x.M_b + 2 * x.M_w) + x.disc
        down = x.r * (x.M_b + 2 * x.M_w) * G * sin(self.slope)
        most, lag, half = h * dry / J, h * f / (2 * J), h / 2
        for _ in range(n):
            # half a step of the places, one of the speeds, half a step of the places
            self.theta += half * self.w
            self.motor += half * self.dm
            self.wheel += half * self.dw
            push = self.push()
            if self.held == "wheels":
                # both sides act on the body; the wheel stands still
                dw = h * (-weight * sin(self.theta) - push) / I_o
                self.w += dw
                self.dw = -self.w
            elif self.held == "body":
                self.dw += h * push / x.disc
                dw = 0.0
            else:
                # theta and phi = theta + wheel: d/dt of both momenta
                w, v = self.w, self.w + self.dw
                off = lever * cos(self.theta)
                p = weight * sin(self.theta) - push + shove
                q = lever * sin(self.theta) * w * w + push - down
                det = I_o * roll - off * off
                dw = h * (roll * p - off * q) / det
                dv = h * (I_o * q - off * p) / det
                self.w, v = w + dw, v + dv
                self.dw = v - self.w
                self.acceleration = dw / h, dv / h
            # the rotor turns N times against the body, and with it
            speed = self.dm * (1 - lag) + h * (drive - push) / J - dw / x.gears
            speed /= 1 + lag
            self.dm = speed - max(-most, min(most, speed))
            self.theta += half * self.w
            self.motor += half * self.dm
            self.wheel += half * self.dw

    @property
    def angle(self):
        """What the encoders see, in rad."""
        return self.motor if self.robot.seen == "motor" else self.wheel


def sine(ends, seconds, T, amplitude):
    """A sine that goes from one frequency to another and back, sample by sample."""
    turns, volts = 0.0, []
    for k in range(round(2 * seconds / T)):
        s = min(k * T, 2 * seconds - k * T)
        volts.append(amplitude * sin(2 * pi * turns))
        turns += T * (ends[0] + (ends[1] - ends[0]) * s / seconds)
    return np.round(volts, 4)


def experiment(robot, name, volts, seed=0, alone=None):
    """The log of an experiment: columns by their names.

    The clock comes late by chance and the time stamps say so.
    """
    random = np.random.default_rng(seed)
    chain = Chain(robot, {"body": "wheels", "wheels": "body"}[name])
    count = robot.counts / (2 * pi)
    late = robot.jitter * random.random(len(volts))
    t = np.arange(len(volts)) * robot.T + late
    steps = np.append(np.diff(t), robot.T)
    speed, angle = [], []
    for k, (V, h) in enumerate(zip(volts.tolist(), steps.tolist())):
        speed.append(chain.w)
        angle.append(chain.angle)
        u = robot.bridge(V)
        both = {0: (u, u), 1: (2 * u, 0.0), 2: (0.0, 2 * u)}[
            alone[k] if alone is not None else 0
        ]
        chain.advance(both, h)
    if name == "body":
        gyro = robot.gyro * np.array(speed) + robot.offset + robot.drift * t
        gyro += robot.noise * random.standard_normal(len(t))
        step = np.radians(1000) / 2**15
        log = {"t": t, "V": volts, "gyro": step * np.round(gyro / step)}
    else:
        starts = random.random(2)
        counts = [np.floor(np.array(angle) * count + x) for x in starts]
        log = {"t": t, "V": volts, "encoder1": counts[0], "encoder2": counts[1]}
    if alone is not None:
        log["alone"] = np.array(alone)
    return log


TABLE = """
name  M_b  l     r      M_w   V_n stall free rotors  gears counts T     delay  play rub
n20   0.46 0.055 0.0325 0.03  6   0.25  42   1.5e-4  50    1400   0.01  0.002  2    0.25
hub   2.5  0.12  0.085  1     12  4     24   1e-3    1     90     0.005 0.001  0    0.15
tele  6    0.6   0.1    0.3   24  7     20   0.02    30    2000   0.01  0.002  1    0.6
lego  0.68 0.1   0.028  0.02  9   0.7   17   9e-4    40    360    0.02  0.003  2    0.4
"""


def machines():
    """The robots of the table, by their names."""
    names, *rows = (line.split() for line in TABLE.strip().splitlines())
    return {
        row[0]: Geared(row[0], **dict(zip(names[1:], map(float, row[1:]))))
        for row in rows
    }


ALL = machines()
