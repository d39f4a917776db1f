"""Competitors in pictures of measured times: their colours and marks."""

from ...runtime.libraries import library
from .style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, SKY, VERMILLION

Line2D = library("matplotlib.lines").Line2D

__all__ = ["competitors", "legend", "pick"]

#: One colour, dash and marker a competitor.
PEER_LOOKS = {
    "sosbook": (BLUE, "-", "o"),
    "clarabel": (VERMILLION, "--", "^"),
    "cvxpy + clarabel": (GREEN, "-.", "D"),
    "cvxpy + clarabel, DPP": (SKY, ":", "P"),
    "cvxopt": (PURPLE, (0, (5, 1, 1, 1, 1, 1)), "s"),
    "sdpa": (ORANGE, (0, (8, 2)), "v"),
    "scs": (INK, (0, (2, 2)), "<"),
}


def pick(records, **wanted):
    """Records whose fields have the wanted values.

    ``records``: the records of a file in the folder benchmarks; ``**wanted``: a value,
    or a tuple of values, for each field. Returns those that match, in their order.

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


def competitors(records):
    """Names of those in the records, in the order of `PEER_LOOKS`."""
    named = dict.fromkeys(r["competitor"] for r in records)
    listed = [name for name in PEER_LOOKS if name in named]
    return listed + [name for name in named if name not in PEER_LOOKS]


def legend(where, names, columns=4, **placed):
    """The competitors' lines and marks, outside below a figure or inside Axes.

    ``where``: what the legend belongs to; ``names``: of the competitors; ``columns``:
    how many columns the legend has; ``**placed``: for matplotlib's ``legend``; outside
    below without it. Returns the legend.
    """
    handles = []
    for name in names:
        colour, dash, marker = look_of(name)
        look = dict(color=colour, ls=dash, marker=marker, ms=4)
        handles.append(Line2D([], [], label=name, **look))
    placed = placed or dict(loc="outside lower center")
    return where.legend(handles=handles, ncols=columns, **placed)


def look_of(name):
    """Colour, dash and marker of a competitor; of its solver if it is new."""
    if name in PEER_LOOKS:
        return PEER_LOOKS[name]
    solver = next((k for k in PEER_LOOKS if name.startswith(k + ",")), None)
    return PEER_LOOKS.get(solver, (INK, "-", ">"))


def mark(ax, x, y, name, hollow=False):
    """A competitor's mark, perhaps hollow."""
    colour, _, marker = look_of(name)
    face = "white" if hollow else colour
    ax.plot(x, y, marker, color=colour, ms=5.5, mfc=face, ls="none")


def empty(ax, said="not in the file"):
    """Axes that say why they are empty."""
    ax.set_axis_off()
    ax.text(
        0.5, 0.5, said, ha="center", va="center", color=GREY, transform=ax.transAxes
    )
    return ax
