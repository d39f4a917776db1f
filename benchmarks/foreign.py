"""Plants of other people: from books, papers and collections.

Each function gives a plant and the other arguments of `design_pid`, and
names its source. The requirements are our own.
"""

import numpy as np

import sosbook as sos

from .elements import beam_matrices
from .plants import public

G = 9.81  # m/s^2
DEGREES = np.radians


def foreign():
    """All of them, with the public plants of `benchmarks.plants`.

    Returns
    -------
    dict
        From a name to (plant, requirements).

    Examples
    --------
    >>> len(foreign()), foreign()["cart_pole"][0].n
    (26, 2)
    """
    makers = (
        acrobot,
        ball_and_beam,
        cart_pole,
        damped_beam,
        furuta,
        gantry,
        half_car,
        jeffcott,
        quadrotor,
        quarter_car,
        reaction_wheel,
        satellite,
        springs,
        storeys,
        tora,
        torsion,
        triple_chain,
        wiresaw,
    )
    return public() | {make.__name__: make() for make in makers}


def tridiagonal(n, off, on):
    """A tridiagonal Toeplitz matrix."""
    return on * np.eye(n) + off * (np.eye(n, k=1) + np.eye(n, k=-1))


def cart_pole():
    """A pendulum on a cart, upright; a force on the cart.

    Source: Control Tutorials for MATLAB and Simulink (University of
    Michigan), Inverted pendulum: 0.5 kg, 0.2 kg, 0.1 N s/m, 0.006 kg m^2,
    0.3 m. The coordinates are the cart's place and the angle.
    """
    M, m, b, J, length = 0.5, 0.2, 0.1, 0.006, 0.3
    plant = sos.SecondOrderSystem(
        M=[[M + m, -m * length], [-m * length, J + m * length**2]],
        D=np.diag([b, 0]),
        S=np.diag([0, -m * G * length]),
        B=[[1], [0]],
        F=[[1], [0]],
    )
    region = sos.PoleRegion(sigma=0.5, theta=DEGREES(80), rho=20)
    return plant, dict(U=[[1, 0]], region=region, gamma=2.0)


def furuta():
    """A pendulum on a rotating arm, upright; a torque on the arm.

    Source: B. S. Cazzolato and Z. Prime, On the dynamics of the Furuta
    pendulum, J. Control Science and Engineering 2011, (35) and (36) for
    slender rods; the numbers are our own: an arm of 0.3 kg and 0.25 m, a
    rod of 0.1 kg and 0.3 m.
    """
    arm, L1, m, half, c = 0.3, 0.25, 0.1, 0.15, 1e-4
    hub, rod = arm * L1**2 / 3 + m * L1**2, 4 / 3 * m * half**2
    plant = sos.SecondOrderSystem(
        M=[[hub, -m * L1 * half], [-m * L1 * half, rod]],
        D=c * np.eye(2),
        S=np.diag([0, -m * G * half]),
        B=[[1], [0]],
        F=[[0], [1]],
    )
    region = sos.PoleRegion(sigma=0.5, theta=DEGREES(80), rho=40)
    return plant, dict(U=[[1, 0]], region=region, gamma=2000.0)


def acrobot():
    """Two links, upright; a torque at the elbow only.

    Source: M. W. Spong, The swing up control problem for the acrobot, IEEE
    Control Systems 15(1), 1995: masses and links of 1 and 1, 1 and 2, with
    their centres halfway and inertias of 0.083 and 0.33.
    """
    m1, m2, l1, c1, c2, I1, I2 = 1, 1, 1, 0.5, 1, 0.083, 0.33
    both, elbow = m1 * c1**2 + m2 * (l1**2 + c2**2) + I1 + I2, m2 * l1 * c2
    lower = m2 * c2**2 + I2
    pull = np.array([m1 * c1 + m2 * l1, m2 * c2]) * G
    plant = sos.SecondOrderSystem(
        M=[[both + 2 * elbow, lower + elbow], [lower + elbow, lower]],
        D=0.01 * np.eye(2),
        S=-np.array([[pull.sum(), pull[1]], [pull[1], pull[1]]]),
        B=[[0], [1]],
        F=[[1], [0]],
    )
    return plant, dict(region=sos.PoleRegion(sigma=0.5, rho=30), gamma=1.0)


