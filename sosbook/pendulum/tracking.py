"""A pendulum's ratios and how it turns, from the log of its own loop.

The voltage of a loop depends on the noise that it measures, so plain
least squares would be biased. A predictor that estimates the state from
the past (a Kalman filter with a constant gain) has no such bias: it is
fitted so that its one-tick predictions of gyro and encoders are best.

How it turns is behind no such loop: the wheels' difference delta = phi_R - phi_L obeys

    p delta'' + d delta' = W + 2 m V - 2 d c s' - k (rub_R - rub_L),

with p = a_d / e and d = f / e of `turning_plants`, W = V_R - V_L, the wheels'
mean angle s against the body, shares m and c by which the right motor has more
e and f than the mean, and the friction k. A simulation of it is fitted to
stretches of the log, each from a start of its own.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm, solve_discrete_are
from scipy.optimize import least_squares
from scipy.signal import lfilter

from ..bisection import lowest
from .spread import scaled

__all__ = ["Heading", "Tracking", "track", "track_heading"]

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
#: Of differences: shorter ones divide the rounding of the filter's Riccati equation.
STEPS = 1e-4 * SIZES
#: Of the fit to how it turns.
STRETCH = 2.0  # s, which is simulated from a start of its own
LEAST_COUNTS = 0.3  # a tick, rms: wheels that turn slower say too little
TURN_RATES = 0.5, 500.0  # 1/s, between which the turning's own rate is looked for
TURN_NAMES = "inertia", "damping", "stronger", "braking", "friction"


@dataclass(frozen=True, eq=False)
class Known:
    """Parameters by name: their ``values`` and ``sd``, their standard deviations."""

    values: dict
    sd: dict

    @classmethod
    def of(cls, names, values, blocks, errors, unit, *rest):
        """The ``names`` with their ``values``, as far as the ``blocks`` know them.

        These are of parts of the log, in units of ``unit``, as are the model's own
        ``errors``; ``rest``: other fields.
        """
        apart = np.std(blocks, axis=0, ddof=1) / BLOCKS**0.5
        sd = unit * np.hypot(apart, errors)
        both = (dict(zip(names, map(float, x))) for x in (values, sd))
        return cls(*both, *rest)

    def interval(self, name, sds=1.96):
        """The ends of the interval of the parameter ``name``, so many ``sds`` away."""
        half = sds * self.sd[name]
        return self.values[name] - half, self.values[name] + half


@dataclass(frozen=True, eq=False)
class Tracking(Known):
    """The pendulum in a loop, identified from the loop's own log.

    ``values``: body, wheels and back-EMF: the factors of e/c, of e/a and of f; delay in
    s; friction in V; ``sd``: their deviations; ``innovations``, (2, N): what the gyro
    (rad/s) and the wheels (rad) said beyond the prediction; ``t``, (N,): their times,
    in s.
    """

    innovations: np.ndarray
    t: np.ndarray


@dataclass(frozen=True, eq=False)
class Heading(Known):
    """The robot's turning, identified from the loop's own log.

    ``values``: inertia, a_d / e, and damping, f / e, in V per rad/s^2 and rad/s;
    stronger and braking, the shares by which the right motor's e and f are above the
    mean; friction in V; ``sd``: their deviations; ``residuals``, (N,): what the wheels'
    difference was beyond the simulation, in rad.
    """

    residuals: np.ndarray


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
        """The fit to the ``part`` of the log, with a ``disturbance`` or without."""
        chosen = [x[part] for x in signals]

        predictor = Predictor(mip, T, *chosen, scale, disturbance)

        def residuals(x):
            try:
                e = predictor.innovations(x)
            except ValueError:  # masses that no pendulum has
                return np.full(2 * predictor.told, 1e3)
            return np.ravel(e / scale[:, None])

        def slopes(x):
            steps = np.where(x + STEPS > LARGEST, -STEPS, STEPS)
            moved = [residuals(x + step) for step in np.diag(steps)]
            return ((moved - residuals(x)) / steps[:, None]).T

        bounds, scales = (SMALLEST, LARGEST), dict(x_scale=SIZES, max_nfev=25)
        return least_squares(residuals, start, slopes, bounds, **scales)

    found = []
    for disturbance in DISTURBANCES:
        fit = fitted(slice(None), disturbance, NOMINAL)
        e = fit.fun.reshape(2, -1)
        found.append((np.linalg.slogdet(e @ e.T)[1], disturbance, fit.x, e))
    _, disturbance, x, e = min(found, key=lambda one: one[0])
    edges = np.linspace(0, len(V), BLOCKS + 1).astype(int)
    blocks = [fitted(slice(*ends), disturbance, x).x for ends in zip(edges, edges[1:])]
    values = np.array([*np.exp(x[:3]), T * x[3], x[4]])
    errors, unit = [*3 * [MODEL_ERROR], 0.0, 0.0], np.array([*values[:3], T, 1.0])
    rest = e * scale[:, None], log.t[use][-e.shape[1] :]
    return Tracking.of(NAMES, values, blocks, errors, unit, *rest)


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
    """The innovations of two sensors: readings beyond a Kalman filter's prediction.

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


