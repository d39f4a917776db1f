"""How a robot turns, from the log of its own loop.

The wheels' difference delta = phi_R - phi_L obeys

    p delta'' + d delta' = W + 2 m V - 2 d c s' - k (rub_R - rub_L),

with p = a_d / e and d = f / e of `turning_plants`, W = V_R - V_L, the wheels'
mean angle s against the body, shares m and c by which the right motor has more
e and f than the mean, and the friction k. A simulation of it is fitted to
stretches of the log, each from a start of its own.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter

__all__ = ["Heading", "track_heading"]

STRETCH = 2.0  # s, which is simulated from a start of its own
BLOCKS = 4  # parts of the log, whose fits say how far one can be trusted
MODEL_ERROR = 0.01  # relative: what the linear plant and the counts leave
LEAST_COUNTS = 0.3  # a tick, rms: wheels that turn slower say too little
STICKING_SPEED = 0.5  # rad/s, below which Coulomb friction fades
SETTLING = 0.5, 500.0  # 1/s, between which the turning's own rate is looked for
NAMES = "inertia", "damping", "stronger", "braking", "friction"


@dataclass(frozen=True, eq=False)
class Heading:
    """What a loop's own log says of how the robot turns.

    ``values``: inertia, a_d / e, and damping, f / e, in V per rad/s^2 and rad/s;
    stronger and braking, the shares by which the right motor's e and f are above the
    mean; friction in V; ``sd``: their standard deviations; ``residuals``, (N,): what
    the wheels' difference was beyond the simulation, in rad.
    """

    values: dict
    sd: dict
    residuals: np.ndarray

    def interval(self, name, sds=1.96):
        """The ends of the interval of the parameter ``name``, so many ``sds`` away."""
        half = sds * self.sd[name]
        return self.values[name] - half, self.values[name] + half


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
    values, residuals = _fitted(delta, signals, T, stretches)
    blocks = [
        _fitted(delta, signals, T, stretches[k::BLOCKS])[0] for k in range(BLOCKS)
    ]
    apart = np.std(blocks, axis=0, ddof=1) / BLOCKS**0.5
    sd = np.hypot(apart, MODEL_ERROR * np.array([values[0], values[1], 1, 1, 0]))
    return Heading(
        dict(zip(NAMES, map(float, values))),
        dict(zip(NAMES, map(float, sd))),
        residuals,
    )


def _late(V, share):
    """The mean of V over each tick, if it acts a ``share`` of one later."""
    whole, part = divmod(share, 1.0)
    V = np.concatenate([np.full(int(whole) + 1, V[0]), V])
    return ((1 - part) * V[1:] + part * V[:-1])[: len(V) - int(whole) - 1]


def _fitted(delta, signals, T, stretches):
    """The values of `NAMES`, and what the best of them leave."""

    def solved(log_rate):
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

    fitted = minimize_scalar(
        lambda x: float(np.mean(solved(x)[1] ** 2)),
        bounds=np.log(SETTLING),
        method="bounded",
        options={"xatol": 1e-4},
    )
    gains, residuals = solved(fitted.x)
    inertia = 1 / gains[0] if gains[0] else np.inf
    damping = np.exp(fitted.x) * inertia
    stronger, mean, rub = gains[1:] * inertia
    return np.array(
        [inertia, damping, stronger / 2, mean / damping / 2, rub]
    ), residuals
