"""The thesis's plants and printed numbers, each with its place.

Nothing here is computed. Where print is wrong, the correction is made
in the open: see the field's comment and the errata.
"""

from dataclasses import dataclass

import numpy as np

from ..analysis.response import Sine
from ..plants.second_order import Polytope, SecondOrderSystem
from ..requirements.input_bound import Saturation
from ..requirements.pole_region import PoleRegion

__all__ = [
    "DelayExample",
    "Example",
    "MipPrint",
    "arm",
    "car_seat",
    "delay_example_1",
    "delay_example_2",
    "example_1",
    "example_2",
    "example_3",
    "example_4",
    "mip",
]


@dataclass(frozen=True, eq=False)
class Example:
    """An example of section 3.1, as printed.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
    U : (a, n) array
        Which errors are integrated.
    region : PoleRegion
        The D-region; theta is the half-angle.
    K_P, K_D : (m, n) arrays
    K_I : (m, a) array
        The printed gains.
    closed_loop_poles : array of complex, or None
        As tabulated; a row per vertex where there are several.
    open_loop_poles : array of complex, or None
        The finite ones, likewise.
    gamma : float, optional
        H-infinity bound.
    saturation : Saturation, optional
        u_max and x(0).
    K_A : (m, n) array, optional
        The printed acceleration gain.
    set_point : (n,) array, optional
        "Unity set point" of the figures.
    disturbance : Sine, optional
        Read as acting on every channel of F (the text doesn't say).
    t_end : float
        Seconds; our choice, the figures' axes are not in the text.
    """

    plant: SecondOrderSystem | Polytope
    U: np.ndarray
    region: PoleRegion
    K_P: np.ndarray
    K_D: np.ndarray
    K_I: np.ndarray
    closed_loop_poles: np.ndarray = None
    open_loop_poles: np.ndarray = None
    gamma: float = None
    saturation: Saturation = None
    K_A: np.ndarray = None
    set_point: np.ndarray = None
    disturbance: Sine = None
    t_end: float = 30.0

    @property
    def K(self):
        """[K_P K_D K_I]."""
        return np.hstack([self.K_P, self.K_D, self.K_I])

    @property
    def requirements(self):
        """Keyword arguments for `design_pid`: U, region, gamma, ..."""
        return dict(
            U=self.U, region=self.region, gamma=self.gamma,
            saturation=self.saturation, K_A=self.K_A,
        )


def example_1():
    """Example 1, a grasping robot, equation (3.1).

    Print has Re(s) < 0.7 for the half-plane Re(s) < -0.7. The
    disturbance is 5 sin(10 t) + 5 for t in [10, 20] s.

    Examples
    --------
    >>> robot = example_1()
    >>> robot.plant.M.diagonal()
    array([10., 11.])
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
    """The plant of Example 2 with a seat and driver of the given mass.

    Parameters
    ----------
    mass : float
        m_s, in kg.
    k22 : float
        Lower right entry of S, in N/m: k1 + k2. Print has k1 + b2,
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
    """Example 2, the seat of a car: m_s between 70 and 120 kg.

    The disturbance is 1000 sin(5 t) + 1000 for t in [7, 12] s, in
    newtons on the car's mass (F = diag(0, 1)).

    Examples
    --------
    >>> [v.M[0, 0] for v in example_2().plant.vertices]
    [np.float64(70.0), np.float64(120.0)]
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
    """Example 3, four masses in a chain; the last weighs nothing.

    The disturbance is sin(5 t) + 1 for t in [10, 20] s. The open-loop
    poles leave out the one at infinity.

    Examples
    --------
    >>> example_3().plant.M.diagonal()
    array([3., 2., 1., 0.])
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
        saturation=Saturation(
            120, 4 * [0.4] + 4 * [-0.02] + 2 * [0.001]
        ),
        K_A=np.array([[1.2655, 0, 0, 0], [0, 0, 0, -1.7345]]),
        K_P=np.array([
            [-61.819, -27.325, 14.2869, -20.834],
            [-16.591, 31.7718, -71.324, 2.8653],
        ]),
        K_D=np.array([
            [-7.9785, -16.5291, 10.9827, -10.6981],
            [-6.8143, 29.4912, -71.0446, 31.8443],
        ]),
        K_I=np.array([[-75.4615, -4.2255], [-9.7808, -33.2117]]),
        open_loop_poles=np.concatenate([
            [-23.698], _pairs(-0.3680 + 0.7923j),
            [-1.9284, -5.0792, -1.0585, -1],
        ]),
        closed_loop_poles=np.concatenate([
            _pairs(-14.2587 + 6.2459j),
            [-4.0065, -3.2294, -1.4582, -1.3700],
            [-7.2055, -5.8602, -1.2489, -1.0232],
        ]),
        set_point=np.ones(4),
        disturbance=Sine(1, 5, offset=1, start=10, stop=20),
        t_end=30.0,
    )


