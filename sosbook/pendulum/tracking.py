"""A pendulum's ratios, delay and friction from the log of its own loop.

The voltage of a loop depends on the noise that it measures, so plain
least squares would be biased. A predictor that estimates the state from
the past (a Kalman filter with a constant gain) has no such bias: it is
fitted so that its one-tick predictions of gyro and encoders are best.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm, solve_discrete_are
from scipy.optimize import least_squares
from scipy.signal import lfilter

from .spread import scaled

__all__ = ["Tracking", "track"]

GENTLE_TILT = 0.35  # rad; beyond it the linear pendulum isn't believed
STICKING_SPEED = 0.5  # rad/s, below which Coulomb friction fades
GYRO_NOISE = 0.003  # rad/s; only its ratio to the other noises matters
DISTURBANCES = 0.01, 0.1  # V; the best of these is taken
LEAST_TICKS = 600
SETTLING = 1.0  # s, which the predictor takes to find the state: left out
BLOCKS = 4  # parts of the log, whose fits say how far one can be trusted
MODEL_ERROR = 0.01  # relative: what the linear pendulum and the counts leave
#: The logarithms of three factors, the delay over T and the friction in V.
NOMINAL = 0.0, 0.0, 0.0, 0.3, 0.05
NAMES = "body", "wheels", "back-EMF", "delay", "friction"
SMALLEST = np.array([-0.5, -0.5, -0.5, 0.0, 0.0])
LARGEST = np.array([0.5, 0.5, 0.5, 1.0, 5.0])
SIZES = np.array([0.1, 0.1, 0.1, 0.3, 0.1])


@dataclass(frozen=True, eq=False)
class Tracking:
    """What a loop's own log says of the pendulum in it.

    ``values``: body, wheels and back-EMF: the factors of e/c, of e/a and of f; delay in
    s; friction in V; ``sd``: their standard deviations; ``innovations``, (2, N): what
    the gyro (rad/s) and the wheels (rad) said beyond the prediction; ``t``, (N,): the
    times of the innovations, in s.
    """

    values: dict
    sd: dict
    innovations: np.ndarray
    t: np.ndarray

    def interval(self, name, sds=1.96):
        """The ends of the interval of the parameter ``name``, so many ``sds`` away."""
        half = sds * self.sd[name]
        return self.values[name] - half, self.values[name] + half


def track(log, mip, T, counts):
    """Fit a pendulum to the log of its own loop.

    ``log``: the ticks of a program; ``mip``: the pendulum that the program was made
    for; ``T``: time between samples, in s; ``counts``: an encoder's counts per turn.
    Returns the factors by which the pendulum differs, the delay and the friction.
    Raises ValueError if the log has too few ticks near upright.
    """
    use = _gentle(log)
    if use.sum() < LEAST_TICKS:
        raise ValueError(
            f"the log has {use.sum()} ticks near upright without a gap, but a fit "
            f"takes {LEAST_TICKS}: let the robot stand longer"
        )
    gyro, wheels, V = (x[use] for x in (log.gyro - log.gyro[0], log.wheels, log.V))
    wheels = wheels - wheels[0]
    scale = np.array([GYRO_NOISE, 2 * np.pi / counts / 12**0.5])
    signals = gyro, wheels, V, _friction(wheels, T)

    def fitted(part, disturbance, start):
        chosen = [x[part] for x in signals]

        predictor = Predictor(mip, T, *chosen, scale, disturbance)

        def residuals(x):
            try:
                e = predictor.innovations(x)
            except ValueError:  # masses that no pendulum has
                return np.full(2 * predictor.told, 1e3)
            return np.ravel(e / scale[:, None])

        return least_squares(
            residuals, start, bounds=(SMALLEST, LARGEST), x_scale=SIZES, max_nfev=25
        )

    found = []
    for disturbance in DISTURBANCES:
        fit = fitted(slice(None), disturbance, NOMINAL)
        e = fit.fun.reshape(2, -1)
        found.append((np.linalg.slogdet(e @ e.T)[1], disturbance, fit.x, e))
    _, disturbance, x, e = min(found, key=lambda one: one[0])
    edges = np.linspace(0, len(V), BLOCKS + 1).astype(int)
    blocks = [fitted(slice(*ends), disturbance, x).x for ends in zip(edges, edges[1:])]
    apart = np.std(blocks, axis=0, ddof=1) / BLOCKS**0.5
    values = np.array([*np.exp(x[:3]), T * x[3], x[4]])
    unit = np.array([*values[:3], T, 1.0])
    sd = unit * np.hypot(apart, [*3 * [MODEL_ERROR], 0.0, 0.0])
    return Tracking(
        dict(zip(NAMES, map(float, values))),
        dict(zip(NAMES, map(float, sd))),
        e * scale[:, None],
        log.t[use][-e.shape[1] :],
    )


def _friction(wheels, T):
    """(N,) array, -1 to 1: how much of Coulomb's friction acts."""
    return np.tanh(np.gradient(wheels, T) / STICKING_SPEED)


