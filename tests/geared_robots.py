"""Robots as shops sell them: gears with play, coarse counts, sagging batteries.

No equation here comes from the package. The motion is that of a chain: body,
motor's side of the gears, wheels, each with its momentum. Between the motor's
side and the wheels there is a gap; a spring and a damper push where it is
closed, and never pull. Friction is Coulomb's, dry: it takes from a speed what
it can and stops there.
"""

from dataclasses import dataclass, fields
from math import cos, pi, sin

import numpy as np

from sosbook.pendulum.log import Log
from sosbook.pendulum.recording import AMPLITUDE_SHARES, SWEEP_SECONDS, sweeps
from tests.cases import campaign
from tests.six_robots import ALL as STIFF
from tests.six_robots import G, Machine, by_its_sheet

TEETH_DAMPING = 0.3  # of the rotors against what they drive
STEP = 2.5e-4  # s, of the simulation


@dataclass(frozen=True)
class Geared(Machine):
    """A machine whose gears have ``play``, in degrees of a wheel from end to end.

    What its electronics and its owner do wrong comes last; the friction is dry.
    """

    play: float = 0.0
    teeth: float = 70.0  # Hz, of the rotors against what they drive
    seen: str = "motor"  # the encoder's side of the gap
    dead: float = 0.02  # duty below which the bridge does nothing
    bits: int = 255  # steps of the duty
    sag: float = 0.03  # of the battery under the whole load
    battery: float = 1.0  # what is left of its volts, which nobody measures
    gyro: float = 1.02  # what the gyro makes of one
    offset: float = 0.0105  # rad/s
    drift: float = 2e-5  # rad/s^2
    noise: float = 0.0017  # rad/s
    askew: float = 0.035  # rad, of the board about the axle
    jitter: float = 0.0005
    lost: float = 0.0  # of the samples of an experiment, by the sensors' bus
    left: float = 1.0  # what the left motor does of its half; 0 if it is dead
    right: float = 1.0

    def bridge(self, V):
        """The volts at the motors where V is asked for."""
        duty = round(self.bits * max(-1.0, min(1.0, V / self.V_n))) / self.bits
        if abs(duty) < self.dead:
            return 0.0
        return duty * self.battery * self.V_n * (1 - self.sag * abs(duty))


class Chain:
    """A robot in motion.

    ``held`` is "wheels" (upside down), "body" (on its back) or None (it stands).
    theta is from upright, from hanging where the wheels are held; the motors' and
    the wheels' angles are against the body.
    """

    def __init__(self, robot, held=None, theta=0.0, slope=0.0):
        self.robot, self.held, self.slope = robot, held, slope
        self.theta, self.motor, self.wheel = theta, 0.0, 0.0
        self.w = self.dm = self.dw = 0.0
        self.acceleration = 0.0, 0.0  # of theta and of the wheels against the ground
        driven = {"wheels": robot.I_o, "body": 2 * robot.I_w, None: robot.rolling}
        least = 1 / (1 / robot.J + 1 / driven[held])
        rate = 2 * pi * robot.teeth
        self.stiff, self.damper = rate**2 * least, 2 * TEETH_DAMPING * rate * least
        self.half = np.radians(robot.play) / 2

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
        h, e, f, J, disc = time / n, x.e, x.f, x.J, 2 * x.I_w
        drive = e * (x.left * volts[0] + x.right * volts[1]) / 2
        dry, weight, lever, I_o, roll = (
            e * x.friction,
            x.weight,
            x.lever,
            x.I_o,
            x.rolling,
        )
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
                self.dw += h * push / disc
                dw = self.w = 0.0
                self.acceleration = 0.0, h * push / disc
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
        which = 0 if alone is None else alone[k]
        u = robot.bridge(2 * V if which else V)
        chain.advance((u * (which != 2), u * (which != 1)), h)
    if name == "body":
        gyro = robot.gyro * np.array(speed) + robot.offset + robot.drift * t
        gyro += robot.noise * random.standard_normal(len(t))
        step = np.radians(1000) / 2**15
        log = {"t": t, "V": volts, "gyro": step * np.round(gyro / step)}
    else:
        starts = random.random(2)
        counts = [np.floor(np.array(angle) * count + x) for x in starts]
        log = {"t": t, "V": volts, "encoder1": counts[0], "encoder2": counts[1]}
    gone = 1 + np.flatnonzero(random.random(len(t) - 2) < robot.lost)
    for column in set(log) - {"t", "V", "alone"}:
        log[column][gone] = np.nan
    if alone is not None:
        log["alone"] = np.array(alone)
    return log


def described(robot):
    """As its owner describes it: gears rub, and an observer is quiet behind play."""
    return by_its_sheet(robot, friction=True, law="observer")


def recorded(robot, seconds=SWEEP_SECONDS, shares=AMPLITUDE_SHARES, seed=0):
    """Logs of the experiments, with the sweeps that the recorders make."""
    ends, logs = sweeps(described(robot)), {}
    for name, share in shares.items():
        volts, alone = sine(ends[name], seconds, robot.T, share * robot.V_n), None
        if name == "body":  # as the recorders: on the way back each motor alone
            t = robot.T * np.arange(len(volts))
            alone = np.where(t < seconds, 0, 1 + t.astype(int) % 2)
        logs[name] = Log(**experiment(robot, name, volts, seed, alone))
    return logs


