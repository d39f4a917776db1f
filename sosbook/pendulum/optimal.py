"""Sampled optimal laws: the regulator of chapter 28 and an observer before it."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_discrete_are

from ..sampled.discretize import SampleTiming, input_vertices
from ..sampled.lqr import design_sampled_lqr
from .law import TRACKING_TIME, SampledLaw

__all__ = ["KINDS", "OptimalLaw", "optimal_law"]

KINDS = ("lqr", "observer")
U = [[0, 1]]  # integrate phi
DISTURBANCE_SHARE = 0.05  # of the limit: V that change from tick to tick
TILT_NOISE = 0.01  # rad, of the estimate of theta
GYRO_NOISE = 0.003  # rad/s
REST_SHARE = 1e-9  # of the disturbance, on every state: no gain dies out
SEEN = (0, 1, 2)  # of theta, phi, theta', phi': a difference isn't needed


@dataclass(frozen=True, eq=False)
class OptimalLaw:
    """A law of least quadratic cost for the pendulum in the middle.

    ``kind``, {"lqr", "observer"}: whether the four signals are taken as they are, or an
    observer stands before the gain; ``K``, (1, 5 + d): the gain of [theta, phi, theta',
    phi', x3] and of the d older voltages; ``M``, (4, 3) or None: how far the observer's
    state follows what theta, phi and theta' say beyond its prediction; ``Q``, (5, 5):
    the weight of the state; ``R``: the weight of the voltage; ``law``: what runs on the
    robot.
    """

    kind: str
    K: np.ndarray
    M: np.ndarray | None
    Q: np.ndarray
    R: float
    law: SampledLaw

    @property
    def specification(self):
        """What is optimal, in words."""
        text = (
            "sampled and delay-aware least quadratic cost for the plant in the middle"
        )
        if self.kind == "observer":
            text += ", behind a Kalman filter of theta, phi and theta'"
        return text


def optimal_law(mip, robot, kind, Q, R):
    """The `OptimalLaw` of a pendulum, for the robot's clock and largest delay.

    Parameters
    ----------
    mip : Mip
        The pendulum in the middle.
    robot : Robot
        Its T, delay, counts and limit are used.
    kind : {"lqr", "observer"}
        As in `OptimalLaw`.
    Q : (5, 5) array_like
        The weight of the state [theta, phi, theta', phi', x3].
    R : float
        The weight of the voltage.

    Returns
    -------
    OptimalLaw
        The gains and the law.

    Raises
    ------
    ValueError
        On another kind, or where Riccati's equations have no solution.

    Notes
    -----
    The regulator is `design_sampled_lqr`'s. The observer is the stationary
    Kalman filter in discrete time for a voltage that is disturbed from tick
    to tick; it is told the voltage after the limit.

    Examples
    --------
    >>> from sosbook.pendulum import Mip, Robot
    >>> late = Robot.shipped("thesis")
    >>> found = optimal_law(Mip.printed(), late, "observer", np.eye(5), 20)
    >>> found.law.order, found.K.shape
    (6, (1, 6))
    """
    if kind not in KINDS:
        raise ValueError(f"law must be one of {KINDS}, got {kind!r}")
    T, plant = robot.T, mip.plant()
    K = design_sampled_lqr(plant, Q, [[R]], T, robot.delay, U).K
    (vertex,) = input_vertices(plant, None)
    A, B = SampleTiming.of(T, robot.delay).held(vertex)
    n = len(A) - 4
    M = None if kind == "lqr" else _filter(vertex, robot, A[:4, :4])
    sees = np.eye(4)[list(SEEN)]
    # x = stay s + take y is the state that the gain sees
    stay = np.zeros((4, 0)) if M is None else np.eye(4) - M @ sees
    take = np.eye(4) if M is None else M @ sees
    observed = stay.shape[1]
    K_x, K_I, K_u = K[:, :4], K[:, 4:5], K[:, 5:]
    C, D = np.hstack([K_x @ stay, K_I, K_u]), K_x @ take
    moves = np.zeros((observed + 1 + n, observed + 1 + n))
    sees_y = np.zeros((observed + 1 + n, 4))
    voltage = np.zeros((observed + 1 + n, 1))
    if observed:
        moves[:4, :4], moves[:4, 5:] = A[:4, :4] @ stay, A[:4, 4:]
        sees_y[:4], voltage[:4] = A[:4, :4] @ take, B[:4]
    moves[observed, observed], sees_y[observed, 1] = 1, T
    moves[observed + 1 :, observed + 1 :] = A[4:, 4:]
    voltage[observed + 1 :] = B[4:]
    withheld = voltage.copy()  # the older voltages are those after the limit
    withheld[observed] = T / (TRACKING_TIME * K_I[0, 0])
    law = SampledLaw(
        moves + voltage @ C,
        sees_y + voltage @ D,
        C,
        D,
        T,
        W=withheld,
        start=[1, 0, 0, 0] * bool(observed) + [0] * (1 + n),
    )
    return OptimalLaw(kind, K, M, np.asarray(Q, float), float(R), law)


def _filter(vertex, robot, flow):
    """The gain of the stationary Kalman filter at the ticks; (4, 3)."""
    _, push = SampleTiming.of(robot.T, 0.0).held(vertex)
    sees = np.eye(4)[list(SEEN)]
    count = 2 * np.pi / robot.counts / 12**0.5
    noise = np.diag([TILT_NOISE, count, GYRO_NOISE]) ** 2
    process = (DISTURBANCE_SHARE * robot.limit) ** 2 * push @ push.T
    process += REST_SHARE * np.trace(process) * np.eye(4)
    P = solve_discrete_are(flow.T, sees.T, process, noise)
    return np.linalg.solve(sees @ P @ sees.T + noise, sees @ P).T
