"""Performance profiles: how often a competitor is within a factor of the best.

Source: E. D. Dolan and J. J. Moré, Benchmarking optimization software with
performance profiles, Math. Program. 91, 2002. Times are by case and competitor,
infinite where there is no right answer.
"""

import math
from statistics import median

import numpy as np

from .peers import competitors, empty, look_of, pick
from .style import GREY

__all__ = [
    "best_of_others",
    "curves",
    "faster",
    "from_data",
    "growth",
    "memory",
    "power",
    "ratios",
    "share",
    "speedup",
    "times",
    "uphill",
]

OURS = "sosbook"


def times(records):
    """Seconds of ``records`` (family, size, competitor, status, cpu_s): a dict from
    (family, size) to one by competitor, infinite where the answer isn't right.

    >>> one = dict(family="chain", size=2, competitor="a", status="right", cpu_s=0.5)
    >>> times([one, one | dict(competitor="b", status="wrong", cpu_s=0.1)])
    {('chain', 2): {'a': 0.5, 'b': inf}}
    """
    found = {}
    for r in records:
        seconds = r["cpu_s"] if r["status"] == "right" else math.inf
        found.setdefault((r["family"], r["size"]), {})[r["competitor"]] = seconds
    return found


def ratios(seconds):
    """Each competitor's ``seconds``, as of `times`, over the best one's, case by case,
    cases that nobody solved among them: infinite without an answer.

    >>> ratios({1: {"a": 2.0, "b": 1.0}, 2: {"a": 3.0, "b": math.inf}})
    {'a': [2.0, 1.0], 'b': [1.0, inf]}
    """
    names = dict.fromkeys(name for case in seconds.values() for name in case)
    found = {name: [] for name in names}
    for case in seconds.values():
        best = min(case.values())
        for name in names:
            t = case.get(name, math.inf)
            found[name].append(t / best if t < math.inf else math.inf)
    return found


def share(factors, tau):
    """The part of all cases in which one of the ``factors`` is at most ``tau``."""
    return sum(r <= tau for r in factors) / len(factors)


def best_of_others(case):
    """The fastest of the others in a ``case``, seconds by competitor, and its seconds;
    None and infinity without one.
    """
    others = {n: t for n, t in case.items() if n != OURS and t < math.inf}
    name = min(others, key=others.get, default=None)
    return name, others.get(name, math.inf)


def faster(seconds):
    """Where somebody else is faster in ``seconds`` of `times`, the worst first: (case,
    who, how many times as long we take).

    >>> faster({1: {"sosbook": 2.0, "b": 1.0}, 2: {"sosbook": 3.0, "b": math.inf}})
    [(1, 'b', 2.0)]
    """
    found = []
    for name, case in seconds.items():
        who, best = best_of_others(case)
        mine = case.get(OURS, math.inf)
        if best < mine:
            found.append((name, who, mine / best))
    return sorted(found, key=lambda entry: -entry[2])


def from_data(records):
    """Our seconds, those of the fastest one who begins with finished data, and what
    these take, by case that both solve, of ``records`` as for `times` with data_s.
    """
    cases = {}
    for r in records:
        if r["status"] == "right":
            cases.setdefault((r["family"], r["size"]), {})[r["competitor"]] = r
    found = {}
    for name, case in cases.items():
        ours = case.pop(OURS, None)
        if ours and case:
            beside = [(r["cpu_s"] - r["data_s"], r["data_s"]) for r in case.values()]
            found[name] = (ours["cpu_s"], *min(beside))
    return found


def speedup(seconds, size, theirs):
    """The median over families of ``theirs``, a competitor's time, over ours, in
    ``seconds`` of `times` at a ``size``; who has no answer takes infinitely long. None
    if nobody has one.
    """
    both = [
        (case.get(theirs, math.inf), case.get(OURS, math.inf))
        for (_, at), case in seconds.items()
        if at == size
    ]
    found = [t / o if o < math.inf else 0.0 for t, o in both if min(t, o) < math.inf]
    return median(found) if found else None


def power(seconds, first, last):
    """p, where ``seconds`` by size grow like the size to the power p, from ``first`` to
    ``last``.
    """
    return math.log2(seconds[last] / seconds[first]) / math.log2(last / first)


def uphill(seconds):
    """The largest ratio of a smaller size's ``seconds`` to a larger one's, and both
    sizes.
    """
    return max(
        (seconds[a] / seconds[b], a, b) for a in seconds for b in seconds if a < b
    )


def curves(ax, factors, most=100.0):
    """Performance profiles: a rising step for each competitor.

    ``ax``: the axes to draw on; ``factors``: as of `ratios`; ``most``: the largest
    factor that is drawn.
    """
    if not factors:
        return empty(ax)
    for name in competitors([dict(competitor=name) for name in factors]):
        inside = sorted(r for r in factors[name] if r <= most)
        x = [1.0, *inside, most]
        y = [share(factors[name], tau) for tau in x]
        colour, dash, _ = look_of(name)
        ax.step(x, y, where="post", color=colour, ls=dash)
    ax.set(xscale="log", xlim=(1, most), ylim=(0, 1.03))
    ax.set_xlabel("time over the best one's, at most")
    return ax


def growth(ax, records, field="cpu_s"):
    """A field over the size, one line a competitor, on logarithmic axes.

    ``ax``: the axes to draw on; ``records``: of one family; ``field``: "cpu_s" or
    "peak_mb".
    """
    known = [r for r in pick(records, status="right") if r[field]]
    if not known:
        return empty(ax)
    for name in competitors(known):
        points = {r["size"]: r[field] for r in pick(known, competitor=name)}
        colour, dash, marker = look_of(name)
        sizes = sorted(points)
        y = [points[s] for s in sizes]
        ax.plot(sizes, y, color=colour, ls=dash, marker=marker, ms=4)
    ax.set(xscale="log", yscale="log", xlabel="n")
    ticks = [s for s in (2, 4, 8, 16, 32, 64, 128, 200) if s <= max_size(known)]
    ax.set_xticks(ticks, [str(s) for s in ticks])
    ax.minorticks_off()
    return ax


def memory(ax, records):
    """Peak memory over the size; the dotted line is what there was before.

    ``ax``: the axes to draw on; ``records``: of one family.
    """
    growth(ax, records, "peak_mb")
    before = [r["base_mb"] for r in records if r["base_mb"]]
    if before:
        ax.axhline(np.median(before), color=GREY, ls=":", lw=1)
        most = max(r["peak_mb"] for r in records if r["peak_mb"])
        ticks = [m for m in 100 * 2 ** np.arange(8) if m < 1.5 * most]
        ax.set_yticks(ticks, [str(m) for m in ticks])
    return ax


def max_size(records):
    """The largest size in the records."""
    return max(r["size"] for r in records)
