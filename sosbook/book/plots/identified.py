"""A machine that was identified: its log, its fit and its frequency response."""

import numpy as np
from scipy.signal import csd

from ...analysis.moved import matrices
from .style import BLUE, GREY, VERMILLION, legend_above

POINTS = 120  # frequencies of a curve


def identified(axes, found, family=None, sensor=0, input=0):
    """Draw, on two Axes ``axes``, what a ``sensor`` said in the log of an
    `Identification` ``found`` beside what is modelled, and how large its response to an
    ``input`` is over frequency: the log's own (the ratio of its spectra, in windows of
    half of it) and the plant's, with a band of the vertices of a ``family``.
    """
    record, (top, ax) = found.record, axes
    y, u = record.y[:, sensor], record.u[:, input]
    keep = slice(None, None, max(1, len(y) // 200))
    look = dict(color=GREY, ls="none", marker=".", ms=3)
    top.plot(record.t[keep], y[keep], **look, label="the log")
    top.plot(record.t[keep], found.modelled[keep, sensor], color=BLUE, label="the fit")
    top.set(xlabel="time t (s)", ylabel=record.outputs[sensor])
    legend_above(top, 2)
    how = dict(fs=1 / record.T, nperseg=len(y) // 2, detrend="linear")
    hertz, power = csd(u, u, **how)
    seen = (power.real > 0.05 * power.real.max()) & (hertz > 0)
    ratio = abs(csd(u, y, **how)[1][seen] / power[seen])
    omega = 2 * np.pi * hertz[seen]
    ax.plot(omega, ratio, **look, label="the log")
    points = np.geomspace(omega[0], omega[-1], POINTS)
    if family is not None:
        sizes = [_size(v, found, points)[:, sensor, input] for v in family.vertices]
        band = dict(fc=(VERMILLION, 0.3), ec=VERMILLION, lw=1, label="the family")
        ax.fill_between(points, np.min(sizes, axis=0), np.max(sizes, axis=0), **band)
    size = _size(found.plant, found, points)[:, sensor, input]
    ax.plot(points, size, color=BLUE, label="the fit")
    ax.set(xscale="log", yscale="log", xlabel="frequency ω (rad/s)")
    ax.set_ylabel(f"{record.outputs[sensor]} by {record.inputs[input]}")
    legend_above(ax, 3)
    return axes


def _size(plant, found, omega):
    A, B, C, D = matrices(plant, found.outputs)
    poles = 1j * omega[:, None, None] * np.eye(len(A)) - A
    return abs(
        C @ np.linalg.solve(poles, np.broadcast_to(B, (len(omega), *B.shape))) + D
    )
