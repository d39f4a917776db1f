"""Plants with springs and sensors, for the searches of `sensors`: M, D, S, B and F."""

import numpy as np

I2 = np.eye(2)


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


FIRST, SECOND = pick(2, 0), pick(2, 1)
DRIFTS = [[1, 0, 0], [0, -1, 1]]
