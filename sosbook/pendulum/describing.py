"""Limit cycles that friction makes, by describing functions.

A describing function is the gain and the phase that a nonlinearity gives
a sine's first harmonic. It predicts a cycle and proves nothing.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ..plants.checks import finite
from .firmware import SOFTNESS

__all__ = ["LimitCycle", "coulomb", "limit_cycle", "soft_sign"]

CYCLES_TRIED = 12  # frequencies at which the search for a balance begins
SLOWEST = 0.5  # rad/s, the slowest of them
BALANCED = 1e-6  # of what is left of the harmonics' balance


def coulomb(amplitude, friction):
    """The gain of friction * sign(v) for v = amplitude * sin."""
    return 4 * friction / (np.pi * amplitude)


def soft_sign(amplitude, compensation, width):
    """The gain of a compensation that is c beyond +-width and c u / width within.

    The sine of u has the ``amplitude``, in V.
    """
    slope, share = compensation / width, min(width / amplitude, 1.0)
    if share == 1.0:
        return slope
    return slope * 2 / np.pi * (np.arcsin(share) + share * np.sqrt(1 - share**2))


@dataclass(frozen=True)
class LimitCycle:
    """A cycle that the first harmonics allow.

    ``frequency``: in Hz; ``speed``: the amplitude of phi' - theta', in rad/s; ``tilt``:
    the amplitude of theta, in rad; ``command``: the amplitude of the law's voltage, in
    V.
    """

    frequency: float
    speed: float
    tilt: float
    command: float


def limit_cycle(loop, friction, compensation=0.0):
    """The cycle of a sampled loop whose gears rub.

    The friction acts as a voltage d = -F sign(phi' - theta') on the motors.
    With V = (1 + n) u + d, the balance of the first harmonics is
    1 + N P = 0, where P is the response of phi' - theta' to d around the
    loop, N the gain of friction, and n that of its compensation. Of some
    cycles the largest is taken.

    ``loop``: the loop without friction; ``friction``: the voltage that just overcomes
    it; ``compensation``: as in `Firmware`. Returns None where no amplitude and
    frequency balance.
    """
    for name, value in (("friction", friction), ("compensation", compensation)):
        if finite(name, value) < 0:
            raise ValueError(f"{name} must be 0 or more, in V, got {value!r}")
    if not friction:
        return None
    T, plant = loop.law.T, loop.robot.plant()

    def responses(omega):
        """Of theta, phi' - theta' and u, per volt of d; and of u per volt of V."""
        s = 1j * omega
        stiff = plant.M * s**2 + plant.D * s + plant.S
        z = np.linalg.solve(stiff, plant.B[:, 0].astype(complex))
        L = loop.loop_gain.at(np.exp(s * T))[0, 0]
        early = L * np.exp(s * (T / 2 + loop.delay))  # friction isn't held
        return z[0], s * (z[1] - z[0]), early, L

    def balance(x):
        omega, speed, command = np.exp(x)
        _, v, early, L = responses(omega)
        more = 1.0
        if compensation:
            more += soft_sign(command, compensation, SOFTNESS * compensation)
        N = coulomb(speed, friction)
        u = early / (1 - more * L)
        gap = 1 + N * v * (1 + more * u)
        return [gap.real, gap.imag, np.log(abs(u) * N * speed / command)]

    def start(omega):
        _, v, early, L = responses(omega)
        d = 4 * friction / np.pi
        return np.log([omega, abs(v / (1 - L)) * d, abs(early / (1 - L)) * d])

    cycles = []
    for omega in np.geomspace(SLOWEST, np.pi / T / 2, CYCLES_TRIED):
        fit = least_squares(balance, start(omega), xtol=1e-12, max_nfev=60)
        if np.abs(fit.fun).max() < BALANCED and np.exp(fit.x[0]) * T < np.pi:
            omega, speed, command = map(float, np.exp(fit.x))
            theta, v, *_ = responses(omega)
            tilt = float(abs(theta / v)) * speed
            cycles.append(LimitCycle(omega / 2 / np.pi, speed, tilt, command))
    return max(cycles, key=lambda cycle: cycle.tilt, default=None)
