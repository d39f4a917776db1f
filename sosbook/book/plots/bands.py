"""Figures over a set of plants: envelopes of signals, tracks of poles.

A polytope isn't a curve but a bundle of them. `envelope` shades what a signal
can do from one plant to the next, `pole_cloud` follows each pole while a
parameter moves.
"""

import numpy as np
from scipy.optimize import linear_sum_assignment

from .regions import draw_axes, frame_plane, window_of
from .style import BLUE, INK, VERMILLION, legend_above


def envelope(ax, t, signals, name="", middle=None, colour=BLUE, points=200):
    """Shade, on Axes ``ax``, the envelope of the ``signals``, (plants, k), of several
    plants at times ``t`` in s; ``name`` is for the legend, ``middle`` a row that is
    drawn as a line, ``colour`` theirs, ``points`` about how many times are drawn.
    Raises ValueError without a plant or where rows don't fit to the times.

    >>> import matplotlib.pyplot as plt
    >>> figure, ax = plt.subplots()
    >>> ax = envelope(ax, [0, 1, 2], [[0, 1, 1], [0, 2, 1]], "z")
    >>> ax.collections[0].get_datalim(ax.transData).intervaly
    array([0., 2.])
    >>> plt.close(figure)
    """
    t, signals = np.asarray(t, float), np.atleast_2d(signals)
    if not signals.size or signals.ndim != 2 or signals.shape[1] != len(t):
        raise ValueError(
            f"signals has shape {signals.shape}, needs a row for each plant "
            f"and a column for each of the {len(t)} times"
        )
    step = max(1, len(t) // points)
    keep = np.unique(np.r_[np.arange(0, len(t), step), len(t) - 1])
    low, high = signals.min(axis=0)[keep], signals.max(axis=0)[keep]
    ax.fill_between(  # with edges: a band without width is a line
        t[keep], low, high, fc=(colour, 0.3), ec=colour, lw=1, label=name
    )
    if middle is not None:
        ax.plot(t[keep], signals[middle][keep], color=colour, ls="-", lw=1.1)
    ax.margins(x=0)
    return ax


def frequency_band(axes, beside):
    """Draw, on two Axes, the sizes and phases of a measured response ``beside`` those
    of plants: the band of these, and the points; those outside of it are crosses.

    >>> import matplotlib.pyplot as plt
    >>> from sosbook.plants import MeasuredResponse, Polytope, SecondOrderSystem
    >>> omega = np.array([1.0, 2.0])
    >>> seen = MeasuredResponse(omega, 1 / (6 - omega**2 + [1j, 4j]))
    >>> plants = Polytope([SecondOrderSystem(1, 1, k, 1) for k in (5, 7)])
    >>> figure, axes = plt.subplots(2)
    >>> axes = frequency_band(axes, seen.beside(plants))
    >>> [len(points.get_xdata()) for points in axes[0].lines]
    [1, 1]
    >>> plt.close(figure)
    """
    omega, inside = beside.measured.omega, beside.inside
    sizes = [20 * np.log10(abs(x)) for x in (beside.measured.H, beside.plants)]
    parts = (
        (*sizes, "size in dB"),
        (*map(np.degrees, beside.angles), "phase in degrees"),
    )
    for ax, (points, band, label) in zip(axes, parts):
        envelope(ax, omega, band, "the plants", points=len(omega))
        for mask, marker, colour, name in (
            (inside, "o", INK, "measured"),
            (~inside, "x", VERMILLION, "outside"),
        ):
            ax.plot(omega[mask], points[mask], marker, ms=4, color=colour, label=name)
        ax.set(xscale="log", ylabel=label)
    axes[-1].set_xlabel("frequency in rad/s")
    legend_above(axes[0], 3)
    return axes


def track_poles(poles):
    """Order each row of poles so that a column follows one pole.

    ``poles``, (count, N): a row for each value of a parameter, in its order. Returns
    (count, N) array of complex: the same rows, each permuted to be nearest to the row
    before.

    >>> track_poles([[-1, -3], [-2.9, -1.1]]).real
    array([[-1. , -3. ],
           [-1.1, -2.9]])
    """
    rows = np.array(poles, complex)
    if rows.ndim != 2 or not rows.size:
        raise ValueError("poles must have a row for each parameter value")
    largest = np.abs(rows).max() or 1.0
    for before, row in zip(rows, rows[1:]):
        x, y = before[:, None], row[None, :]
        # a pair that meets on the real axis could part either way
        tie = x.imag * y.real + x.real * y.imag
        distance = np.abs(x - y) + 1e-6 * tie / largest
        row[:] = row[linear_sum_assignment(distance)[1]]
    return rows


def pole_cloud(ax, poles, values, region=None, window=None, name="value"):
    """Draw, on Axes ``ax``, the ``poles``, (count, N) in rad/s, over the rising
    ``values`` of a parameter with a ``name``, over the shaded ``region``. ``window`` is
    (left, right, height) of the plane, else all is shown. Raises ValueError if poles
    hasn't a row for each value.

    >>> import matplotlib.pyplot as plt
    >>> figure, ax = plt.subplots()
    >>> ax = pole_cloud(ax, [[-1, -3], [-2, -4]], [70, 120], name="m")
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['m = 70', 'm = 120']
    >>> plt.close(figure)
    """
    rows, values = track_poles(poles), np.asarray(values, float)
    if values.shape != (len(rows),):
        raise ValueError(
            f"values has shape {values.shape}, needs one for each of the "
            f"{len(rows)} rows of poles"
        )
    window = window or window_of([rows], region)
    draw_axes(ax, region, window)
    line = dict(color=BLUE, ls="-", lw=2, alpha=0.6, zorder=2.5)
    for branch in rows.T:
        ax.plot(branch.real, branch.imag, **line)
    ends = ((0, "o", "none", BLUE), (-1, "x", VERMILLION, VERMILLION))
    for k, marker, face, edge in ends:
        look = dict(ls="none", marker=marker, mfc=face, mec=edge, ms=5.5, mew=1.3)
        label = f"{name} = {values[k]:g}"
        ax.plot(rows[k].real, rows[k].imag, **look, zorder=3, label=label)
    frame_plane(ax, window)
    legend_above(ax, 3)
    return ax
