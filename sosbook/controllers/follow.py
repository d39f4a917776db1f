r"""Bounds of every motion within velocity, acceleration and jerk: for every plant.

Let a set point move by :math:`v_k = (r_{k+1} - r_k)/T`, and a and j be the same of v
and a. With the rest :math:`x_r` at r = 1 and any :math:`y_v`, :math:`y_a`, let
:math:`s_v = F y_v - y_v - T x_r` and :math:`s_a = F y_a - y_a - T y_v`.

**Theorem.** Of a motion from rest :math:`p = x - x_r r - y_v v - y_a a` obeys
:math:`p_{k+1} = F p_k + s_v v_k + s_a a_k - T y_a j_k`. So if v, a and j are at most V,
A and J in size at all ticks, an output h with :math:`|h x| \le c |x|_q` has

.. math::

    |h (x - x_r r)| \le |h y_v| V + |h y_a| A + T J \sum_i |h F^i y_a|
    + c\, (|s_v|_q V + |s_a|_q A) / (1 - \rho) ,

and, whatever j is, :math:`|h y_v| V + T A \sum_i |h F^i y_v| + c |s_v|_q V /
(1 - \rho)`, and, whatever a is, :math:`T V \sum_i |h F^i x_r|`. Each of the three
holds, and so does the least: where an integral is slow, the sum of the jerk is long.

Of a u, which is h x + d r, the size itself counts: :math:`|h x_r + d| R` more, where
|r| is at most R. Without springs that is zero. Where each plant has its own rest,
:math:`x_r` is the one of `Tube.rest`, to which the polynomial is near.

*Proof.* :math:`x_{k+1} = F x_k + (x_r - F x_r) r_k`, v rises by T a, and a by T j; a
push s now is at most :math:`c \rho^i |s|_q` after i ticks. For the second let y_a = 0,
and for the third both. []

The y are polynomials in the plant, of which the s are what floats leave; the sums are
those of tubes: see `sosbook.controllers.tube`.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import fftconvolve

from .bounds import GOOD, of_all_plants, ticks_of
from .cells import Joined, work
from .step_bounds import Row
from .tube import SAFE, _gamma

MOST_CELLS = 64
AHEAD = 3  # ticks before a motion, in which its differences begin


@dataclass(frozen=True, eq=False)
class PerUnit:
    """How much an output is moved by each unit of the set point, of its velocity, its
    acceleration and its jerk.

    ``cells``, (cells, 3, 4), or None: proven, of each part of the family, by each bound
    of the theorem, from that of all three limits to that of velocity alone; ``seen``,
    (corners, 3, 4): in floats. ``kernels``: of one motion alone, a `Kernel` for each
    part. ``unit``: the output's.
    """

    cells: np.ndarray | None
    seen: np.ndarray
    kernels: list
    unit: str

    def bound(self, size):
        """(proven, seen) for ``size``, (4,): R, V, A and J, floats, also infinite."""
        size = np.asarray(size, float)
        seen = float(least(self.seen, size).max())
        if self.cells is None:
            return None, seen
        proven = np.nextafter(least(self.cells, size).max() * SAFE, np.inf)
        return float(proven), seen


def least(bounds, size):
    """(cells, k) of ``bounds``, (cells, bounds, 4), the least one for ``size``, (4,) or
    (4, k); what a bound doesn't count may be infinite.
    """
    some = np.where(np.isfinite(size), size, 0.0)
    sums = bounds @ some + np.where((bounds > 0) @ np.isinf(size) * 1.0, np.inf, 0.0)
    return sums.min(axis=1)


@dataclass(frozen=True, eq=False)
class Kernel:
    """The answer to one motion alone at a cell's corners, by each bound of the theorem.

    ``now``, (3, corners): h x_r + d, which is zero but for a u that springs ask, h y_v
    and h y_a; ``later``, (3, ticks, corners): h F^i y_a, h F^i y_v and h F^i x_r;
    ``off``, (3, ticks): how much these differ in other plants; from then on they are at
    most ``tail``, (3,), and fall by ``rho``; ``spare``, (3, 4): how much the rest
    differs, by each bound, a unit of R, V, A and J.
    """

    now: np.ndarray
    later: np.ndarray
    off: np.ndarray
    tail: np.ndarray
    rho: float
    spare: np.ndarray

    def largest(self, r, T, proven=True):
        """A bound of |h (x - x_r r)|, or of |u|, at all ticks of one motion r, which
        begins and ends at rest; without ``proven`` what is seen at the corners.
        """
        return min(float(x.max()) for x in self._courses(r, T, proven))

    def arrival(self, r, T, band, proven=True):
        """Seconds of the motion r after which all ticks are within a ``band``, as of
        `largest`; None where no bound says so.
        """
        found = []
        for course in self._courses(r, T, proven):
            beyond = np.flatnonzero(course > band)
            if not len(beyond) or beyond[-1] < len(course) - 1:
                found.append((max([*beyond[-1:], AHEAD - 1]) + 1 - AHEAD) * T)
        return min(found, default=None)

    def _courses(self, r, T, proven):
        """(ticks,) a bound of the size at each tick, `AHEAD` before r and on, by each
        bound of the theorem; the last is of all later ticks.
        """
        moves = [np.concatenate([[r[0]] * AHEAD, r, [r[-1]] * 4])]
        for _ in range(3):
            moves.append(np.diff(moves[-1]) / T)
        size = np.array([abs(x).max() for x in moves])
        blur = (SAFE - 1) * size + 8 * 2.0**-52 * abs(r).max() / T ** np.arange(4)
        if not proven:
            return [self._by(2, moves, T)]
        courses = []
        for k in range(3):
            course, sizes = self._by(k, moves, T), abs(moves[3 - k])
            course[1:-1] += T * fftconvolve(sizes, self.off[k])
            doubt = self._doubt(k, T) @ blur + self.spare[k] @ size
            long = min(sizes.max() / (1 - self.rho), sizes.sum())
            doubt += T * self.tail[k] * long
            courses.append(SAFE * (course + doubt))
        return courses

    def _by(self, k, moves, T):
        """(ticks,) the size at the worst corner, by bound k, of the ``moves`` r, v, a
        and j; zero at last.
        """
        found, count = [], 3 - k
        for now, later in zip(self.now.T, self.later[k].T):
            u = np.zeros(len(moves[count]) + len(later))
            for share, move in zip(now[:count], moves):
                u[: len(move)] += share * move
            u[1:] -= T * fftconvolve(moves[count], later)[: len(u) - 1]
            found.append(abs(u))
        return np.append(np.max(found, axis=0), 0.0)

    def _doubt(self, k, T):
        """(4,) how much an error of r, v, a or j is felt in `_by`."""
        found, count = np.zeros(4), 3 - k
        found[:count] = abs(self.now[:count]).max(axis=1)
        found[count] = T * (abs(self.later[k]).sum(axis=0).max() + self.off[k].sum())
        return found


@work
def per_unit(c, x, j, output, most=MOST_CELLS):
    """The `PerUnit` of an ``output`` (see `OutputBounds.step_response`) of c while set
    point j moves from rest, x being where it rests (see `bounds.rest`): of an output
    other than a u its distance from there. ``most``: parts of the family; none proves
    nothing.
    """
    row = Row.of(c, j, x, output)
    ticks, T = ticks_of(c.radius), float(c.T)
    pushed = slice(0) if x is not None else [j]
    joined = Joined(c, c.B_r[:, pushed], c.D_r[:, pushed])

    def judged(tube):
        """A cell's bounds and its kernel, and by how much it is above what is good."""
        *_, reach = tube.seen_by(row.row)
        rest, away = tube.rest(x)
        y_v, lost_v = _followed(tube, T, rest)
        lost_v += T * away
        y_a, lost_a = _followed(tube, T, y_v)
        lost = [reach * s / (1 - tube.rho) for s in (lost_v, lost_a)]
        ends = [_largest(tube, row.row, y) for y in (y_v, y_a)]
        now = [(h, off + s) for (h, off), s in zip(ends, lost)]
        u, doubt = np.zeros(len(tube.weights)), 0.0
        if x is None and row.direct is not None:  # springs ask something at rest
            u, doubt = _largest(tube, row.row, rest, away)
            u, doubt = u + row.direct, doubt + (SAFE - 1) * abs(row.direct)
        now.insert(0, (u, doubt))
        found, spare, excess, courses = np.zeros((3, 4)), np.zeros((3, 4)), [], []
        for k, start in enumerate(((y_a,), (y_v,), (rest, away))):
            near, off, tail = tube.motion(*start, ticks=ticks).seen(row.row)
            sizes = T * abs(near[:-1]).sum(axis=0).max()
            late = T * (off[:-1].sum() + tail / (1 - tube.rho))
            courses.append((near[:-1], off[:-1], tail))
            spare[k, : 3 - k] = [doubt for _, doubt in now[: 3 - k]]
            found[k, : 4 - k] = [*(abs(h).max() for h, _ in now[: 3 - k]), sizes + late]
            excess.append(late - (GOOD - 1) * sizes)
        found += spare
        excess.append(doubt + sum(lost) - (GOOD - 1) * found[0].sum())
        later = map(np.array, zip(*courses))
        kernel = Kernel(np.array([h for h, _ in now]), *later, tube.rho, spare)
        return (found * SAFE, kernel), max(excess)

    found = of_all_plants(c, joined, judged, most) if most else None
    cells, kernels = (None, []) if found is None else zip(*found)
    cells = None if cells is None else np.array(cells)
    seen = [_seen(loop, x, row, T, ticks, j) for loop in c.loops]
    return PerUnit(cells, np.array(seen), list(kernels), row.unit)


