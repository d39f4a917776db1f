"""The shapes that an SVG draws, with all references followed."""

import html
import re
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from .paths import bounds, lines

GEOMETRY = {
    "use": {"x", "y"},
    "path": {"d"},
    "polyline": {"points"},
    "polygon": {"points"},
    "line": {"x1", "y1", "x2", "y2"},
    "rect": {"x", "y", "width", "height"},
    "circle": {"cx", "cy", "r"},
    "ellipse": {"cx", "cy", "rx", "ry"},
    "text": {"x", "y"},
    "tspan": {"x", "y"},
    "svg": {"x", "y", "width", "height", "viewbox"},
}
INSIDE = {"g", "svg", "a", "symbol", "clippath"}
BY_REFERENCE = {"defs", "clippath", "symbol", "pattern", "marker", "mask", "metadata"}
BY_REFERENCE |= {"lineargradient", "radialgradient"}
ROUND = 0.5522847498  # a quarter circle as a Bezier curve
UNIT = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)


@dataclass
class Shape:
    """One thing drawn: curve, mark (a path at many places), glyph, text or clip.

    ``style`` has all but its place, ``outline`` path data in its own coordinates,
    ``matrix`` leads from these to the viewBox, in whose ``box`` it can be seen.
    """

    kind: str
    style: str
    outline: str
    matrix: tuple
    text: str
    box: tuple

    @cached_property
    def polylines(self):
        """Its subpaths in the units of the viewBox."""
        a, b, c, d, e, f = self.matrix
        return [
            line @ np.array([[a, b], [c, d]]) + (e, f) for line in lines(self.outline)
        ]

    @property
    def corners(self):
        """Two opposite corners of its outline's box: x, y, x, y."""
        a, b, c, d, e, f = self.matrix
        (x, y), (u, v) = bounds(self.outline)
        return (
            a * x + c * y + e,
            b * x + d * y + f,
            a * u + c * v + e,
            b * u + d * v + f,
        )

    def __str__(self):
        if self.kind == "glyph":
            return "letter"
        own = self.style.rpartition(" > ")[2]
        words = re.findall(r"(?:fill|stroke|stroke-dasharray)[:=][^;\s]+", own)
        return f"{self.kind} ({' '.join(words) or own})"


def drawn(svg):
    """All shapes of an svg Node in order of drawing; marks of a group by their look."""
    return Canvas(svg).shapes


class Canvas:
    def __init__(self, svg):
        self.names = {
            node.attributes["id"]: node
            for node in svg.elements()
            if "id" in node.attributes
        }
        self.numbers, self.shapes = {}, []
        self.own, self.corners = {}, {}
        width, height = _view(svg)[2:]
        self._inside(svg, UNIT, "", (0.0, 0.0, width, height))

    def _inside(self, node, matrix, style, box):
        """Draw an element with children."""
        style, matrix, box = self._look(node, matrix, style, box)
        marks = []
        for child in node.children:
            if isinstance(child, str):
                continue
            if not _is_mark(child):
                self._flush(marks)
            before = len(self.shapes)
            self._draw(child, matrix, style, box)
            if _is_mark(child):
                marks += self.shapes[before:]
                del self.shapes[before:]
        self._flush(marks)

    def _flush(self, marks):
        self.shapes += sorted(marks, key=lambda mark: (mark.style, mark.outline))
        marks.clear()

    def _draw(self, node, matrix, style, box, used=""):
        tag = node.tag
        if tag in BY_REFERENCE and not used:
            return
        if tag in INSIDE:
            self._inside(node, matrix, style, box)
            return
        style, matrix, box = self._look(node, matrix, style, box)
        if tag == "use":
            name = node.attributes.get("xlink:href", node.attributes.get("href", ""))
            target = self.names.get(name[1:])
            kind = "mark" if _is_mark(node) else "glyph"
            if target is None:
                self._add("text", style, "", matrix, f"refers to {name}", box)
            else:
                matrix = _times(matrix, (1, 0, 0, 1, *_floats(node, "x", "y")))
                self._draw(target, matrix, style, box, kind)
            return
        outline = _outline(node)
        if outline is None:
            at = _times(matrix, (1, 0, 0, 1, *_floats(node, "x", "y")))
            self._add("text", style, "", at, node.text, box)
        else:
            self._add(used or "curve", style, outline, matrix, "", box)

    def _add(self, kind, style, *rest):
        self.shapes.append(Shape(kind, style, *rest))

    def _look(self, node, matrix, style, box):
        """Style, matrix and visible box inside an element."""
        if node not in self.own:
            self.own[node] = self._own(node)
        words, clip, place, step = self.own[node]
        if clip:
            box = self._clip(clip, matrix, style, box)
            words = words[:place] + [f"clip={self.numbers[clip]}"] + words[place:]
        if step:
            matrix = _times(matrix, step)
        if node.tag == "svg" and style:
            matrix = _times(matrix, _nested(node))
        return f"{style} > {node.tag} {' '.join(words)}", matrix, box

    def _own(self, node):
        """An element's own words, its clip and where it stands in them, its matrix."""
        known = GEOMETRY.get(node.tag, ())
        words, clip, place, step = [], None, None, None
        for key, value in sorted(node.attributes.items()):
            value = value or ""
            if key == "transform":
                step = _transform(value)
            elif key == "clip-path" and value[5:-1] in self.names:
                clip, place = value[5:-1], len(words)
            elif key not in known and key not in ("id", "href", "xlink:href"):
                words.append(f"{key}={self._followed(value)}")
            elif key == "id" and node.tag in ("g", "svg"):
                words.append(f"id={value}")
        return words, clip, place, step

    def _clip(self, name, matrix, style, box):
        """Draw a clip path when it is first used, and narrow the box."""
        known = name in self.numbers
        self.numbers.setdefault(name, len(self.numbers))
        if (name, matrix) not in self.corners:
            before = len(self.shapes)
            self._draw(self.names[name], matrix, style, box, "clip")
            self.corners[name, matrix] = [x.corners for x in self.shapes[before:]]
            if known:
                del self.shapes[before:]
        for x, y, u, v in self.corners[name, matrix]:
            box = (
                max(box[0], min(x, u)),
                max(box[1], min(y, v)),
                min(box[2], max(x, u)),
                min(box[3], max(y, v)),
            )
        return box

    def _followed(self, value):
        """An attribute with what url(#name) refers to instead of the name."""

        def content(found):
            node = self.names.get(found[1])
            if node is None:
                return found[0]
            return re.sub(r' id="[^"]*"', "", str(node))

        return re.sub(r"url\(#([^)]+)\)", content, value) if "url" in value else value


