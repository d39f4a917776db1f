"""Poles and the region in which they must lie, as a small picture."""

import numpy as np

from .escape import page_text
from .outline import region_outline, window_of

AXES_HEIGHT = 230.0  # in pixels
LEFT, TOP, BOTTOM, RIGHT = 46.0, 8.0, 34.0, 10.0  # room around the axes, in pixels


def pole_map(rows, region=None, label="poles, rad/s"):
    """An inline SVG of poles, ``rows`` of each vertex in rad/s, and a ``region``,
    ``label`` below; its colours are the classes ``sos-region``, ``sos-axis``,
    ``sos-pole``.
    """
    rows = [np.asarray(row, complex) for row in rows]
    window = left, right, top = window_of(rows, region)
    scale = AXES_HEIGHT / (2 * top)
    width = (right - left) * scale
    axes = f'x="{LEFT}" y="{TOP}" width="{width:.1f}" height="{AXES_HEIGHT}"'

    def at(s):
        s = np.asarray(s, complex)
        return LEFT + (s.real - left) * scale, TOP + (top - s.imag) * scale

    inside = []
    outline = () if region is None else region_outline(region, window)
    if len(outline):
        corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(*at(outline)))
        inside.append(f'<polygon class="sos-region" points="{corners}"/>')
    (zero_x, zero_y) = at(0)
    inside.append(
        f'<path class="sos-axis" d="M{zero_x:.1f} {TOP}V{TOP + AXES_HEIGHT}'
        f'M{LEFT} {zero_y:.1f}H{LEFT + width:.1f}"/>'
    )
    for x, y in zip(*at(np.concatenate(rows))):
        inside.append(
            f'<path class="sos-pole" d="M{x - 4:.1f} {y - 4:.1f}l8 8m0-8l-8 8"/>'
        )
    ticks = []
    for v in round_ticks(left, right, 4):
        x, _ = at(v)
        ticks.append(
            f'<text x="{x:.1f}" y="{TOP + AXES_HEIGHT + 13}" text-anchor="middle">'
            f"{v + 0.0:.4g}</text>"
        )
    for v in round_ticks(-top, top):
        _, y = at(1j * v)
        ticks.append(
            f'<text x="{LEFT - 5}" y="{y + 4:.1f}" text-anchor="end">'
            f"{v + 0.0:.4g}</text>"
        )
    middle = LEFT + width / 2
    ticks.append(
        f'<text x="{middle:.1f}" y="{TOP + AXES_HEIGHT + 29}" text-anchor="middle">'
        f"{page_text(label)}</text>"
    )
    wide, high = LEFT + width + RIGHT, TOP + AXES_HEIGHT + BOTTOM
    return (
        f'<svg role="img" aria-label="{page_text(_words(rows, region))}" '
        f'width="{wide:.0f}" height="{high:.0f}" viewBox="0 0 {wide:.1f} {high:.1f}">'
        f'<rect class="sos-frame" {axes}/>'
        f'<svg {axes} aria-hidden="true" viewBox="{LEFT} {TOP} {width:.1f} '
        f'{AXES_HEIGHT}">'
        f"{''.join(inside)}</svg>"
        f"{''.join(ticks)}</svg>"
    )


def _words(rows, region):
    poles = np.concatenate(rows)
    sentence = f"{len(poles)} poles, the rightmost at Re s = {poles.real.max():.3g}"
    if region is not None:
        inside = region.contains(poles)
        sentence += "; all lie in the shaded region" if inside else "; some lie outside"
        sentence += "" if inside else " the shaded region"
    return sentence


def round_ticks(low, high, most=5):
    """Round numbers from ``low`` to ``high``, about ``most`` of them.

    >>> round_ticks(-1.3, 0.3).round(1) + 0.0
    array([-1. , -0.5,  0. ])
    """
    step = 10.0 ** np.floor(np.log10((high - low) / 3))
    for factor in (1, 2, 5, 10):
        if (high - low) / (factor * step) <= most + 0.5:
            break
    step *= factor
    return step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)