def gantry():
    """A load of 200 to 800 kg under a trolley of 1000 kg.

    Small angles of the rope, of 6 m. Source: B. Jakovljevic and others,
    and many textbooks of crane control, by Lagrange; numbers are our own.
    """
    length, trolley, vertices = 6.0, 1000.0, []
    for load in (200.0, 800.0):
        vertices.append(
            sos.SecondOrderSystem(
                M=[[trolley + load, load * length], [load * length, load * length**2]],
                D=np.diag([50.0, 0]),
                S=np.diag([0, load * G * length]),
                B=[[1], [0]],
                F=[[1], [0]],
            )
        )
    region = sos.PoleRegion(sigma=0.1, rho=4)
    return sos.Polytope(vertices), dict(region=region, gamma=0.05)


def quarter_car():
    """A wheel and a quarter of a car on it, a force between the two.

    Source: R. Rajamani, Vehicle Dynamics and Control, 2012, chapter 10:
    290 and 59 kg, 16812 and 190000 N/m, 1000 N s/m. The road lifts the
    tyre's spring.
    """
    ms, mu, ks, kt, b = 290, 59, 16812, 190_000, 1000
    plant = sos.SecondOrderSystem(
        M=np.diag([ms, mu]),
        D=[[b, -b], [-b, b]],
        S=[[ks, -ks], [-ks, ks + kt]],
        B=[[1], [-1]],
        F=[[0], [kt]],
    )
    region = sos.PoleRegion(sigma=2.5, rho=100)
    return plant, dict(region=region, gamma=4.0)


def half_car():
    """Heave and pitch of a car's body on two wheels, two forces.

    Source: D. Hrovat, Survey of advanced suspension developments,
    Automatica 33, 1997, by Lagrange; the numbers are our own.
    """
    m, J, a, b = 730.0, 1230.0, 1.0, 1.5
    wheels, ks, ct, kt = [40.0, 36.0], [20e3, 18e3], [1300.0, 1500.0], 180e3
    arms = np.array([[1, 1], [-a, b]])  # of forces on the body
    reach = np.vstack([arms, -np.eye(2)])
    plant = sos.SecondOrderSystem(
        M=np.diag([m, J, *wheels]),
        D=reach * ct @ reach.T,
        S=reach * ks @ reach.T + np.diag([0, 0, kt, kt]),
        B=reach,
        F=kt * np.eye(4)[:, 2:],
    )
    return plant, dict(region=sos.PoleRegion(sigma=2, rho=150), gamma=6.0)


def quadrotor():
    """A planar quadrotor that hovers: x, y and tilt, two propellers.

    Source: R. Tedrake, Underactuated Robotics, chapter 3, with 0.486 kg,
    arms of 0.25 m and an inertia of 0.00383 kg m^2.
    """
    m, r, J = 0.486, 0.25, 0.00383
    S = np.zeros((3, 3))
    S[0, 2] = m * G
    plant = sos.SecondOrderSystem(
        M=np.diag([m, m, J]),
        D=np.zeros((3, 3)),
        S=S,
        B=[[0, 0], [1, 1], [r, -r]],
        F=np.eye(3)[:, :2],
    )
    region = sos.PoleRegion(sigma=0.8, theta=DEGREES(75), rho=20)
    return plant, dict(U=np.eye(3)[:2], region=region, gamma=2.0)


def satellite():
    """A satellite with an instrument on a boom of uncertain stiffness.

    Source: G. F. Franklin, J. D. Powell and A. Emami-Naeini, Feedback
    Control of Dynamic Systems, chapter 10: inertias 1 and 0.1, k from 0.09
    to 0.4, b from 0.038 sqrt(k / 10) to 0.2 sqrt(k / 10).
    """
    vertices = []
    for k in (0.09, 0.4):
        for b in (0.038 * np.sqrt(k / 10), 0.2 * np.sqrt(k / 10)):
            tie = np.array([[1, -1], [-1, 1]])
            vertices.append(
                sos.SecondOrderSystem(
                    np.diag([1, 0.1]), b * tie, k * tie, [[1], [0]], [[1], [0]]
                )
            )
    region = sos.PoleRegion(sigma=0.05, rho=20)
    return sos.Polytope(vertices), dict(region=region, gamma=5.0)


def ball_and_beam():
    """A ball on a beam, held at the middle; a torque on the beam.

    Source: J. Hauser, S. Sastry and P. Kokotovic, IEEE Trans. Autom. Control
    37(3), 1992: 0.05 kg, radius 0.01 m, 0.02 kg m^2, 2e-6 kg m^2.
    """
    m, r, beam, ball = 0.05, 0.01, 0.02, 2e-6
    plant = sos.SecondOrderSystem(
        M=np.diag([ball / r**2 + m, beam + ball]),
        D=np.zeros((2, 2)),
        S=[[0, m * G], [m * G, 0]],
        B=[[0], [1]],
        F=[[1], [0]],
    )
    region = sos.PoleRegion(sigma=0.5, theta=DEGREES(75), rho=15)
    return plant, dict(U=[[1, 0]], region=region, gamma=20.0)