def stand(
    robot,
    controller,
    seconds=20.0,
    tilt=0.03,
    slope=0.0,
    shove=(0.0, 0.0, 0.0),
    lift=(0.0, 0.0),
    dropouts=0.0,
    seed=0,
):
    """Tilts, volts and wheels' turns, tick by tick, and the fault, of a program.

    It has start(tilt, wheels, bias), step(gyro, wheels, tilt) and fault. A ``shove``
    is a torque on the body, of M_b g l, from one time to another; a ``lift`` holds
    the body upright in the air between two times. Sensors say nothing at so many
    ``dropouts`` of the ticks, both at once.
    """
    random, x = np.random.default_rng(seed), robot
    chain, turn, height = Chain(x, None, tilt, slope), 2 * pi / x.counts, x.l / 2
    controller.start(tilt, 0.0, 0.8 * x.offset)
    path, u, now = [], 0.0, 0.0
    for k in range(round(seconds / x.T)):
        at = k * x.T + 0.05 * x.T * random.random()
        push, begin, end = shove
        push *= x.weight * (begin <= at < end)
        if lift[0] <= at < lift[1] and chain.held is None:
            chain.held, chain.theta = "body", 0.0
        elif at >= lift[1]:
            chain.held = None
        chain.advance((u, u), at - now, push)
        ddq, ddphi = chain.acceleration
        q, w = chain.theta, chain.w
        along = G * sin(q) - x.r * cos(q) * ddphi - height * ddq
        up = G * cos(q) + x.r * sin(q) * ddphi - height * w * w
        level = np.arctan2(along, up) + x.askew + 0.01 * random.standard_normal()
        gyro = x.gyro * w + x.offset + x.drift * at + x.noise * random.standard_normal()
        gyro, wheels = 0.001 * round(gyro / 0.001), turn * np.floor(chain.angle / turn)
        if random.random() < dropouts:
            gyro = wheels = np.nan
        V = float(controller.step(gyro, wheels, level)[0])
        now = at + x.delay * random.random()
        chain.advance((u, u), now - at, push)
        u = x.bridge(V)
        path.append((chain.theta, V, chain.wheel + chain.theta))
        if abs(chain.theta) > 1.2 or controller.fault[0]:
            break
    return (*np.array(path).T, int(controller.fault[0]))


TABLE = """
name  M_b  l     r      M_w   V_n stall free rotor   gears counts T     delay  play friction
n20   0.46 0.055 0.0325 0.03  6   0.125 42   3e-8    50    1400   0.01  0.002  2    0.25
hub   2.5  0.12  0.085  1     12  2     24   5e-4    1     90     0.005 0.001  0    0.15
tele  6    0.6   0.1    0.3   24  3.5   20   1.11e-5 30    2000   0.01  0.002  1    0.6
lego  0.68 0.1   0.028  0.02  9   0.35  17   2.81e-7 40    360    0.02  0.003  2    0.4
"""  # noqa: E501


def machines():
    """The robots of the table, by their names; two that are stiff elsewhere."""
    names, *rows = (line.split() for line in TABLE.strip().splitlines())
    found = {
        row[0]: Geared(row[0], **dict(zip(names[1:], map(float, row[1:]))), shape=1.35)
        for row in rows
    }
    for name, friction, play in (("gear motors 200 Hz", 0.4, 1.5), ("8 kg", 0.6, 1.0)):
        of = {x.name: getattr(STIFF[name], x.name) for x in fields(Machine)}
        found[name] = Geared(**of | dict(friction=friction, play=play))
    return found


def drawn(seed):
    """A robot of 0.25 to 8 kg, by chance: no fit was tuned on it."""
    random = np.random.default_rng(seed)

    def between(low, high):  # any order of magnitude is as likely
        return float(low * (high / low) ** random.random())

    M_b, V_n = between(0.25, 8), float(random.choice([6, 7.4, 9, 12, 24]))
    l, shape = 0.1 * M_b ** (1 / 3) * between(0.6, 2.2), random.uniform(1.1, 1.6)
    r = float(np.clip(0.6 * l * between(0.5, 1.2), 0.016, 0.11))
    M_w, gears = M_b * between(0.015, 0.08), between(20, 100)
    stall, free = between(0.6, 2) * M_b * G * r, between(12, 45)
    alone = between(0.008, 0.03)  # s, the time constant of the motors on no wheels
    return Geared(
        f"robot {seed}", M_b, l, r, M_w, stall, free, V_n, gears,
        stall / free * alone / gears**2, round(between(90, 4096)),
        float(random.choice([0.005, 0.01, 0.02])), 0.002, shape=shape,
        friction=V_n * random.uniform(0.02, 0.08), play=random.uniform(0, 2),
        teeth=between(40, 120), dead=random.uniform(0, 0.03),
        sag=random.uniform(0, 0.05), lost=random.uniform(0, 0.01),
        gyro=random.uniform(0.98, 1.02), offset=0.01 * random.standard_normal(),
    )  # fmt: skip


ALL = machines()
#: For the gate the robot whose gears play; the others once a week.
GATE = "gear motors 200 Hz"
KINDS = [GATE, *campaign(name for name in ALL if name != GATE)]
