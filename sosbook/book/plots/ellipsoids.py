"""Shadows of ellipsoids."""

import numpy as np

from .style import BLUE, INK, SKY, VERMILLION, legend_above, subscript


def ellipsoid(ax, P, plane=(0, 1), x0=None, x=None, names=None):
    """Draw, on Axes ``ax``, the shadow of the ellipsoid x' P^-1 x <= 1 (Lemma 2.2) of
    ``P`` on a ``plane`` of two coordinates, with the start ``x0`` as a dot, the motion
    ``x``, (T, order), and the coordinates' ``names``.
    """
    i, j = plane
    outline = ellipse_outline(P, plane)
    ax.fill(*outline, fc=SKY, alpha=0.25, ec=BLUE, lw=1, label="x' P⁻¹ x ≤ 1")
    if x is not None:
        x = np.asarray(x)
        ax.plot(x[:, i], x[:, j], color=INK, ls="-", lw=1.1, label="x(t)")
    if x0 is not None:
        ax.plot(x0[i], x0[j], marker="o", ls="none", color=VERMILLION, label="x(0)")
    x_name, y_name = names or [f"x{subscript(k + 1)}" for k in plane]
    ax.set(xlabel=x_name, ylabel=y_name)
    legend_above(ax, 3)
    return ax


def ellipse_outline(P, plane=(0, 1), corners=120):
    """The outline, (2, ``corners``), of the shadow of x' P^-1 x <= 1 of ``P`` on a
    ``plane`` of two coordinates.
    """
    block = np.asarray(P, float)[np.ix_(plane, plane)]
    angle = 2 * np.pi * np.arange(corners) / corners
    return np.linalg.cholesky(block) @ np.array([np.cos(angle), np.sin(angle)])
