"""Parts of a mechanism's drawing: masses, springs, dampers, joints, forces.

Each function draws one part into equal Axes; a chapter joins them.
"""

import numpy as np

from .style import BLUE, GREY, INK, SKY, VERMILLION

CENTRED = {"ha": "center", "va": "center"}

__all__ = [
    "angle",
    "canvas",
    "damper",
    "displacement",
    "force",
    "joint",
    "mass",
    "rod",
    "spring",
    "sway",
    "wall",
    "wheel",
]


def canvas(ax, width, height):
    """Make the axes ax bare and equal, from (0, 0) to (width, height)."""
    ax.set(xlim=(0, width), ylim=(0, height), aspect="equal")
    ax.set_axis_off()
    return ax


def sway(ax, places, axis=0):
    """Let what is drawn on ax swing and come to rest where a page shows it.

    ``places``: pairs of a place and its displacement there at first, between which
    parts are stretched; bodies lie between two places that move alike; ``axis``: 0
    along x, 1 along y. Put it last: `output.show` asks for it.
    """
    ax.sway = np.asarray(places, float), axis


def mass(ax, centre, text, size=(1.6, 0.8), weightless=False):
    """A box of a size around ``centre`` on ax, with a text in it.

    It is dashed and empty if it is weightless.
    """
    (x, y), (w, h) = centre, size
    corners = x + w * np.array([-1, 1, 1, -1]) / 2, y + h * np.array([-1, -1, 1, 1]) / 2
    look = dict(fc=SKY, ls="-", alpha=0.55)
    if weightless:
        look = dict(fc="white", ls="--", alpha=1.0)
    ax.fill(*corners, ec=INK, lw=1.2, zorder=2, **look)
    ax.text(x, y, text, **CENTRED, zorder=3)


def spring(ax, start, end, text="", coils=5, width=0.16):
    """A zigzag of so many coils and a width, from ``start`` to ``end``.

    It is drawn on ax, with a text beside it.
    """
    along = np.r_[
        0, 0.18, 0.18 + 0.64 * (np.arange(2 * coils) + 0.5) / (2 * coils), 0.82, 1
    ]
    across = np.r_[0, 0, np.resize([1, -1], 2 * coils), 0, 0] * width
    _stroke(ax, start, end, along, across)
    _label(ax, start, end, text, width)


def damper(ax, start, end, text="", width=0.16):
    """A dashpot of a width from ``start`` to ``end``: a piston in an open cup.

    It is drawn on ax, with a text beside it.
    """
    nan = np.nan
    along = [0, 0.35, nan, 0.7, 0.35, 0.35, 0.7, nan, 0.55, 0.55, nan, 0.55, 1]
    across = np.array([0, 0, nan, -1, -1, 1, 1, nan, -0.75, 0.75, nan, 0, 0]) * width
    _stroke(ax, start, end, np.array(along), across)
    _label(ax, start, end, text, width)


def wall(ax, start, end):
    """A fixed line on ax, hatched on its right as seen from ``start`` to ``end``."""
    _stroke(ax, start, end, np.array([0, 1]), np.zeros(2))
    marks = np.linspace(0.04, 0.96, 12)
    along = np.c_[marks, marks - 0.03, np.full(12, np.nan)].ravel()
    across = np.tile([0, -0.14, np.nan], 12)
    _stroke(ax, start, end, along, across, GREY)


def force(ax, tip, vector, text, colour=VERMILLION):
    """An arrow of the given vector that ends in ``tip``, with its text.

    It is drawn on ax in one colour.
    """
    tail = np.subtract(tip, vector)
    _head(ax, tip, tail, colour)
    away = tail - 0.22 * np.asarray(vector) / np.linalg.norm(vector)
    ax.text(*away, text, color=colour, **CENTRED)


def displacement(ax, tail, vector, text):
    """An arrow, a ``vector``, that starts at ``tail``: a coordinate's direction.

    It is drawn on ax, with a text beside it.
    """
    force(ax, np.add(tail, vector), vector, "", BLUE)
    away = np.add(tail, vector) + 0.25 * np.asarray(vector) / np.linalg.norm(vector)
    ax.text(*away, text, color=BLUE, **CENTRED)


def _head(ax, tip, tail, colour):
    """An arrow from its tail to its tip."""
    look = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", tip, tail, zorder=4, arrowprops=look)


def _stroke(ax, start, end, along, across, colour=INK):
    start, way = np.asarray(start, float), np.subtract(end, start)
    normal = np.array([-way[1], way[0]]) / np.linalg.norm(way)
    x, y = start[:, None] + np.outer(way, along) + np.outer(normal, across)
    ax.plot(x, y, color=colour, ls="-", lw=1.2, solid_joinstyle="round", zorder=1)


def _label(ax, start, end, text, width):
    way = np.subtract(end, start)
    normal = np.array([-way[1], way[0]]) / np.linalg.norm(way)
    middle = np.add(start, end) / 2 + normal * (width + 0.22)
    ax.text(*middle, text, **CENTRED)


def joint(ax, centre, radius=0.12):
    """A hinge: a ring of a radius around ``centre`` on ax."""
    disc(ax, centre, (radius, radius), "white", zorder=4)


def wheel(ax, centre, radius=0.22):
    """A wheel of a radius around ``centre`` on ax, with its axle."""
    disc(ax, centre, (radius, radius), "white", zorder=3)
    ax.plot(*centre, ".", color=INK, ms=3, zorder=4)


def rod(ax, start, end, width=5):
    """A stiff link on ax from ``start`` to ``end``, of a line width in points."""
    look = dict(color=GREY, ls="-", lw=width, solid_capstyle="round", zorder=2)
    ax.plot(*np.transpose([start, end]), **look)


def angle(ax, centre, radius, between, text, colour=BLUE):
    """A bent arrow on ax around ``centre``: an angle, or a turning force.

    It has a radius and runs ``between`` two directions in degrees,
    counterclockwise if the second one is larger; its text and colour are given.
    """
    turn = np.radians(np.linspace(*between, 40))
    x, y = centre[0] + radius * np.cos(turn), centre[1] + radius * np.sin(turn)
    ax.plot(x[:-3], y[:-3], color=colour, ls="-", lw=1.2, zorder=4)
    _head(ax, (x[-1], y[-1]), (x[-4], y[-4]), colour)
    far, middle = 1 + 0.25 / radius, np.radians(np.mean(between))
    u = centre[0] + far * radius * np.cos(middle)
    v = centre[1] + far * radius * np.sin(middle)
    ax.text(u, v, text, color=colour, **CENTRED)


def disc(ax, centre, axes, colour, zorder, alpha=1.0, corners=41):
    """An ellipse on ax with a centre and half-axes, filled with a colour."""
    turn = np.linspace(0, 2 * np.pi, corners)
    x, y = centre[0] + axes[0] * np.cos(turn), centre[1] + axes[1] * np.sin(turn)
    ax.fill(x, y, fc=colour, ec=INK, ls="-", lw=1.2, alpha=alpha, zorder=zorder)
