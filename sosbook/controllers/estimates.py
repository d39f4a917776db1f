"""A balancing robot's program, from the true signals to the volts."""

import numpy as np

from ..sampled.system import SampledSystem


def estimated(T, blend):
    """The program's estimates of the ``states`` [theta, phi, theta', phi']: theta^, the
    gyro and the absolute angle, one tick T ago; ``blend``: the accelerometers' share.
    """
    theta, phi, gyro, _ = np.eye(4)
    trust = 1 - blend
    angle = [trust, trust * T / 2, 0]
    new = trust * T / 2 * gyro + blend * theta
    wheel = phi - theta + new
    rate = np.array([angle]) / T - [[0, 0, 1 / T]]
    A, B = [angle, [0, 0, 0], angle], [new, gyro, wheel]
    C, D = np.vstack([angle, angle, [0, 0, 0], rate]), [new, wheel, gyro, wheel / T]
    return SampledSystem(A, B, C, D, T)


def balancing(gains):
    """That of the law whose ``gains`` were read from a program."""
    A, B, C, D = (gains[name] for name in "ABCD")
    if not gains["STATES"]:
        A, B, C = A[:0, :0], B[:0], C[:, :0]
    T = gains["TICK"]
    return estimated(T, gains["BLEND"]).then(SampledSystem(A, B, C, D, T))


def heading(K, T):
    """From [delta, delta'] to the volts; K: of the error, its steps over T, its sum."""
    k, k_rate, k_sum = K
    A, B = [[0, 0], [0, 1]], [[1, 0], [T, 0]]
    return SampledSystem(A, B, [[-k_rate / T, k_sum]], [[k + k_rate / T, 0]], T)
