"""Characteristic roots, decay over the delay, and the delay over time."""

import numpy as np

from ...delay.spectrum import spectral_abscissa
from .regions import cross
from .style import BLUE, COLOURS, DASHES, GREY, LIMIT, MARKERS, SPAN, legend_above


def root_map(ax, roots, delta=None, label=None, colour=None):
    """Draw, on Axes ``ax``, characteristic ``roots`` in rad/s; call it again to
    compare. ``delta``, in 1/s, draws the line Re s = -delta; ``label`` is for the
    legend; ``colour`` and marker follow from how many sets are there.

    >>> import matplotlib.pyplot as plt
    >>> figure, ax = plt.subplots()
    >>> len(root_map(ax, [-1 + 2j, -1 - 2j], delta=0.5).collections)
    1
    >>> plt.close(figure)
    """
    roots = np.ravel(np.asarray(roots, complex))
    drawn = len(ax.collections)
    if not drawn:
        cross(ax)
    colour, marker = colour or COLOURS[drawn % 6], MARKERS[drawn % 6]
    hollow = {"facecolors": "none", "edgecolors": colour}
    face = {"c": colour} if marker in "x+" else hollow
    look = dict(s=26, marker=marker, linewidths=1.4, zorder=3, **face)
    ax.scatter(roots.real, roots.imag, label=label, **look)
    if delta is not None:
        ax.axvline(-delta, **LIMIT, label=f"Re s = {0 - delta:g}")
    legend_above(ax, 4)
    return ax


def decay_curve(ax, A, A_d, delays, interval=None, delta=None, label=None):
    """Draw, on Axes ``ax``, the spectral abscissa of x' = ``A`` x + ``A_d`` x(t - h)
    over increasing ``delays`` h in s. ``interval``, (low, high), is shaded, ``delta``
    draws the line of a decay rate in 1/s; ``label`` is for the legend.

    >>> import matplotlib.pyplot as plt
    >>> figure, ax = plt.subplots()
    >>> ax = decay_curve(ax, [[0]], [[-1]], [0, 1], interval=(0.2, 0.4))
    >>> ax.lines[-1].get_ydata().round(4)
    array([-1.    , -0.3181])
    >>> plt.close(figure)
    """
    drawn = sum(line.get_gid() == "curve" for line in ax.lines)
    values = [spectral_abscissa(A, A_d, h) for h in delays]
    if interval is not None:
        ax.axvspan(*interval, **SPAN, label="interval of delays")
    if not drawn:
        ax.axhline(0, color=GREY, lw=0.7, ls="-")
        ax.set(xlabel="constant delay h (s)", ylabel="rightmost Re s (1/s)")
    if delta is not None:
        ax.axhline(-delta, **LIMIT, label=f"−δ = {0 - delta:g}")
    look = dict(color=COLOURS[drawn % 6], ls=DASHES[drawn % 6], gid="curve")
    ax.plot(delays, values, label=label, **look)
    ax.margins(x=0)
    legend_above(ax, 4)
    return ax


def delay_signal(ax, delay, t_end):
    """Draw, on Axes ``ax``, a ``delay`` signal d(t), such as `SawtoothDelay`, up to
    ``t_end`` in s, its range shaded, with gaps at its jumps.

    >>> import matplotlib.pyplot as plt
    >>> from sosbook.delay import SwitchingDelay
    >>> figure, ax = plt.subplots()
    >>> ax = delay_signal(ax, SwitchingDelay(0.1, 0.3, dwell=1), t_end=2)
    >>> ax.lines[0].get_ydata()
    array([0.1, 0.1, nan, 0.3, 0.3])
    >>> plt.close(figure)
    """
    edges = np.r_[0.0, delay.jumps(t_end), t_end]
    turns = delay.rate * t_end / (2 * np.pi)
    count = int(np.ceil(40 * turns / (len(edges) - 1))) + 2
    t, d = [], []
    for start, end in zip(edges, edges[1:]):
        piece = np.linspace(start, end, count)
        inside = piece.clip(None, end - 1e-9 * (end - start))
        t += [*piece, end]
        d += [*delay(inside), np.nan]
    ax.axhspan(delay.low, delay.high, **SPAN)
    ax.plot(t[:-1], np.round(d[:-1], 8), color=BLUE, ls="-")
    ax.margins(x=0)
    ax.set(xlabel="time t (s)", ylabel="delay d (s)")
    return ax
