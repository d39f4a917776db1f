"""Singular values over frequency."""

import numpy as np

from .style import COLOURS, DASHES, LIMIT, legend_above


def singular_values(ax, systems, gamma=None):
    """Draw, on Axes ``ax``, the largest singular value over frequency of ``systems``,
    one StateSpace or a tuple of them for a polytope, from w to z: ``loop[:n, :p]`` of
    `Design.closed_loop`. ``gamma`` draws a bound.
    """
    systems = systems if isinstance(systems, (list, tuple)) else (systems,)
    moduli = np.abs(np.concatenate([system.poles() for system in systems]))
    frequency = np.geomspace(max(moduli.min(), 1e-3) / 20, moduli.max() * 10, 120)
    for k, system in enumerate(systems):
        matrices = system.A, system.B, system.C, system.D
        values = largest_singular_value(*matrices, frequency)
        label = "σ_max" if len(systems) == 1 else f"vertex {k + 1}"
        look = dict(color=COLOURS[k % 6], ls=DASHES[k % 6])
        ax.plot(frequency, values, label=label, **look)
    if gamma is not None:
        ax.axhline(gamma, **LIMIT, label="bound γ")
    ax.set(xscale="log", yscale="log")
    ax.set(xlabel="frequency ω (rad/s)", ylabel="largest singular value")
    legend_above(ax, 4)
    return ax


def largest_singular_value(A, B, C, D, frequency):
    """The largest singular value of ``C`` (jw I - ``A``)^-1 ``B`` + ``D`` at each w of
    ``frequency`` in rad/s.
    """
    A, B, C, D = (np.atleast_2d(np.asarray(X, float)) for X in (A, B, C, D))
    points = 1j * np.asarray(frequency, float)[:, None, None]
    inputs = np.broadcast_to(B, (len(points), *B.shape))
    gain = C @ np.linalg.solve(points * np.eye(len(A)) - A, inputs) + D
    return np.linalg.svd(gain, compute_uv=False)[:, 0]
