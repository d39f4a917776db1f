"""Families of plants with known gains: springs and sensors, and parameters in squares.

Each is a plant with a gain K of u = K x, and can be had in other units. The gains of
the first fifteen are those that a search for the fastest decay has found, to five
digits, where the sensors allow them; the others stand in no relation to what is asked.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

import sosbook as sos

I2 = np.eye(2)


@dataclass(frozen=True)
class Known:
    """A plant and its gain; whether squares of parameters pull the hull far away.

    ``matrices``: from values of the parameters to E, A, B, B_w and C.
    """

    name: str
    matrices: Any
    K: Any
    ranges: dict
    squares: bool = False

    @cached_property
    def plant(self):
        """All plants: an `Uncertain`, or one where there are no ranges."""

        def made(**values):
            return sos.DescriptorSystem(*self.matrices(**values))

        return sos.Uncertain(made, **self.ranges) if self.ranges else made()

    def in_units(self, force=1.0, length=1.0, time=1.0):
        """The same in other units; its poles are those of this one over ``time``.

        All states are lengths. The lower half of the rows are sums of forces.
        """

        def scaled(**values):
            E, A, B, push, C = (np.array(x, object) for x in self.matrices(**values))
            rows = np.where(2 * np.arange(len(E)) < len(E), 1.0, force)[:, None]
            E, A = rows * E * length * time, rows * A * length
            return E, A, rows * B, rows * push, C * length

        return replace(self, matrices=scaled, K=length * np.array(self.K))


def law(M, D, S, B, F, sensors, outputs, integrals=0, tau=None, order=0):
    """The plant with what a controller remembers: E, A, B, B_w and C.

    The states are z, z', the integrals of the first so many of the measured
    positions, ``order`` states of a dynamic controller, or the measured positions
    behind filters xi' = (y - xi) / tau. The outputs are rows on z.
    """
    M, D, S, B, F = (np.atleast_2d(np.array(x, dtype=object)) for x in (M, D, S, B, F))
    sensors, n = np.atleast_2d(sensors), len(M)
    filters = len(sensors) if tau else 0
    more = integrals + filters + order
    N = 2 * n + more
    E, A = np.eye(N).astype(object), np.zeros((N, N), dtype=object)
    E[n : 2 * n, n : 2 * n] = M
    A[:n, n : 2 * n] = np.eye(n)
    A[n : 2 * n, :n], A[n : 2 * n, n : 2 * n] = -S, -D
    A[2 * n : 2 * n + integrals, :n] = sensors[:integrals]
    if filters:
        rows = slice(2 * n + integrals, 2 * n + integrals + filters)
        A[rows, :n] = sensors * (1 / tau)
        A[rows, rows] = np.eye(filters) * (-1 / tau)
    inputs = np.zeros((N, B.shape[1] + order), dtype=object)
    inputs[n : 2 * n, : B.shape[1]] = B
    inputs[N - order :, B.shape[1] :] = np.eye(order)
    push = np.zeros((N, F.shape[1]), dtype=object)
    push[n : 2 * n] = F
    C = np.zeros((len(outputs), N))
    C[:, :n] = outputs
    return E, A, inputs, push, C


def row(n, springs, wall, m=None, damping=0.05):
    """Masses in a row, springs between them and to a wall: M, D and S."""
    S = np.zeros((n, n), dtype=object)
    for i, k in enumerate(springs):
        S[i : i + 2, i : i + 2] += k * np.array([[1, -1], [-1, 1]])
    S[0, 0] += wall
    M = np.zeros((n, n), dtype=object)
    M[range(n), range(n)] = np.ones(n, int) if m is None else m
    return M, damping * S, S


def pick(n, *places):
    """Rows of the identity."""
    return np.eye(n)[list(places)]


OUTER = pick(5, 0, 2, 4)


def three_masses(k):
    return *row(3, [k, k], 1), pick(3, 0).T, pick(3, 2).T


def carts(m, k):
    return *row(2, [k], 1, (1, m)), I2, pick(2, 1).T


def pair(m):
    return *row(2, [1], 0.5, (1, m)), pick(2, 0).T, pick(2, 1).T


def car(m):
    D, S = [[1000, -1000], [-1000, 1000]], [[16000, -16000], [-16000, 176000]]
    M = np.array([[m, 0], [0, 45]], dtype=object)
    return M, D, S, [[1], [-1]], [[0], [160000]]


def pendulum_on_cart(m):
    M = [[1 + m, m / 2], [m / 2, m / 4]]
    S = [[0, 0], [0, -4.905 * m]]
    return M, [[0.1, 0], [0, 0.01]], S, [[1], [0]], [[0], [1]]


def joint(J, k):
    D = [[0.15, -0.05], [-0.05, 0.05]]
    return [[1, 0], [0, J]], D, [[k, -k], [-k, k]], [[1], [0]], [[0], [1]]


def bearings(speed):
    D = [[0.02, 0.6 * speed], [-0.6 * speed, 0.02]]
    return I2, D, -4 * I2, I2, I2


def building(a, b):
    parts = row(3, [100 * b, 80 * b], 120 * b, (a, a, 0.8 * a), 0.002)
    return *parts, [[1, 0], [0, -1], [0, 1]], np.ones((3, 1))


def two(m, k, d):
    D, S = [[0.1 + d, -d], [-d, d]], [[1 + k, -k], [-k, k]]
    return [[1, 0], [0, m]], D, S, [[1], [0]], [[0], [1]]


def five_masses(m, k):
    return *row(5, [k] * 4, 1, (1, 1, m, 1, 1)), OUTER.T, pick(5, 1).T


def hover(m):
    M = np.diag([m, 0.05 * m + 0.05, 0.2]) + (m - 1) * 0.02 * np.ones((3, 3))
    B = [[1, 1, 1], [0.3, -0.3, 0], [0.2, 0.2, -0.4]]
    return M, 0.02 * np.eye(3), 0 * np.eye(3), B, np.eye(3)


def free_masses(k=1):
    S = k * np.array([[1, -1], [-1, 1]])
    return I2, np.zeros((2, 2)), S, [[1], [0]], pick(2, 1).T


def bicycle(v):
    M = [[80.817, 2.3194], [2.3194, 0.29784]]
    K0, K2 = [[-80.95, -2.5995], [-2.5995, -0.80329]], [[0, 76.597], [0, 2.6543]]
    C1 = np.array([[0, 33.866], [-0.85035, 1.6854]])
    S = 9.81 * np.array(K0) + v**2 * np.array(K2)
    return M, v * C1, S, [[0], [1]], [[1], [0]]


def crane(m, rope):
    M = [[1000 + m, m * rope], [m * rope, m * rope**2]]
    return M, 0 * I2, [[0, 0], [0, 9.81 * m * rope]], [[1], [0]], [[1], [0]]


def five_numbers(m1, m2, k1, k2, d):
    D, S = [[0.3 + d, -d], [-d, d]], [[k1 + k2, -k2], [-k2, k2]]
    return [[m1, 0], [0, m2]], D, S, [[1], [0]], [[0], [1]]


def rotor(speed, k):
    D = np.zeros((4, 4), dtype=object)
    D[:2, :2], D[2:, 2:] = 0.1 * I2, 0.02 * I2
    D[2:, 2:] += speed * 0.06 * np.array([[0, 1], [-1, 0]])
    S = np.zeros((4, 4), dtype=object)
    S[:2, :2], S[2:, 2:] = k * I2, 0.3 * k * I2
    S[:2, 2:] = S[2:, :2] = 0.1 * I2
    return np.diag([1, 1, 0.2, 0.2]), D, S, pick(4, 0, 1).T, pick(4, 2).T


def arm(load, c):
    """Two links; c is the cosine of the angle between them."""
    M = np.array([[1.2 + 0.41 * load, 0.1], [0.1, 0.2 + 0.16 * load]], dtype=object)
    M = M + c * (0.2 * load + 0.1) * np.array([[2, 1], [1, 0]])
    return M, 0.1 * I2, 0 * I2, I2, I2


def whirling(k, c):
    """A shaft with circulatory forces, in units of 0.3 and 9.81: S isn't symmetric."""
    M, D = 0.3 * 9.81 * I2, 0.9 * I2
    return M, D, [[9.81 * k, 9.81 * c], [-9.81 * c, 7 * k]], I2, [[1], [0]]


