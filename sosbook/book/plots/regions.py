"""Poles and the regions in which they must lie."""

import numpy as np

from ...display.outline import region_outline, region_parts, window_of
from ...runtime.libraries import library
from .style import COLOURS, GREEN, GREY, MARKERS, legend_above

plt = library("matplotlib.pyplot")


__all__ = [
    "pole_map",
    "poles",
    "region_outline",
    "region_parts",
    "shade_region",
    "window_of",
]


def shade_region(ax, region, window):
    """Shade a D-region on the axes ax within a window (left, right, height)."""
    outline = region_outline(region, window)
    if outline.size:
        ax.fill(outline.real, outline.imag, fc=GREEN, alpha=0.18, ec="none", zorder=1)
        ax.plot([], [], color=GREEN, alpha=0.4, lw=7, ls="-", label="D-region")
    return ax


def draw_axes(ax, region, window):
    """Draw both axes of the complex plane on ax, over a region shaded in a window."""
    if region is not None:
        shade_region(ax, region, window)
    cross(ax)


def cross(ax):
    """Draw both axes of the complex plane on ax, and name them."""
    for line in (ax.axhline, ax.axvline):
        line(0, color=GREY, lw=0.7, ls="-", zorder=1.5)
    ax.set(xlabel="Re s (1/s)", ylabel="Im s (rad/s)")


def frame_plane(ax, window):
    """Limit ax to a window (left, right, height) of the complex plane."""
    left, right, height = window
    ax.set(xlim=(left, right), ylim=(-height, height))
    ax.set_aspect("equal", adjustable="box")


def poles(ax, poles, region=None, window=None, label="closed loop"):
    """Draw, on Axes ``ax``, ``poles``, of any shape, or of several loops in a dict by
    label, over the shaded ``region`` that was asked. ``window`` is (left, right,
    height) of the plane, else all is shown; ``label`` is for the legend.
    """
    sets = dict(poles) if isinstance(poles, dict) else {label: poles}
    window = window or window_of(list(sets.values()), region)
    draw_axes(ax, region, window)
    order = (1, 0) if len(sets) == 2 else range(len(sets))
    for (name, values), k in zip(sets.items(), order):
        values = np.ravel(np.asarray(values, complex))
        marker, colour = MARKERS[k % 6], COLOURS[k % 6]
        look = dict(ls="none", marker=marker, color=colour, ms=6, mew=1.4, zorder=3)
        look |= {} if marker in "x+" else {"mfc": "none"}
        ax.plot(values.real, values.imag, label=name, **look)
    frame_plane(ax, window)
    legend_above(ax, len(sets) + (region is not None))
    return ax


def pole_map(places, region=None):
    """A figure of its own for `poles`: takes ``places`` and a region as it does."""
    figure, ax = plt.subplots(figsize=(4.6, 4.4))
    poles(ax, places, region)
    return figure
