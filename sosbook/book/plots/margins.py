"""How far each requirement is from failing."""

import re

import numpy as np

from .style import BLUE, VERMILLION


def margins(ax, margins, labels=None):
    """Draw, on Axes ``ax``, how far each requirement is from failing, as logarithmic
    bars: ``margins`` as of a design, of which the smallest of the vertices and pairs
    counts, with other ``labels``, a dict. What is violated is hatched and says so.
    """
    names = {
        "P": "P > 0",
        "half-plane": "half-plane σ",
        "sector": "sector θ",
        "disk": "disk ρ",
        "hinf": "H∞ bound γ",
        "x0": "x(0) in ellipsoid",
        "u_max": "‖u‖ ≤ u_max",
    } | dict(labels or {})
    margins = smallest_of_each(margins)
    keys = list(margins)
    sizes = np.array([abs(float(margins[key])) for key in keys])
    held = [float(margins[key]) > 0 for key in keys]
    floor = 10.0 ** np.floor(
        np.log10(max(np.min(sizes, where=sizes > 0, initial=1.0), 1e-16)) - 0.5
    )
    top = max(floor, np.max(sizes, initial=0.0)) * 30
    places = np.arange(len(keys))[::-1]
    for place, length, good in zip(places, np.maximum(sizes, floor), held):
        look = dict(color="white", ec=VERMILLION, hatch="////")
        if good:
            look = dict(color=BLUE, ec=BLUE)
        ax.barh(place, length - floor, 0.62, floor, lw=1, **look)
        said = f"{length:.1e}" if good else f"violated by {length:.1e}"
        ax.text(length * 1.15, place, said, va="center", fontsize=8)
    ax.set(xscale="log", xlim=(floor, top))
    ax.set_yticks(places, [names.get(key, key) for key in keys])
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("smallest scaled eigenvalue")
    return ax


def smallest_of_each(margins):
    """The smallest of the ``margins`` of each requirement, over vertices and pairs."""
    least = {}
    for name, value in margins.items():
        name = re.sub(r" [\d,]+$", "", name)
        least[name] = min(float(value), least.get(name, np.inf))
    return least