def arm(factor):
    """The plant of Example 4 with m g l sin(phi1) as m g l factor phi1.

    Parameters
    ----------
    factor : float
        sin(phi1) / phi1 for a motion about the rest position (3.3).
    """
    k, mgl = 50, 1 * 10 * 0.1
    return SecondOrderSystem(
        M=np.diag([0.05, 0.1]),
        D=np.zeros((2, 2)),
        S=[[k + mgl * factor, -k], [-k, k]],
        B=[[0], [1]],
    )


def example_4():
    """Example 4, a flexible rotor with an arm: phi1 in [-pi/2, pi/2].

    The vertices are those of (3.3): factor 1 and 2 / pi. Print rounds
    the second S11 to 50.64 and tabulates the poles for 50 + 2 / pi. U
    isn't printed: integrating the motor's angle phi2 gives Table 3.3.

    Examples
    --------
    >>> [round(float(v.S[0, 0]), 4) for v in example_4().plant.vertices]
    [51.0, 50.6366]
    """
    return Example(
        plant=Polytope([arm(1.0), arm(2 / np.pi)]),
        U=np.array([[0.0, 1.0]]),
        region=PoleRegion(sigma=5, theta=np.pi / 3, rho=15),
        K_P=np.array([[-75.7438, 69.9357]]),
        K_D=np.array([[3.2975, -4.1265]]),
        K_I=np.array([[-13.9027]]),
        open_loop_poles=np.array([
            _pairs(38.9023j, 2.5705j), _pairs(38.8396j, 2.0543j),
        ]),
        closed_loop_poles=np.array([
            [*_pairs(-8.0620 + 11.9675j), -13.5952,
             *_pairs(-5.7727 + 4.0952j)],
            [*_pairs(-6.8103 + 9.9304j), -5.9872,
             *_pairs(-10.8284 + 6.7034j)],
        ]),
        t_end=10.0,
    )


@dataclass(frozen=True, eq=False)
class DelayExample:
    """An example of section 3.2, with a delayed input, as printed.

    Parameters
    ----------
    plant : SecondOrderSystem
    U : (a, n) array
        Which errors are integrated.
    tau, mu : float
        The delay stays in [tau - mu, tau + mu], in seconds.
    delta : float
        Decay rate, in 1/s.
    alpha : float
        The scalar of Theorem 2.3.
    K_P, K_D : (m, n) arrays
    K_I : (m, a) array
        The printed gains.
    t_end : float
        Seconds; our choice, the figures' axes are not in the text.
    """

    plant: SecondOrderSystem
    U: np.ndarray
    tau: float
    mu: float
    delta: float
    alpha: float
    K_P: np.ndarray
    K_D: np.ndarray
    K_I: np.ndarray
    t_end: float = 30.0

    @property
    def K(self):
        """[K_P K_D K_I]."""
        return np.hstack([self.K_P, self.K_D, self.K_I])

    @property
    def requirements(self):
        """Keyword arguments for `design_delay_pid`: U, tau, mu, ..."""
        return dict(U=self.U, tau=self.tau, mu=self.mu, delta=self.delta,
                    alpha=self.alpha)


