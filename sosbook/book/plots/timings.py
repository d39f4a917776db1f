"""Measured times as pictures, from the records of benchmarks/waiting.json.

A record is a dict; what its fields mean stands in the file. Every function
copes with records that are missing and with competitors that gave no right
answer: where there is no time, the picture says why.
"""

import numpy as np

from .peers import empty, mark, pick
from .style import BLUE, GREY, INK, ORANGE, VERMILLION

__all__ = ["pick", "seconds", "shares", "two", "verdicts", "words"]

SHARE_COLOURS = (("solver", BLUE), ("drawing", GREY))
LABEL_BOX = dict(fc="white", ec="none", pad=0.4)
UNITS = ((86400, "d"), (3600, "h"), (60, "min"), (1, "s"), (1e-3, "ms"), (1e-6, "µs"))


def words(seconds):
    """A time of some ``seconds`` in words with two digits, as 2.3 ms or 13 min."""
    unit_in_seconds, unit = next(
        (u for u in UNITS if seconds >= 0.9995 * u[0]), UNITS[-1]
    )
    return f"{two(seconds / unit_in_seconds)} {unit}"


def two(number):
    """A ``number`` with two digits, more before the point only if it must be."""
    return f"{number:.2g}" if number < 99.5 else f"{number:.0f}"


def seconds(ax, records, label="competitor"):
    """Draw, on Axes ``ax``, a row a record of benchmarks/waiting.json, ``records``,
    named by the field ``label``: its median, hollow where it was measured on a part.
    """
    if not records:
        return empty(ax)
    times = [r["median_s"] for r in records if r["median_s"]]
    if not times:
        return empty(ax)
    middle = np.sqrt(min(times) * max(times))
    for k, r in enumerate(records):
        x, said = r["median_s"], r["status"]
        scaled = r["measured"] is not None and r["measured"] < r["count"]
        if x:
            said = words(x) + (", scaled" if scaled else "")
            mark(ax, x, k, r["competitor"], hollow=scaled)
        place = x or min(times)
        far, side = (-7, "right") if place > middle else (7, "left")
        look = dict(va="center", ha=side, fontsize=8, bbox=LABEL_BOX)
        look |= dict(textcoords="offset points", color=INK if x else GREY)
        ax.annotate(said, (place, k), (far, 0), **look)
    ax.set(xscale="log", xlim=(min(times) / 3, max(times) * 3), xlabel="seconds")
    return _listed(ax, [r[label] for r in records])


def _listed(ax, names):
    """Axes with a name for each row, the first on top."""
    ax.set_yticks(range(len(names)), names)
    ax.set_ylim(len(names) - 0.4, -0.6)
    return ax


def shares(ax, records, limit=0.025):
    """Draw, on Axes ``ax``, slider moves of the ``records``, as long as their medians,
    split into solver and drawing: cold above, warm below; ``limit`` in s is a dashed
    line.
    """
    moves = pick(records, family="slider")
    if not moves:
        return empty(ax)
    cases = list(dict.fromkeys(r["case"] for r in moves))
    for r in moves:
        warm = "warm" in r["competitor"]
        y = cases.index(r["case"]) + (0.2 if warm else -0.2)
        parts = [r[f"share_{name}"] for name, _ in SHARE_COLOURS]
        scale, end = 1e3 * r["median_s"] / sum(parts), 0
        for (_, colour), part in zip(SHARE_COLOURS, parts):
            ax.barh(y, part * scale, 0.36, end, color=colour, ec="white", lw=0.4)
            end += part * scale
        said = " warm" if warm else " cold"
        ax.text(end, y, said, va="center", fontsize=7, bbox=LABEL_BOX)
    for name, colour in SHARE_COLOURS:
        ax.barh(0, 0, color=colour, label=name)
    ax.axvline(1e3 * limit, color=VERMILLION, ls="--", label=f"{1e3 * limit:.0f} ms")
    ax.set_xlim(0, 1.12 * max(1e3 * limit, *(1e3 * r["median_s"] for r in moves)))
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("milliseconds of a move, median")
    return _listed(ax, cases)


def verdicts(ax, counts):
    """Stacked bars of random requests: what was known, what was answered.

    ``ax``: the axes to draw on; ``counts``: how many there are of each "kind, known
    verdict: answer".
    """
    if not counts:
        return empty(ax, "robustness.json isn't there")
    colours = {"feasible": BLUE, "infeasible": ORANGE, "undecided": GREY}
    rows = {}
    for key, count in counts.items():
        kind, answer = key.rsplit(": ", 1)
        rows.setdefault(kind, {})[answer] = count
    shown = list(colours) + sorted(
        {a for row in rows.values() for a in row} - set(colours)
    )
    ends = dict.fromkeys(rows, 0)
    for answer in shown:
        look = dict(color=colours.get(answer, VERMILLION), ec="white")
        look |= dict(hatch="////" if answer == "infeasible" else None)
        for k, (kind, row) in enumerate(rows.items()):
            count = row.get(answer, 0)
            ax.barh(k, count, 0.7, ends[kind], lw=0.5, **look)
            ends[kind] += count
        ax.barh(0, 0, label=answer, **look)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("requests")
    return _listed(ax, list(rows))
