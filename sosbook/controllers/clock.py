"""The clock of a controller: its ticks, its delay, and how far they vary."""

import numpy as np

from ..loops.clock import Clock
from ..plants.checks import not_negative, positive
from ..runtime.saying import warn_outside
from ..sampled.timing import TimeBox

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
