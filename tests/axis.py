"""The two-mass drive of the controllers' tests, and a plant of it by somebody else."""

import functools
from dataclasses import replace

import numpy as np

import sosbook as sos

T = 1e-3
UNITS = {"motor": "rad", "load": "rad", "u": "N m"}


def drive(J2, k=1.9, d=0.004):
    return sos.SecondOrderSystem(
        [[0.0025, 0], [0, J2]],
        [[d, -d], [-d, d]],
        [[k, -k], [-k, k]],
        [[1], [0]],
        [[0], [1]],
        coordinates=["motor", "load"],
    )


@functools.cache
def design():
    """For every load from .003 to .006 kg m^2, with the least torque from .5 rad."""
    return sos.design_pid(
        sos.Uncertain(drive, J2=(0.003, 0.006)),
        [[1, 0]],
        region=sos.PoleRegion(sigma=5, rho=400),
        saturation=sos.Saturation(None, [0.5, 0.5, 0, 0, 0]),
        minimize="u_max",
    )


@functools.cache
def axis():
    """Of the motor's encoder alone, a tick late."""
    return design().controller(["motor"], T=T, delay=T, units=UNITS, counts=4096)


def rubbed(program, J2, r, seconds, lose=0, u_max=np.inf):
    """(load's angle, torque) of a program on a drive with friction, by RK4."""
    step = 2 * np.pi / 4096
    x, act, angles, torques = np.zeros(4), 0.0, [], []

    def rate(x):
        twist = 1.9 * (x[0] - x[1]) + 0.004 * (x[2] - x[3])
        return np.array(
            [
                x[2],
                x[3],
                (act - twist - 0.03 * np.tanh(x[2] / 0.05)) / 0.0025,
                (twist - 0.02 * np.tanh(x[3] / 0.05)) / J2,
            ]
        )

    for n in range(round(seconds / T)):
        y = step * np.floor(x[0] / step + 0.5)
        if n == 0:
            program.start([y])
        lost = lose and n % lose == lose - 1
        new = float(program.step([np.nan if lost else y], [r])[0, 0])
        for _ in range(5):
            h = T / 5
            a = rate(x)
            b = rate(x + h / 2 * a)
            c = rate(x + h / 2 * b)
            e = rate(x + h * c)
            x = x + h / 6 * (a + 2 * b + 2 * c + e)
        act = new
        angles.append(x[1])
        torques.append(new)
        if abs(x[1]) > 1e4:
            break
    return np.array(angles), np.array(torques)


def stepless(c):
    """A controller c whose sensors have no steps."""
    return replace(c, readings=replace(c.readings, steps=0 * c.readings.steps))
