"""Pendulums, arms and bicycles.

Each function gives a plant and what is asked of it, by the arguments of
the kind of request that `benchmarks.catalogue` names.
"""

import numpy as np

import sosbook as sos

G = 9.81  # m/s^2


def links(masses, length):
    """M and S of point masses on rods, upright; angles against the vertical.

    Parameters
    ----------
    masses : (n,) array
        From the lowest, kg.
    length : float
        Of each rod, m.

    Examples
    --------
    One pendulum falls with the rate sqrt(g / l):

    >>> M, S = links(np.array([2.0]), 0.5)
    >>> float(-S[0, 0] / M[0, 0]) * 0.5
    9.81
    """
    above = np.cumsum(masses[::-1])[::-1]  # what each joint carries
    carried = above[np.maximum.outer(np.arange(len(masses)), np.arange(len(masses)))]
    return carried * length**2, -np.diag(above) * G * length


def pendulums(n, seed=0):
    """n - 1 pendulums, end to end, upright on a cart; a force on the cart.

    From three pendulums on a torque helps at every second joint. Masses of
    0.1 kg, the cart has 1 kg; all rods together are 0.5 m long.
    """
    count = n - 1
    rng = np.random.default_rng([seed, n])
    masses = 0.1 * (1 + 0.2 * rng.uniform(-1, 1, count))
    length = 0.5 / count
    m, s = links(masses, length)
    above = np.cumsum(masses[::-1])[::-1] * length
    M = np.block([[np.array([[1.0 + masses.sum()]]), above[None]], [above[:, None], m]])
    S = np.block([[np.zeros((1, n))], [np.zeros((count, 1)), s]])
    joints = np.eye(n) - np.eye(n, k=1)  # a torque turns two neighbours
    B = joints[:, [0, *range(2, n, 2)] if n > 3 else [0]]
    B[0, 1:] = 0
    D = np.diag([0.5, *np.full(count, 1e-3)])
    return sos.SecondOrderSystem(M, D, S, B, np.eye(n)[:, :1]), {}


def arm(n):
    """n links, upright, a torque at each joint; uncertain masses.

    Each mass is 1 kg or 1.3 kg: 2^n vertices of different M and S.
    """
    joints = np.eye(n) - np.eye(n, k=1)
    vertices = []
    for k in range(2**n):
        heavy = np.array([k >> i & 1 for i in range(n)])
        M, S = links(1.0 + 0.3 * heavy, 0.3)
        D = 0.02 * joints @ joints.T
        vertices.append(sos.SecondOrderSystem(M, D, S, joints, joints[:, -1:]))
    region = sos.PoleRegion(sigma=1.0, rho=60)
    return sos.Polytope(vertices), dict(region=region, gamma=0.5)


# Meijaard et al. 2007, table 1 and the matrices of their benchmark
BICYCLE = dict(
    M=[[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]],
    C1=[[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]],
    K0=[[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]],
    K2=[[0, 76.59734589573222], [0, 2.65431523794604]],
)


def bicycle_at(v, square=None):
    """The bicycle at a speed, m/s: roll and steer angle, a steering torque.

    Source: J. P. Meijaard, J. M. Papadopoulos, A. Ruina and A. L. Schwab, Proc.
    R. Soc. A 463, 2007: M q'' + v C1 q' + (g K0 + v^2 K2) q = f. ``square``
    stands in for v^2, of which S is affine.
    """
    M, C1, K0, K2 = (np.array(BICYCLE[name]) for name in ("M", "C1", "K0", "K2"))
    square = v**2 if square is None else square
    return sos.SecondOrderSystem(
        M, v * C1, G * K0 + square * K2, B=[[0], [1]], F=[[1], [0]]
    )


def hull(low, high, count):
    """Points (v, s) whose convex hull holds s = v^2 for v from low to high.

    The ends, and where neighbouring tangents of the parabola meet.

    Examples
    --------
    >>> [(float(v), float(s)) for v, s in hull(2, 4, 3)]
    [(2.0, 4.0), (4.0, 16.0), (3.0, 8.0)]
    """
    touched = np.linspace(low, high, count - 1)
    corners = [(u + v) / 2 for u, v in zip(touched[:-1], touched[1:])]
    meet = [u * v for u, v in zip(touched[:-1], touched[1:])]
    return [(low, low**2), (high, high**2), *zip(corners, meet)]


def bicycles(count):
    """The bicycle at 5 m/s (count 1), or at all speeds from 4 to 6 m/s.

    Parameters
    ----------
    count : int
        Vertices; the more, the closer the hull is to the speeds.
    """
    asked = dict(region=sos.PoleRegion(sigma=0.5, rho=30), gamma=0.01)
    if count == 1:
        return bicycle_at(5.0), asked
    if count == 2:
        raise ValueError("count = 2 doesn't enclose a parabola: take 3 or more")
    return sos.Polytope([bicycle_at(*p) for p in hull(4.0, 6.0, count)]), asked
