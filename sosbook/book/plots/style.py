"""Colours and matplotlib's defaults."""

from ...runtime.libraries import library

plt = library("matplotlib.pyplot")


BLUE, VERMILLION, GREEN, ORANGE = "#0072B2", "#D55E00", "#009E73", "#E69F00"
PURPLE, SKY, GREY, INK = "#CC79A7", "#56B4E9", "#767676", "#1f2328"
COLOURS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)
MARKERS = ("x", "o", "+", "s", "d", "^")
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)))
#: The looks of a bound's line, and of a span of time.
LIMIT = {"color": VERMILLION, "ls": (0, (1, 1))}
SPAN = {"color": ORANGE, "alpha": 0.15, "lw": 0}

STYLE = {
    "svg.fonttype": "path",
    "svg.hashsalt": "sosbook",
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "mathtext.fontset": "dejavusans",
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": GREY,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlesize": 9.0,
    "axes.prop_cycle": plt.cycler(color=COLOURS, linestyle=DASHES),
    "grid.color": "#e3e5e8",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.figsize": (6.8, 3.2),
    "figure.facecolor": "white",
    "axes.facecolor": "white",
    "figure.constrained_layout.use": True,
}


def use_book_style():
    """Set matplotlib's defaults to the book's: call it once, in the first cell. Text
    becomes paths, so a figure doesn't depend on a machine's fonts, and ids follow from
    a fixed salt.
    """
    plt.rcParams.update(STYLE)


def subscript(number):
    """A ``number`` or a label with its digits as subscripts: "z₁" for "z1"."""
    return str(number).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))


def legend_above(ax, columns):
    """A legend with so many columns over the axes ax, where it hides nothing."""
    if ax.get_legend_handles_labels()[0]:
        place = dict(loc="lower left", bbox_to_anchor=(0, 1.0), borderaxespad=0.2)
        room = dict(handlelength=1.8, columnspacing=0.9, handletextpad=0.5)
        ax.legend(**place, **room, ncols=columns)