def _gentle(log):
    """(N,) bool: the longest stretch of running ticks near upright, all read."""
    good = log.running & (np.abs(log.theta) < GENTLE_TILT)
    good &= np.isfinite(log.gyro) & np.isfinite(log.wheels)
    bad = np.flatnonzero(~np.append(good, False))
    before = np.append(-1, bad[:-1])
    k = int(np.argmax(bad - before))
    use = np.zeros(len(good), bool)
    use[before[k] + 1 : bad[k]] = True
    return use


class Predictor:
    """What two sensors say beyond a Kalman filter's prediction.

    The unknowns x are the logarithms of the three factors, the delay over T
    and the friction.

    ``mip``: the pendulum whose factors are one; ``T``: time between samples, in s;
    ``gyro``, ``wheels``, ``V``, (N,): the samples; ``rubs``, (N,): the share of the
    friction that acts; ``scale``, (2,): the sensors' noise; ``disturbance``: the noise
    of the voltage, in V.
    """

    C = np.array([[0.0, 0, 1, 0, 1], [-1, 1, 0, 0, 0]])  # gyro + offset, wheels

    def __init__(self, mip, T, gyro, wheels, V, rubs, scale, disturbance):
        self.mip, self.T, self.disturbance = mip, T, disturbance
        self.y = np.array([gyro, wheels - wheels[0]])
        self.start = np.array([0, 0, gyro[0], gyro[0], 0])
        self.inputs = np.array([V, np.append(V[0], V[:-1]), rubs])
        self.R = np.diag(scale**2)
        self.first = min(round(SETTLING / T), len(V) // 2)
        self.told = len(V) - self.first

    def innovations(self, x):
        """(2, told) array: what the sensors say beyond the prediction."""
        C = self.C
        F, now, last = self._parts(x)
        push = now + last
        Q = self.disturbance**2 * np.outer(push, push)
        Q += np.diag([1e-14] * 4 + [1e-12])
        P = solve_discrete_are(F.T, C.T, Q, self.R)
        K = P @ C.T @ np.linalg.inv(C @ P @ C.T + self.R)
        forces = np.stack([now, last, -x[4] * push], axis=1) @ self.inputs
        forced = F @ K @ self.y + forces
        forced = np.column_stack([self.start, forced[:, :-1]])
        states = _filtered(F - F @ K @ C, forced)
        return (self.y - C @ states)[:, self.first :]

    def _parts(self, x):
        """F, and how a volt of this tick and one of the last act in a tick."""
        body, wheel, motor = np.exp(x[:3])
        robot, T = scaled(self.mip, body, wheel), self.T
        plant = replace(robot, f=robot.f * motor).plant()
        both = np.zeros((6, 6))  # the states and a voltage that is held
        both[:2, 2:4] = np.eye(2)
        both[2:4, :4] = -np.linalg.solve(plant.M, np.hstack([plant.S, plant.D]))
        both[2:4, 5:] = np.linalg.solve(plant.M, plant.B)
        first, then = expm(both * T * x[3]), expm(both * T * (1 - x[3]))
        return (then @ first)[:5, :5], then[:5, 5], then[:5, :5] @ first[:5, 5]


def _filtered(F, forced):
    """(n, N) array: x(k) = F x(k - 1) + forced(k), and x(0) is forced(0)."""
    poles, modes = np.linalg.eig(F)
    inputs = np.linalg.solve(modes, forced)
    rows = [lfilter([1.0], [1.0, -p], row) for p, row in zip(poles, inputs)]
    return (modes @ np.array(rows)).real
