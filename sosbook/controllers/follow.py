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

and, without a bound of j, :math:`|h y_v| V + T A \sum_i |h F^i y_v| + c |s_v|_q V /
(1 - \rho)`.

*Proof.* :math:`x_{k+1} = F x_k + (x_r - F x_r) r_k`, v rises by T a, and a by T j; a
push s now is at most :math:`c \rho^i |s|_q` after i ticks. For the second let y_a = 0.
[]

The y are polynomials in the plant, of which the s are what floats leave; the sums are
those of tubes: see `sosbook.controllers.tube`.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb
from scipy.signal import fftconvolve

from ..exact.rational import exact
from ..sampled.balls import balls, balls_of, middle
from .bounds import GOOD, of_all_plants, rounded, ticks_of
from .cells import Joined, work
from .step_bounds import Row
from .tube import SAFE, _above, _gamma

MOST_CELLS = 64


@dataclass(frozen=True, eq=False)
class PerUnit:
    """How much an output is moved by each unit of velocity, acceleration and jerk.

    ``cells``, (cells, 3): proven, of each part of the family; ``seen``, (corners, 3):
    in floats; the bound of a motion is the largest sum of a row. ``kernels``: of one
    motion alone, a `Kernel` for each part. ``unit``: the output's.
    """

    cells: np.ndarray | None
    seen: np.ndarray
    kernels: list
    unit: str

    def bound(self, size):
        """(proven, seen) for ``size``, (3,): V, A and J, rationals or floats."""
        seen = float((self.seen @ np.asarray(size, float)).max())
        if self.cells is None:
            return None, seen
        sizes = [arb(exact(float(x))) for x in size]
        sums = [sum((arb(a) * b for a, b in zip(row, sizes)), arb(0))
                for row in self.cells]  # fmt: skip
        return max(rounded(x, np.inf) for x in sums), seen


@dataclass(frozen=True, eq=False)
class Kernel:
    """h y_v, h y_a, (corners,), and h F^i y_a, (ticks, corners), at a cell's corners;
    ``spare``, (3,): how much others differ, a unit of V, A and J.
    """

    now: tuple
    later: np.ndarray
    spare: np.ndarray

    def largest(self, r, T, proven=True):
        """A bound of |h (x - x_r r)| at all ticks of one motion r, which begins and
        ends at rest; without ``proven`` what is seen at the corners.
        """
        rest = np.full(3, r[0]), np.full(4, r[-1])
        v = np.diff(np.concatenate([rest[0], r, rest[1]])) / T
        a = np.diff(v) / T
        j = np.diff(a) / T
        most = sizes = 0.0
        for one, two, later in zip(*self.now, self.later.T):
            u = np.zeros(len(j) + len(later))
            u[: len(v)] = one * v
            u[: len(a)] += two * a
            u[1:] -= T * fftconvolve(j, later)[: len(u) - 1]
            most = max(most, abs(u).max())
            sizes = max(sizes, T * abs(later).sum() + abs(one) + abs(two))
        size = np.array([abs(x).max() for x in (v, a, j)])
        rounded = 8 * 2.0**-52 * abs(r).max() / T**3  # in what floats make of j
        doubt = self.spare @ size + sizes * ((SAFE - 1) * size.max() + rounded)
        return (most + doubt) * SAFE if proven else most


@work
def per_unit(c, x, j, output, jerk=True, most=MOST_CELLS):
    """The `PerUnit` of an ``output`` (see `OutputBounds.step_response`) of c while set
    point j moves from rest, x being where it rests: of an output that ends elsewhere
    than at zero its distance from there. Without ``jerk`` that column is zero.
    ``most``: parts of the family; none proves nothing.
    """
    row = Row.of(c, j, x, output)
    ticks, T = ticks_of(c.radius), float(c.T)
    joined = Joined(c, c.B_r[:, :0], c.D_r[:, :0])

    def judged(tube):
        """A cell's row, and by how much it is above what is good."""
        *_, reach = tube.seen_by(row.row)
        y_v, lost_v = _followed(tube, T, _rest_of(tube, x))
        lost_v += T * tube.longest * _blurred(tube, x)
        parts = [_largest(tube, row.row, y_v)]
        last, lost_a = y_v, 0.0
        if jerk:
            last, lost_a = _followed(tube, T, y_v)
            parts.append(_largest(tube, row.row, last))
        near, off, tail = tube.motion(first=last, ticks=ticks).seen(row.row)
        sizes = abs(near[:-1]).sum(axis=0).max()
        late = T * (off[:-1].sum() + tail / (1 - tube.rho))
        lost = [reach * s / (1 - tube.rho) for s in (lost_v, lost_a)]
        pairs = [(abs(near).max() + off, off, near) for near, off in parts]
        found = [most + s for (most, *_), s in zip(pairs, lost)] + [T * sizes + late]
        kernel = None
        if jerk:
            spare = [off + s for (_, off, _), s in zip(pairs, lost)] + [late]
            kernel = Kernel((pairs[0][2], pairs[1][2]), near[:-1], np.array(spare))
        found += [0.0] * (3 - len(found))
        excess = max(late - (GOOD - 1) * T * sizes, sum(lost) - (GOOD - 1) * sum(found))
        return (np.array(found) * SAFE, kernel), excess

    found = of_all_plants(c, joined, judged, most) if most else None
    cells, kernels = (None, []) if found is None else zip(*found)
    cells = None if cells is None else np.array(cells)
    seen = [_seen(loop, x, row, T, jerk, ticks) for loop in c.loops]
    return PerUnit(cells, np.array(seen), list(kernels), row.unit)


def _rest_of(tube, x):
    """The rest x in a tube's frame, as a polynomial in floats."""
    found = np.zeros((len(tube.exponents), len(tube.frame)))
    found[0] = middle(balls_of(tube.frame) @ balls(x))[:, 0]
    return found


def _blurred(tube, x):
    """How far the rest x is from its floats, in the frame."""
    whole = (balls_of(tube.frame) @ balls(x))[:, 0]
    return float(np.linalg.norm(_above(whole - balls_of(middle(whole[:, None])[:, 0]))))


def _followed(tube, T, goal):
    """(y, lost): a polynomial y with F y - y near T ``goal``, and |s|_q at most."""
    y = tube.solved(-T * goal)
    now = np.concatenate([y.ravel(), np.zeros(tube.joined.inputs)])
    lost = tube.defect(now[:, None], (y + T * goal).ravel()[:, None])[0]
    most = tube.largest(tube.exponents)
    sizes = _gamma(3) * (abs(y) + T * abs(goal))  # of the sum's roundings
    return y, lost + tube.longest * float(most @ np.linalg.norm(sizes, axis=1))


def _largest(tube, row, y):
    """(near, off) of row y for a polynomial y, as `Motion.seen` has them."""
    near, off, _ = tube.motion(first=y, ticks=1).seen(row)
    return near[0], float(off[0])


def _seen(loop, x, row, T, jerk, ticks):
    """A plant's row of `PerUnit`, in floats."""
    h = row.row.astype(float)
    left = np.eye(len(loop.F)) - loop.F
    y = np.linalg.solve(left, -T * x.astype(float)[:, 0])
    found = [abs(h @ y)]
    if jerk:
        y = np.linalg.solve(left, -T * y)
        found.append(abs(h @ y))
    total = 0.0
    for _ in range(ticks):
        total += abs(h @ y)
        y = loop.F @ y
    return [*found, T * total, *[0.0] * (2 - len(found))]
