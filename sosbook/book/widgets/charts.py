"""Charts that several explorers draw: the complex plane, a step's response."""

import numpy as np

from ...display.outline import region_outline
from ..elements.chart import Chart
from ..plots import GREEN, GREY

__all__ = ["plane", "pole_chart", "set_point_chart"]


def plane(window, title, region=None, colour=GREEN, hatched=False, axis=False, **more):
    """A chart of the complex plane.

    Parameters
    ----------
    window : (left, right, height)
        The part that is shown, |Im s| <= height.
    title : str
        What a screen reader says.
    region : Region, optional
        Drawn in a ``colour``, tinted or hatched.
    colour : str
        The colour of the region.
    hatched : bool
        Whether the region is hatched.
    axis : bool
        Whether the imaginary axis is drawn.
    **more
        Keywords of `Chart`; a unit is as long on both axes without them.
    """
    left, right, height = window
    chart = Chart(
        (left, right),
        (-height, height),
        "Re s (1/s)",
        "Im s (rad/s)",
        title,
        **{"square": True} | more,
    )
    if region is not None:
        outline = region_outline(region, window)
        chart.polygon(outline.real, outline.imag, colour, hatched)
    if axis:
        chart.line([0, 0], [-height, height], GREY, True)
    return chart


def pole_chart(pole_sets, colours, left, title):
    """The plane right of ``left`` with one or two sets of poles, as SVG.

    Parameters
    ----------
    pole_sets : sequence of (k,) arrays
        The first set is drawn as circles, the second as crosses.
    colours : sequence of str
        The colour of each set.
    left : float
        The left end of the window, in 1/s; poles beyond it aren't seen.
    title : str
        What a screen reader says.
    """
    shown = np.concatenate(pole_sets)
    shown = shown[shown.real > left]
    right, height = max(2, *(1.2 * shown.real)), 1.2 * max(5, *abs(shown.imag))
    chart = plane((left, right, height), title, axis=True, square=False)
    for poles, colour, shape in zip(pole_sets, colours, ("circle", "cross")):
        chart.marks(poles.real, poles.imag, colour, shape)
    return chart.svg()


def set_point_chart(end, z):
    """An empty chart for responses to a unit set point.

    Parameters
    ----------
    end : float
        The last time, in seconds.
    z : array
        The responses that shall fit.
    """
    low, high = min(z.min(), 0.0), max(z.max(), 1.0)
    room = 0.06 * (high - low)
    chart = Chart(
        (0, end),
        (low - room, high + room),
        "t (s)",
        "z",
        "Response to a unit set point",
    )
    chart.line([0, end], [1, 1], GREY, dashed=True)
    return chart
