"""Six robots by an independent simulator: own equations, own sensors.

No equation of motion here comes from the package: Lagrange's equations of a body, two
wheels and two motors with rotors that turn against the body, Coulomb
friction in the gears, a gyro and encoders with steps, and
accelerometers that feel how the body moves. q = (theta, phi), phi the
wheels' angle against the ground.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, sin, tanh

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from sosbook.pendulum import Mip, Robot

G = 9.81


@dataclass(frozen=True)
class Machine:
    """A robot's parts, in SI units.

    The motor: stall torque and free speed of one gear motor at V_n, its
    rotor's inertia and its gears; friction is the voltage that they eat.
    """

    name: str
    M_b: float
    l: float
    r: float
    M_w: float
    stall: float
    free: float
    V_n: float
    gears: float
    rotor: float
    counts: float
    T: float
    delay: float
    friction: float = 0.0
    shape: float = 1.4  # inertia about the axle over M_b l^2
    law: str = "gain"

    @cached_property
    def J(self):
        """Both rotors, as seen at the wheels."""
        return 2 * self.gears**2 * self.rotor

    @cached_property
    def I_w(self):
        """One wheel: a disc, without the rotor."""
        return self.M_w * self.r**2 / 2

    @cached_property
    def e(self):
        return 2 * self.stall / self.V_n

    @cached_property
    def f(self):
        return 2 * self.stall / self.free

    @cached_property
    def I_o(self):
        return self.shape * self.M_b * self.l**2

    @cached_property
    def rolling(self):
        """The factor of phi'^2 / 2 in the energy, but for the rotors."""
        return self.r**2 * (self.M_b + 2 * self.M_w) + 2 * self.I_w

    @cached_property
    def weight(self):
        return self.M_b * G * self.l

    @cached_property
    def lever(self):
        return self.M_b * self.l * self.r

    @property
    def truth(self):
        """The five ratios, of the stiff robot."""
        c, a = self.I_o + self.J, 2 * self.I_w + self.J
        over = dict(e_c=self.e / c, f_c=self.f / c, d_c=self.weight / c)
        return over | dict(e_a=self.e / a, f_a=self.f / a)

    def torque(self, V, speed):
        """Of both motors between body and wheels, gears' friction off."""
        rub = self.friction and self.e * self.friction * tanh(speed / 0.05)
        return self.e * V - self.f * speed - rub

    def rate(self, x, V):
        """x = [theta, phi, theta', phi'] on the ground."""
        theta, _, w, v = x
        sine, J = sin(theta), self.J
        # 2 T = I_o w^2 + 2 M_b l r cos w v + m v^2 + J (v - w)^2
        off = self.lever * cos(theta) - J
        A, C = self.I_o + J, self.rolling + J
        tau = self.torque(V, v - w)
        p = self.weight * sine - tau
        q = self.lever * sine * w**2 + tau
        det = A * C - off**2
        return w, v, (C * p - off * q) / det, (A * q - off * p) / det

    def hanging(self, x, V):
        """x = [q, q'], wheels held, the body upside down."""
        q, w = x
        tau = self.torque(V, -w)
        return w, (-self.weight * sin(q) - tau) / (self.I_o + self.J)

    def spinning(self, x, V):
        """x = [phi, phi'], on its back, wheels in the air."""
        _, v = x
        return v, self.torque(V, v) / (2 * self.I_w + self.J)


def advance(rate, x, V, time, steps):
    """The state x after a time by Runge and Kutta, in floats: few are slow in numpy."""
    x, V = np.asarray(x, float).tolist(), np.asarray(V, float).tolist()
    h = time / steps
    half, sixth = h / 2, h / 6
    for _ in range(steps):
        a = rate(x, V)
        b = rate([p + half * s for p, s in zip(x, a)], V)
        c = rate([p + half * s for p, s in zip(x, b)], V)
        d = rate([p + h * s for p, s in zip(x, c)], V)
        slopes = zip(x, a, b, c, d)
        x = [p + sixth * (i + 2 * j + 2 * k + l) for p, i, j, k, l in slopes]
    return np.array(x)


def sweep(first, last, seconds, T, amplitude):
    """A sine from one frequency to another and back."""
    t = T * np.arange(round(2 * seconds / T))
    there = np.where(t <= seconds, t, 2 * seconds - t)
    turns = first * there + (last - first) * there**2 / (2 * seconds)
    turns = np.where(t <= seconds, turns, (first + last) * seconds - turns)
    return t, np.round(amplitude * np.sin(2 * np.pi * turns), 3)


