"""The sampled optimal law: the regulator of chapter 23 behind an observer."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_discrete_are

from ..sampled.discretize import SampleTiming, input_vertices
from ..sampled.lqr import design_sampled_lqr
from .law import TRACKING_TIME, SampledLaw

__all__ = ["OptimalLaw", "optimal_law"]

U = [[0, 1]]  # integrate phi
DISTURBANCE_SHARE = 0.05  # of the limit: V that change from tick to tick
TILT_NOISE = 0.01  # rad, of the estimate of theta
GYRO_NOISE = 0.003  # rad/s
REST_SHARE = 1e-9  # of the disturbance, on every state: no gain dies out
SEEN = (0, 1, 2)  # of theta, phi, theta', phi': a difference isn't needed


@dataclass(frozen=True, eq=False)
class OptimalLaw:
    """A law of least quadratic cost for the pendulum in the middle.

    ``K``, (1, 5 + d): the gain of [theta, phi, theta', phi', x3] and of the d older
    voltages; ``M``, (4, 3): how far the observer's state follows what theta, phi and
    theta' say beyond its prediction; ``Q``, (5, 5): the weight of the state; ``R``: the
    weight of the voltage; ``law``: what runs on the robot.
    """

    K: np.ndarray
    M: np.ndarray
    Q: np.ndarray
    R: float
    law: SampledLaw


def optimal_law(mip, robot, Q, R):
    """The `OptimalLaw` of a pendulum, for the robot's clock and largest delay.

    ``mip``: the pendulum in the middle; ``robot``: its T, delay, counts and limit are
    used; ``Q``, (5, 5) array_like: the weight of the state [theta, phi, theta', phi',
    x3]; ``R``: the weight of the voltage. Returns the gains and the law. Raises
    ValueError where Riccati's equations have no solution.

    The regulator is `design_sampled_lqr`'s. The observer is the stationary
    Kalman filter in discrete time for a voltage that is disturbed from tick
    to tick; it is told the voltage after the limit.
    """
    T, plant = robot.T, mip.plant()
    K = design_sampled_lqr(plant, Q, [[R]], T, robot.delay, U).K
    (vertex,) = input_vertices(plant, None)
    A, B = SampleTiming.of(T, robot.delay).held(vertex)
    n = len(A) - 4
    M = _filter(vertex, robot, A[:4, :4])
    # x = stay s + take y is the state that the gain sees
    take = M @ np.eye(4)[list(SEEN)]
    stay = np.eye(4) - take
    K_x, K_I, K_u = K[:, :4], K[:, 4:5], K[:, 5:]
    C, D = np.hstack([K_x @ stay, K_I, K_u]), K_x @ take
    moves, sees_y = np.zeros((5 + n, 5 + n)), np.zeros((5 + n, 4))
    moves[:4, :4], moves[:4, 5:] = A[:4, :4] @ stay, A[:4, 4:]
    moves[4, 4], moves[5:, 5:] = 1, A[4:, 4:]
    sees_y[:4], sees_y[4, 1] = A[:4, :4] @ take, T
    voltage = np.vstack([B[:4], [[0]], B[4:]])
    withheld = voltage.copy()  # the older voltages are those after the limit
    withheld[4] = T / (TRACKING_TIME * K_I[0, 0])
    parts = moves + voltage @ C, sees_y + voltage @ D, C, D, T
    law = SampledLaw(*parts, W=withheld, start=[1, 0, 0, 0] + [0] * (1 + n))
    return OptimalLaw(K, M, np.asarray(Q, float), float(R), law)


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
