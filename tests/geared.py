"""Robots whose gears have play: own equations of six_robots' machines.

The rotors are a third body: q = (theta, phi, rho), rho the angle of the motor's side of
the gears against the ground. Between rho and phi lies a gap, at whose ends the teeth
are springs with dampers. Gears rub; the driver has a dead zone and 8 bits, and the
battery sags; the IMU is askew, its gyro's scale is off and it drifts.
"""

from dataclasses import dataclass, replace
from math import cos, pi, radians, sin, sqrt

import numpy as np

from tests.six_robots import ALL, G, Machine

__all__ = ["KINDS", "Geared", "rest"]

TEETH = 90.0, 0.2  # Hz and damping of rotors against wheels: nobody knows their own
PWM, DEAD, SAG = 255, 0.02, 0.03  # steps, share of the limit, share under full load
SCALE, DRIFT, ASKEW = 1.02, 2e-5, radians(2)  # gyro: scale, rad/s a second; mount


@dataclass(frozen=True)
class Geared:
    """A machine with ``play`` in degrees of a wheel, from one end to the other."""

    machine: Machine
    play: float

    def rates(self, x, V):
        """x = [theta, phi, rho, and their rates], by the three equations of motion."""
        m, (q, phi, rho, w, v, n) = self.machine, x
        J, half = m.J, radians(self.play) / 2
        both = J * m.rolling / (J + m.rolling)
        k = both * (2 * pi * TEETH[0]) ** 2
        twist = rho - phi
        over = twist - half if twist > half else twist + half if twist < -half else 0.0
        bite = k * over + 2 * TEETH[1] * sqrt(k * both) * (n - v) if over else 0.0
        bite = 0.0 if bite * over < 0 else bite  # teeth push and never pull
        tau = m.torque(V, n - w)
        lean = m.lever * cos(q)
        # I_o q'' + lean phi'' - J (rho'' - q'') = weight - tau, J (rho'' - q'') = ...
        spin = tau - bite
        p = m.weight * sin(q) - tau + spin
        r = m.lever * sin(q) * w * w + bite
        det = m.I_o * m.rolling - lean * lean
        ddq = (m.rolling * p - lean * r) / det
        return w, v, n, ddq, (m.I_o * r - lean * p) / det, ddq + spin / J


def advance(rates, x, V, time, longest=5e-4):
    """The state after a time, by Heun's method in short steps."""
    steps = max(1, int(np.ceil(time / longest)))
    h = time / steps
    for _ in range(steps):
        a = rates(x, V)
        b = rates([p + h * s for p, s in zip(x, a)], V)
        x = [p + h / 2 * (s + t) for p, s, t in zip(x, a, b)]
    return x


def rest(geared, controller, limit, seconds=40.0, seed=0, dropouts=0.0):
    """Tilts and volts of the last two thirds, and the fault, of a robot at rest."""
    m, random = geared.machine, np.random.default_rng(seed)
    x, V, bias, turn = [0.03, 0, 0.0, 0, 0, 0], 0.0, 0.008, 2 * pi / m.counts
    controller.start(x[0], 0.0, bias)
    tilts, volts, now = [], [], 0.0
    for k in range(round(seconds / m.T)):
        at = k * m.T + 0.05 * m.T * random.random()
        x = advance(geared.rates, x, V, at - now)
        _, _, _, ddq, ddphi, _ = geared.rates(x, V)
        height = 0.5 * m.l
        along = G * sin(x[0]) - m.r * cos(x[0]) * ddphi - height * ddq
        up = G * cos(x[0]) + m.r * sin(x[0]) * ddphi - height * x[3] ** 2
        level = np.arctan2(along, up) + ASKEW + 0.01 * random.standard_normal()
        gyro = SCALE * x[3] + bias + DRIFT * at + 0.002 * random.standard_normal()
        gyro = 0.001 * round(gyro / 0.001)
        wheels = turn * np.floor((x[2] - x[0]) / turn)
        if random.random() < dropouts:
            gyro = wheels = np.nan
        u = float(controller.step(gyro, wheels, level)[0])
        now = at + m.delay * random.random()
        x = advance(geared.rates, x, V, now - at)
        duty = round(PWM * u / limit) / PWM
        duty = 0.0 if abs(duty) < DEAD else duty
        V = duty * limit * (1 - SAG * abs(duty))
        tilts.append(x[0])
        volts.append(u)
        if abs(x[0]) > 1.2 or controller.fault[0]:
            break
    third = len(tilts) // 3
    return np.array(tilts[third:]), np.array(volts[third:]), int(controller.fault[0])


_big = ALL["8 kg"]
#: Small gear motors, a tall robot, toy encoders, and hubs without gears.
KINDS = {
    "small gear motors": Geared(
        Machine("small gear motors", M_b=0.41, l=0.055, r=0.033, M_w=0.021, stall=0.15,
                free=22.0, V_n=6.0, gears=50.0, rotor=4e-8, counts=1400.0, T=0.01,
                delay=0.003, friction=0.25), 2.0),
    "tall": Geared(
        Machine("tall", M_b=5.2, l=0.6, r=0.09, M_w=0.35, stall=5.0, free=13.0,
                V_n=24.0, gears=28.0, rotor=2.5e-6, counts=2800.0, T=0.01,
                delay=0.003, friction=0.8), 1.0),
    "toy": Geared(
        Machine("toy", M_b=0.62, l=0.11, r=0.028, M_w=0.021, stall=0.35, free=17.0,
                V_n=9.0, gears=45.0, rotor=2.2e-7, counts=360.0, T=0.02,
                delay=0.005, friction=0.3), 2.0),
    "hubs": Geared(
        Machine("hubs", M_b=2.3, l=0.12, r=0.085, M_w=1.0, stall=2.5, free=22.0,
                V_n=12.0, gears=1.0, rotor=1.2e-3, counts=90.0, T=0.005,
                delay=0.002, friction=0.1), 0.0),
}  # fmt: skip
KINDS |= {
    "gear motors": Geared(replace(ALL["gear motors 200 Hz"], friction=0.4), 1.5),
    "heavy": Geared(replace(_big, friction=0.6), 1.0),
}