def moved(rate, volts, T):
    """Angle and rate at the samples of an experiment, from rest."""
    x, path = np.zeros(2), []
    for u in volts:
        path.append(x)
        x = advance(rate, x, u, T, 8)
    return np.array(path).T


def logs(machine, seed=0, seconds=10.0):
    """(t, V, gyro) and (t, V, counts, counts), as a computer logs them."""
    random = np.random.default_rng(seed)
    volts = max(0.35 * machine.V_n, 3 * machine.friction)
    swing = np.sqrt(G / machine.l / machine.shape) / 2 / np.pi
    t, V = sweep(0.3 * swing, 6 * swing, seconds, machine.T, volts)
    step = np.deg2rad(1000) / 2**15
    gyro = 0.007 + moved(machine.hanging, V, machine.T)[1]
    gyro = gyro + 0.002 * random.standard_normal(len(t))
    gyro = step * np.round(gyro / step)
    corner = machine.f / (2 * machine.I_w + machine.J) / 2 / np.pi
    t2, V2 = sweep(
        0.1 * corner, min(4 * corner, 0.2 / machine.T), seconds, machine.T, volts
    )
    angle = moved(machine.spinning, V2, machine.T)[0] * machine.counts / (2 * np.pi)
    counts = [np.floor(angle + random.random()) for _ in range(2)]
    return (t, V, gyro), (t2, V2, *counts)


def balancing(machine, drive=0.0, seed=0, samples=1500):
    """(t, V, gyro, counts) of a robot on its wheels, upright, under its own controller,
    which drives so far to and fro, in rad.
    """
    random, T = np.random.default_rng(seed), machine.T
    h = 1e-6 * np.eye(5)
    rates = [np.array(machine.rate(x[:4], x[4])) / 1e-6 for x in h]
    E = expm(T * np.vstack([np.array(rates).T, np.zeros((1, 5))]))
    A, B = E[:4, :4], E[:4, 4:]
    P = solve_discrete_are(A, B, np.diag([1, 0.1, 0.01, 0.01]), [[0.05]])
    K = np.linalg.solve(0.05 + B.T @ P @ B, B.T @ P @ A)[0]
    x, rows = np.array([0.05, 0, 0, 0]), []
    for k in range(samples):
        seen = x + random.standard_normal(4) * [2e-3, 2e-3, 5e-3, 2e-2]
        seen[1] -= drive * np.sign(np.sin(k * T))
        V = round(float(np.clip(-K @ seen, -machine.V_n, machine.V_n)), 3)
        counts = np.floor((x[1] - x[0]) * machine.counts / (2 * np.pi))
        rows.append((k * T, V, seen[2] + 0.006, counts))
        x = advance(machine.rate, x, V, T, 3)
    return np.array(rows).T


def write(path, names, columns):
    rows = [",".join(f"{v:.9g}" for v in row) for row in zip(*columns)]
    path.write_text("\n".join([names, *rows]) + "\n", "utf-8")


#: What a machine of the tests and a robot's description call alike.
PARTS = "M_b", "l", "r", "M_w", "counts"


def by_its_sheet(machine, **more):
    """As its owner describes it: the sheet's numbers, and a pair of scales."""
    facts = {key: getattr(machine, key) for key in (*PARTS, "name", "T", "delay")}
    own = dict(gyro_range=34.9, limit=machine.V_n, rotors=True, jitter=0.0005)
    return Robot(**facts | own | more)


def wired(machine, **more):
    """The thesis's robot with a machine's parts."""
    facts = {key: getattr(machine, key) for key in PARTS}
    return Robot.shipped("thesis").but(**facts, rotors=True, g=G, **more)


def pendulum(m):
    """The machine's own numbers."""
    a = m.r**2 * (m.M_b + 2 * m.M_w) + 2 * m.I_w + m.J
    I_w = m.I_w + m.J / 2
    return Mip(a, m.lever, m.I_o + m.J, m.weight, m.e, m.f, I_w=I_w, J=m.J)


def spared(found, **known):
    """A deployment whose slow facts are given, where they aren't the matter.

    Runs say its ``reach`` and its ``rest``; without others no delays vary.
    """
    vars(found).update(dict(reach=0.3, rest=0.1, varying_robots=()) | known)
    return found


