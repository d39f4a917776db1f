"""Nonlinear pendulums under a sampled controller, with real sensors.

Many runs go side by side: every array has an axis for them, and Python
loops over ticks only.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np

from ..plants.checks import positive
from .drivetrain import Drivetrain
from .firmware import Firmware
from .fleet import Fleet, Push
from .model import V_MAX, Mip
from .play import Geared
from .sensors import Readings, Sensors

__all__ = ["Drivetrain", "Push", "Run", "Sensors", "simulate"]

SETTLED_TILT = np.deg2rad(3)  # rad; a robot that settled stays within


@dataclass(frozen=True, eq=False)
class Run:
    """The motion of the robots over k ticks.

    Parameters
    ----------
    t : (k,) array
        The times of the ticks, in s.
    x : (4, runs, k) array
        [theta; phi; theta'; phi'] at the ticks.
    V : (runs, k) array
        The voltage commanded at the ticks, after the limit.
    estimate : (runs, k) array
        theta as the controller has it; not a number if it doesn't say.
    fault : (runs, k) array of int
        The index in `FAULTS`; zero if the controller doesn't say.
    limit : float
        The largest voltage, in V.
    """

    t: np.ndarray
    x: np.ndarray
    V: np.ndarray
    estimate: np.ndarray
    fault: np.ndarray
    limit: float = V_MAX

    @property
    def fell(self):
        """(runs,) bool: lies on the ground or has its motors off."""
        lies = np.abs(self.x[0, :, -1]) >= np.pi / 2
        return lies | (self.fault[:, -1] > 0)

    @property
    def settled(self):
        """(runs,) bool: within 3 degrees in the run's last fifth."""
        late = self.x[0][:, 4 * len(self.t) // 5 :]
        return ~self.fell & (np.abs(late) < SETTLED_TILT).all(axis=1)

    @property
    def peak_voltage(self):
        """(runs,) array, in V."""
        return np.abs(self.V).max(axis=1)

    @property
    def full(self):
        """(runs,) array: share of the ticks with V at its limit."""
        return (np.abs(self.V) > 0.999999 * self.limit).mean(axis=1)


def simulate(
    robots,
    controller,
    tilt,
    t_end,
    delay=0.0,
    sensors=Sensors(),
    seed=0,
    substeps=10,
    push=None,
    target=None,
    start=(0, 0, 0),
    drivetrain=Drivetrain(),
):
    """Let robots go at a tilt and run their controller.

    At t = k T the sensors are read; the voltage that follows acts from
    k T + delay on and is held until the next one acts.

    ``robots``: one `Mip` for all runs, or one for each; ``controller``: a `Firmware`,
    or any object with start(tilt, wheels, bias) and step(gyro, wheels, tilt, target,
    rate) as `Controller` has them, and its ``firmware`` or its own ``T``, in s;
    ``tilt``, float or (runs,): theta at the start, in rad; ``t_end``: how long the run
    lasts, in s; ``delay``, float or (k,): the time from the reading to the voltage, in
    s; or one for each tick. A voltage that is overtaken by a later one never acts;
    ``sensors``: what the controller is told of the state; ``seed``: run i draws its
    noise from ``default_rng(seed + i)``, whatever runs beside it; ``substeps``:
    Runge-Kutta steps per tick, at least; ``push``: a disturbance; none without it;
    ``target``, float, (runs,) or callable: set point of phi since the start, in rad; or
    a function of t that gives [target, rate]; ``start``, (3,) or (3, runs): [phi;
    theta'; phi'] at the start; ``drivetrain``: the gears and the battery. Returns
    `Run`: a robot that tips by 90 degrees stays on the ground from then on. Raises
    ValueError on sizes that don't match, numbers out of range, or a controller whose
    voltage isn't finite.

    Source: thesis (4.13), without small angles.

    >>> from sosbook.book import thesis
    >>> from sosbook.pendulum import Mip, SampledLaw
    >>> law = SampledLaw.of_gain(thesis.mip().gains["PD"][5], 0.01)
    >>> run = simulate(Mip.printed(), Firmware(law), [0.1, 1.2], 1.0)
    >>> run.fell
    array([False,  True])
    """
    fleet, tilt, runs = _line_up(robots, tilt, sensors)
    fleet.friction = drivetrain.friction
    if drivetrain.backlash:
        fleet = Geared(fleet.robots, drivetrain.backlash, drivetrain.friction, runs)
    if isinstance(controller, Firmware):
        controller = controller.controller(runs)
    T, limit = _pace(controller, runs)
    count = round(positive("t_end", t_end) / T) + 1
    delay = _delays(delay, count)
    if not isinstance(substeps, int) or substeps < 1:
        raise ValueError(f"substeps must be 1 or more, got {substeps!r}")
    x = np.zeros((4, runs))
    x[0], x[1:] = tilt, np.reshape(np.asarray(start, float), (3, -1))
    readings = Readings(sensors, runs, count, seed)
    controller.start(
        readings.first_tilt(tilt), readings.wheels(fleet.seen(x)), readings.bias()
    )

    path, V = np.empty((4, runs, count)), np.empty((runs, count))
    estimate, fault = np.empty((runs, count)), np.zeros((runs, count), int)
    hold, unknown = _Hold(np.zeros(runs), T), np.full(runs, np.nan)
    edges = [] if push is None else [push.at, push.at + push.length]
    for k in range(count):
        now, then = k * T, (k + 1) * T
        seen = [readings.gyro(x, k), readings.wheels(fleet.seen(x)), unknown]
        if sensors.accelerometer is not None:
            ddz = fleet.acceleration(x, hold.V, _torques(push, now))
            seen[2] = readings.tilt(x, ddz, k)
        if sensors.dropouts is not None:
            missed = np.broadcast_to(readings.missed(k), runs)
            seen = [np.where(missed, np.nan, reading) for reading in seen]
        u = controller.step(*seen, *_wanted(target, now))
        if not np.isfinite(u).all():
            raise ValueError(
                f"controller gave {u} V at tick {k}: every voltage must be finite"
            )
        path[..., k], V[:, k] = x, u
        estimate[:, k] = getattr(controller, "theta", np.nan)
        fault[:, k] = getattr(controller, "fault", 0)

        hold.send(now + delay[k], drivetrain.gives(V[:, k], now))
        for stop in hold.stops(now, then, edges):
            hold.reach(now)
            torques = _torques(push, (now + stop) / 2)
            steps = max(1, ceil(substeps * (stop - now) / T - 1e-6))
            x = fleet.advance(x, hold.V, torques, stop - now, steps)
            now = stop
    return Run(np.arange(count) * T, path, V, estimate, fault, limit)


class _Hold:
    """The voltage that acts, and those under way."""

    def __init__(self, V, T):
        self.V, self.tiny, self.coming = V, 1e-9 * T, []

    def send(self, when, V):
        """Let V act from a time on; voltages that it overtakes never do."""
        self.coming = [command for command in self.coming if command[0] < when]
        self.coming.append((when, V))

    def stops(self, now, then, edges):
        """Times at which something changes, up to then."""
        times = sorted([when for when, _ in self.coming] + edges)
        changes, last = [], now
        for time in times:
            if last + self.tiny < time < then - self.tiny:
                changes.append(time)
                last = time
        return [*changes, then]

    def reach(self, now):
        """Let the voltage act that is due."""
        while self.coming and self.coming[0][0] <= now + self.tiny:
            self.V = self.coming.pop(0)[1]


def listed(robots):
    """A list of Mips, of one or of many."""
    robots = [robots] if isinstance(robots, Mip) else list(robots)
    if not robots or not all(isinstance(r, Mip) for r in robots):
        raise ValueError(
            "robots must be a Mip or a sequence of them, got "
            f"{', '.join(type(r).__name__ for r in robots) or 'an empty one'}"
        )
    return robots


def _line_up(robots, tilt, sensors):
    """The fleet, the tilt of each run and their number."""
    robots, tilt = listed(robots), np.asarray(tilt, float)
    sizes = {"robots": len(robots), "tilt": tilt.size}
    sizes |= {x: getattr(sensors, x).size for x in ("offset", "tilt_error")}
    runs = max(sizes.values())
    for name, entries in sizes.items():
        if entries not in (1, runs):
            raise ValueError(
                f"{name} has {entries} entries for {runs} runs: "
                "give one, or one for each"
            )
    if not (np.abs(tilt) <= np.pi / 2).all():
        raise ValueError(
            "tilt must lie within a quarter turn of upright, in rad: np.radians takes "
            f"degrees; got up to {np.abs(tilt).max():g}"
        )
    tilt = np.broadcast_to(tilt.ravel(), runs)
    return Fleet(robots), tilt, runs


def _pace(controller, runs):
    """The T of a controller for so many runs, and the limit of its voltage."""
    if getattr(controller, "runs", runs) != runs:
        raise ValueError(
            f"controller is for {controller.runs} runs, but there are {runs}"
        )
    firmware = getattr(controller, "firmware", None)
    if firmware is not None:
        return firmware.law.T, firmware.limit
    if not hasattr(controller, "T"):
        raise ValueError("controller must have a firmware or a T, in s")
    return positive("T", controller.T), getattr(controller, "limit", V_MAX)


def _delays(delay, count):
    late = np.asarray(delay, float)
    if late.size not in (1, count) or not (late >= 0).all():
        raise ValueError(
            "delay must be 0 or more, in s: one number, or one "
            f"for each of the {count} ticks"
        )
    return np.broadcast_to(late.ravel(), count)


def _torques(push, t):
    return (0.0, 0.0) if push is None else push.torques(t)


def _wanted(target, t):
    if callable(target):
        return target(t)
    return (0.0 if target is None else np.asarray(target, float)), 0.0
