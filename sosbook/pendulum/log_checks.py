"""The checks of one log before any fit."""

from dataclasses import dataclass
from itertools import groupby

import numpy as np

from .counters import Counter

__all__ = ["Finding", "Subject", "check_log", "refused"]

SPIKE_STEPS = 12.0  # times the usual step away from both neighbours
CLIPPED_SAMPLES = 4  # samples in a row at the very largest value
WRAP_SHARE = 2 / 3  # of the gyro's whole span: a jump beyond it goes over the end
FROZEN_SHARE = 0.1  # of a log, in which a gyro that lives doesn't say the same
SAMPLES_AT_REST = 10  # at the beginning of a log
#: Of V's standard deviation: so far half of all samples lie from what four on either
#: side tell. Of sweeps at most 0.024, with noise; of robots that balance mostly 0.1.
ERRATIC, EITHER_SIDE = 0.03, 4
FASTEST_RATE = 60.0  # rad/s, 573 rpm at the wheel or 3400 deg/s of a body
PLAUSIBLE_VOLTS = 0.2, 60.0  # of a plausible chirp
PLAUSIBLE_T = 1e-3, 0.1  # s, between two samples


@dataclass(frozen=True)
class Finding:
    """Something about the logs that a working robot doesn't do.

    ``severity``, {"refused", "warning"}: whether it forbids a program; ``subject``: the
    log or the fit; ``text``: what is wrong, and what it may come from.
    """

    severity: str
    subject: str
    text: str

    def __str__(self):
        return f"{self.subject}: {self.text}"


class Subject(str):
    """A log or a fit by its name, about which there are findings."""

    def refused(self, text):
        """A `Finding` that forbids a program; the ``text`` says why."""
        return Finding("refused", str(self), text)

    def warned(self, text):
        """A `Finding` that forbids nothing; the ``text`` says what."""
        return Finding("warning", str(self), text)


def refused(findings):
    """The findings that forbid a program, unless it is forced."""
    return [f for f in findings if f.severity == "refused"]


def check_log(name, log, robot=None):
    """Look at one log before any fit.

    ``name``, {"body", "wheels"}: the experiment; ``log``: its log; ``robot``: its
    counts and its gyro's range. Returns list of Finding: what speaks against the log;
    empty if nothing does.
    """
    if name not in ("body", "wheels"):
        raise ValueError(f"name must be 'body' or 'wheels', got {name!r}")
    subject = Subject(f"log of the {name}")
    findings = [*_whole(subject, log, robot)]
    if name == "body":
        return findings + [*_gyro(subject, log, *log.need("gyro"), robot)]
    both = ("encoder1", "encoder2")[: 1 + (log.encoder2 is not None)]
    for column in both:
        findings += _encoder(subject, log, column, *log.need(column), robot)
    return findings


def _whole(subject, log, robot):
    """Findings on a log's time and voltage."""
    low, high = PLAUSIBLE_T
    if not low <= log.T <= high:
        yield subject.refused(
            f"samples are {log.T:g} s apart, which is no robot's "
            "clock: t must be in seconds (not in ms)"
        )
    for column, lost in log.filled.items():
        yield subject.warned(
            f"{column} says nothing in {lost} sample(s), which lines fill: look at its "
            "bus"
        )
    top = abs(log.V).max()
    if not PLAUSIBLE_VOLTS[0] <= top <= PLAUSIBLE_VOLTS[1]:
        yield subject.refused(
            f"V reaches {top:g}: it must be in volts, not a duty or mV"
        )
    elif robot and top > 1.05 * robot.limit:
        yield subject.refused(
            f"V reaches {top:g} V, but limit = {robot.limit:g} V: "
            "are V and the description about the same motors?"
        )
    if abs(log.V[:SAMPLES_AT_REST]).max() == 0 and len(set(log.V)) < 5:
        yield subject.refused("V hardly changes: it needs a chirp")
    if _erratic(log.V) > ERRATIC:
        yield subject.refused(
            "V jumps from sample to sample, as a controller's does: does the robot "
            "balance? It must hang or lie, its wheels off the ground, under a sweep to "
            "which no sensor adds"
        )


def _erratic(V):
    """How far V's samples lie from what their neighbours tell, in the median, over its
    standard deviation.
    """
    k, near = np.arange(EITHER_SIDE, len(V) - EITHER_SIDE), range(1, EITHER_SIDE + 1)
    beside = np.array([V[k + i * side] for i in near for side in (1, -1)]).T
    if len(k) < 3 * beside.shape[1] or np.ptp(V) == 0:
        return 0.0
    told = beside @ np.linalg.lstsq(beside, V[k], rcond=None)[0]
    return float(np.median(abs(V[k] - told)) / np.std(V))