def stand(
    machine,
    controller,
    limit,
    seconds=60.0,
    tilt=0.1,
    seed=0,
    dropouts=0.01,
    jitter=0.0005,
):
    """The largest and the last tilt, and the fault, of the program.

    ``controller`` has start(tilt, wheels, bias), step(gyro, wheels,
    tilt) and fault. Its ticks come late by chance, it takes its time
    to compute, and a sensor may say nothing.
    """
    random = np.random.default_rng(seed)
    x, V, bias = np.array([tilt, 0.0, 0.0, 0.0]), 0.0, 0.008
    turn, height = 2 * np.pi / machine.counts, 0.5 * machine.l
    controller.start(tilt + 0.01, 0.0, bias)
    tilts, now = [], 0.0
    for k in range(round(seconds / machine.T)):
        at = k * machine.T + jitter * random.random()
        x = advance(machine.rate, x, V, at - now, 3)
        d = machine.rate(x, V)
        along = G * np.sin(x[0]) - machine.r * np.cos(x[0]) * d[3] - height * d[2]
        up = G * np.cos(x[0]) + machine.r * np.sin(x[0]) * d[3] - height * x[2] ** 2
        gyro = x[2] + bias + 0.002 * random.standard_normal()
        wheels = turn * np.floor((x[1] - x[0]) / turn)
        level = np.arctan2(along, up) + 0.01 * random.standard_normal()
        lost = random.random(2) < dropouts
        u = float(
            controller.step(
                np.nan if lost[0] else gyro, np.nan if lost[1] else wheels, level
            )[0]
        )
        assert abs(u) <= limit * (1 + 1e-6)
        now = at + machine.delay * random.random()
        x = advance(machine.rate, x, V, now - at, 2)
        V = u
        tilts.append(x[0])
        if abs(x[0]) > 1.2 or controller.fault[0]:
            break
    return np.array(tilts), int(controller.fault[0])


TABLE = """
name                    M_b   l     r      M_w   stall free V_n gears rotor   counts T     delay
eduMIP-like             0.272 0.04  0.034  0.027 0.11  34   7.4 35.6  5e-08   2134   0.01  0.003
Balboa-like             0.32  0.032 0.04   0.02  0.14  30   6   51.5  3e-08   1212   0.005 0.002
LEGO-like               0.6   0.1   0.028  0.02  0.3   17   9   40    3e-07   360    0.005 0.002
gear motors 100 Hz      1     0.075 0.0325 0.04  0.5   21   12  34    4e-07   1496   0.01  0.002
gear motors 200 Hz      1     0.075 0.0325 0.04  0.5   21   12  34    4e-07   1496   0.005 0.002
8 kg                    8     0.25  0.1    0.45  5     15   24  25    2.5e-06 2000   0.01  0.003
tall and thin           0.7   0.28  0.04   0.03  0.5   20   12  30    4e-07   1320   0.005 0.002
0.2 kg                  0.17  0.028 0.016  0.009 0.035 60   6   30    1.2e-08 360    0.005 0.001
30 kg, 24 V             30    0.45  0.2    2     22    14   24  30    1.2e-05 4000   0.01  0.004
1:100 at 50 Hz          1.6   0.16  0.06   0.09  2.2   11   12  100   4e-07   4800   0.02  0.004
15 kg on 50 mm, 125 Hz  15    0.2   0.05   0.8   3     40   24  20    2e-06   2048   0.008 0.002
0.12 kg, 3.7 V, 333 Hz  0.1   0.03  0.018  0.006 0.02  70   3.7 30    4e-09   420    0.003 0.0008
"""  # noqa: E501


def machines():
    """The machines of the table, by their names."""
    names, *rows = (line.split() for line in TABLE.strip().splitlines())
    count = len(names) - 1
    return {
        " ".join(row[:-count]): Machine(
            " ".join(row[:-count]), **dict(zip(names[1:], map(float, row[-count:])))
        )
        for row in rows
    }


ALL = machines()
ALL["tall and thin"] = replace(ALL["tall and thin"], shape=1.1)
ALL["1:100 at 50 Hz"] = replace(ALL["1:100 at 50 Hz"], friction=0.3, law="observer")
SIX, LIGHT = tuple(ALL.values())[:7], ALL["0.2 kg"]
#: Unlike the six: very light, very heavy, gears that rub, a slow clock, a fast one.
OTHERS = (
    LIGHT,
    replace(LIGHT, name="0.2 kg with friction", friction=0.15),
    *tuple(ALL.values())[8:],
)
