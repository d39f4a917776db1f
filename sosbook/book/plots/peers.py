"""Competitors in pictures of measured times: their marks, and who is faster.

A record is a dict of benchmarks/results.json. Every function copes with records
that are missing and with competitors that gave no right answer.
"""

import numpy as np

from ...runtime.libraries import library
from .style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, SKY, VERMILLION

Line2D = library("matplotlib.lines").Line2D

__all__ = ["competitors", "growth", "legend", "memory", "pick", "ratios"]

#: One colour a solver, one marker a competitor.
PEER_LOOKS = {
    "sosbook": (BLUE, "o"),
    "sosbook, complete design": (SKY, "s"),
    "clarabel": (VERMILLION, "^"),
    "clarabel, stopped early": (VERMILLION, "v"),
    "cvxpy + clarabel": (GREEN, "D"),
    "cvxpy + clarabel, DPP": (GREEN, "P"),
    "cvxpy + clarabel, centre": (GREEN, "*"),
    "cvxopt": (PURPLE, "s"),
    "picos + cvxopt": (PURPLE, "X"),
    "sdpa": (ORANGE, "o"),
    "scs": (INK, "<"),
    "scipy, Riccati": (GREY, "p"),
}
FAILED = ("wrong", "no answer")


def pick(records, **wanted):
    """Records whose fields have the wanted values.

    Parameters
    ----------
    records : list of dict
        The records of benchmarks/results.json.
    **wanted
        A value, or a tuple of values, for each field.

    Returns
    -------
    list of dict
        Those that match, in their order.

    Examples
    --------
    >>> pick([{"n": 2}, {"n": 4}, {"n": 8}], n=(2, 8))
    [{'n': 2}, {'n': 8}]
    """

    def allowed(value, choice):
        return value in choice if isinstance(choice, tuple) else value == choice

    return [
        r
        for r in records
        if all(allowed(r[field], choice) for field, choice in wanted.items())
    ]


def ratios(ax, records, clock):
    """A row of dots for each case: median time over sosbook's.

    An arrow starts at the least ratio of a call that went over its limit.
    Open marks on the right have no time: the answer was wrong, or there
    was none. A ring means that the competitor was given sosbook's
    coordinates, because it failed in the plant's own.

    Parameters
    ----------
    ax : matplotlib Axes
        The axes to draw on.
    records : list of dict
        The records of benchmarks/results.json.
    clock : {"end to end", "solve only"}
        What was timed.

    Returns
    -------
    matplotlib Axes
        The same axes.
    """
    peers = competitors(records)
    cases = list(dict.fromkeys(r["case"] for r in records))
    offset = dict(zip(peers, np.linspace(-0.32, 0.32, max(2, len(peers)))))
    ours = {
        r["case"]: r["median_s"]
        for r in pick(records, competitor="sosbook", clock=clock)
    }
    drawn, failed, late = [], {}, []
    for r in _settled(records):
        y = cases.index(r["case"]) + offset[r["competitor"]]
        if r["clock"] == clock and r["ratio"]:
            mark(ax, r["ratio"], y, r, ring=_helped(r))
            drawn.append(r["ratio"])
        elif r["clock"] is None and _has(records, r["competitor"], clock):
            if r["status"] == "over the limit" and ours.get(r["case"]):
                late.append((r["limit_s"] / ours[r["case"]], y, r))
            elif r["status"] in FAILED:
                place = failed[r["case"]] = failed.get(r["case"], 0) + 1
                mark(
                    ax,
                    1 + 0.045 * place,
                    y,
                    r,
                    hollow=True,
                    clip_on=False,
                    transform=ax.get_yaxis_transform(),
                )
    for x, y, r in late:
        mark(ax, x, y, r, hollow=True)
        ax.annotate(
            "",
            (x * 3, y),
            (x * 1.2, y),
            arrowprops=dict(
                arrowstyle="->", color=look_of(r["competitor"])[0], shrinkA=0, shrinkB=0
            ),
        )
    if not drawn:
        return empty(ax)
    bounds = [x for x, *_ in late]
    ax.set_xscale("log")
    ax.set_xlim(min(drawn) / 2, max(drawn + [3 * b for b in bounds]) * 2)
    ax.axvline(1, color=BLUE, lw=1, ls="-", zorder=0)
    for k in range(len(cases) - 1):
        ax.axhline(k + 0.5, color="#e3e5e8", lw=0.6, ls="-", zorder=0)
    if failed:
        ax.text(
            1.02, 1.005, "wrong,\nnone", transform=ax.transAxes, fontsize=7, va="bottom"
        )
    ax.set_yticks(range(len(cases)), cases)
    ax.set_ylim(len(cases) - 0.5, -0.5)
    ax.grid(axis="y", visible=False)
    ax.tick_params(axis="y", length=0)
    ax.set_xlabel(f"time over sosbook's, {clock}")
    return ax