def inside(**v):
    """The damping is least between the ends of the ranges: its hull is below zero."""
    d = sum((0.05 + (x - 0.4) ** 2 for x in v.values()), start=0)
    return [[1, 0], [0, 1]], d * I2, [[2, -1], [-1, 2]], [[1], [0]], [[0], [1]]


def heated(c1, c2, h):
    """Three rooms, one of them heated: no second derivatives at all."""
    E = [[c1, 0, 0], [0, c2, 0], [0, 0, 3]]
    A = [[-1 - h, h, 0], [h, -2 * h, h], [0, h, -h]]
    return E, A, [[1], [0], [0]], [[0], [0], [1]], [[0, 0, 1]]


def known(name, parts, K, sensors, outputs, *more, squares=False, **ranges):
    """A `Known` of the ``parts`` M, D, S, B, F; ``more`` is that of `law`."""

    def matrices(**values):
        return law(*parts(**values), sensors, outputs, *more)

    return Known(name, matrices, K, ranges, squares)


FIRST, SECOND = pick(2, 0), pick(2, 1)
DRIFTS = [[1, 0, 0], [0, -1, 1]]
FAMILIES = [
    known("three masses, z1 and z1', PID", three_masses,
          [[0.61779, 0, 0, -1.2743, 0, 0, -0.032709]], pick(3, 0), pick(3, 2), 1,
          k=(0.8, 1.25)),
    known("three masses, z1 only, filter", three_masses,
          [[-24.293, 0, 0, 0, 0, 0, -0.030293, 24.939]],
          pick(3, 0), pick(3, 2), 1, 0.05, k=(0.8, 1.25)),
    known("two masses, PD", pair, [[-0.20864, 0, -1.8427, 0]], FIRST, SECOND,
          m=(0.5, 1.5)),
    known("carts, decentralised PID", carts,
          [[-9.3547, 0, -5.6799, 0, -9.9995, 0], [0, -9.9999, 0, -5.455, 0, -8.993]],
          I2, SECOND, 2, m=(0.5, 1.5), k=(0.8, 1.6)),
    known("carts, positions only", carts,
          [[-46.471, 0, 0, 0, -10, 0, 39.406, 0],
           [0, -51.868, 0, 0, 0, -10, 0, 42.586]], I2, SECOND, 2, 0.1,
          m=(0.5, 1.5), k=(0.8, 1.6)),
    known("quarter car", car, [[-19952, 19952, -4912.5, 4912.5]], [[1, -1]], FIRST,
          m=(250, 350)),
    known("cart and pendulum, positions only", pendulum_on_cart,
          [[3176.2, 2468.5, 0, 0, -3125, -2353.4]], I2, SECOND, 0, 0.01, m=(0.1, 0.3)),
    known("flexible joint, motor angle only", joint,
          [[-306.75, 0, 0, 0, -2.1307, 300.73]], FIRST, SECOND, 1, 0.02,
          J=(1, 2), k=(8, 12)),
    known("magnetic bearings, equal gains", bearings,
          [[-750.83, 0, 0, 0, -187.77, 0, 660.83, 0],
           [0, -750.83, 0, 0, 0, -187.77, 0, 660.83]], I2, I2, 2, 0.02, speed=(0, 8)),
    known("building, decentralised PD", building,
          [[54.506, 0, 0, -22.589, 0, 0], [0, 51.028, -51.028, 0, 44.27, -44.27]],
          DRIFTS, [[1, 0, 0], [-1, 1, 0], [0, -1, 1]], a=(0.85, 1.15), b=(0.8, 1.2)),
    known("two masses, m k d, PID", two,
          [[0.35809, 0, -1.7099, 0, -0.08562]],
          FIRST, SECOND, 1, m=(0.7, 1.4), k=(0.7, 1.4), d=(0.02, 0.1)),
    known("five masses, decentralised PD", five_masses,
          [[-0.12121, 0, 0, 0, 0, -1.0052, 0, 0, 0, 0],
           [0, 0, -1.1615, 0, 0, 0, 0, -4.4913, 0, 0],
           [0, 0, 0, 0, -1.2306, 0, 0, 0, 0, -1.3993]], OUTER, pick(5, 1),
          m=(0.6, 1.6), k=(0.8, 1.3)),
    known("hovering body, positions only", hover,
          [[-182.3, -51.851, -7.1831, 0, 0, 0, 183.51, 27.175, -14.041],
           [-266.91, 108.71, -13.796, 0, 0, 0, 242.18, -83.983, -10.075],
           [-139.19, 1.1659, 92.385, 0, 0, 0, 114.46, -7.0375, -76.831]],
          np.eye(3), np.eye(3), 0, 0.05, m=(1, 2)),
    known("two free masses, order 3", free_masses,
          [[0, 0, 0, 0, -4.4598, 3.4906, -6.4375],
           [0, 1.7721, 0, 0, -1.9109, -0.29641, -0.64557],
           [0, 0.18948, 0, 0, 2.1696, -2.1193, 2.7871],
           [0, -5.8934, 0, 0, 0.76169, 3.9305, -9.976]], SECOND, SECOND, 0, None, 3,
          k=(0.5, 2)),
    known("two free masses, order 2, k = 1", free_masses,
          [[0, 0, 0, 0, 0.95224, -0.50659], [0, -1.6092, 0, 0, -0.61477, -1.2098],
           [0, -0.028654, 0, 0, 0.93701, -1.079]], SECOND, SECOND, 0, None, 2),
    known("bicycle, 5 to 10 m/s", bicycle, [[25, -20, 6, -4]], I2, FIRST, v=(5, 10)),
    known("bicycle, 3 to 30 m/s", bicycle, [[40, -30, 8, -6]], I2, FIRST, v=(3, 30)),
    known("crane, load and rope", crane, [[-600, 4000, -1800, 0]], I2, FIRST,
          m=(100, 4000), rope=(3, 20)),
    known("two masses, m k d wide, PD", two, [[-0.5, 0.2, -1.2, -0.1]], FIRST, SECOND,
          m=(0.4, 2), k=(0.4, 2), d=(0.02, 0.2)),
    known("two masses, five numbers", five_numbers, [[-0.5, 0.2, -1.2, -0.1]],
          I2, SECOND, m1=(0.8, 1.2), m2=(0.8, 1.2), k1=(0.8, 1.2), k2=(0.8, 1.2),
          d=(0.05, 0.1)),
    known("rotor, speed and stiffness", rotor,
          [[-4, 0, 0, 0, -2, 0, 0, 0], [0, -4, 0, 0, 0, -2, 0, 0]],
          np.eye(4), pick(4, 0, 1), speed=(0, 80), k=(3, 5)),
    known("robot arm, load and angle", arm,
          [[-9, -1, -6, -0.5], [-1, -4, -0.5, -2]], I2, I2, load=(0, 3), c=(-0.9, 0.9)),
    known("whirling shaft", whirling, [[-3, 0, -4, 0], [0, -2, 0, -5]],
          I2, I2, k=(1, 4), c=(0, 0.9)),
    Known("heated rooms", heated, [[-2, -0.3, -0.1]],
          dict(c1=(0.5, 3), c2=(1, 9.81), h=(0.3, 1.2))),
    *(known(f"least damping inside, {k}", inside, [[-1, 0, -0.1, 0]], I2, SECOND,
            squares=True, **{f"v{i}": (0, 1) for i in range(k)}) for k in (1, 2, 3)),
]  # fmt: skip