def _followed(tube, T, goal):
    """(y, lost): a polynomial y with F y - y near T ``goal``, and |s|_q at most."""
    y = tube.solved(-T * goal)
    now = np.concatenate([y.ravel(), np.zeros(tube.joined.inputs)])
    lost = tube.defect(now[:, None], (y + T * goal).ravel()[:, None])[0]
    most = tube.largest(tube.exponents)
    sizes = _gamma(3) * (abs(y) + T * abs(goal))  # of the sum's roundings
    return y, lost + tube.longest * float(most @ np.linalg.norm(sizes, axis=1))


def _largest(tube, row, *start):
    """(near, off) of row x for x of a polynomial, as `Motion.seen` has them."""
    near, off, _ = tube.motion(*start).seen(row)
    return near[0], float(off[0])


def _seen(loop, x, row, T, ticks, j):
    """A plant's bounds of `PerUnit`, (3, 4), in floats."""
    h, left = row.row.astype(float), np.eye(len(loop.F)) - loop.F
    found = np.zeros((3, 4))
    if x is None:
        ys = [np.linalg.solve(left, loop.set_point[:, j])]
        found[:, 0] = 0 if row.direct is None else abs(h @ ys[0] + row.direct)
    else:
        ys = [x.astype(float)[:, 0]]
    for k in range(2):
        ys.append(np.linalg.solve(left, -T * ys[-1]))
        found[: 2 - k, k + 1] = abs(h @ ys[-1])
    for k, y in enumerate(reversed(ys)):
        for _ in range(ticks):
            found[k, 3 - k] += T * abs(h @ y)
            y = loop.F @ y
    return found
