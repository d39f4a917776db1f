"""The thesis's plants and printed numbers, each with its place.

Nothing here is computed. Where print is wrong, the correction is made
in the open: see the field's comment and the errata.
"""

from dataclasses import dataclass

import numpy as np

from .regions import PoleRegion
from .request import Saturation
from .simulate import Sine
from .system import SecondOrderSystem

__all__ = ["Example1", "example_1"]


@dataclass(frozen=True, eq=False)
class Example1:
    """The grasping robot of section 3.1, Example 1.

    Parameters
    ----------
    plant : SecondOrderSystem
        Equation (3.1).
    U : (2, 2) array
        Both errors are integrated.
    region : PoleRegion
        Re s < -0.7 (print: 0.7), half-angle pi/4, radius 5 rad/s.
    gamma : float
        H-infinity bound.
    saturation : Saturation
        u_max and x(0).
    K_P, K_D, K_I : (2, 2) arrays
        The printed gains.
    open_loop_poles, closed_loop_poles : arrays of complex
        Table 3.1.
    set_point : (2,) array
        "Unity set point" of Figs 3.2 and 3.3.
    disturbance : Sine
        5 sin(10 t) + 5 for t in [10, 20] s, read as acting on both
        channels (the text doesn't say).
    t_end : float
        Seconds; our choice, the figures' axes are not in the text.
    """

    plant: SecondOrderSystem
    U: np.ndarray
    region: PoleRegion
    gamma: float
    saturation: Saturation
    K_P: np.ndarray
    K_D: np.ndarray
    K_I: np.ndarray
    open_loop_poles: np.ndarray
    closed_loop_poles: np.ndarray
    set_point: np.ndarray
    disturbance: Sine
    t_end: float

    @property
    def K(self):
        """[K_P K_D K_I]."""
        return np.hstack([self.K_P, self.K_D, self.K_I])

    @property
    def requirements(self):
        """Keyword arguments for `design_pid`: U, region, gamma, ..."""
        return dict(
            U=self.U, region=self.region, gamma=self.gamma,
            saturation=self.saturation,
        )


def example_1():
    """Example 1, as printed.

    Examples
    --------
    >>> robot = example_1()
    >>> robot.plant.M.diagonal()
    array([10., 11.])
    """
    return Example1(
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


def _pairs(*poles):
    both = [[p, p.conjugate()] for p in poles]
    return np.array(both).ravel()
