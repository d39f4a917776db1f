"""A matplotlib figure as accessible inline SVG."""

import io
import re
import warnings
from itertools import count

import numpy as np

from ...display.escape import page_text
from ...runtime.libraries import library
from .style import STYLE

plt = library("matplotlib.pyplot")
FigureCanvasSVG = library("matplotlib.backends.backend_svg").FigureCanvasSVG
Bbox = library("matplotlib.transforms").Bbox
Text = library("matplotlib.text").Text


# In inches: it is 338 px on a phone of 390, where letters of 8 points are 7.4 px.
WIDTH = 5.1
SMALLEST = 8.0  # points
# CSS px a point at most: 9 points are 14.4 px, a little less than the page's letters.
LARGEST = 1.6


class Figure:
    """An inline ``svg`` with its ``alt`` text and ``caption``, and all of it as
    ``html``.
    """

    def __init__(self, svg, alt, caption=""):
        self.svg, self.alt, self.caption = svg, alt, caption
        below = f"<figcaption>{page_text(caption, quote=False)}</figcaption>"
        self.html = (
            '<figure class="sos-figure" style="margin:0.5em 0">'
            f"{svg}{below if caption else ''}</figure>"
        )

    def _repr_html_(self):
        return self.html

    def __repr__(self):
        return f"Figure: {self.alt}"


def show(figure, alt=None, caption=""):
    """Turn a matplotlib ``figure`` into an accessible output, a `Figure`; put it last
    in a cell. ``alt`` says what it shows to readers who can't see it, and must be there
    (ValueError); ``caption`` what to take from it. The figure is closed.

    >>> figure, ax = plt.subplots()
    >>> show(figure, alt="Empty axes", caption="Nothing yet.")
    Figure: Empty axes
    """
    if not isinstance(alt, str) or not alt.strip():
        raise ValueError(
            "alt is missing: say in a sentence what the figure "
            "shows, show(figure, alt='...')"
        )
    cut = _fitted(figure)
    for ax in figure.axes:
        _swaying(ax, *getattr(ax, "sway", ((), 0)))
    buffer = io.StringIO()
    with plt.rc_context({key: STYLE[key] for key in ("svg.fonttype", "svg.hashsalt")}):
        screen, canvas = figure.canvas, FigureCanvasSVG(figure)
        _lay_out(figure)
        figure.set_layout_engine("none")  # or it is drawn twice, for its layout
        canvas.print_svg(
            buffer,
            metadata={"Date": None, "Creator": None, "Format": None, "Type": None},
        )
    figure.set_canvas(screen)
    parts = _parts(figure) if cut else ()
    plt.close(figure)
    alt = alt.strip()
    return Figure(_inline(buffer.getvalue(), alt, caption, parts), alt, caption)


def _fitted(figure):
    """Make a figure's letters readable on a phone; say whether it can be cut there.

    A figure that can't be cut is made so narrow that its letters stay readable.
    """
    for text in figure.findobj(Text):
        text.set_fontsize(max(text.get_fontsize(), SMALLEST))
    figure.set_dpi(72)  # as an SVG has it: a layout depends on it by a point
    _lay_out(figure)
    cut = len(_columns(figure)) > 1
    if not cut:
        _narrow(figure, *figure.get_size_inches())
    return cut


def _lay_out(figure):
    """Place a figure's axes, which takes half of the time of drawing it."""
    engine = figure.get_layout_engine()
    if engine is None:
        figure.draw_without_rendering()
    elif figure.axes:
        engine.execute(figure)
        for ax in figure.axes:
            ax.apply_aspect()


def _parts(figure):
    """Where a phone cuts a saved figure: boxes (x, y, width, height) in points."""
    over = [x for x in (*figure.legends, figure._suptitle) if x is not None]
    boxes = [x.get_window_extent() for x in over] + _columns(figure)
    top = figure.bbox.height
    return [[x.x0, top - x.y1, x.width, x.height] for x in boxes]


def _narrow(figure, width, height):
    """Make a figure as narrow as a phone asks, if its axes have room there."""
    if width > WIDTH:
        figure.set_size_inches(WIDTH, height * WIDTH / width)
        with warnings.catch_warnings(record=True) as collapsed:
            warnings.simplefilter("always")
            _lay_out(figure)
        if collapsed:
            figure.set_size_inches(width, height)


