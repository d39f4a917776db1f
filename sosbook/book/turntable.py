"""The machine of part VII: a motor turns a table with a payload on it."""

import numpy as np
from scipy.sparse import coo_array

from ..plants.second_order import SecondOrderSystem

__all__ = ["arm", "arm_row", "drive", "table"]

PIECES, LAYERS, HIGH, DEEP = 1000, 9, 0.009, 0.02  # of 1 m; m
YOUNG, POISSON, DENSITY = 70e9, 0.3, 2700.0  # aluminium: N/m², 1, kg/m³


def drive(J, k=10):
    """A motor of 0.01 kg m² turns a table of J kg m².

    The shaft between them has k N m/rad.

    z: the angles of motor and load in rad. u: the motor's torque,
    w: a torque on the load, both in N m.

    >>> drive(0.02).n
    2
    """
    return SecondOrderSystem(
        M=[[0.01, 0], [0, J]],
        D=[[0.03, -0.01], [-0.01, 0.01]],
        S=[[k, -k], [-k, k]],
        B=[[1], [0]],
        F=[[0], [1]],
        coordinates=["motor", "load"],
    )


def table(m, r, k=10):
    """A table of 0.01 kg m² with m kg on it, r m from the axis.

    k: as in drive.

    >>> table(2, 0.1).M[1, 1].round(9)
    np.float64(0.03)
    """
    return drive(0.01 + m * r**2, k)


def square(side):
    """Mass and stiffness, (8, 8), of a square piece of the arm, ``side`` m long.

    Four corners with two displacements each, in plane stress, integrated by
    Gauss's four points.
    """
    nu, at = POISSON, 1 / np.sqrt(3)
    law = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) / (1 - nu**2)
    x, y = np.array([[-1, 1, 1, -1], [-1, -1, 1, 1]])
    mass, stiffness = np.zeros((2, 8, 8))
    for a, b in ((-at, -at), (-at, at), (at, -at), (at, at)):
        shape = np.kron((1 + a * x) * (1 + b * y) / 4, np.eye(2))
        along, up = x * (1 + b * y) / 2 / side, y * (1 + a * x) / 2 / side
        strain = np.zeros((3, 8))
        strain[0, ::2], strain[1, 1::2] = along, up
        strain[2, ::2], strain[2, 1::2] = up, along
        mass += shape.T @ shape
        stiffness += strain.T @ law @ strain
    volume = side**2 * DEEP / 4
    return DENSITY * volume * mass, YOUNG * volume * stiffness


def arm():
    """M and S, sparse, of an aluminium arm on the table: 20,000 displacements.

    1 m long, 9 mm high, 20 mm deep, clamped at one end, in 1000 x 9 squares.

    >>> M, S = arm()
    >>> S.shape
    (20000, 20000)
    """
    node = np.arange((PIECES + 1) * (LAYERS + 1)).reshape(PIECES + 1, LAYERS + 1)
    corners = node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]
    corner = np.stack(corners, -1).reshape(-1, 4)
    place = (2 * corner[:, :, None] + [0, 1]).reshape(-1, 8)
    rows, columns = np.repeat(place, 8, axis=1).ravel(), np.tile(place, 8).ravel()
    free = slice(2 * (LAYERS + 1), None)  # the first nodes are held
    both = []
    for piece in square(HIGH / LAYERS):
        values = np.tile(piece.ravel(), len(place))
        both.append(coo_array((values, (rows, columns))).tocsc()[free][:, free])
    return tuple(both)


def arm_row(place):
    """The row of the arm's displacement across at a ``place``, in m from the clamp.

    >>> arm_row(1.0)
    19989
    """
    return 2 * (LAYERS + 1) * (round(PIECES * place) - 1) + LAYERS
