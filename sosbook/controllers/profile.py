"""Moves from rest to rest within velocity, acceleration and jerk, tick by tick.

A step of a set point that goes through three moving averages of n1, n2 and n3 ticks
moves by at most :math:`D/(n_1 T)` a second, and so on: its fourth difference is eight
impulses. So a move is four integer counters, which end exactly: nothing drifts. The
program <name>_move.h is `Profile.points`, operation by operation.

A set point that comes tick by tick, from a hand or another program, is followed within
the same limits: as a ramp, and then as the means of its last m2 and m3 ticks. A mean of
m ticks makes of a speed V an acceleration of at most 2 V / (m T), and so on. A stop
leaves the ramp where it is, so the motion comes to rest within the limits, too.

Source: L. Biagiotti and C. Melchiorri, Trajectory Planning for Automatic Machines and
Robots (2008), on moves by convolution.
"""

from dataclasses import dataclass
from itertools import product
from math import ceil
from typing import Any

import numpy as np

from ..exact.rational import exact
from ..plants.checks import finite, positive
from .follow import least
from .numbers import checked_words, literal
from .template import noted, read, renamed, written_by

MOST = 2**52  # of the counters, which floats then hold exactly
SHARES = np.linspace(0.02, 1, 50)  # of t1, that t2 and t3 are tried at
SIGNS = (1, -1, -1, -1, 1, 1, 1, -1)
HALVINGS = 60
TWO, THREE = (0.4, 0.55, 0.7, 0.85, 1.0), (0.0, 0.06, 0.12, 0.25, 0.5)  # t2/t1, t3/t2
FINEST, LONGEST = 2**20, 2**62  # counts of a set point in a tick; all counters
ROOM, FINE = (1.0, 1.003, 1.01, 1.03), 1e-3