def growth(ax, records, clock):
    """Seconds over n for the chains, one line a competitor.

    Open marks above went over their limit, those at the bottom stand for
    a wrong answer or none.

    Parameters
    ----------
    ax : matplotlib Axes
        The axes to draw on.
    records : list of dict
        The records of benchmarks/results.json.
    clock : {"end to end", "solve only"}
        What was timed.

    Returns
    -------
    matplotlib Axes
        The same axes.
    """
    chains = pick(records, family="chain")
    if not _lines(ax, chains, clock, "median_s"):
        return empty(ax)
    late, failed = {}, {}
    for r in _settled(chains):
        if not _has(chains, r["competitor"], clock):
            continue
        if r["status"] == "over the limit":
            place = late[r["n"]] = late.get(r["n"], 0) + 1
            mark(ax, r["n"], r["limit_s"] * 1.7**place, r, hollow=True)
        elif r["status"] in FAILED:
            place = failed[r["n"]] = failed.get(r["n"], 0) + 1
            mark(
                ax,
                r["n"],
                0.05 * place - 0.02,
                r,
                hollow=True,
                transform=ax.get_xaxis_transform(),
            )
    _axes_of_n(ax, chains)
    ax.set_ylabel(f"{clock} (s)")
    return ax


def memory(ax, records):
    """Peak memory over n for the chains; the dotted line is the start.

    Parameters
    ----------
    ax : matplotlib Axes
        The axes to draw on.
    records : list of dict
        The records of benchmarks/results.json.

    Returns
    -------
    matplotlib Axes
        The same axes.
    """
    chains = pick(records, family="chain", status="right")
    if not _lines(ax, chains, None, "peak_mb"):
        return empty(ax)
    base = np.median([r["base_mb"] for r in chains if r["base_mb"]])
    ax.axhline(base, color=GREY, ls=":", lw=1)
    _axes_of_n(ax, chains)
    ax.set_ylabel("peak memory (MB)")
    return ax


def legend(where, records, columns=3, **placed):
    """The competitors' marks, outside below a figure or inside Axes.

    Parameters
    ----------
    where : matplotlib Figure or Axes
        What the legend belongs to.
    records : list of dict
        Those of benchmarks/results.json that were drawn.
    columns : int
        How many columns the legend has.
    **placed
        For matplotlib's ``legend``; outside below without it.

    Returns
    -------
    matplotlib Legend
        The legend.
    """
    handles = []
    for name in competitors(records):
        colour, marker = look_of(name)
        handles.append(
            Line2D([], [], color=colour, marker=marker, ls="", ms=5, label=name)
        )
    placed = placed or dict(loc="outside lower center")
    return where.legend(handles=handles, ncols=columns, **placed)


def competitors(records):
    """Names of those with an attempt in the records, in the order of `PEER_LOOKS`."""
    tried = dict.fromkeys(
        r["competitor"]
        for r in records
        if r["median_s"] or r["status"] in (*FAILED, "over the limit")
    )
    listed = [name for name in PEER_LOOKS if name in tried]
    return listed + [name for name in tried if name not in PEER_LOOKS]


def look_of(name):
    """Colour and marker of a competitor; those of its solver if it is new."""
    if name not in PEER_LOOKS and name.startswith("sosbook"):
        return PEER_LOOKS["sosbook"]
    if name not in PEER_LOOKS:
        solver = next((k for k in PEER_LOOKS if name.startswith(k + ",")), None)
        return PEER_LOOKS.get(solver, (INK, ">"))
    return PEER_LOOKS[name]


def mark(ax, x, y, r, hollow=False, ring=False, **more):
    """A competitor's mark; hollow, or with a ring around it."""
    colour, marker = look_of(r["competitor"])
    ax.plot(
        x,
        y,
        marker,
        color=colour,
        ms=8 if marker == "*" else 5.5,
        mfc="white" if hollow else colour,
        mec=INK if ring else colour,
        **more,
    )


def _has(records, competitor, clock):
    """Whether a competitor has this clock, as far as the records tell."""
    clocks = {
        r["clock"] for r in records if r["competitor"] == competitor and r["clock"]
    }
    return clock in clocks or not clocks


def _helped(r):
    """Whether a competitor was given sosbook's coordinates."""
    return r["coordinates"] == "frame" and not r["competitor"].startswith("sosbook")


def _settled(records):
    """Without failures that a second try, in other coordinates, replaced."""
    last = {(r["case"], r["competitor"]): r["coordinates"] for r in records}
    return [r for r in records if r["coordinates"] == last[r["case"], r["competitor"]]]


def _lines(ax, records, clock, field):
    """Lines over n; the largest value where there is more than one."""
    drawn = {}
    for name in competitors(records):
        points = {}
        for r in pick(records, competitor=name):
            if r[field] and clock in (None, r["clock"]):
                points[r["n"]] = max(r[field], points.get(r["n"], 0))
        if points:
            x = sorted(points)
            y = [points[n] for n in x]
            colour, marker = look_of(name)
            ax.plot(x, y, marker=marker, color=colour, ls="-", lw=1, ms=4)
            drawn[name] = x, y
    return drawn


def _axes_of_n(ax, records):
    ax.set_xscale("log")
    ax.set_yscale("log")
    sizes = sorted({r["n"] for r in records})
    labels = [
        str(n) if n == small or n > 1.5 * small else ""
        for small, n in zip(sizes[:1] + sizes, sizes)
    ]
    ax.set_xticks(sizes, labels)
    ax.minorticks_off()
    ax.margins(x=0.12)
    ax.set_xlabel("masses n")


def empty(ax, said="not in the file"):
    """Axes that say why they are empty."""
    ax.set_axis_off()
    ax.text(
        0.5, 0.5, said, ha="center", va="center", color=GREY, transform=ax.transAxes
    )
    return ax
