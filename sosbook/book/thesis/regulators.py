"""The examples of section 3.1: regulators in a D-region, as printed."""

from dataclasses import dataclass

import numpy as np

from ...plants.second_order import Polytope, SecondOrderSystem
from ...plants.signals import Sine
from ...requirements.hinf import HInfinity
from ...requirements.input_bound import Saturation
from ...requirements.pole_region import PoleRegion


@dataclass(frozen=True, eq=False)
class Example:
    """An example of section 3.1, as printed: its ``plant``; ``U``, (a, n), which errors
    are integrated; the D-``region``, whose theta is the half-angle; the printed gains
    ``K_P`` and ``K_D``, (m, n), of z and z', ``K_I``, (m, a), of the integrated errors,
    and ``K_A``, (m, n), of z''; ``closed_loop_poles`` and the finite
    ``open_loop_poles`` as tabulated, a row for each vertex where there are several;
    ``gamma``, the H-infinity bound; ``saturation``, u_max and x(0); ``set_point``,
    (n,), the "unity set point" of the figures; ``disturbance``, read as acting on every
    channel of F (the text doesn't say); ``t_end`` in s, our choice, for the figures'
    axes are not in the text.
    """

    plant: SecondOrderSystem | Polytope
    U: np.ndarray
    region: PoleRegion
    K_P: np.ndarray
    K_D: np.ndarray
    K_I: np.ndarray
    closed_loop_poles: np.ndarray | None = None
    open_loop_poles: np.ndarray | None = None
    gamma: float | None = None
    saturation: Saturation | None = None
    K_A: np.ndarray | None = None
    set_point: np.ndarray | None = None
    disturbance: Sine | None = None
    t_end: float = 30.0

    @property
    def K(self):
        """[K_P K_D K_I]."""
        return np.hstack([self.K_P, self.K_D, self.K_I])

    @property
    def requirements(self):
        """Keyword arguments for `design_pid`: U, region, gamma, ...

        With mu = 1, as Theorem 2.1 is printed.
        """
        return dict(
            U=self.U,
            region=self.region,
            gamma=None if self.gamma is None else HInfinity(self.gamma, mu=1.0),
            saturation=self.saturation,
            K_A=self.K_A,
        )


def example_1():
    """Example 1, a grasping robot, equation (3.1). The thesis prints Re(s) < 0.7 for
    the half-plane Re(s) < -0.7. The disturbance is 5 sin(10 t) + 5 for t in [10, 20] s.
    """
    return Example(
        plant=SecondOrderSystem(
            M=np.diag([10, 11]),
            D=[[4, 1], [1, 5]],
            S=[[8, 4], [-4, 9]],
            B=np.eye(2),
            F=np.eye(2),
        ),
        U=np.eye(2),
        region=PoleRegion(sigma=0.7, theta=np.pi / 4, rho=5),
        gamma=1.2570,
        saturation=Saturation(150, [0.2, 0.2, 0.8, 0.8, 0.1, 0.1]),
        K_P=np.array([[-101.9639, 9.7931], [-1.8587, -101.0996]]),
        K_D=np.array([[-51.3961, 2.6837], [3.0071, -51.4268]]),
        K_I=np.array([[-62.1859, 6.3242], [-5.9849, -61.5149]]),
        open_loop_poles=_pairs(0.0039 + 0.9001j, -0.4312 + 0.8953j),
        closed_loop_poles=_pairs(
            -0.9119 + 0.1141j, -2.0789 + 1.3140j, -2.3439 + 1.1754j
        ),
        set_point=np.ones(2),
        disturbance=Sine(5, 10, offset=5, start=10, stop=20),
        t_end=30.0,
    )


def car_seat(mass, k22=4e4 + 5e3):
    """The plant of Example 2 with a seat and driver of the given ``mass`` in kg.
    ``k22``, the lower right entry of S in N/m, is k1 + k2; the thesis prints k1 + b2,
    which adds newtons per metre to newton seconds per metre.
    """
    k2, b1, b2 = 5e3, 4e3, 500
    return SecondOrderSystem(
        M=np.diag([mass, 1500]),
        D=[[b2, -b2], [-b2, b1 + b2]],
        S=[[k2, -k2], [-k2, k22]],
        B=np.eye(2),
        F=np.diag([0, 1]),
    )


