"""Poles and the regions in which they must lie."""

import matplotlib.pyplot as plt
import numpy as np

from .style import COLOURS, GREEN, GREY, MARKERS, legend_above

__all__ = [
    "pole_map",
    "poles",
    "region_outline",
    "region_parts",
    "shade_region",
    "window_of",
]


def region_outline(region, window=(-10.0, 2.0, 6.0), rays=360):
    """Corners of a polygon that traces a D-region within a window.

    A region f(z) = alpha + beta z + beta' conj(z) < 0 is convex and symmetric
    about the real axis.  From an interior point c the boundary along a
    direction d is where f(c) + t (f(c + d) - f(c)) becomes singular: one
    eigenvalue problem a ray, no search.

    Parameters
    ----------
    region : PoleRegion, LMIRegion or a sequence of LMIRegion
    window : (left, right, height)
        The part of the plane to trace, |Im s| <= height.
    rays : int
        Directions; the polygon has as many corners.

    Returns
    -------
    ndarray of complex, or an empty one if the region misses the window
    """
    left, right, height = window
    parts = region_parts(region)
    pairs = [(np.asarray(part.alpha, float), np.asarray(part.beta, float))
             for part in parts]
    one = np.ones((1, 1))
    pairs += [(left * one, -one / 2), (-right * one, one / 2),
              (np.diag([-height, -height]) + 0.0,
               np.array([[0, 1], [-1, 0]]) / 2)]

    def values(points):
        worst = []
        for alpha, beta in pairs:
            f = (alpha + beta * points[:, None, None]
                 + beta.T * points[:, None, None].conj())
            worst.append(np.linalg.eigvalsh(f)[:, -1]
                         / (np.linalg.norm(alpha) + np.linalg.norm(beta)))
        return np.max(worst, axis=0)

    a, b = left, right
    for _ in range(6):                           # convex along the real axis
        grid = np.linspace(a, b, 41)
        worst = values(grid + 0j)
        k = int(np.argmin(worst))
        a, b = grid[max(k - 1, 0)], grid[min(k + 1, 40)]
    if worst[k] >= -1e-9:
        return np.empty(0, complex)
    centre = grid[k]
    directions = np.exp(2j * np.pi * (np.arange(rays) + 0.5) / rays)
    reach = np.full(rays, np.inf)
    for alpha, beta in pairs:
        at_centre = alpha + centre * (beta + beta.T)
        root = np.linalg.inv(np.linalg.cholesky(-at_centre))
        slope = (beta * directions[:, None, None]
                 + beta.T * directions[:, None, None].conj())
        top = np.linalg.eigvalsh(root @ slope @ root.T)[:, -1]
        reach = np.minimum(reach, np.where(top > 1e-12, 1 / np.maximum(
            top, 1e-12), np.inf))
    return centre + reach * directions


def region_parts(region):
    """The LMI regions whose intersection `region` is; an empty tuple for None."""
    if region is None:
        return ()
    if hasattr(region, "parts"):
        return tuple(region.parts)
    return tuple(region) if isinstance(region, (list, tuple)) else (region,)


def window_of(poles, region=None):
    """A window (left, right, height) that shows the poles and the region.

    Examples
    --------
    >>> window_of([-1 + 1j, -1 - 1j])
    (-1.3, 0.325, 1.3)
    """
    points = np.concatenate([np.ravel(np.asarray(p, complex)) for p in poles]
                            ) if len(poles) else np.array([-1 + 1j])
    points = points[np.isfinite(points)]
    far = max(np.max(np.abs(points.real)), np.max(np.abs(points.imag)), 1e-9)
    rho = getattr(region, "rho", None)
    far = 1.08 * max(far, rho) if rho else 1.3 * far
    right = max(0.25 * far, 1.3 * np.max(points.real))
    return (float(round(-far, 6)), float(round(right, 6)), float(round(far, 6)))


def shade_region(ax, region, window, colour=GREEN, label="D-region"):
    """Shade a D-region within a window (left, right, height)."""
    outline = region_outline(region, window)
    if outline.size:
        ax.fill(outline.real, outline.imag, facecolor=colour, alpha=0.18,
                edgecolor="none", zorder=1)
        ax.plot([], [], color=colour, alpha=0.4, linewidth=7, linestyle="-",
                label=label)
    return ax


def poles(ax, poles, region=None, window=None, label="closed loop"):
    """Poles in the complex plane, over the shaded D-region.

    Parameters
    ----------
    ax : matplotlib Axes
    poles : array of complex, any shape, or a dict {label: array}
        (N, order) for a polytope; a dict compares several loops.
    region : PoleRegion, LMIRegion or a sequence of LMIRegion, optional
    window : (left, right, height), optional
        The part of the plane shown; chosen to fit everything if left out.
    label : str
        Name in the legend when `poles` is no dict.

    Returns
    -------
    matplotlib Axes
    """
    sets = dict(poles) if isinstance(poles, dict) else {label: poles}
    window = window or window_of(list(sets.values()), region)
    left, right, height = window
    if region is not None:
        shade_region(ax, region, window)
    ax.axhline(0, color=GREY, linewidth=0.7, linestyle="-", zorder=1.5)
    ax.axvline(0, color=GREY, linewidth=0.7, linestyle="-", zorder=1.5)
    order = (1, 0) if len(sets) == 2 else range(len(sets))
    for (name, values), k in zip(sets.items(), order):
        values = np.ravel(np.asarray(values, complex))
        marker, colour = MARKERS[k % 6], COLOURS[k % 6]
        hollow = {} if marker in "x+" else {"markerfacecolor": "none"}
        ax.plot(values.real, values.imag, linestyle="none", marker=marker,
                color=colour, markersize=6, markeredgewidth=1.4, label=name,
                zorder=3, **hollow)
    ax.set_xlim(left, right)
    ax.set_ylim(-height, height)
    ax.set_aspect("equal", adjustable="box")
    ax.set_xlabel("Re s (1/s)")
    ax.set_ylabel("Im s (rad/s)")
    legend_above(ax, len(sets) + (region is not None))
    return ax


def pole_map(poles_, region=None, window=None, label="closed loop",
             figsize=(4.6, 4.4)):
    """A figure of its own for `poles`; takes what `poles` takes."""
    figure, ax = plt.subplots(figsize=figsize)
    poles(ax, poles_, region=region, window=window, label=label)
    return figure
