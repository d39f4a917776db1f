"""The mobile inverted pendulum of chapter 4, as printed."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class MipPrint:
    """The mobile inverted pendulum of chapter 4, as printed. ``constants``: known
    parameters, in SI units: they don't give a to f, and l isn't printed; ``body``,
    (4.19): b1, b0, f/c and d/c of (b1 s + b0) / (s^2 + f/c s + d/c); ``wheels``,
    (4.23), (4.24): e/a and f/a of either; ``ratios``: e/c, f/c, d/c of (4.20) and e/a,
    f/a of (4.23); ``spread``: Delta of section 4.2.2 is 1 - spread to 1 + spread;
    ``identified``: I_b, C_m, t_m and I_w, in SI units, as multiples of Delta;
    ``letters``: a to f, of a the nominal, least and greatest value, of e the least and
    greatest; ``M``, ``D``, ``S``, (4, 2, 2), of (4.25), D and S with the opposite sign
    of (2.1), ``B``, (4, 2, 1), ``F``, (2, 1), ``C``, (2, 3); ``pd``, ``pid``, Tables
    4.1 and 4.2: [K_P K_D] and [K_P K_D K_I] for each R; ``lqe``, Table 4.3: K = [K_P
    K_D] (1, 3) and L (3, 2) for each R, of the state [theta, theta', phi']; ``E_1``,
    ``A_1``, ``B_1``, ``B_w``, (4.27): the first vertex without phi, but B_1 is vertex
    4's; ``controller``, ``reduced``, (4.28) and (4.29), R = 2: for theta' and phi' the
    gain and the zeros, then the poles; ``discrete``, (4.30): A, B, C, D at 100 Hz, from
    [theta', phi'].
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

    @property
    def gains(self):
        """``pd`` and ``pid`` as each a `Gain` that names its signals."""
        # the pendulum's room isn't loaded for the sake of numbers
        from ...pendulum import PD_SIGNALS, PID_SIGNALS, Gain

        tables = ("PD", self.pd, PD_SIGNALS), ("PID", self.pid, PID_SIGNALS)
        return {
            law: {R: Gain(K, signals) for R, K in table.items()}
            for law, table, signals in tables
        }


def mip():
    """The `MipPrint`, every printed number of chapter 4; `sosbook.pendulum` has its
    signs mended.
    """
    low, mid, high = -0.5584, -0.5659, -0.5739  # D of vertices 2, 1, 3
    wheels = [0.9024, -0.9024]
    return MipPrint(
        constants=dict(g=9.8, V_max=7.4, R_g=35.37, M_b=0.027, M_w=0.263, r=0.034),
        body=(-30.11, -52.49, 7.133, 110.6),
        wheels=((208.8, 33.02), (208.5, 33.32)),
        ratios=dict(e_c=30.52, f_c=7.133, d_c=110.6, e_a=208.8, f_a=33.02),
        spread=0.04,
        identified=dict(I_b=4.98e-4, C_m=2.39e-6, t_m=0.0027, I_w=6.1313e-5),
        letters=dict(
            a=[4.747e-4, 4.639e-4, 4.865e-4],
            b=3.482e-4,
            c=9.641e-4,
            d=0.1066,
            e=[0.0282, 0.0306],
            f=0.0069,
        ),
        M=1e-6 * np.array([x * np.eye(2) for x in (0.3365, 0.3260, 0.3478, 0.3365)]),
        D=1e-5 * np.array([[[x, -x], wheels] for x in (mid, low, high, mid)]),
        S=1e-4
        * np.array([[[x, 0], [-0.3712, 0]] for x in (0.5062, 0.4946, 0.5187, 0.5062)]),
        B=1e-4
        * np.array(
            [
                [[-0.2324], [0.3706]],
                [[-0.2294], [0.3706]],
                [[-0.2554], [0.4015]],
                [[-0.2518], [0.4015]],
            ]
        ),
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
            1: (
                np.array([[34.6136, 3.6216, 1.2728]]),
                1e3
                * np.array([[-0.0019, -0.0005], [-1.2599, 0.1975], [1.9754, -0.3320]]),
            ),
            2: (
                np.array([[26.3376, 2.6619, 0.9914]]),
                1e3
                * np.array([[-0.0018, -0.0004], [-1.2580, 0.1976], [1.9763, -0.3302]]),
            ),
        },
        E_1=np.diag([1, 0.3365e-6, 0.3365e-6]),
        A_1=np.array(
            [
                [0, 1, 0],
                [0.5062e-4, -0.5659e-5, 0.5659e-5],
                [-0.3712e-4, 0.9024e-5, -0.9024e-5],
            ]
        ),
        B_1=1e-4 * np.array([[0], [-0.2518], [0.4015]]),
        B_w=np.array([[0.0], [1], [1]]),
        controller=(
            (-1436.1, [-9.031, -88.33]),
            (188.18, [232.5, -1.992]),
            [-1694, -10.45, -5.039],
        ),
        reduced=((-0.8476, [-9.031, -88.33]), (-25.831, [-1.992]), [-5.039, -10.45]),
        discrete=(
            np.array([[0.9008, 0.1481], [0, 0.9509]]),
            np.array([[-0.08405, -0.03019], [-0.02148, 0.00599]]),
            np.array([[8.0, 0]]),
            np.array([[-0.8477, 0]]),
        ),
    )