def example_2():
    """Example 2, the seat of a car: m_s between 70 and 120 kg. The disturbance is 1000
    sin(5 t) + 1000 for t in [7, 12] s, in newtons on the car's mass (F = diag(0, 1)).
    """
    return Example(
        plant=Polytope([car_seat(70), car_seat(120)]),
        U=np.eye(2),
        region=PoleRegion(sigma=0.9, theta=np.pi / 3, rho=15),
        gamma=0.1732,
        saturation=Saturation(40000, [-0.1, -0.1, 0.09, 0.09, 0.05, 0.05]),
        K_P=np.array([[-5748.0, -3723], [-4844, -7029]]),
        K_D=np.array([[-1090.0, -567], [-485, -9837]]),
        K_I=np.array([[-11803.0, 1676], [-4838, -46515]]),
        set_point=np.ones(2),
        disturbance=Sine(1000, 5, offset=1000, start=7, stop=12),
        t_end=20.0,
    )


def example_3():
    """Example 3, four masses in a chain; the last weighs nothing. The disturbance is
    sin(5 t) + 1 for t in [10, 20] s. The open-loop poles leave out the one at infinity.
    """
    B = np.array([[1.0, 0, 0, 0], [0, 0, 0, 1]]).T
    return Example(
        plant=SecondOrderSystem(
            M=np.diag([3, 2, 1, 0]),
            D=_chain([5, 10, 15, 20]),
            S=_chain([5, 15, 15, 20]),
            B=B,
            F=np.diag([1, 0, 0, 1]),
        ),
        U=B.T,
        region=PoleRegion(sigma=0.9, theta=np.pi / 4, rho=20),
        gamma=0.9010,
        saturation=Saturation(120, 4 * [0.4] + 4 * [-0.02] + 2 * [0.001]),
        K_A=np.array([[1.2655, 0, 0, 0], [0, 0, 0, -1.7345]]),
        K_P=np.array(
            [[-61.819, -27.325, 14.2869, -20.834], [-16.591, 31.7718, -71.324, 2.8653]]
        ),
        K_D=np.array(
            [
                [-7.9785, -16.5291, 10.9827, -10.6981],
                [-6.8143, 29.4912, -71.0446, 31.8443],
            ]
        ),
        K_I=np.array([[-75.4615, -4.2255], [-9.7808, -33.2117]]),
        open_loop_poles=np.concatenate(
            [[-23.698], _pairs(-0.3680 + 0.7923j), [-1.9284, -5.0792, -1.0585, -1]]
        ),
        closed_loop_poles=np.concatenate(
            [
                _pairs(-14.2587 + 6.2459j),
                [-4.0065, -3.2294, -1.4582, -1.3700],
                [-7.2055, -5.8602, -1.2489, -1.0232],
            ]
        ),
        set_point=np.ones(4),
        disturbance=Sine(1, 5, offset=1, start=10, stop=20),
        t_end=30.0,
    )


def arm(factor):
    """The plant of Example 4 with m g l sin(phi1) as m g l ``factor`` phi1, about rest
    (3.3).
    """
    k, mgl = 50, 1 * 10 * 0.1
    return SecondOrderSystem(
        M=np.diag([0.05, 0.1]),
        D=np.zeros((2, 2)),
        S=[[k + mgl * factor, -k], [-k, k]],
        B=[[0], [1]],
    )


def example_4():
    """Example 4, a flexible rotor with an arm: phi1 in [-pi/2, pi/2]; the vertices have
    the factors 1 and 2 / pi of (3.3). The thesis rounds the second S11 to 50.64 and
    tabulates the poles for 50 + 2 / pi. U isn't printed: integrating the motor's angle
    phi2 gives Table 3.3.
    """
    return Example(
        plant=Polytope([arm(1.0), arm(2 / np.pi)]),
        U=np.array([[0.0, 1.0]]),
        region=PoleRegion(sigma=5, theta=np.pi / 3, rho=15),
        K_P=np.array([[-75.7438, 69.9357]]),
        K_D=np.array([[3.2975, -4.1265]]),
        K_I=np.array([[-13.9027]]),
        open_loop_poles=np.array(
            [_pairs(38.9023j, 2.5705j), _pairs(38.8396j, 2.0543j)]
        ),
        closed_loop_poles=np.array(
            [
                [*_pairs(-8.0620 + 11.9675j), -13.5952, *_pairs(-5.7727 + 4.0952j)],
                [*_pairs(-6.8103 + 9.9304j), -5.9872, *_pairs(-10.8284 + 6.7034j)],
            ]
        ),
        t_end=10.0,
    )


def _pairs(*poles):
    both = [[p, np.conj(p)] for p in poles]
    return np.array(both).ravel()


def _chain(links):
    """Matrix of springs (or dampers) wall - 1 - 2 - 3 - 4."""
    links = np.asarray(links, float)
    after = np.append(links[1:], 0)
    return np.diag(links + after) - np.diag(links[1:], 1) - np.diag(links[1:], -1)
