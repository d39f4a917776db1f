"""Bounds of the output error by the rounding of a program's arithmetic.

A sum of n products is off by at most (n + 2) e times the sum of their sizes, to first
order in e, the rounding of one operation: n roundings of sums, one of a product and one
of a number that the program has for a decimal (Higham, 2002). These errors are inputs
of the loop, and what they do to an output is a sum as in `sosbook.controllers.bounds`,
proven for every plant. So they don't pile up: the loop forgets them.
"""

import numpy as np

from ..plants.checks import positive
from .bounded import Bounded
from .bounds import bounded_output, rest, sizes_of

EPSILON = {"double": 2.0**-53, "single": 2.0**-24}


def rounding_bound(c, precision, range, speed, output):
    """The `Bounded` of what rounding in this ``precision`` does to an ``output`` of c,
    with one set point, no springs: from zero as far as ``range``, by ``speed`` a
    second.
    """
    if precision not in EPSILON:
        raise ValueError(f"precision must be 'double' or 'single', got {precision!r}")
    positive("range", range), positive("speed", speed)
    x = rest(c, 0)
    if x is None or len(c.set_points) != 1:
        raise ValueError(
            "set_point: a bound of the rounding needs one set point, at which the "
            "plant rests by itself"
        )
    own = _sizes(c, x, range, speed)
    if own is None:
        return Bounded(None, np.nan, c.outputs[output].unit)
    sizes, seen = own
    columns = _errors(c, sizes, seen, range)
    found = bounded_output(c, *columns, output)
    there = []
    for loop in c.loops:
        G = loop.pushed @ columns[1]
        G[len(G) - len(c.A) :] = columns[0]
        there.append(float(sizes_of(loop, G, columns[1], output).sum()))
    e = EPSILON[precision]  # a power of two: no product is rounded
    found = None if found is None else e * found
    return Bounded(found, e * max(there), c.outputs[output].unit)


def _sizes(c, x, range, speed):
    """The largest sizes of the memory and of y in such motions, or None."""
    N, l = len(x), len(c.A)
    plant = c.readings.rows.shape[1]
    rows = [np.eye(N)[N - l + i] for i in np.arange(l)]
    rows += [np.concatenate([row, np.zeros(N - plant)]) for row in c.readings.rows]
    found = []
    for row in rows:
        moved = bounded_output(c, c.B_r, c.D_r, row, -x)
        if moved is None:
            return None
        at_rest = abs(row @ x.astype(float)[:, 0]) * range
        found.append(at_rest + moved * speed * c.T)
    return np.array(found[:l]), np.array(found[l:])


def _errors(c, memory, seen, range):
    """How roundings act on the memory and on u: own and direct, a column each, for a
    relative error of one in each operation.
    """
    r = np.full(len(c.set_points), range)

    def row_errors(*pairs):
        count = sum(M.shape[1] for M, _ in pairs) + 2
        return count * sum(abs(M) @ v for M, v in pairs)

    own = row_errors((c.A, memory), (c.B, seen), (c.B_r, r))
    direct = row_errors((c.C, memory), (c.D, seen), (c.D_r, r))
    n, m = len(own), len(direct)
    read, ramped = seen, 3 * r
    return (
        np.hstack([np.diag(own), np.zeros((n, m)), c.B * read, c.B_r * ramped]),
        np.hstack([np.zeros((m, n)), np.diag(direct), c.D * read, c.D_r * ramped]),
    )