def reaction_wheel():
    """A pendulum that stands by turning a wheel; its angle, the wheel's.

    Source: M. W. Spong, P. Corke and R. Lozano, Nonlinear control of the
    reaction wheel pendulum, Automatica 37, 2001; m g l = 0.379 N m,
    inertias of 4.571e-3 and 2.495e-5 kg m^2.
    """
    J, wheel, mgl = 4.571e-3, 2.495e-5, 0.379
    plant = sos.SecondOrderSystem(
        M=[[J + wheel, wheel], [wheel, wheel]],
        D=np.zeros((2, 2)),
        S=np.diag([-mgl, 0]),
        B=[[0], [1]],
        F=[[1], [0]],
    )
    return plant, dict(region=sos.PoleRegion(sigma=1, rho=60))


def tora():
    """A cart on a spring with an unbalanced rotor, at rest.

    Source: R. T. Bupp, D. S. Bernstein and V. T. Coppola, A benchmark
    problem for nonlinear control design, Int. J. Robust Nonlinear Control
    8, 1998: 1.3608 kg, 186.3 N/m, 0.096 kg, 0.0592 m, 2.175e-4 kg m^2.
    """
    cart, k, m, e, J = 1.3608, 186.3, 0.096, 0.0592, 2.175e-4
    plant = sos.SecondOrderSystem(
        M=[[cart + m, m * e], [m * e, J + m * e**2]],
        D=np.zeros((2, 2)),
        S=np.diag([k, 0]),
        B=[[0], [1]],
        F=[[1], [0]],
    )
    return plant, dict(region=sos.PoleRegion(sigma=0.3, rho=60), gamma=30.0)


def storeys():
    """Five equal storeys in an earthquake, a force under the first floor.

    Source: A. K. Chopra, Dynamics of Structures, the uniform five-story
    shear frame: 100 kips / g and 31.54 kips/in each. Modal damping
    of 5 % in the first and the third mode by Rayleigh.
    """
    n, m, k = 5, 100 / 386.4, 31.54
    S = k * tridiagonal(n, -1, 2)
    S[-1, -1] = k
    M = m * np.eye(n)
    w = np.sqrt(np.linalg.eigvalsh(S) / m)[[0, 2]]
    a, b = 2 * 0.05 * np.array([w.prod(), 1]) / w.sum()
    plant = sos.SecondOrderSystem(
        M, a * M + b * S, S, B=np.eye(n)[:, :1], F=-M @ np.ones((n, 1))
    )
    region = sos.PoleRegion(sigma=0.4, rho=80)
    return plant, dict(region=region, gamma=1.5)


def torsion():
    """Three disks on a shaft, a torque on the first.

    Source: T. R. Parks, Manual for Model 205, Educational Control Products,
    1999, as used by many: inertias of 2.4e-3, 1.9e-3, 1.9e-3 kg m^2, 2.8
    and 2.6 N m, 7e-3 N m s each.
    """
    tie = [np.array([[1, -1, 0]]), np.array([[0, 1, -1]])]
    plant = sos.SecondOrderSystem(
        M=np.diag([2.4e-3, 1.9e-3, 1.9e-3]),
        D=np.diag([7e-3, 1e-3, 1e-3]),
        S=2.8 * tie[0].T @ tie[0] + 2.6 * tie[1].T @ tie[1],
        B=[[1], [0], [0]],
        F=[[0], [0], [1]],
    )
    region = sos.PoleRegion(sigma=1, rho=120)
    return plant, dict(U=[[0, 0, 1]], region=region, gamma=3.0)


def jeffcott(speed=150.0):
    """A disk on a turning shaft with rotating damping, above its critical speed.

    x and y of the centre: m z'' + (c + d) z' + (k I - d speed J) z = f. Source:
    G. Genta, Dynamics of Rotating Systems, 2005, chapter 2; the numbers are
    our own.
    """
    m, k, c, d = 1.0, 1e4, 1.0, 5.0
    J = np.array([[0, -1], [1, 0]])
    plant = sos.SecondOrderSystem(
        M=m * np.eye(2),
        D=(c + d) * np.eye(2),
        S=k * np.eye(2) - d * speed * J,
        B=np.eye(2),
        F=np.eye(2),
    )
    region = sos.PoleRegion(sigma=5, rho=300)
    return plant, dict(U=np.eye(2), region=region, gamma=1e-3)


