"""Plants of every size, and public ones, with what is asked of them.

Each function gives a plant and the other arguments of `design_pid`.
"""

import numpy as np

import sosbook as sos

from .elements import beam_matrices
from .machines import bicycle_at


def chain(n):
    """n masses in a row, 2 or more, each on a spring to the ground.

    Unit masses, springs and dampers between neighbours, to the walls at both ends and
    to the ground: M = I, D = 0.1 I + 0.05 T, S = I + T with T = tridiag(-1, 2, -1). A
    force acts on the masses 1, 5, 9, ..., a disturbance enters and the error is
    integrated at the same places. All modes lie between 1 and 2.24 rad/s, and each
    group of four masses is much like the next: the requirements are as hard for 200
    masses as for four. The open loop breaks three of them: its slowest mode decays with
    0.05 to 0.075, its sector has 87 degrees, its H-infinity norm is 0.6 or more.

    >>> plant, asked = chain(8)
    >>> plant.n, plant.m, asked["U"].shape
    (8, 2, (2, 8))
    """
    if n < 2:
        raise ValueError(f"n = {n} must be 2 or more")
    T = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    places = np.eye(n)[:, : 4 * max(1, n // 4) : 4]
    plant = sos.SecondOrderSystem(
        M=np.eye(n), D=0.1 * np.eye(n) + 0.05 * T, S=np.eye(n) + T, B=places, F=places
    )
    region = sos.PoleRegion(sigma=0.1, theta=np.radians(86), rho=4)
    return plant, dict(U=places.T, region=region, gamma=0.2)


def beam(n):
    """A cantilever of n finite elements, 1 or more, clamped at z = 0.

    Euler-Bernoulli beam of unit length, mass and bending stiffness, of the elements of
    `beam_matrices`: 2 n degrees of freedom. The damping is D = 0.3 M + 0.0005 S. The
    lowest mode has 3.5 rad/s; the largest eigenvalue of M^-1 S grows like n^4, which is
    badly conditioned on purpose. A force acts at the tip and, from four elements on,
    one in the middle; the disturbance acts at the tip. The open loop decays with 0.15
    only. The highest modes decay faster by themselves, and no disk (rho) asks the
    forces to move them.

    >>> plant, asked = beam(4)
    >>> plant.n, plant.m
    (8, 2)
    >>> round(float(np.abs(plant.poles()).min()), 2)  # 1.8751^2
    3.52
    """
    if n < 1:
        raise ValueError(f"n = {n} must be 1 or more")
    M, S = beam_matrices(n)
    tip = np.eye(2 * n)[:, [-2]]
    B = tip
    if n >= 4:
        B = np.hstack([tip, np.eye(2 * n)[:, [2 * (n // 2) - 2]]])
    plant = sos.SecondOrderSystem(M, 0.3 * M + 0.0005 * S, S, B, tip)
    bent = np.zeros(4 * n + 1)  # by a unit force at the tip
    bent[: 2 * n] = np.linalg.solve(S, tip[:, 0])
    return plant, dict(
        U=tip.T,
        region=sos.PoleRegion(sigma=0.5),
        gamma=0.4,
        saturation=sos.Saturation(30, bent),
    )


def public():
    """Public plants of second order: from a name to (plant, requirements).

    The function of that name says its source.
    """
    found = (two_masses, bicycle, wing, building, bus, pendulums, joint, rotor)
    return {make.__name__: make() for make in found}


def two_masses():
    """Two masses and an uncertain spring, the force on the first.

    Unit masses, stiffness 0.5 to 2, no damping; w acts on the second
    mass. Source: B. Wie and D. S. Bernstein, Benchmark problems for
    robust control design, J. Guidance, Control and Dynamics 15(5),
    1992. The requirements are our own.
    """
    vertices = [
        sos.SecondOrderSystem(
            M=np.eye(2),
            D=np.zeros((2, 2)),
            S=[[k, -k], [-k, k]],
            B=[[1], [0]],
            F=[[0], [1]],
        )
        for k in (0.5, 2.0)
    ]
    region = sos.PoleRegion(sigma=0.1, rho=8)
    return sos.Polytope(vertices), dict(region=region, gamma=4)


def bicycle(speed=5.0):
    """A bicycle with its rider, steered by a torque; roll, steer angle.

    See `benchmarks.machines.bicycle_at`. Speed and requirements are our own.
    """
    plant = bicycle_at(speed)
    region = sos.PoleRegion(sigma=1, theta=np.radians(75), rho=20)
    return plant, dict(U=[[1, 0]], region=region, gamma=0.002)


def wing():
    """A wing in an airstream, in flutter.

    Source: R. A. Frazer, W. J. Duncan and A. R. Collar, Elementary
    Matrices, 1938; the problem "wing" of NLEVP (T. Betcke et al., ACM
    Trans. Math. Softw. 39(2), 2013). The inputs, two forces, and the
    requirements are our own.
    """
    plant = sos.SecondOrderSystem(
        M=[[17.6, 1.28, 2.89], [1.28, 0.824, 0.413], [2.89, 0.413, 0.725]],
        D=[[7.66, 2.45, 2.1], [0.23, 1.04, 0.223], [0.6, 0.756, 0.658]],
        S=[[121, 18.9, 15.9], [0, 2.7, 0.145], [11.9, 3.64, 15.5]],
        B=np.eye(3)[:, 1:],
        F=np.eye(3)[:, :1],
    )
    region = sos.PoleRegion(sigma=0.3, theta=np.radians(84), rho=10)
    return plant, dict(U=np.eye(3)[1:], region=region, gamma=0.08)


def building():
    """Three storeys of a scaled building, a force at the first floor.

    Displacements against the ground, which shakes with w. Source: S. J.
    Dyke et al., Modeling and control of magnetorheological dampers for
    seismic response reduction, Smart Mater. Struct. 5, 1996: M, D, S.
    The requirements are our own.
    """
    M = 98.3 * np.eye(3)
    plant = sos.SecondOrderSystem(
        M,
        D=[[175, -50, 0], [-50, 100, -50], [0, -50, 50]],
        S=1e5 * np.array([[12, -6.84, 0], [-6.84, 13.7, -6.84], [0, -6.84, 6.84]]),
        B=[[1], [0], [0]],
        F=-M @ np.ones((3, 1)),
    )
    region = sos.PoleRegion(sigma=1, rho=180)
    return plant, dict(region=region, gamma=0.001)


def bus():
    """A quarter of a bus on its wheel, a force between the two.

    The road lifts the tyre's spring. Source: Control Tutorials for
    MATLAB and Simulink (University of Michigan), Suspension: masses,
    springs, dampers. Our own: the road acts through the spring only,
    the body's mass of 2500 kg may be as large as 3500 kg, and the
    requirements.
    """
    k1, k2, b1, b2 = 80_000, 500_000, 350, 15_020
    vertices = [
        sos.SecondOrderSystem(
            M=np.diag([body, 320]),
            D=[[b1, -b1], [-b1, b1 + b2]],
            S=[[k1, -k1], [-k1, k1 + k2]],
            B=[[1], [-1]],
            F=[[0], [k2]],
        )
        for body in (2500, 3500)
    ]
    region = sos.PoleRegion(sigma=1, rho=60)
    limit = sos.Saturation(10_000, [0.01, 0.01, 0, 0])
    return sos.Polytope(vertices), dict(region=region, saturation=limit)


def pendulums():
    """Two pendulums on top of each other on a cart, upright.

    Point masses on rods without mass; cart, angles against the
    vertical. A textbook plant, its linear equations by Lagrange; the
    numbers and the requirements are our own.
    """
    cart, m1, m2, l1, l2, g = 1.0, 0.3, 0.2, 0.5, 0.4, 9.81
    plant = sos.SecondOrderSystem(
        M=[
            [cart + m1 + m2, (m1 + m2) * l1, m2 * l2],
            [(m1 + m2) * l1, (m1 + m2) * l1**2, m2 * l1 * l2],
            [m2 * l2, m2 * l1 * l2, m2 * l2**2],
        ],
        D=np.diag([0.5, 0.01, 0.01]),
        S=-np.diag([0, (m1 + m2) * g * l1, m2 * g * l2]),
        B=[[1], [0], [0]],
        F=[[1], [0], [0]],
    )
    region = sos.PoleRegion(sigma=0.5, theta=np.radians(80), rho=15)
    return plant, dict(U=[[1, 0, 0]], region=region, gamma=0.05)


def joint():
    """A robot's link on an elastic joint; angles of link and motor.

    I q1'' + k (q1 - q2) = -M g L q1, J q2'' + k (q2 - q1) = u. Source:
    M. W. Spong, Modeling and control of elastic joint robots, J. Dyn.
    Syst. Meas. Control 109, 1987, here upright (M g L negative). The
    numbers, the spring's range and the requirements are our own.
    """
    vertices = [
        sos.SecondOrderSystem(
            M=np.eye(2),
            D=np.diag([0.05, 0.1]),
            S=[[k - 10, -k], [-k, k]],
            B=[[0], [1]],
            F=[[1], [0]],
        )
        for k in (80, 120)
    ]
    region = sos.PoleRegion(sigma=1, theta=np.radians(80), rho=25)
    return sos.Polytope(vertices), dict(U=[[1, 0]], region=region, gamma=0.05)


def rotor(speed=400.0):
    """A rigid rotor in magnetic bearings, which pull it off centre.

    Displacements x, y and tilts about y, -x of the centre of mass. The
    polar inertia couples the tilts: Ip speed [[0, 1], [-1, 0]]. Each
    bearing, at a distance l, has a negative stiffness. Source: the
    linear rotor of G. Schweitzer and E. H. Maslen (eds.), Magnetic
    Bearings, 2009; the numbers and the requirements are our own.
    """
    m, It, Ip, left, right, k = 4.0, 0.05, 0.02, 0.15, 0.10, 3e4
    arms = np.array([[1, 1], [-left, right]])  # forces to force, moment
    inertia = np.diag([m, It])
    pull = -k * arms @ arms.T
    M, S = np.kron(inertia, np.eye(2)), np.kron(pull, np.eye(2))
    D = np.zeros((4, 4))
    D[2:, 2:] = Ip * speed * np.array([[0, 1], [-1, 0]])
    plant = sos.SecondOrderSystem(
        M, D, S, B=np.kron(arms, np.eye(2)), F=np.eye(4)[:, :2]
    )
    region = sos.PoleRegion(sigma=30, theta=np.radians(75), rho=400)
    return plant, dict(U=np.eye(4), region=region, gamma=5e-6)