def _is_mark(node):
    return not isinstance(node, str) and node.tag == "use" and "x" in node.attributes


def _outline(node):
    """Path data of a basic shape; None if it is none."""
    tag = node.tag
    if tag == "path":
        return node.attributes.get("d", "")
    if tag in ("polyline", "polygon"):
        points = node.attributes.get("points", "")
        return f"M{points}{'Z' * (tag == 'polygon')}"
    if tag == "line":
        return "M{} {}L{} {}".format(*_floats(node, "x1", "y1", "x2", "y2"))
    if tag == "rect":
        x, y, width, height = _floats(node, "x", "y", "width", "height")
        return f"M{x} {y}h{width}v{height}h{-width}z"
    if tag in ("circle", "ellipse"):
        names = ("r", "r") if tag == "circle" else ("rx", "ry")
        x, y, a, b = _floats(node, "cx", "cy", *names)
        k, m = ROUND * a, ROUND * b
        return (
            f"M{x + a} {y}c0 {m} {k - a} {b} {-a} {b}s{-a} {m - b} {-a} {-b}"
            f"s{a - k} {-b} {a} {-b}s{a} {b - m} {a} {b}z"
        )
    return None


def _floats(node, *names):
    return [_float(node.attributes.get(name)) for name in names]


@lru_cache(maxsize=65536)
def _float(text):
    found = re.match(r"\s*([-+\d.eE]+)(?:px)?\s*$", text or "0")
    if not found:
        raise ValueError(f"a place that is no number: {html.escape(text)}")
    return float(found[1])


def _view(svg):
    view = svg.attributes.get("viewbox")
    if view:
        return [float(v) for v in view.replace(",", " ").split()]
    return [0.0, 0.0, *_floats(svg, "width", "height")]


def _nested(svg):
    """The matrix of an svg in an svg."""
    x, y, width, height = _floats(svg, "x", "y", "width", "height")
    left, top, wide, high = _view(svg)
    scale = min(width / wide, height / high) if width and height else 1.0
    return (scale, 0, 0, scale, x - scale * left, y - scale * top)


@lru_cache(maxsize=65536)
def _transform(text):
    matrix = UNIT
    for name, inner in re.findall(r"(\w+)\(([^)]*)\)", text):
        v = [float(x) for x in re.split(r"[\s,]+", inner.strip())]
        if name == "matrix":
            step = tuple(v)
        elif name == "translate":
            step = (1, 0, 0, 1, v[0], v[1] if len(v) > 1 else 0)
        elif name == "scale":
            step = (v[0], 0, 0, v[-1], 0, 0)
        elif name == "rotate":
            c, s = np.cos(np.radians(v[0])), np.sin(np.radians(v[0]))
            x, y = v[1:] or (0, 0)
            step = (c, s, -s, c, x - c * x + s * y, y - s * x - c * y)
        else:
            raise ValueError(f"the transform {name} is not known")
        matrix = _times(matrix, step)
    return matrix


def _times(m, n):
    a, b, c, d, e, f = m
    g, h, i, j, k, o = n
    return (
        a * g + c * h,
        b * g + d * h,
        a * i + c * j,
        b * i + d * j,
        a * k + c * o + e,
        b * k + d * o + f,
    )
