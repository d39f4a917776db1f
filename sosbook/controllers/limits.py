"""Limits of a controller's output, and the faults that stop it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..plants.checks import not_negative, positive
from .bounds import settled

#: Why the output is off, by number; 0 is no fault.
FAULTS = ("running", "sensor", "clock", "stall", "command", "silent")
COARSE = 0.5  # of the limit, that steps of the sensors may ask by themselves
MOST_TICKS = 32766  # the least that C promises of an int, 32767, less one

#: A turn in each unit of an angle.
TURNS = dict.fromkeys(("", "rad"), 2 * np.pi) | {"mrad": 2000 * np.pi}
TURNS |= dict.fromkeys(("deg", "degree", "degrees", "\N{DEGREE SIGN}"), 360.0)


def per_signal(name, value, signals):
    """A number for each of the ``signals``, of a ``value`` or dict called ``name``."""
    if value is None:
        return np.full(len(signals), np.inf)
    if not isinstance(value, dict):
        return np.full(len(signals), positive(name, value))
    known = [s.name for s in signals]
    if strange := [x for x in value if x not in known]:
        raise ValueError(f"{name} names {strange[0]!r}, which is none of {known}")
    return np.array(
        [positive(f"{name}[{x!r}]", value[x]) if x in value else np.inf for x in known]
    )


def quantum(counts, signals):
    """How fine each of some ``signals`` is measured, from its ``counts``: so many a
    turn of an angle, in rad without a unit, and a unit of others; zero: unknown.

    >>> from sosbook.controllers.signals import Signal
    >>> signals = [Signal("a"), Signal("b"), Signal("c", "deg"), Signal("d", "m")]
    >>> quantum({"a": 4, "c": 4, "d": 4}, signals).round(3)
    array([ 1.571,  0.   , 90.   ,  0.25 ])
    """
    given = per_signal("counts", counts, signals)
    turns = [TURNS.get(s.unit.partition("/")[0].strip(), 1.0) for s in signals]
    return np.where(np.isfinite(given), turns / given, 0.0)


@dataclass(frozen=True, eq=False)
class Limits:
    """Bounds of the output and of the set point.

    Parameters
    ----------
    u_max : (m,) array
        Of each output, either way; infinite without a limit.
    slew : (m,) array
        By how much each may change in a second; infinite without.
    ramp : (p,) array
        How fast each set point is followed, per second; infinite without.
    tracking_time : float or None
        In s: while the output is at its limit the integral follows what is withheld
        with this time constant. None: it knows nothing of the limit.
    profile : Profile or None
        Of the moves of the first set point that the program's <name>_move.h makes.
    """

    u_max: np.ndarray
    slew: np.ndarray
    ramp: np.ndarray
    tracking_time: float | None = None
    profile: Any = None


@dataclass(frozen=True)
class Faults:
    """When a controller gives up; all times in seconds.

    Parameters
    ----------
    lost : float
        For so long samples that are missing or unbelievable are bridged.
    late : float
        For so long ticks may come late in a row.
    slack : float
        By which share of T a tick may be early or late and isn't counted.
    stall : float
        For so long the output may be at its limit.
    silence : float
        For so long the set point may be missing; with zero it isn't watched.
    fastest : float or dict, optional
        The fastest that what is measured moves, per second, one number or by name:
        a sample that is further from the last one isn't believed.

    Examples
    --------
    >>> Faults(lost=0.005).ticks(0.001)["lost"]
    5
    """

    lost: float = 0.005
    late: float = 0.01
    slack: float = 0.1
    stall: float = 3.0
    silence: float = 0.0
    fastest: object = None

    def __post_init__(self):
        for name in ("lost", "late", "slack", "stall", "silence"):
            not_negative(name, getattr(self, name), "s")

    def ticks(self, T):
        """The times as numbers of ticks of T seconds."""
        found = {}
        for name in ("lost", "late", "stall", "silence"):
            found[name] = count = round(getattr(self, name) / T)
            if count > MOST_TICKS:
                raise ValueError(
                    f"{name} = {getattr(self, name):g} s is {count} ticks, more than "
                    f"C's int must hold: watch({name}=...), at most {MOST_TICKS * T:g}"
                )
        return found


def limits_of(c, u_max, slew, load, anti_windup, tracking_time):
    """The `Limits` of a controller c; ``u_max``, ``slew``, ``load``, ``anti_windup``,
    ``tracking_time``: see `Controller.limit`.
    """
    u_max = per_signal("u_max", u_max, c.outputs)
    if load is not None:
        need = abs(c.static(w=load)[1]).max(axis=0)
        for k, signal in enumerate(c.outputs):
            if need[k] >= u_max[k]:
                raise ValueError(
                    f"u_max = {u_max[k]:g} is below the static need: {signal} "
                    f"must be {need[k]:.6g} to hold the load {load!r}"
                )
    _not_too_coarse(c, u_max)
    if not (anti_windup and (c.gains[1].size or c.estimate.winds_up)):
        tracking_time = None
    elif tracking_time is None:
        slowest = -c.T / np.log(min(c.radius, 1 - 1e-12))
        tracking_time = float(f"{np.sqrt(c.T * slowest):.3g}")
    elif positive("tracking_time", tracking_time) < c.T:
        raise ValueError(
            f"tracking_time = {tracking_time:g} s is below T = {c.T:g} s: the integral "
            "would overshoot what is withheld"
        )
    slew = per_signal("slew", slew, c.outputs)
    held = c.limits.ramp, tracking_time, c.limits.profile
    return Limits(u_max, slew, *held)


def _not_too_coarse(c, u_max):
    """Raise where the steps of the sensors may ask half of the limit."""
    asked = np.zeros(len(u_max))
    for loop in c.loops:
        if loop.radius < 1 and c.readings.steps.any() and np.isfinite(u_max).any():
            h = abs(loop.impulses(loop.noise, loop.direct, settled(loop)))
            asked = np.maximum(asked, h.sum(axis=0) @ c.readings.steps / 2)
    for k, signal in enumerate(c.outputs):
        if asked[k] > COARSE * u_max[k]:
            one = abs(c.D[k]) @ c.readings.steps
            raise ValueError(
                "counts are too coarse for this law: their steps can move "
                f"{signal} by {asked[k]:.3g}, one alone by {one:.3g} a count, and "
                f"u_max is {u_max[k]:.3g}. Take more counts, a larger T, a quieter "
                "observer (peak) or a softer gain"
            )
