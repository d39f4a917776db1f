"""The examples of section 3.2: a delayed input, as printed."""

from dataclasses import dataclass

import numpy as np

from ...laws import FullState
from ...loops import Loop
from ...plants.second_order import SecondOrderSystem


@dataclass(frozen=True, eq=False)
class DelayExample:
    """An example of section 3.2, with a delayed input, as printed.

    ``plant``: the plant of the example; ``U``, (a, n): which errors are integrated;
    ``tau``, ``mu``: the delay stays in [tau - mu, tau + mu], in seconds; ``delta``:
    decay rate, in 1/s; ``alpha``: the scalar of Theorem 2.3; ``K_P``, ``K_D``, (m, n):
    the printed gains of z and z'; ``K_I``, (m, a): the printed gain of the integrated
    errors; ``t_end``: seconds; our choice, the figures' axes are not in the text.
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
    def loop(self):
        """The plant with the printed gains, a `Loop`."""
        return Loop(self.plant, FullState(self.U), self.K)

    @property
    def requirements(self):
        """Keyword arguments for `design_delay_pid`: U, tau, mu, ..."""
        return dict(
            U=self.U, tau=self.tau, mu=self.mu, delta=self.delta, alpha=self.alpha
        )


def delay_example_1(published=False):
    """Example 1 of section 3.2, a wing in an air flow, equation (3.5). The thesis
    prints D12 = 2.5 and S22 = 27. Frazer, Duncan and Collar (1938) have 2.45 and 2.7,
    the ``published`` numbers: with 2.7 the wing flutters, whichever D12 it has; with 27
    it doesn't.
    """
    return DelayExample(
        plant=SecondOrderSystem(
            M=[[17.6, 1.28, 2.89], [1.28, 0.824, 0.413], [2.89, 0.413, 0.725]],
            D=[
                [7.66, 2.45 if published else 2.5, 2.1],
                [0.23, 1.04, 0.223],
                [0.6, 0.756, 0.658],
            ],
            S=[
                [121, 18.9, 15.9],
                [0, 2.7 if published else 27, 0.145],
                [11.9, 3.64, 15.5],
            ],
            B=[[1], [0], [0]],
        ),
        U=np.array([[1.0, 0, 0]]),
        tau=0.2,
        mu=0.1,
        delta=0.6,
        alpha=0.6,
        K_P=np.array([[-7.7475, 15.5212, 0.9003]]),
        K_D=np.array([[-75.0955, -4.6038, -12.3270]]),
        K_I=np.array([[-66.2748]]),
    )


def delay_example_2():
    """Example 2 of section 3.2, two masses of Ram et al., (3.6)."""
    return DelayExample(
        plant=SecondOrderSystem(
            M=np.eye(2), D=[[1, -1], [-1, 1]], S=[[3, -2], [-2, 3]], B=[[1], [0]]
        ),
        U=np.array([[1.0, 0]]),
        tau=0.4,
        mu=0.2,
        delta=0.1,
        alpha=0.8,
        K_P=np.array([[0.2727, -0.0513]]),
        K_D=np.array([[-1.1878, -1.0302]]),
        K_I=np.array([[-0.3308]]),
    )
