r"""Loops of a family that fall, proven by a norm of each corner's modes.

**Theorem.** Let the loops F of a cell be mixtures :math:`\sum a_i F_i` of those at its
corners, but for D with :math:`D^\top D \le W`; let :math:`0 < P_i \le p I` and t > 0.
If for all corners i, j and k, the same or not,

.. math::

    \tfrac16 \sum \big( \rho^2 P_i - (1 + t) F_j^\top P_i F_k \big) -
    (1 + 1/t)\, p\, W > 0 ,

where the sum is over their six orders, then :math:`F^\top P F < \rho^2 P` with
:math:`P = \sum a_i P_i`, in the whole cell.

*Proof.* (F + D)'P (F + D) is at most (1 + t) F'P F + (1 + 1/t) D'P D, for P > 0, and
D'P D is at most p W. What is left is the sum of a_i a_j a_k times such a matrix over
all i, j and k, as the a_i are of sum one. []

The theorem of `sosbook.sampled.cells` has a multiplier G in the place of the P_i, and
loses what G and P_i differ by squared, at each tick: much, where little falls from tick
to tick. Here a loop near one loses that share of it which a tick changes. Any P_i will
do: these have the modes of each corner as axes, each as long as in the middle, with
sizes for which what one mode does to another in the cell is alike both ways.
"""

from itertools import combinations_with_replacement as choices
from itertools import permutations

import numpy as np
from flint import arb
from scipy.linalg import matrix_balance
from scipy.optimize import linear_sum_assignment

from ..exact.definite import round_digits
from ..exact.rational import exact
from ..runtime.time_limit import check_time
from ..sampled.balls import middle, product
from ..sampled.cells import PlantCell, _turned, least_pivot
from ..sampled.cover import LYAPUNOV_DIGITS, _longest, _within

ABOVE = 1 + 1e-6  # of the largest eigenvalue of a P, which balls then confirm
CORNERS = 8  # of a cell; of more, there are too many threes of them


def by_modes(family, clocks, rho, budget, sizes):
    """Cells (weights, L, P), in rationals, that hold a ``family`` whose loops fall by
    ``rho`` in the norm of the mixed P in coordinates L x; None where a ``budget`` of
    cells doesn't do. ``clocks``: a `TimeBox` of one clock;
    ``sizes``, (N,): of the states.
    """
    shape, queue, found = family.shape, [family.shape.whole()], []
    if len(shape.corners) > CORNERS:
        return None
    while queue:
        check_time()
        weights, budget = queue.pop(), budget - 1
        cell, far = _cell(family, clocks, weights, rho, sizes)
        if cell is not None and _least(cell, rho) > 0:
            found.append((weights, exact(cell.L), exact(cell.P)))
            continue
        if len(weights) == 1 or len(queue) + 2 > budget:
            return None
        queue += shape.halves(weights, _longest(shape, weights, far))
    return found


def _cell(family, clocks, weights, rho, sizes):
    """(cell, far): the `PlantCell`, or None where floats see no decay by ``rho``, and
    how far its corners' loops are apart.
    """
    (timing,) = clocks.corners
    mixed = [*weights, weights.sum(axis=0) / len(weights)]
    *loops, mean = (middle(family.loop(w, timing)) for w in mixed)
    L = round_digits(_axes(loops, mean, sizes), LYAPUNOV_DIGITS)
    *loops, mean = (_within(F, L) for F in (*loops, mean))
    far = np.linalg.norm(np.array(loops)[:, None] - loops, 2, axis=(2, 3))
    P = [_modal(F, mean) for F in loops]
    blocks = _threes(rho**2, P, loops, np.matmul)
    if not all(np.linalg.eigvalsh(x)[0] > 0 for x in (*P, *blocks)):
        return None, far
    P = np.array([round_digits(x, LYAPUNOV_DIGITS) for x in P])
    return PlantCell(family, weights, L, clocks, 0, P), far


def _threes(pace, P, loops, times):
    """The theorem's matrices without W: ``pace`` is rho^2 / (1 + t), and they are
    divided by 1 + t, ``times`` is a product.
    """
    moved = [[times(x, F) for F in loops] for x in P]
    for three in choices(range(len(P)), 3):
        orders = set(permutations(three))
        drops = [pace * P[i] - times(loops[j].T, moved[i][k]) for i, j, k in orders]
        S = sum(drops[1:], drops[0]) / len(orders)
        yield (S + S.T) / 2


def _least(cell, rho):
    """A positive number if the theorem holds for a ``cell``, in balls."""
    try:
        (loops,), (W,) = cell.loops(cell.clocks), cell.bent(cell.clocks)
    except ZeroDivisionError:  # some E in the hull is singular
        return -np.inf
    one = np.eye(len(cell.L), dtype=int)
    several = [_turned(x, cell.turn) for x in cell.P]
    p = arb(ABOVE * max(np.linalg.eigvalsh(middle(x))[-1] for x in several))
    pivots = [least_pivot(x) for y in several for x in (y, p * one - y)]
    less, t = 0 * one, arb(0)
    if W is not None:
        t = arb(float(np.sqrt(max(np.linalg.norm(middle(W), 2), 1e-40))))
        less = (1 / t) * p * W
    pace = arb(exact(rho)) ** 2 / (1 + t)
    for S in _threes(pace, several, loops, product):
        if not min(pivots) > 0:
            break
        pivots.append(least_pivot(S - less))
    return min(pivots)


def _axes(loops, mean, sizes):
    """Coordinates in which the modes of the ``mean`` loop are orthogonal, as long as
    makes them mix least in the other loops, and with states of such ``sizes``.
    """
    B = np.diag(1 / sizes)
    inside = _within(mean, B)
    values, V = np.linalg.eig(inside)
    rows = np.linalg.pinv(V)
    mixed = sum(abs(rows @ (_within(F, B) - inside) @ V) for F in loops)
    falls = np.sqrt(np.maximum(1 - abs(values), 1e-12))
    mixed = mixed / falls / falls[:, None]
    np.fill_diagonal(mixed, 0)
    moved = np.linalg.norm(rows, axis=1) / falls  # by the states, and what moves them
    seen = np.linalg.norm(V, axis=0) / falls
    moved, seen = (x / np.sqrt(moved @ seen) for x in (moved, seen))
    mixed = np.block([[mixed, moved[:, None]], [seen, np.zeros(1)]])
    long = matrix_balance(mixed, permute=False, separate=True)[1][0]
    rows = rows * (long[-1] / long[:-1])[:, None]
    try:
        return np.linalg.cholesky((rows.conj().T @ rows).real).T @ B
    except np.linalg.LinAlgError:  # two modes are nearly one
        return B


def _modal(F, mean):
    """The P of a loop F whose modes are as long as those of the ``mean`` loop."""
    V, W = (np.linalg.eig(x)[1] for x in (mean, F))
    share = abs(np.linalg.pinv(V) @ W) ** 2
    order = linear_sum_assignment(-share / share.sum(axis=0))[1]
    rows = np.linalg.pinv(W[:, order])
    rows = rows / np.einsum("ij,ji->i", rows, V)[:, None]
    P = (rows.conj().T @ rows).real
    return (P + P.T) / 2