def delay_example_1(published=False):
    """Example 1 of section 3.2, a wing in an air flow, equation (3.5).

    Print has D12 = 2.5 and S22 = 27. Frazer, Duncan and Collar (1938)
    have 2.45 and 2.7, and only with these does the wing flutter.

    Parameters
    ----------
    published : bool
        Take the published numbers instead of the printed ones.

    Examples
    --------
    >>> [float(delay_example_1(p).plant.poles().real.max().round(4))
    ...  for p in (False, True)]
    [-0.256, 0.0947]
    """
    return DelayExample(
        plant=SecondOrderSystem(
            M=[[17.6, 1.28, 2.89], [1.28, 0.824, 0.413],
               [2.89, 0.413, 0.725]],
            D=[[7.66, 2.45 if published else 2.5, 2.1],
               [0.23, 1.04, 0.223], [0.6, 0.756, 0.658]],
            S=[[121, 18.9, 15.9], [0, 2.7 if published else 27, 0.145],
               [11.9, 3.64, 15.5]],
            B=[[1], [0], [0]],
        ),
        U=np.array([[1.0, 0, 0]]),
        tau=0.2, mu=0.1, delta=0.6, alpha=0.6,
        K_P=np.array([[-7.7475, 15.5212, 0.9003]]),
        K_D=np.array([[-75.0955, -4.6038, -12.3270]]),
        K_I=np.array([[-66.2748]]),
    )


def delay_example_2():
    """Example 2 of section 3.2, two masses of Ram et al., (3.6).

    Examples
    --------
    >>> delay_example_2().K.shape
    (1, 5)
    """
    return DelayExample(
        plant=SecondOrderSystem(
            M=np.eye(2), D=[[1, -1], [-1, 1]], S=[[3, -2], [-2, 3]],
            B=[[1], [0]],
        ),
        U=np.array([[1.0, 0]]),
        tau=0.4, mu=0.2, delta=0.1, alpha=0.8,
        K_P=np.array([[0.2727, -0.0513]]),
        K_D=np.array([[-1.1878, -1.0302]]),
        K_I=np.array([[-0.3308]]),
    )


@dataclass(frozen=True, eq=False)
class MipPrint:
    """The mobile inverted pendulum of chapter 4, as printed.

    Parameters
    ----------
    constants : dict
        Known parameters, in SI units, as printed: they don't give a to
        f, and l isn't printed.
    body : tuple
        (4.19): b1, b0, f/c and d/c of (b1 s + b0) / (s^2 + f/c s + d/c).
    wheels : tuple of tuples
        (4.23), (4.24): e/a and f/a of either wheel.
    ratios : dict
        e/c, f/c, d/c of (4.20) and e/a, f/a of (4.23).
    spread : float
        Delta of section 4.2.2 is 1 - spread to 1 + spread.
    identified : dict
        I_b, C_m, t_m and I_w, in SI units, as multiples of Delta.
    letters : dict
        a to f; of a the nominal, least and greatest value, of e the
        least and greatest.
    M, D, S : (4, 2, 2) arrays
        (4.25). D and S have the opposite sign of (2.1).
    B : (4, 2, 1) array
    F : (2, 1) array
    C : (2, 3) array
    pd, pid : dict
        Tables 4.1 and 4.2: [K_P K_D] and [K_P K_D K_I] for each R.
    lqe : dict
        Table 4.3: K = [K_P K_D] (1, 3) and L (3, 2) for each R; the
        state is [theta, theta', phi'].
    E_1, A_1, B_1, B_w : arrays
        (4.27): the first vertex without phi. B_1 is vertex 4's.
    controller, reduced : tuple
        (4.28) and (4.29), R = 2: for theta' and phi' the gain and the
        zeros; then the poles.
    discrete : tuple of arrays
        (4.30): A, B, C, D at 100 Hz, from [theta', phi'].
    """

    constants: dict
    body: tuple
    wheels: tuple
    ratios: dict
    spread: float
    identified: dict
    letters: dict
    M: np.ndarray
    D: np.ndarray
    S: np.ndarray
    B: np.ndarray
    F: np.ndarray
    C: np.ndarray
    pd: dict
    pid: dict
    lqe: dict
    E_1: np.ndarray
    A_1: np.ndarray
    B_1: np.ndarray
    B_w: np.ndarray
    controller: tuple
    reduced: tuple
    discrete: tuple