def _swaying(ax, places, axis):
    """Name what sways: how far its end moves, by how much it is stretched, its end."""
    if not len(places):
        return
    scale = ax.transData.transform([[0, 0], [1, 1]])
    unit, zero = scale[1, axis] - scale[0, axis], scale[0, axis]
    top, sign = (ax.figure.bbox.height, -1) if axis else (0, 1)
    for part in (*ax.patches, *ax.lines, *ax.texts):
        box = part.get_window_extent()
        ends = np.array([box.min[axis], box.max[axis]])
        if isinstance(part, Text):
            ends[:] = ends.mean()
        first, last = np.interp((ends - zero) / unit, *places.T) * unit * sign
        stretch = (last - first) * sign / (ends[1] - ends[0] or 1)
        first, stretch = round(first, 2) + 0.0, round(stretch, 4) + 0.0  # no sign of 0
        name = f"sway {axis} {first:.2f} {stretch:.4f} {top + sign * ends[0]:.2f}"
        part.set_gid(name)
        if arrow := getattr(part, "arrow_patch", None):
            arrow.set_gid(name)


def _columns(figure):
    """The boxes of the columns of a figure's axes that stand each for itself."""
    axes = [ax for ax in figure.axes if ax.get_visible()]
    if any(ax.get_subplotspec() is None for ax in axes):
        return []
    axes.sort(key=lambda ax: ax.get_subplotspec().colspan.start)
    boxes = []
    for ax in axes:
        box = ax.get_tightbbox()
        shares = not any(t.get_visible() and t.get_text() for t in ax.get_yticklabels())
        if boxes and (shares or box.x0 < boxes[-1].x1):
            boxes[-1] = Bbox.union([boxes[-1], box])
        else:
            boxes.append(box)
    return boxes


def _inline(text, alt, caption, parts=()):
    """Matplotlib's SVG file made small, responsive and safe to put in a page."""
    width, height = map(
        float, re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', text).groups()
    )
    body = text[text.index(">", text.index("<svg")) + 1 :]
    body = re.sub(r"<metadata>.*?</metadata>", "", body, flags=re.S)
    body = re.sub(r"<!--.*?-->", "", body, flags=re.S)
    # This rule would reach the whole page; the root's attributes do instead.
    body = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", body, flags=re.S)
    for pattern, shorter in (
        (r'(?s:(<path[^>]*? d=")([^"]*)")', lambda m: f'{m[1]}{_short(m[2])}"'),
        (
            r'(\s(?:x|y|width|height)=")(-?[\d.]+)"',
            lambda m: m[1] + _number(m[2]) + '"',
        ),
        (r"translate\(([^)]*)\)", lambda m: f"translate({_short(m[1])})"),
        (r'style="[^"]*"', lambda m: re.sub(r"([:;]) ", r"\1", m[0])),
    ):
        body = re.sub(pattern, shorter, body)
    body = re.sub(
        r'id="sway (\d) (\S+) (\S+) (\S+)"',
        r'class="sos-sway-\1" style="--by:\2px;--more:\3;--from:\4px"',
        body,
    )
    body = _rename(body, _stem(alt + caption))
    body = re.sub(r"\n\s*", "\n", body).replace(">\n<", "><").strip()
    cut = ";".join(" ".join(map(_number, box)) for box in parts)
    cut = f'data-parts="{cut}" ' if cut else ""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" '
        f'xmlns:xlink="http://www.w3.org/1999/xlink" '
        'stroke-linejoin="round" stroke-linecap="butt" '
        f'role="img" aria-label="{page_text(alt)}" '
        f'viewBox="0 0 {_number(width)} {_number(height)}" {cut}'
        f'style="display:block;width:100%;max-width:{width * LARGEST:.0f}px;'
        f'height:auto;background:#fff;border-radius:6px">{body}'
    )


def _number(value):
    return f"{round(float(value), 2) + 0.0:.2f}".rstrip("0").rstrip(".")


def _short(path):
    """Path data with two decimals: a hundredth of a point can't be seen."""
    path = re.sub(r"-?\d+\.\d+(e-?\d+)?", lambda match: _number(match[0]), path)
    path = re.sub(r"\s+", " ", path).strip()
    return re.sub(r" ?([A-Za-z]) ?", r"\1", path)


def _stem(text):
    """A short id that follows from the words, so it is the same everywhere."""
    value = 0
    for letter in text.encode():
        value = (value * 131 + letter) % 16777213
    return f"f{value:06x}"


def _rename(body, stem):
    """Keep the ids that something refers to, renamed so pages have no doubles."""
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', body))
    numbers = count()
    names = {}
    for name in re.findall(r'\sid="([^"]+)"', body):
        if name in used and name not in names:
            names[name] = f"{stem}-{next(numbers)}"
    body = re.sub(
        r'\sid="([^"]+)"',
        lambda match: f' id="{names[match[1]]}"' if match[1] in names else "",
        body,
    )
    return re.sub(
        r'(href="#|url\(#)([^")]+)',
        lambda match: match[1] + names.get(match[2], match[2]),
        body,
    )