def track_heading(log, T, counts, delay):
    """Fit how a robot turns to the log of its own loop.

    ``log``: the ticks of a program that steers; ``T``: time between samples, in s;
    ``counts``: an encoder's counts per turn; ``delay``: from the samples to the volts,
    in s. Returns the plant behind the heading, and how the motors differ. Raises
    ValueError if the robot hardly turned, or the log is too short.
    """
    use = log.running & np.isfinite(log.left) & np.isfinite(log.right)
    last = np.flatnonzero(use)[-1] + 1 if use.any() else 0
    first = last - int(np.argmin(np.append(use[:last][::-1], False)))
    length = max(round(STRETCH / T), 4)
    if last - first < 2 * BLOCKS * length:
        raise ValueError(
            f"the log's last {max(last - first, 0)} ticks without a gap are too few to "
            f"fit how it turns, which takes {2 * BLOCKS * length}"
        )
    wheels = np.array([log.left, log.right])[:, first:last]
    delta = wheels[1] - wheels[0]
    speed = float(np.sqrt(np.mean(np.diff(delta) ** 2))) * counts / (2 * np.pi)
    if speed < LEAST_COUNTS:
        raise ValueError(
            f"the wheels turn against each other by {speed:.2g} counts a tick, too "
            "little to fit: let it turn left and right"
        )
    rub = np.tanh(np.gradient(wheels, T, axis=1) / STICKING_SPEED)
    mean = np.diff(wheels.mean(axis=0), append=wheels[:, -1].mean()) / T
    volts = [(log.V_right - log.V_left)[first:last], log.V[first:last]]
    late = [_late(V, delay / T) for V in volts]
    signals = np.array([*late, -mean, rub[0] - rub[1]])
    stretches = [
        slice(k, k + length) for k in range(0, len(delta) - length + 1, length)
    ]
    values, residuals = _turning(delta, signals, T, stretches)
    blocks = [
        _turning(delta, signals, T, stretches[k::BLOCKS])[0] for k in range(BLOCKS)
    ]
    errors = MODEL_ERROR * np.array([values[0], values[1], 1, 1, 0])
    return Heading.of(TURN_NAMES, values, blocks, errors, 1.0, residuals)


def _late(V, share):
    """The mean of V over each tick, if it acts a ``share`` of one later."""
    whole, part = divmod(share, 1.0)
    V = np.concatenate([np.full(int(whole) + 1, V[0]), V])
    return ((1 - part) * V[1:] + part * V[:-1])[: len(V) - int(whole) - 1]


def _turning(delta, signals, T, stretches):
    """The values of `TURN_NAMES`, and what the best of them leave."""

    def solved(log_rate):
        """(gains, residuals) of the fit for one rate."""
        rate = np.exp(log_rate)
        fall = np.exp(-rate * T)
        rise = -np.expm1(-rate * T) / rate
        speed = lfilter([0.0, rise], [1.0, -fall], signals, axis=1)
        step = rise * speed + (T - rise) / rate * signals
        columns, rest = [], []
        for part in stretches:
            # how a stretch starts: its angle, and a speed that fades
            angle = np.cumsum(step[:, part], axis=1)
            angle = np.column_stack([np.zeros(len(angle)), angle[:, :-1]])
            t = T * np.arange(angle.shape[1])
            free = np.array([np.ones_like(t), np.exp(-rate * t)])
            basis = np.linalg.qr(free.T)[0]
            columns.append(angle.T - basis @ (basis.T @ angle.T))
            rest.append(delta[part] - basis @ (basis.T @ delta[part]))
        columns, rest = np.vstack(columns), np.concatenate(rest)
        scale = np.maximum(np.linalg.norm(columns, axis=0), 1e-12)
        gains = np.linalg.lstsq(columns / scale, rest, rcond=1e-9)[0] / scale
        return gains, rest - columns @ gains

    least, most = np.log(TURN_RATES)
    turn, _ = lowest(lambda x: np.mean(solved(x)[1] ** 2), least, most, 1e-4)
    gains, residuals = solved(turn)
    inertia = 1 / gains[0] if gains[0] else np.inf
    damping = np.exp(turn) * inertia
    stronger, mean, rub = gains[1:] * inertia
    values = inertia, damping, stronger / 2, mean / damping / 2, rub
    return np.array(values), residuals