@dataclass(frozen=True)
class Profile:
    """Moves of a set point within these limits, every ``T`` s.

    Parameters
    ----------
    velocity, acceleration, jerk : float
        Of the set point, per second, and so on.
    T : float
        Between ticks, in s.
    unit : str
        Of the set point.
    range : float, optional
        How far from zero it goes, where springs push back: what the outputs are bounded
        for. The program doesn't look after it.

    Raises
    ------
    ValueError
        If one isn't positive, or windows of so many ticks can't be counted.

    Examples
    --------
    >>> profile = Profile(2.0, 8.0, 64.0, 0.01)
    >>> r = profile.points(1.0)
    >>> float(r[0]), float(r[-1]), len(r) - 1 == profile.ticks(1.0)
    (0.0, 1.0, True)
    >>> bool(abs(np.diff(r)).max() / 0.01 < 2.0 + 1e-9)
    True
    """

    velocity: float
    acceleration: float
    jerk: float
    T: float
    unit: str = ""
    range: float | None = None

    def __post_init__(self):
        """Check the numbers."""
        for name in ("velocity", "acceleration", "jerk", "T"):
            positive(name, getattr(self, name))
        if self.range is not None:
            positive("range", self.range)
        self.windows(0.0)

    def windows(self, distance):
        """(n1, n2, n3) of a move over a ``distance``; n1 >= n2 + n3 and n2 >= n3.

        Then velocity, acceleration and jerk are at most D/(n1 T), D/(n1 n2 T^2) and
        D/(n1 n2 n3 T^3), for no two of the averages' flanks meet.
        """
        D, T = abs(exact(finite("distance", distance))), exact(self.T)
        V, A, J = map(exact, (self.velocity, self.acceleration, self.jerk))
        n3 = int((A / (J * T)).ceil())
        n2 = max(int((V / (A * T)).ceil()), n3)
        n1 = max(int((D / (V * T)).ceil()), n2 + n3)
        if n1 * n2 * n3 > MOST:
            raise ValueError(
                f"distance = {float(D):g} would take windows of {n1}, {n2} and {n3} "
                "ticks, which floats can't count: take a larger jerk or a longer T"
            )
        return n1, n2, n3

    def ticks(self, distance):
        """After how many ticks a move over a ``distance`` has ended."""
        return sum(self.windows(distance)) - 2

    def duration(self, distance):
        """Seconds of a move over a ``distance``."""
        return self.ticks(distance) * self.T

    def points(self, distance, start=0.0):
        """(ticks + 1,) set points of a move over a ``distance`` from a ``start``."""
        n1, n2, n3 = self.windows(distance)
        at = (0, n1, n2, n3, n1 + n2, n1 + n3, n2 + n3, n1 + n2 + n3)
        count, whole = self.ticks(distance), n1 * n2 * n3
        jumps = np.zeros(sum(at[1:4]) + 1, np.int64)
        np.add.at(jumps, np.array(at), np.array(SIGNS))
        place = jumps
        for _ in range(4):
            place = np.cumsum(place)
        place = place[:count]
        end = start + distance
        found = start + (end - start) * (place / whole)
        return np.concatenate([[start], np.where(place == whole, end, found)])

    @property
    def means(self):
        """(m2, m3): over how many ticks the ramp that follows is averaged, twice."""
        T, V, A, J = map(exact, (self.T, self.velocity, self.acceleration, self.jerk))
        return tuple(max(int((2 * x).ceil()), 1) for x in (V / (A * T), A / (J * T)))

    def follow(self, goals: Any, start: float = 0.0) -> np.ndarray:
        """The set points that follow some ``goals``, one each tick, from a ``start`` at
        rest; as axis_follow_next makes them. A goal that is no number, or is too far
        to be counted, changes nothing: the last one stays.

        >>> r = Profile(2.0, 8.0, 64.0, 0.01).follow([1.0] * 200)
        >>> float(r[-1]), bool(np.diff(r).max() / 0.01 < 2.0 + 1e-9)
        (1.0, True)
        """
        unit, whole = float(exact(self.velocity) * exact(self.T) / FINEST), 1
        to, goal, found = float(start), _counts(start / unit), []
        ramp, last = goal, []
        for m in self.means:
            last.append([goal * whole] * m)
            whole *= m
        sums = [sum(x) for x in last]
        for k, r in enumerate(np.asarray(goals, float).tolist()):
            if abs(r / unit) < float(LONGEST // whole):
                to, goal = r, _counts(r / unit)
            ramp += min(max(goal - ramp, -FINEST), FINEST)
            now = ramp
            for i, several in enumerate(last):
                at = k % len(several)
                sums[i] += now - several[at]
                several[at], now = now, sums[i]
            found.append(to if now == goal * whole else float(now) / whole * unit)
        return np.array(found)

    def to_c(self, name: str = "axis", precision: str = "double") -> str:
        """The text of <name>_move.h, C99: `points`, one after the other.

        Parameters
        ----------
        name : str
            In front of each identifier.
        precision : {"double", "single"}
            Of the set points.
        """
        checked_words(name, precision)
        u = self.unit.replace("/", "_per_")
        u = "".join(x if x.isalnum() else "_" for x in u).upper()
        mark = f"_{u}" if u else ""
        real = {"double": "double", "single": "float"}[precision]
        n1, n2, n3 = self.windows(0.0)
        m2, m3 = self.means
        per_tick = exact(self.velocity) * exact(self.T)
        numbers = {
            f"VELOCITY{mark}_S": self.velocity,
            f"ACCELERATION{mark}_S2": self.acceleration,
            f"JERK{mark}_S3": self.jerk,
            "MOVE_REAL": real,
            "MOVE_TICK": float(self.T),
            "MOVE_STEP": float(per_tick),
            "MOVE_UNIT": float(per_tick / FINEST),
            **{f"MOVE_N{k}": x for k, x in enumerate((n1, n2, n3), 1)},
            "MOVE_MOST": MOST // (n2 * n3),
            "MOVE_M2": m2,
            "MOVE_M3": m3,
            "MOVE_WHOLE": m2 * m3,
            "MOVE_FINEST": FINEST,
            "MOVE_LONGEST": LONGEST // (m2 * m3),
        }
        lines = (
            f"#define AXIS_{x} {literal(y, precision) if isinstance(y, float) else y}\n"
            for x, y in numbers.items()
        )
        text = noted(read("sosbook.controllers", "axis_move.h"), [written_by()])
        return renamed(text.replace("@NUMBERS@", "".join(lines)), "axis", name)


def fastest(units, limits, way, T, unit=""):
    """The `Profile` in which a ``way``, (distance, start), takes least where outputs
    with these ``units``, a `PerUnit` each, stay within ``limits``, (outputs,), for
    every motion as near to zero. ``T``: between ticks; ``unit``: of the set point.
    """
    distance, start = way
    far = max(abs(start), abs(start + distance))
    bounds = np.vstack([p.cells / limit for p, limit in zip(units, limits)])
    if not (most := far * bounds[..., 0].max()) < 1:
        raise ValueError(
            f"u_max: where the set point rests at {far:g} springs may ask {most:.4g} "
            "times that, and a motion asks more: take a shorter distance"
        )
    two, three = (x.ravel() for x in np.meshgrid(SHARES, SHARES))
    good = (two >= three) & (two + three <= 1)
    two, three = two[good], three[good]
    parts = np.array([np.ones(len(two)), 1 / two, 1 / (two * three)])

    def asked(t):
        size = distance * parts / np.array([t, t**2, t**3])
        return least(bounds, np.vstack([0 * t + far, size])).max(axis=0)

    low, high = np.full(len(two), 1e-12), np.full(len(two), 1.0)
    while (asked(high) > 1).any():
        high = np.where(asked(high) > 1, 2 * high, high)
    for _ in range(HALVINGS):
        mean = np.sqrt(low * high)
        fine = asked(mean) <= 1
        low, high = np.where(fine, low, mean), np.where(fine, mean, high)
    best = int(np.argmin(high * (1 + two + three)))
    t1 = high[best]
    n3, n2 = (ceil(x * t1 / T) for x in (three[best], two[best]))
    n2 = max(n2, n3)
    n1 = max(ceil(t1 / T), n2 + n3)
    held = bounds[..., 0].any()
    return _of_windows(n1, n2, n3, distance, T, unit, float(far) if held else None)


def quickest(units, limits, way, T, unit=""):
    """As `fastest`, with the same ``units``, ``limits``, ``way``, ``T`` and ``unit``,
    of this one move alone, which asks less than the worst motion.
    """
    distance, start = way

    def fits(t, two, three, proven=False):
        n3 = max(ceil(three * two * t / T), 1)
        n2 = max(ceil(two * t / T), n3)
        n1 = max(ceil(t / T), n2 + n3)
        profile = _of_windows(n1, n2, n3, distance, T, unit, slow.range)
        r = profile.points(distance, start)
        good = all(
            kernel.largest(r, T, proven) <= limit
            for p, limit in zip(units, limits)
            for kernel in p.kernels
        )
        return profile if good else None

    slow = fastest(units, limits, way, T, unit)
    best, ticks = slow, slow.ticks(distance)
    for two, three in product(TWO, THREE):
        if two * (1 + three) > 1:
            continue
        low, high = 0.0, ticks * T / (1 + two * (1 + three))  # no better beyond it
        if fits(high, two, three) is None:
            continue
        while high - low > max(T, FINE * high):
            mean = (low + high) / 2
            low, high = (low, mean) if fits(mean, two, three) else (mean, high)
        for more in ROOM:  # for the plants between corners
            found = fits(high * more, two, three, True)
            if found is not None and found.ticks(distance) < ticks:
                best, ticks = found, found.ticks(distance)
                break
    return best


def _of_windows(n1, n2, n3, distance, T, unit, range):
    """The `Profile` in which a ``distance`` has these windows, and this ``range``."""
    if n1 * n2 * n3 > MOST:
        raise ValueError(
            f"distance = {distance:g} would take {n1 + n2 + n3} ticks, more than are "
            "counted: take a shorter one"
        )
    V = distance / (n1 * T)
    sizes = V, V / (n2 * T), V / (n2 * n3 * T**2)
    # a little more than what the windows need, so that they come out the same
    return Profile(*map(_six, sizes), T, unit, range)


def _counts(x):
    """The whole number next to x, as C rounds it."""
    return int(x - 0.5 if x < 0 else x + 0.5)


def _six(x: Any) -> float:
    """A float of eight digits that is a little more than x."""
    return float(f"{x * (1 + 1e-7):.8g}")
