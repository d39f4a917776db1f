"""Measured times as pictures, from the records of benchmarks/results.json.

A record is a dict; what its fields mean stands in the file. Every function
copes with records that are missing and with competitors that gave no right
answer: where there is no time, the picture says why.
"""

import numpy as np
from matplotlib.lines import Line2D

from .style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, SKY, VERMILLION

__all__ = [
    "competitors",
    "growth",
    "legend",
    "memory",
    "pick",
    "ratios",
    "seconds",
    "shares",
    "two",
    "verdicts",
    "words",
]

LOOKS = {  # one colour a solver, one marker a competitor
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
PARTS = (("solver", BLUE), ("simulation", ORANGE), ("drawing", GREY))
PAPER = dict(facecolor="white", edgecolor="none", pad=0.4)
UNITS = ((86400, "d"), (3600, "h"), (60, "min"), (1, "s"), (1e-3, "ms"),
         (1e-6, "µs"))


def pick(records, **wanted):
    """Records whose fields have the wanted values.

    Parameters
    ----------
    records : list of dict
    **wanted
        A value, or a tuple of values, for each field.

    Examples
    --------
    >>> pick([{"n": 2}, {"n": 4}, {"n": 8}], n=(2, 8))
    [{'n': 2}, {'n': 8}]
    """
    def allowed(value, choice):
        return value in choice if isinstance(choice, tuple) else value == choice

    return [r for r in records if all(
        allowed(r[field], choice) for field, choice in wanted.items())]


def words(seconds):
    """A time in words, with two digits.

    Examples
    --------
    >>> [words(s) for s in (0.00231, 3, 754, 200_000)]
    ['2.3 ms', '3 s', '13 min', '2.3 d']
    """
    size, unit = next(
        (u for u in UNITS if seconds >= 0.9995 * u[0]), UNITS[-1])
    return f"{two(seconds / size)} {unit}"


def two(number):
    """A number with two digits, more before the point only if it must be.

    Examples
    --------
    >>> [two(x) for x in (0.0318, 1, 6.84, 143.2)]
    ['0.032', '1', '6.8', '143']
    """
    return f"{number:.2g}" if number < 99.5 else f"{number:.0f}"


def ratios(ax, records, clock):
    """A row of dots for each case: median time over sosbook's.

    An arrow starts at the least ratio of a call that went over its limit.
    Open marks on the right have no time: the answer was wrong, or there
    was none. A ring means that the competitor was given sosbook's
    coordinates, because it failed in the plant's own.

    Parameters
    ----------
    ax : matplotlib Axes
    records : list of dict
    clock : {"end to end", "solve only"}
    """
    peers = competitors(records)
    cases = list(dict.fromkeys(r["case"] for r in records))
    lift = dict(zip(peers, np.linspace(-0.32, 0.32, max(2, len(peers)))))
    ours = {r["case"]: r["median_s"] for r in pick(
        records, competitor="sosbook", clock=clock)}
    seen, failed, late = [], {}, []
    for r in _settled(records):
        y = cases.index(r["case"]) + lift[r["competitor"]]
        if r["clock"] == clock and r["ratio"]:
            _mark(ax, r["ratio"], y, r, ring=_helped(r))
            seen.append(r["ratio"])
        elif r["clock"] is None and _has(records, r["competitor"], clock):
            if r["status"] == "over the limit" and ours.get(r["case"]):
                late.append((r["limit_s"] / ours[r["case"]], y, r))
            elif r["status"] in FAILED:
                place = failed[r["case"]] = failed.get(r["case"], 0) + 1
                _mark(ax, 1 + 0.045 * place, y, r, hollow=True, clip_on=False,
                      transform=ax.get_yaxis_transform())
    for x, y, r in late:
        _mark(ax, x, y, r, hollow=True)
        ax.annotate("", (x * 3, y), (x * 1.2, y), arrowprops=dict(
            arrowstyle="->", color=_look(r["competitor"])[0], shrinkA=0,
            shrinkB=0))
    if not seen:
        return _empty(ax)
    bounds = [x for x, *_ in late]
    ax.set_xscale("log")
    ax.set_xlim(min(seen) / 2, max(seen + [3 * b for b in bounds]) * 2)
    ax.axvline(1, color=BLUE, lw=1, ls="-", zorder=0)
    for k in range(len(cases) - 1):
        ax.axhline(k + 0.5, color="#e3e5e8", lw=0.6, ls="-", zorder=0)
    if failed:
        ax.text(1.02, 1.005, "wrong,\nnone", transform=ax.transAxes, fontsize=7,
                va="bottom")
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
    records : list of dict
    clock : {"end to end", "solve only"}
    """
    found = pick(records, family="chain")
    if not _lines(ax, found, clock, "median_s"):
        return _empty(ax)
    late, failed = {}, {}
    for r in _settled(found):
        if not _has(found, r["competitor"], clock):
            continue
        if r["status"] == "over the limit":
            place = late[r["n"]] = late.get(r["n"], 0) + 1
            _mark(ax, r["n"], r["limit_s"] * 1.7**place, r, hollow=True)
        elif r["status"] in FAILED:
            place = failed[r["n"]] = failed.get(r["n"], 0) + 1
            _mark(ax, r["n"], 0.05 * place - 0.02, r, hollow=True,
                  transform=ax.get_xaxis_transform())
    _axes_of_n(ax, found)
    ax.set_ylabel(f"{clock} (s)")
    return ax


def memory(ax, records):
    """Peak memory over n for the chains; the dotted line is the start."""
    found = pick(records, family="chain", status="right")
    if not _lines(ax, found, None, "peak_mb"):
        return _empty(ax)
    base = np.median([r["base_mb"] for r in found if r["base_mb"]])
    ax.axhline(base, color=GREY, ls=":", lw=1)
    _axes_of_n(ax, found)
    ax.set_ylabel("peak memory (MB)")
    return ax


def seconds(ax, records, label="competitor"):
    """One row a record: its median on a log axis, and in words.

    Hollow marks were measured on a part and scaled up.

    Parameters
    ----------
    label : str
        The field that names a row.
    """
    if not records:
        return _empty(ax)
    times = [r["median_s"] for r in records if r["median_s"]]
    ends = [r["limit_s"] for r in records
            if r["status"] == "over the limit" and r.get("limit_s")]
    known = times + ends or [1.0]
    middle = np.sqrt(min(known) * max(known))
    for k, r in enumerate(records):
        x, said = r["median_s"], r["status"]
        scaled = r["measured"] is not None and r["measured"] < r["count"]
        if x:
            said = words(x) + (", scaled" if scaled else "")
            _mark(ax, x, k, r, hollow=scaled)
        elif r["status"] == "over the limit":
            x, said = r["limit_s"], f"over {words(r['limit_s'])}"
            _mark(ax, x, k, r, hollow=True)
        place = x or min(known)
        left = place > middle
        ax.annotate(said, (place, k), (-7 if left else 7, 0), va="center",
                    textcoords="offset points", fontsize=8,
                    ha="right" if left else "left", bbox=PAPER,
                    color=INK if x else GREY)
    ax.set_xscale("log")
    ax.set_xlim(min(known) / 3, max(known) * 3)
    ax.set_yticks(range(len(records)), [r[label] for r in records])
    ax.set_ylim(len(records) - 0.4, -0.6)
    ax.set_xlabel("seconds")
    return ax


def shares(ax, records, limit=0.025):
    """Stacked bars of slider moves: solver, simulation, drawing.

    For each case the upper bar starts cold, the lower one warm. The median
    shares are scaled so that a bar is as long as the median move.

    Parameters
    ----------
    limit : float
        Seconds; a dashed line.
    """
    found = pick(records, family="slider")
    if not found:
        return _empty(ax)
    cases = list(dict.fromkeys(r["case"] for r in found))
    for r in found:
        warm = "warm" in r["competitor"]
        y = cases.index(r["case"]) + (0.2 if warm else -0.2)
        parts = [r[f"share_{name}"] for name, _ in PARTS]
        scale, left = 1e3 * r["median_s"] / sum(parts), 0
        for (_, colour), part in zip(PARTS, parts):
            ax.barh(y, part * scale, 0.36, left, color=colour,
                    edgecolor="white", lw=0.4)
            left += part * scale
        ax.text(left, y, " warm" if warm else " cold", va="center", fontsize=7,
                bbox=PAPER)
    for name, colour in PARTS:
        ax.barh(0, 0, color=colour, label=name)
    ax.axvline(1e3 * limit, color=VERMILLION, ls="--",
               label=f"{1e3 * limit:.0f} ms")
    ax.set_yticks(range(len(cases)), cases)
    ax.set_ylim(len(cases) - 0.4, -0.6)
    ax.set_xlim(0, 1.12 * max(1e3 * limit, *(
        1e3 * r["median_s"] for r in found)))
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("milliseconds of a move, median")
    return ax


def verdicts(ax, counts):
    """Stacked bars of random requests: what was known, what was answered.

    Parameters
    ----------
    counts : dict
        From "kind, known verdict: answer" to how many.
    """
    if not counts:
        return _empty(ax, "robustness.json isn't there")
    colours = {"feasible": BLUE, "infeasible": ORANGE, "undecided": GREY}
    rows = {}
    for key, number in counts.items():
        kind, answer = key.rsplit(": ", 1)
        rows.setdefault(kind, {})[answer] = number
    shown = list(colours) + sorted(
        {a for row in rows.values() for a in row} - set(colours))
    left = dict.fromkeys(rows, 0)
    for answer in shown:
        for k, (kind, row) in enumerate(rows.items()):
            number = row.get(answer, 0)
            ax.barh(k, number, 0.7, left[kind], edgecolor="white", lw=0.5,
                    color=colours.get(answer, VERMILLION),
                    hatch={"infeasible": "////"}.get(answer))
            left[kind] += number
        ax.barh(0, 0, color=colours.get(answer, VERMILLION), ec="white",
                hatch={"infeasible": "////"}.get(answer), label=answer)
    ax.set_yticks(range(len(rows)), list(rows))
    ax.set_ylim(len(rows) - 0.4, -0.6)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("requests")
    return ax


def legend(where, records, columns=3, **placed):
    """The competitors' marks, outside below a figure or inside Axes."""
    handles = []
    for name in competitors(records):
        colour, marker = _look(name)
        handles.append(Line2D([], [], color=colour, marker=marker, ls="",
                              ms=5, label=name))
    placed = placed or dict(loc="outside lower center")
    return where.legend(handles=handles, ncols=columns, **placed)


def competitors(records):
    """Names of those with an attempt, sosbook first; see `LOOKS`."""
    tried = dict.fromkeys(
        r["competitor"] for r in records
        if r["median_s"] or r["status"] in (*FAILED, "over the limit"))
    known = [name for name in LOOKS if name in tried]
    return known + [name for name in tried if name not in LOOKS]


def _look(name):
    if name not in LOOKS and name.startswith("sosbook"):
        return LOOKS["sosbook"]
    if name not in LOOKS:
        solver = next((k for k in LOOKS if name.startswith(k + ",")), None)
        return LOOKS.get(solver, (INK, ">"))
    return LOOKS[name]


def _mark(ax, x, y, r, hollow=False, ring=False, **more):
    """A competitor's mark; hollow, or with a ring around it."""
    colour, marker = _look(r["competitor"])
    ax.plot(x, y, marker, color=colour, ms=8 if marker == "*" else 5.5,
            mfc="white" if hollow else colour, mec=INK if ring else colour,
            **more)


def _has(records, competitor, clock):
    """Whether a competitor has this clock, as far as the records tell."""
    clocks = {r["clock"] for r in records
              if r["competitor"] == competitor and r["clock"]}
    return clock in clocks or not clocks


def _helped(r):
    """Whether a competitor was given sosbook's coordinates."""
    return r["coordinates"] == "frame" and not r["competitor"].startswith(
        "sosbook")


def _settled(records):
    """Without failures that a second try, in other coordinates, replaced."""
    last = {(r["case"], r["competitor"]): r["coordinates"] for r in records}
    return [r for r in records
            if r["coordinates"] == last[r["case"], r["competitor"]]]


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
            colour, marker = _look(name)
            ax.plot(x, y, marker=marker, color=colour, ls="-", lw=1, ms=4)
            drawn[name] = x, y
    return drawn


def _axes_of_n(ax, records):
    ax.set_xscale("log")
    ax.set_yscale("log")
    sizes = sorted({r["n"] for r in records})
    words = [str(n) if n == small or n > 1.5 * small else ""
             for small, n in zip(sizes[:1] + sizes, sizes)]
    ax.set_xticks(sizes, words)
    ax.minorticks_off()
    ax.margins(x=0.12)
    ax.set_xlabel("masses n")


def _empty(ax, said="not in the file"):
    ax.set_axis_off()
    ax.text(0.5, 0.5, said, ha="center", va="center", color=GREY,
            transform=ax.transAxes)
    return ax