def mip():
    """The mobile inverted pendulum: every printed number of chapter 4.

    `sosbook.pendulum` has the model with the signs mended.

    Examples
    --------
    >>> mip().pid[5]
    array([[22.276 ,  0.9197,  2.1935,  0.9469,  0.4472]])
    """
    low, mid, high = -0.5584, -0.5659, -0.5739  # D of vertices 2, 1, 3
    wheels = [0.9024, -0.9024]
    return MipPrint(
        constants=dict(g=9.8, V_max=7.4, R_g=35.37, M_b=0.027, M_w=0.263,
                       r=0.034),
        body=(-30.11, -52.49, 7.133, 110.6),
        wheels=((208.8, 33.02), (208.5, 33.32)),
        ratios=dict(e_c=30.52, f_c=7.133, d_c=110.6, e_a=208.8, f_a=33.02),
        spread=0.04,
        identified=dict(I_b=4.98e-4, C_m=2.39e-6, t_m=0.0027,
                        I_w=6.1313e-5),
        letters=dict(a=[4.747e-4, 4.639e-4, 4.865e-4], b=3.482e-4,
                     c=9.641e-4, d=0.1066, e=[0.0282, 0.0306], f=0.0069),
        M=1e-6 * np.array([
            x * np.eye(2) for x in (0.3365, 0.3260, 0.3478, 0.3365)]),
        D=1e-5 * np.array([
            [[x, -x], wheels] for x in (mid, low, high, mid)]),
        S=1e-4 * np.array([
            [[x, 0], [-0.3712, 0]]
            for x in (0.5062, 0.4946, 0.5187, 0.5062)]),
        B=1e-4 * np.array([
            [[-0.2324], [0.3706]], [[-0.2294], [0.3706]],
            [[-0.2554], [0.4015]], [[-0.2518], [0.4015]]]),
        F=np.ones((2, 1)),
        C=np.array([[0.0, 1, 0], [0, 0, 1]]),
        pd={
            1: np.array([[38.3431, 1.0001, 4.0221, 1.5153]]),
            2: np.array([[29.0634, 0.7072, 2.9553, 1.1669]]),
            5: np.array([[21.2689, 0.4472, 2.0587, 0.8688]]),
        },
        pid={
            1: np.array([[41.0411, 1.9873, 4.3391, 1.7000, 0.9997]]),
            2: np.array([[30.8834, 1.4191, 3.1781, 1.2952, 0.7071]]),
            5: np.array([[22.2760, 0.9197, 2.1935, 0.9469, 0.4472]]),
        },
        lqe={
            1: (np.array([[34.6136, 3.6216, 1.2728]]), 1e3 * np.array(
                [[-0.0019, -0.0005], [-1.2599, 0.1975],
                 [1.9754, -0.3320]])),
            2: (np.array([[26.3376, 2.6619, 0.9914]]), 1e3 * np.array(
                [[-0.0018, -0.0004], [-1.2580, 0.1976],
                 [1.9763, -0.3302]])),
        },
        E_1=np.diag([1, 0.3365e-6, 0.3365e-6]),
        A_1=np.array([
            [0, 1, 0],
            [0.5062e-4, -0.5659e-5, 0.5659e-5],
            [-0.3712e-4, 0.9024e-5, -0.9024e-5]]),
        B_1=1e-4 * np.array([[0], [-0.2518], [0.4015]]),
        B_w=np.array([[0.0], [1], [1]]),
        controller=(
            (-1436.1, [-9.031, -88.33]), (188.18, [232.5, -1.992]),
            [-1694, -10.45, -5.039]),
        reduced=(
            (-0.8476, [-9.031, -88.33]), (-25.831, [-1.992]),
            [-5.039, -10.45]),
        discrete=(
            np.array([[0.9008, 0.1481], [0, 0.9509]]),
            np.array([[-0.08405, -0.03019], [-0.02148, 0.00599]]),
            np.array([[8.0, 0]]), np.array([[-0.8477, 0]])),
    )


def _pairs(*poles):
    both = [[p, np.conj(p)] for p in poles]
    return np.array(both).ravel()


def _chain(links):
    """Matrix of springs (or dampers) wall - 1 - 2 - 3 - 4."""
    links = np.asarray(links, float)
    after = np.append(links[1:], 0)
    return (
        np.diag(links + after) - np.diag(links[1:], 1)
        - np.diag(links[1:], -1)
    )
