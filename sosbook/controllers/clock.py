"""The clock of a controller: its ticks, its delay, and how far they vary."""

from dataclasses import replace

import numpy as np

from ..loops.clock import Clock
from ..plants.checks import not_negative, positive
from ..runtime.saying import warn_outside
from ..sampled.discretize import SampleTiming, input_vertices
from ..sampled.timing import TimeBox
from ..synthesis.request import Request

ROUNDING = 1e-9  # of a slack
SAMPLES = 10  # in the time in which the loop's slowest pole moves by one


def checked_delay(T, delay):
    """T and delay, or a ValueError."""
    return positive("T", T), not_negative("delay", delay, "s")


def checked_clock(T, delay, jitter):
    """The `Clock` of these ticks; ``delay``: a number or (low, high), ``jitter`` of T.

    >>> checked_clock(0.1, (0, 0.05), 0.02).ranges
    ((0.08, 0.12), (0.0, 0.05))
    """
    ends = delay if isinstance(delay, (tuple, list)) else (delay, delay)
    if len(ends) != 2 or not ends[0] <= ends[1]:
        raise ValueError(f"delay must be a number or (low, high), got {delay!r}")
    (T, early), (_, late) = (checked_delay(T, x) for x in ends)
    off = not_negative("jitter", jitter, "s")
    if off >= T:
        raise ValueError(f"jitter = {off:g} s must be below T = {T:g} s")
    clock = Clock(T, (early, late) if early < late else late, off)
    if clock.varies:
        TimeBox.of(*clock.ranges)  # raises where a delay outlasts its interval
    return clock


def is_stepped(plant):
    """True of a ``plant`` of discrete time."""
    return getattr(plant, "dt", None) is not None


def timing_of(plant, T, delay):
    """The `SampleTiming` of a ``plant`` every T s, ``delay`` s late."""
    return replace(SampleTiming.of(T, delay), steps=is_stepped(plant))


def vertices_of(plant):
    """The ``plant``'s vertices, a `Descriptor` each; of discrete time its change's."""
    return Request(plant).vertices if is_stepped(plant) else input_vertices(plant, None)


def clock_of(plant, T, delay, jitter):
    """The `Clock` of a ``plant``'s program: that of `checked_clock` for a ``T``, a
    ``delay`` and a ``jitter``, or the plant's own ticks where it is of discrete time.
    """
    if not is_stepped(plant):
        if T is None:
            raise ValueError("T is missing: give the time between samples, in s")
        return checked_clock(T, delay, jitter)
    for name, value, own in (
        ("T", T, plant.dt),
        ("delay", delay, 0.0),
        ("jitter", jitter, 0.0),
    ):
        if value is not None and value != own:
            raise ValueError(
                f"{name} = {value!r}: the plant is one of discrete time, known at its "
                f"ticks of {plant.dt:g} s alone, where u(k) of what is measured at k "
                f"acts until k + 1: leave {name} out, and put an input that comes "
                "later into the plant's states"
            )
    return Clock(plant.dt)


def least_slack(clock):
    """The share of T by which ticks of a proven ``clock`` come early or late."""
    if not clock.varies:
        return 0.0
    early, late = clock.ranges[0]
    return max(clock.T - early, late - clock.T) / clock.T * (1 + ROUNDING)


def checked_slack(slack, clock):
    """The ``slack`` of a watch of ticks, in which all of a proven ``clock`` are."""
    least = least_slack(clock)
    if slack < least * (1 - 2 * ROUNDING):
        raise ValueError(
            f"slack = {slack:g} is below {least:.6g}: ticks that come "
            f"{least * clock.T:.6g} s early or late are proven, and would be faults. "
            "Leave slack out, or make the controller with less jitter"
        )
    return max(slack, least)


def warn_of_long_ticks(design, T):
    """Warn where even the slowest motion of a ``design``'s loop is over in a tick T."""
    slowest = abs(np.atleast_2d(design.poles())).min(axis=1).max()
    if slowest * T > 1:
        warn_outside(
            f"T = {T:g} s: the loop is sampled {1 / T:.3g} times a second, but even "
            f"its slowest pole in continuous time, {slowest:.3g} rad/s, needs some "
            f"{SAMPLES * slowest:.3g} samples a second; T is in seconds"
        )