def _gyro(subject, log, y, robot):
    """Findings on a gyro's column y."""
    if (y == np.round(y)).all() and np.ptp(y) > 10:
        yield subject.refused(
            "gyro has whole numbers: is it raw, or an encoder's column? It must be in "
            "rad/s"
        )
    still = np.flatnonzero(np.diff(y))
    longest = np.diff(np.concatenate([[0], still + 1, [len(y)]])).max()
    if longest > max(FROZEN_SHARE * len(y), CLIPPED_SAMPLES):
        yield subject.refused(
            f"gyro says the same for {longest} samples: it is frozen, or the body is "
            "blocked. Look at its wires and record it anew"
        )
        return
    yield from _fast(subject, "gyro", y, "is it in deg/s? It must be in rad/s")
    top = abs(y).max()
    for end in (y.max(), y.min()):
        longest = max(len([*run]) for at, run in groupby(y == end) if at)
        if longest >= CLIPPED_SAMPLES and abs(end) > 0.5 * top and top > 0:
            yield subject.refused(
                f"gyro stays at {end:.4g} rad/s for {longest} samples: it is clipped. "
                "Widen its range or lower V"
            )
            break
    else:
        if robot and top > 0.98 * robot.gyro_range:
            beyond = top > 1.01 * robot.gyro_range
            words = "more than" if beyond else "it is clipped at"
            yield subject.refused(
                f"gyro reads {top:.3g} rad/s: {words} gyro_range = "
                f"{robot.gyro_range:g} rad/s{'. Is it in deg/s?' * bool(beyond)}"
            )
    spikes, jumps = _spikes(y)
    if len(jumps) and _goes_over(y, jumps):
        before, after = y[jumps[0]], y[jumps[0] + 1]
        yield subject.refused(
            f"gyro jumps from {before:.4g} to {after:.4g} rad/s, the first time in "
            f"{_row(log, jumps[0] + 1)}: the body turns faster than its number can "
            "say, which goes on at the other end. Widen the gyro's range or lower V"
        )
    else:
        yield from _glitches(subject, log, "gyro", spikes)


def _encoder(subject, log, column, y, robot):
    """Findings on an encoder's ``column`` y."""
    counter = log.unwrapped.get(column)
    if counter is not None:
        yield subject.warned(
            f"{column} is of a counter of {counter.bits} bits, which goes over its end "
            f"{len(counter.wraps)} time(s), first in {_row(log, counter.wraps[0])}: "
            "it is read as one that goes on"
        )
    elif (counter := Counter.of(y)) is not None:  # it isn't known how far it went
        if counter.too_fast:
            yield subject.refused(
                f"{column} seems to be of a counter of {counter.bits} bits, which goes "
                f"over its end {len(counter.wraps)} times, first in "
                f"{_row(log, counter.wraps[0])}, and by too much between two samples "
                "to say how far: read it more often, count in more bits, or lower V"
            )
        else:
            apart = np.diff(counter.wild, prepend=-2) > 1
            yield from _glitches(subject, log, column, counter.wild[apart])
        return
    if (y != np.round(y)).any():
        yield subject.refused(
            f"{column} has fractions: it must be in counts, not in rad or degrees, "
            "and no gyro's column"
        )
    if np.ptp(y) == 0:
        yield subject.refused(
            f"{column} says the same all the time: is the motor or the encoder dead, "
            "or V too small to turn the wheel?"
        )
        return
    turn = 2 * np.pi / (robot.counts if robot else 2000.0)
    rate = np.diff(y) * turn / np.diff(log.t)
    yield from _fast(subject, column, rate, "are the counts per turn right?")
    yield from _glitches(subject, log, column, _spikes(y, 1.0)[0])


def _fast(subject, column, rate, question):
    """Ask a ``question`` about a ``column`` whose ``rate`` no such robot has."""
    fast = np.quantile(abs(rate), 0.98)
    if fast > FASTEST_RATE:
        yield subject.refused(
            f"{column} means {fast:.3g} rad/s, faster than such robots are: {question}"
        )


def _spikes(y, least=1e-12):
    """The samples that stand alone, and those before the larger jumps beside them.

    A step of ``least`` is usual.
    """
    step = np.diff(y)
    usual = max(np.quantile(abs(np.diff(step)), 0.9), least)
    alone = (abs(np.diff(step)) > SPIKE_STEPS * usual) & (step[1:] * step[:-1] < 0)
    places = np.flatnonzero(alone)
    later = abs(step[places]) <= abs(step[places + 1])
    return places + 1, places + later


def _glitches(subject, log, column, spikes):
    """Findings on so many ``spikes``."""
    if len(spikes):
        yield subject.refused(
            f"{column} has {len(spikes)} spike(s), the first in "
            f"{_row(log, spikes[0])}: a glitch of the bus? Cut the log there or record "
            "it anew"
        )


def _row(log, sample):
    """A sample's row in the file, and its time, in words."""
    return f"row {sample + 2} (t = {log.t[sample]:g} s)"


def _goes_over(y, jumps):
    """True if each jump, after a sample, is from near one end to near the other."""
    low, high = y.min(), y.max()
    before, after = y[jumps], y[jumps + 1]
    down = (before > high / 2) & (after < low / 2)
    up = (before < low / 2) & (after > high / 2)
    far = abs(after - before) > WRAP_SHARE * (high - low)
    return low < 0 < high and bool((far & (down | up)).all())
