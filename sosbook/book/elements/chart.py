"""A small SVG plot as a string: what the live sliders draw with."""

import numpy as np

from ...display.escape import page_text
from ...display.ticks import round_ticks
from ..plots import GREY, INK

__all__ = ["Chart"]


class Chart:
    """A small SVG plot with axes, built as a string.

    Parameters
    ----------
    x, y : (float, float)
        Both ends of the axes.
    x_label, y_label : str
        What stands at the axes.
    title : str
        What a screen reader says.
    square : bool
        Whether a unit is as long on both axes.
    log : bool
        Whether the ticks are powers of ten.
    """

    width, height = 330, 280
    left, right, top, bottom = 48, 8, 24, 38

    def __init__(self, x, y, x_label, y_label, title, square=False, log=False):
        self.x, self.y = tuple(map(float, x)), tuple(map(float, y))
        self.labels, self.title, self.log = (x_label, y_label), title, log
        self.names, self.body = [], []
        wide = self.width - self.left - self.right
        high = self.height - self.top - self.bottom
        sx = wide / (self.x[1] - self.x[0])
        sy = high / (self.y[1] - self.y[0])
        self.scale = (min(sx, sy),) * 2 if square else (sx, sy)

    def _at(self, x, y):
        px = self.left + (np.asarray(x, float) - self.x[0]) * self.scale[0]
        base = self.top + (self.y[1] - self.y[0]) * self.scale[1]
        return px, base - (np.asarray(y, float) - self.y[0]) * self.scale[1]

    def _points(self, x, y):
        flat = np.column_stack(self._at(x, y)).ravel().tolist()
        return ("%.1f,%.1f " * (len(flat) // 2))[:-1] % tuple(flat)

    def polygon(self, x, y, colour, hatched=False):
        """Add an area with the corners (x, y) in a colour, tinted or hatched."""
        fill, edge = f"fill='{colour}' fill-opacity='0.2'", ""
        if hatched:
            fill, edge = "fill='url(#sos-hatch)'", " stroke-dasharray='5 4'"
            self.body.append(
                "<pattern id='sos-hatch' width='9' height='9' "
                "patternUnits='userSpaceOnUse' "
                "patternTransform='rotate(45)'><line y2='9' "
                f"stroke='{colour}' stroke-width='1.4'/></pattern>"
            )
        self.body.append(
            f"<polygon points='{self._points(x, y)}' {fill} stroke='{colour}'{edge}/>"
        )

    def line(self, x, y, colour, dashed=False, name=""):
        """Add a line through the points (x, y); its ``name`` joins the legend.

        It has a colour and may be dashed.
        """
        dash = " stroke-dasharray='6 4'" if dashed else ""
        self.body.append(
            f"<polyline points='{self._points(x, y)}' fill='none' "
            f"stroke='{colour}' stroke-width='1.6'{dash}/>"
        )
        if name:
            self.names.append((name, colour))

    def marks(self, x, y, colour, shape):
        """Add a mark at each point (x, y): a "circle" or else a cross, by ``shape``.

        All have one colour.
        """
        for a, b in zip(*self._at(x, y)):
            if shape == "circle":
                mark = f"<circle cx='{a:.1f}' cy='{b:.1f}' r='4'"
            else:
                mark = f"<path d='M{a - 4:.1f} {b - 4:.1f}l8 8m0-8l-8 8'"
            self.body.append(
                f"{mark} fill='none' stroke='{colour}' stroke-width='1.8'/>"
            )

    def svg(self):
        """The whole plot as the text of an SVG element."""
        right, bottom = self._at(self.x[1], self.y[0])
        wide, high = right - self.left, bottom - self.top
        window = (
            f"x='{self.left}' y='{self.top}' width='{wide:.1f}' height='{high:.1f}'"
        )
        frame = [f"<rect {window} fill='none' stroke='{GREY}'/>"]
        for v in round_ticks(*self.x):
            a, _ = self._at(v, self.y[0])
            frame.append(
                f"<text x='{a:.1f}' y='{bottom + 13:.1f}' "
                f"text-anchor='middle'>{self._tick(v)}</text>"
            )
        for v in round_ticks(*self.y):
            _, b = self._at(self.x[0], v)
            frame.append(
                f"<text x='{self.left - 4}' y='{b + 3:.1f}' "
                f"text-anchor='end'>{self._tick(v)}</text>"
            )
        middle = (self.top + bottom) / 2
        frame.append(
            f"<text x='{(self.left + right) / 2:.0f}' "
            f"y='{bottom + 29:.0f}' text-anchor='middle'>"
            f"{page_text(self.labels[0])}</text>"
            f"<text x='12' y='{middle:.0f}' text-anchor='middle' "
            f"transform='rotate(-90 12 {middle:.0f})'>"
            f"{page_text(self.labels[1])}</text>"
        )
        for k, (name, colour) in enumerate(self.names):
            frame.append(
                f"<text x='{self.left + 70 * k}' y='15' fill='{colour}' "
                f"font-weight='bold'>{page_text(name)}</text>"
            )
        title = page_text(self.title, quote=True)
        return (
            f"<svg role='img' aria-label='{title}' width='{self.width}' "
            f"height='{self.height}' viewBox='0 0 {self.width} "
            f"{self.height}' font-size='11' font-family='sans-serif' "
            f"fill='{INK}'><svg {window} viewBox='{self.left} {self.top} "
            f"{wide:.1f} {high:.1f}'>{''.join(self.body)}</svg>"
            f"{''.join(frame)}</svg>"
        )

    def _tick(self, v):
        return f"1e{v:.0f}" if self.log else f"{v + 0.0:.4g}"
