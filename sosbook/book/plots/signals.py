"""Responses of a loop."""

import numpy as np

from ...runtime.libraries import library
from .style import COLOURS, DASHES, GREY, LIMIT, SPAN, legend_above, subscript

plt = library("matplotlib.pyplot")


LABELS = {
    "z": "position z",
    "dz": "velocity z′ (1/s)",
    "e": "error e = z − r",
    "u": "input u",
}


def response(response, u_max=None):
    """A figure of z, z', e and u over time, a panel each, of a ``response`` of
    `Design.simulate`; ``u_max`` draws its limit and the norm of u.
    """
    figure, axes = plt.subplots(2, 2, sharex=True, figsize=(6.8, 4.6))
    for ax, (key, label) in zip(axes.flat, LABELS.items()):
        name = "z′" if key == "dz" else key
        signal(ax, response.t, getattr(response, key), name=name)
        if key == "u" and u_max is not None:
            input_limit(ax, response.t, response.u, u_max)
        ax.set_ylabel(label)
        legend_above(ax, 5)
    for ax in axes[-1]:
        ax.set_xlabel("time t (s)")
    return figure


def signal(ax, t, values, name="z", disturbance=None, points=400):
    """Draw the rows of the values of a signal over t on the axes ax.

    The ``name`` stands at the axis; ``disturbance`` shades a window of time;
    no line has more than ``points`` points.
    """
    t, values = np.asarray(t), _rows(t, values)
    step = max(1, len(t) // points)
    keep = np.unique(np.r_[np.arange(0, len(t), step), len(t) - 1])
    if disturbance is not None:
        ax.axvspan(*disturbance, **SPAN, label="disturbance")
    for k, row in enumerate(values):
        mark = subscript(k + 1) if len(values) > 1 else ""
        label = name.rstrip("′") + mark + "′" * name.endswith("′")
        look = dict(color=COLOURS[k % 6], ls=DASHES[k % 6])
        ax.plot(t[keep], row[keep], label=label, **look)
    ax.margins(x=0)
    return ax


def input_limit(ax, t, u, u_max):
    """Draw the norm of u(t) and the limit u_max of Lemma 2.2 on the axes ax."""
    norm = np.linalg.norm(_rows(t, u), axis=0)
    step = max(1, len(t) // 400)
    ax.plot(np.asarray(t)[::step], norm[::step], color=GREY, ls="-", lw=1, label="‖u‖")
    ax.axhline(u_max, **LIMIT, lw=1.4, label="u_max")
    return ax


def _rows(t, values):
    """A signal as (channels, times), the layout of `Response`."""
    values = np.atleast_2d(values)
    if values.shape[1] != len(t):
        raise ValueError(
            f"values has shape {values.shape}, needs one row a channel and "
            f"one column for each of the {len(t)} times"
        )
    return values
