r"""The weight b of a set point: P sees y - b r, the integral sees y - r.

After a step from rest every output is affine in b, of each plant and at each tick. So a
bound leaves an interval of b: a linear program of one unknown. Two of these intervals
that share nothing prove that no b does it, by Farkas's multipliers of their two rows.
"""

from bisect import bisect_left
from dataclasses import replace

import numpy as np
from flint import arb, ctx

from ..exact.rational import exact
from ..plants.checks import not_negative, positive
from ..sampled.balls import balls, product, solve
from .bounded import plants_of
from .bounds import outputs_of, rest, stable, ticks_of
from .cells import Joined
from .step_bounds import Row, motion_of
from .step_limits import share_of_step

ROUNDS = 5  # of a proof; before each next one the bounds that it missed are tighter,
FINE = 0.002, 0.01  # by what it missed and this
BITS = 4000  # of balls that hold a power of a loop
STILL = 1e-9  # of a step: what b moves by less is taken as constant
BAND = 0.98  # of the band, that is asked of plants in floats


def weighted(c, overshoot, effort, size, j, output, band):
    """A controller c with the b of set point ``j`` that settles soonest, proven.

    ``overshoot``, ``effort``, ``size``, ``output``, ``band``: as in `OutputBounds`.
    """
    stable(c, "weights")
    positive("size", size)
    asked = [share_of_step(not_negative, overshoot), positive("band", band)]
    most = (
        None if effort is None else positive("effort", effort) / positive("size", size)
    )
    ends = [c.set_point(b=b) for b in (0.0, 1.0)]
    row = Row.of(c, j, rest(ends[0], j), output)
    if not row.ends:
        raise ValueError(
            "output must end where the set point moves it, with every plant alike"
        )
    plants, ticks = plants_of(c), ticks_of(c.radius)
    asks = [] if most is None else [*outputs_of(c)]
    hs = [row.row / row.ends, *asks]
    below = len(hs)  # where the rows for the other sign begin
    hs += [-h for h in hs]
    floats = np.array(hs, float)

    def after(one, d):
        """(ticks, rows): of a plant d, the outputs less where they end, and each u."""
        loop = one.loop(d)
        x = np.linalg.solve(np.eye(len(loop.F)) - loop.F, loop.set_point[:, [j]])
        held = (loop.H @ x)[:, 0] + loop.direct_r[:, j]
        held = np.concatenate([[0.0], held[: len(asks)]])
        return motion_of(loop, -x, ticks) @ floats.T + np.concatenate([held, -held])

    seen = np.array([[after(one, d) for one in ends] for _, _, d in plants]).transpose(
        3, 1, 0, 2
    )  # of each row, end, plant and tick
    room = [0.0, 0.0]
    for _ in range(ROUNDS):
        limits = [(0, asked[0] - room[0])]
        limits += [
            (start + 1 + k, most - room[1])
            for start in (0, below)
            for k, _ in enumerate(asks)
        ]
        low, high, places = _shared(seen, limits)
        if low > high:
            if not any(room) and _refuted(ends, plants, hs[:below], j, limits, places):
                at = [f"{plants[i][0]} at {k * c.T:.4g} s" for _, i, k in places]
                raise ValueError(
                    f"no b keeps to it: b must be below {high:.4g} for {at[1]} and "
                    f"above {low:.4g} for {at[0]}: proven by one program, in balls"
                )
            break
        rows = [(i, BAND * asked[1]) for i in (0, below)]

        def keeps(k, limits=limits, rows=rows):
            low, high, _ = _shared(seen, limits, rows, k)
            return low <= high

        # the first tick from which on some b keeps the band
        first = bisect_left(range(ticks), True, key=keeps)
        low, high, _ = _shared(seen, limits, rows, first)
        b = (low + high) / 2 if np.isfinite(low + high) else np.clip(1.0, low, high)
        found = c.set_point(b=float(f"{b:.6g}"))
        shown = found.bounds.step_response(size, j, output, band)
        efforts = [bound.proven for bound in shown.effort]
        if None in (shown.overshoot.proven, *efforts):
            break
        over = [shown.overshoot.proven - asked[0]]
        over.append(0.0 if most is None else max(efforts) / size - most)
        if max(over) <= 0:
            return found
        room = [x + (y + fine) * (y > 0) for x, y, fine in zip(room, over, FINE)]
    if abs(np.diff(seen, axis=1)).max() <= STILL:
        raise ValueError(
            "b changes nothing here, where the law's P sees no jump of r, or all of it "
            "by set_point(r=...): shape the set point by motions.move, or ask for less"
        )
    raise ValueError("undecided: no b was proven, and none refuted; ask for less")


def _shared(seen, limits, late=(), first=0):
    """(low, high, places): the b that keep rows below their limits at all plants and
    ticks, and ``late`` ones from a ``first`` tick on; whose row, plant and tick it is.
    """
    ends, places = [-np.inf, np.inf], [None, None]
    for (row, most), start in [(x, 0) for x in limits] + [(x, first) for x in late]:
        at, slope = seen[row][0][:, start:], np.diff(seen[row], axis=0)[0][:, start:]
        moved = abs(slope) > STILL
        b = (most - at) / np.where(moved, slope, 1.0)
        lows = np.where(moved & (slope < 0), b, -np.inf)
        highs = np.where(moved & (slope > 0), b, np.inf)
        never = ~moved & (at > most + STILL)  # whatever b is
        lows[never], highs[never] = np.inf, -np.inf
        for end, sign, values in ((0, 1, lows), (1, -1, highs)):
            k = np.unravel_index((sign * values).argmax(), values.shape)
            if sign * values[k] > sign * ends[end]:
                ends[end] = float(values[k])
                places[end] = row, int(k[0]), int(k[1]) + start
    return *ends, places


def _refuted(several, plants, hs, j, limits, places):
    """True if balls prove that the two rows at these places share no b, the controllers
    with b = 0 and 1 being ``several``. The rows are ``hs``, then these times -1.
    """
    if None in places:
        return False
    ends, slopes = [], []
    with ctx.workprec(BITS):
        for row, i, tick in places:
            values = []
            for c in several:
                one = replace(c, plant=plants[i][1])
                joined = Joined(one, c.B_r[:, [j]], c.D_r[:, [j]])
                whole = joined.family.loop(exact(np.ones(1)), c.timing)
                F, G = whole[:-1, :-1], whole[:-1, -1:]
                x = solve(balls(np.eye(len(F), dtype=int)) - F, G)
                v = -x
                for _ in range(tick):
                    v = product(F, v)
                low, k = divmod(row, len(hs))
                h = balls(hs[k][None])
                value = (h @ v)[0, 0]
                if k:  # a u, with what springs ask at rest
                    value += (h @ x)[0, 0] + arb(exact(c.D_r[k - 1, j]))
                values.append(-value if low else value)
            slopes.append(values[1] - values[0])
            most = arb(exact(dict(limits)[row]))
            ends.append((most - values[0]) / slopes[-1])
    return bool(slopes[0] < 0 < slopes[1] and ends[0] > ends[1])
