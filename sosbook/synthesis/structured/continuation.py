"""A goal that is asked for in numbers: each a little more than what was reached.

A descent of the goal itself may end on a ridge, far from where it could go, and its
starts are those of the plant's own rates. What is asked in numbers has starts at its
own rate, and begins where the last number was kept.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...requirements.lmi_region import LMIRegion
from ...runtime.time_limit import OutOfTime
from . import slopes
from .objective import DECAY
from .search import search

MORE = 1.05  # times what was reached is asked for, then its square, and so on
DOUBLINGS = 3  # of the exponent, at most
HASTY = 20.0  # times the decay: a pole that nobody asked for
ALIKE = 0.98  # of a limit: such a number is at it


@dataclass(frozen=True, eq=False)
class Ended:
    """Where the search of a goal ended: ``missed``, the nearest number that was asked
    for and not found, None without one, by so many ``starts``.
    """

    missed: float | None = None
    starts: int = 0


def further(best, reached, ask, harder):
    """(best `Found`, `Ended`) after asking for a little more than ``best`` reaches, for
    far more as long as it is found, then between. ``reached`` maps free numbers to the
    goal's value, which ``harder``, 1 or -1, says how to better; ``ask`` maps such a
    value and the best numbers so far to what is `Found`, whose value is negative where
    it is kept.
    """
    count, ended, k = best.starts, Ended(), 0
    try:
        level = reached(best.kappa)
        while k >= 0 and np.isfinite(level) and level > 0 and not best.stopped:
            wanted = float(level * MORE ** (harder * 2**k))
            found = ask(wanted, best.kappa)
            count += found.starts
            now = np.nan if found.kappa is None else reached(found.kappa)
            if found.value < 0 and harder * now > harder * level:
                best, level = found, now
                k = min(k + 1, DOUBLINGS) if ended.missed is None else k - 1
            elif found.stopped:
                best = replace(best, stopped=True)
            else:
                ended, k = Ended(wanted, found.starts), k - 1
    except OutOfTime:
        best = replace(best, stopped=True)
    return replace(best, starts=count), ended


def of_loops(task, loops, best, starts, seed):
    """`further` for the goal of a ``task`` for some ``loops``, from the ``best`` found;
    ``starts`` and ``seed`` as in `search`.
    """
    goal = task.goal

    def reached(kappa):
        K = loops.K(kappa)
        if goal == DECAY:
            return float(-slopes.Poles(loops, K).s.real.max())
        seen = [loops.descriptor(i, K, task.m) for i in range(len(loops))]
        harder = goal.parameter.harder
        return harder * min(harder * goal.reached([d], gain) for d, gain in seen)

    def ask(level, kappa):
        if goal == DECAY:
            more = LMIRegion.half_plane(level)
            asked = replace(task, regions=(*task.regions, more), rate=level, goal=None)
        else:
            more = goal.with_bound(level)
            asked = replace(task, bounded=(*task.bounded, more), goal=None)
        return search(asked, loops, starts, seed, (kappa,))

    harder = 1 if goal == DECAY else goal.parameter.harder
    return further(best, reached, ask, harder)


def why_ended(ended, shown, kappa, ends, blocks):
    """The reason that a goal's search ended at the numbers ``kappa``, in words:
    `at_limits`, of ``ends`` and ``blocks``, or the number that was ``ended`` with,
    which ``shown`` makes one for readers.
    """
    full, moves = at_limits(kappa, ends, blocks)
    if full:
        return f"The search ended at a limit: {full}. The law's {moves}= moves it."
    if ended.missed is None:
        return ""
    starts = "1 start" if ended.starts == 1 else f"{ended.starts} starts"
    return (
        f"The search ended where {shown(ended.missed):.4g}, the next that was asked, "
        f"wasn't found by {starts}; more starts may find it."
    )


def hasty(poles, filter_time, cure="ask for rho, too, or for limits"):
    """Words where the fastest of some ``poles`` is far faster than the slowest, and
    than a filter with the time constant ``filter_time``, or None; with the ``cure``.
    """
    slow, fast = -poles.real.max(), abs(poles).max()
    if fast <= HASTY * max(slow, 1 / (filter_time or np.inf)):
        return ""
    return (
        f"Its fastest pole is at {fast:.3g} rad/s, {fast / slow:.3g} times the decay: "
        f"where nothing in the machine is so fast, {cure}."
    )


def at_limits(kappa, ends, blocks):
    """Words for the free numbers ``kappa``, (k,), that are at their ``ends``, (2, k),
    by the ``blocks`` of their gains, and the argument that moves the last of
    them; empty without one.
    """
    start, words, moves = 0, [], "limits"
    for b in blocks:
        sizes = abs(b.shares).max(axis=(1, 2), initial=0)
        own, low, high = (x[start : start + len(sizes)] for x in (kappa, *ends))
        start += len(sizes)
        for k, (x, *both) in enumerate(zip(own, low, high)):
            room = x - both[0], both[1] - x
            near = [a <= (1 - ALIKE) * abs(end) for a, end in zip(room, both)]
            if any(near):
                way = "most" if near[1] or both[0] == -both[1] else "least"
                end = both[way == "most"]
                words.append(
                    f"an entry of {b.name} is {sizes[k] * x:.6g}, and may be "
                    f"{sizes[k] * end:.4g} at {way}"
                )
                moves = "structure" if end in b.ranges[k] else moves
                break
    return " and ".join(words), moves
