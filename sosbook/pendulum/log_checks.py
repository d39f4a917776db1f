"""What can be seen in one log before any fit."""

import numpy as np

from .counters import Counter
from .finding import Finding

__all__ = ["check_log"]

SPIKE_STEPS = 12.0  # times the usual step away from both neighbours
CLIPPED_SAMPLES = 4  # samples in a row at the very largest value
WRAP_SHARE = 2 / 3  # of the gyro's whole span: a jump beyond it goes over the end
SAMPLES_AT_REST = 10  # at the beginning of a log
FASTEST_RATE = 60.0  # rad/s, 573 rpm at the wheel or 3400 deg/s of a body
PLAUSIBLE_VOLTS = 0.2, 60.0  # of a plausible chirp
PLAUSIBLE_T = 1e-3, 0.1  # s, between two samples


def check_log(name, log, robot=None):
    """Look at one log before any fit.

    Parameters
    ----------
    name : {"body", "wheels"}
    log : Log
        The log of that experiment.
    robot : Robot, optional
        Its counts and its gyro's range.

    Returns
    -------
    list of Finding
        What speaks against the log; empty if nothing does.
    """
    if name not in ("body", "wheels"):
        raise ValueError(f"name must be 'body' or 'wheels', got {name!r}")
    findings, subject = [], f"log of the {name}"

    def say(severity, text):
        findings.append(Finding(severity, subject, text))

    low, high = PLAUSIBLE_T
    if not low <= log.T <= high:
        say(
            "refused",
            f"samples are {log.T:g} s apart, which is no robot's "
            "clock: t must be in seconds (not in ms)",
        )
    top = abs(log.V).max()
    if not PLAUSIBLE_VOLTS[0] <= top <= PLAUSIBLE_VOLTS[1]:
        say("refused", f"V reaches {top:g}: it must be in volts, not a duty or mV")
    elif robot and top > 1.05 * robot.limit:
        say(
            "refused",
            f"V reaches {top:g} V, but limit = {robot.limit:g} V: "
            "are V and the description about the same motors?",
        )
    if abs(log.V[:SAMPLES_AT_REST]).max() == 0 and len(set(log.V)) < 5:
        say("refused", "V hardly changes: it needs a chirp")
    columns = (
        ["gyro"]
        if name == "body"
        else [x for x in ("encoder1", "encoder2") if getattr(log, x) is not None]
    )
    for column in columns:
        _check_column(say, log, column, *log.need(column), robot)
    return findings


def _check_column(say, log, column, y, robot):
    """One sensor's column; ``say`` takes a severity and a text."""
    whole = bool((y == np.round(y)).all())
    if column == "gyro":
        rate = y
        if whole and np.ptp(y) > 10:
            say(
                "refused",
                "gyro has whole numbers: is it raw, or an "
                "encoder's column? It must be in rad/s",
            )
    elif _check_counter(say, log, column, y):
        return
    else:
        turn = 2 * np.pi / (robot.counts if robot else 2000.0)
        rate = np.diff(y) * turn / np.diff(log.t)
        if not whole:
            say(
                "refused",
                f"{column} has fractions: it must be in counts, "
                "not in rad or degrees, and no gyro's column",
            )
    fast = np.quantile(abs(rate), 0.98)
    if fast > FASTEST_RATE:
        say(
            "refused",
            f"{column} means {fast:.3g} rad/s, faster than such "
            "robots are: "
            + (
                "is it in deg/s? It must be in rad/s"
                if column == "gyro"
                else "are the counts per turn right?"
            ),
        )
    if column == "gyro":
        _check_gyro(say, y, robot)
    step = np.diff(y)
    usual = np.quantile(abs(np.diff(step)), 0.9) + 1e-12
    alone = (abs(np.diff(step)) > SPIKE_STEPS * usual) & (step[1:] * step[:-1] < 0)
    if not alone.any():
        return
    places = np.flatnonzero(alone)
    jumps = np.where(abs(step[places]) > abs(step[places + 1]), places, places + 1)
    if column == "gyro" and _goes_over(y, jumps):
        before, after = y[jumps[0]], y[jumps[0] + 1]
        say(
            "refused",
            f"gyro jumps from {before:.4g} to {after:.4g} rad/s, the first time in "
            f"{_row(log, jumps[0] + 1)}: the body turns faster than its number can "
            "say, which goes on at the other end. Widen the gyro's range or lower V",
        )
        return
    _say_spikes(say, log, column, len(places), places[0] + 1)


def _say_spikes(say, log, column, count, first):
    say(
        "refused",
        f"{column} has {count} spike(s), the first in {_row(log, first)}: a glitch of "
        "the bus? Cut the log there or record it anew",
    )


def _row(log, sample):
    """A sample's row in the file, and its time, in words."""
    return f"row {sample + 2} (t = {log.t[sample]:g} s)"


def _goes_over(y, jumps):
    """Whether each jump, after a sample, is from near one end to near the other."""
    low, high = y.min(), y.max()
    before, after = y[jumps], y[jumps + 1]
    down = (before > high / 2) & (after < low / 2)
    up = (before < low / 2) & (after > high / 2)
    far = abs(after - before) > WRAP_SHARE * (high - low)
    return low < 0 < high and bool((far & (down | up)).all())


def _check_counter(say, log, column, y):
    """Say what is known of a counter's end; whether it isn't known how far it went."""
    counter = log.unwrapped.get(column)
    if counter is not None:
        say(
            "warning",
            f"{column} is of a counter of {counter.bits} bits, which goes over its end "
            f"{len(counter.wraps)} time(s), first in {_row(log, counter.wraps[0])}: "
            "it is read as one that goes on",
        )
        return False
    counter = Counter.of(y)
    if counter is None:
        return False
    if not counter.too_fast:
        apart = 1 + np.count_nonzero(np.diff(counter.wild) > 1)
        _say_spikes(say, log, column, apart, counter.wild[0])
    else:
        say(
            "refused",
            f"{column} seems to be of a counter of {counter.bits} bits, which goes "
            f"over its end {len(counter.wraps)} times, first in "
            f"{_row(log, counter.wraps[0])}, and by too much between two samples to "
            "say how far: read it more often, count in more bits, or lower V",
        )
    return True


def _check_gyro(say, y, robot):
    top = max(abs(y.max()), abs(y.min()))
    for end in (y.max(), y.min()):
        runs, longest = 0, 0
        for at in y == end:
            runs = runs + 1 if at else 0
            longest = max(longest, runs)
        if longest >= CLIPPED_SAMPLES and abs(end) > 0.5 * top and top > 0:
            say(
                "refused",
                f"gyro stays at {end:.4g} rad/s for {longest} "
                "samples: it is clipped. Widen its range or lower V",
            )
            return
    if robot and top > 1.01 * robot.gyro_range:
        say(
            "refused",
            f"gyro reads {top:.3g} rad/s, more than gyro_range = "
            f"{robot.gyro_range:g} rad/s",
        )
    elif robot and top > 0.98 * robot.gyro_range:
        say(
            "refused",
            f"gyro reads {top:.3g} rad/s: it is clipped at "
            f"gyro_range = {robot.gyro_range:g} rad/s",
        )