def springs(n=10):
    """Masses, springs and dampers in a row; a force on every third.

    M = I, D = 10 tridiag(-1, 3, -1), S = 5 tridiag(-1, 3, -1): overdamped.
    Source: F. Tisseur, Backward error and condition of polynomial eigenvalue
    problems, Linear Algebra Appl. 309, 2000; "spring" in NLEVP (T. Betcke
    et al., ACM Trans. Math. Softw. 39(2), 2013).
    """
    plant = sos.SecondOrderSystem(
        M=np.eye(n),
        D=tridiagonal(n, -10, 30),
        S=tridiagonal(n, -5, 15),
        B=np.eye(n)[:, ::3],
        F=np.eye(n)[:, :1],
    )
    return plant, dict(region=sos.PoleRegion(sigma=0.3), gamma=0.5)


def damped_beam(elements=6):
    """A simply supported beam with a damper and a force in the middle.

    Source: N. J. Higham, D. S. Mackey, F. Tisseur and S. D. Garvey, Scaling,
    sensitivity and stability in the numerical solution of quadratic eigenvalue
    problems, Int. J. Numer. Methods Eng. 73, 2008; "damped_beam" in NLEVP:
    0.674 kg/m, 1 m, 7e10 Pa, 0.05 by 0.005 m, damper 5. With 1 % of material
    damping, which is our own.
    """
    n, EI, rho = elements, 7e10 * 0.05 * 0.005**3 / 12, 0.674
    M, S = beam_matrices(n, (0, 2 * n))
    M, S = rho * M, EI * S
    middle = np.eye(2 * n)[:, [2 * (n // 2) - 1]]
    w = np.sqrt(np.linalg.eigvals(np.linalg.solve(M, S)).real.min())
    plant = sos.SecondOrderSystem(
        M, 5 * middle @ middle.T + 0.02 / w * S, S, B=middle, F=middle
    )
    return plant, dict(region=sos.PoleRegion(sigma=0.5), gamma=1e-2)


def wiresaw(n=6, speed=0.3):
    """A travelling wire, gyroscopic; forces on all its modes but one.

    M = I / 2, D_jk = 4 j k v / (j^2 - k^2) for odd j + k, S_jj = j^2 pi^2 (1 -
    v^2) / 2. Source: S. Wei and I. Kao, Vibration analysis of wire and
    frequency response in the modern wiresaw manufacturing process, J. Sound
    Vibration 231, 2000; "wiresaw1" in NLEVP.
    """
    j = np.arange(1, n + 1)
    odd = (j[:, None] + j) % 2 == 1
    gap = np.where(odd, j[:, None] ** 2 - j**2, 1)
    plant = sos.SecondOrderSystem(
        M=np.eye(n) / 2,
        D=np.where(odd, 4 * np.outer(j, j) * speed / gap, 0),
        S=np.diag(j**2 * np.pi**2 * (1 - speed**2) / 2),
        B=np.eye(n)[:, :-1],
        F=np.ones((n, 1)),
    )
    region = sos.PoleRegion(sigma=0.2, rho=40)
    return plant, dict(region=region, gamma=1.0)


def triple_chain(length=3):
    """Three rows of masses that are tied to one mass at their end.

    Source: N. Truhar and K. Veselic, An efficient method for estimating the
    optimal dampers' viscosity for linear vibrating systems using Lyapunov
    equation, SIAM J. Matrix Anal. Appl. 31, 2009: masses 1, 2, 3 and 10,
    stiffnesses 10, 20, 1 and 50; 0.4 % of internal damping. The forces are
    our own: one on the first mass of each row, one on the end.
    """
    n = 3 * length + 1
    M = np.diag([*np.repeat([1.0, 2.0, 3.0], length), 10.0])
    S = np.zeros((n, n))
    for row, k in enumerate((10.0, 20.0, 1.0)):
        part = slice(row * length, (row + 1) * length)
        S[part, part] = k * tridiagonal(length, -1, 2)
        S[part.stop - 1, -1] = S[-1, part.stop - 1] = -k
    S[-1, -1] = 10 + 20 + 1 + 50
    w, V = np.linalg.eigh(S / np.sqrt(np.outer(np.diag(M), np.diag(M))))
    root = np.sqrt(M)
    D = 0.008 * root @ V * np.sqrt(w) @ V.T @ root
    places = np.eye(n)[:, [0, length, 2 * length, n - 1]]
    plant = sos.SecondOrderSystem(M, (D + D.T) / 2, S, places, places)
    return plant, dict(region=sos.PoleRegion(sigma=0.05, rho=20), gamma=1.0)
