"""Figures and tables that cells show, as numbered objects with an address.

Sphinx numbers what stands in the text of a page: equations, theorems,
exercises. The book's figures and tables are outputs of cells, which it takes
for opaque HTML. Here each of them becomes an enumerated node, so it has a
number of its chapter ("Figure 9.2"), an id and a link of its own. A cell with
the tag ``fig-09-hole`` or ``tab-p-sizes`` gives its first figure or table
that name, and the text cites it like any other thing: {numref}`fig-09-hole`.

Pages that aren't chapters have no number; there the counts start again.
"""

import re

from docutils import nodes
from sphinx.transforms import SphinxTransform
from thesis_references import linked

#: The text of a figure is at least so high on the page, in pixels; on a narrow
#: screen the figure scrolls inside its box instead of shrinking further.
TEXT_HEIGHT = 7.2
#: Letters that are so much smaller than the largest are subscripts.
SUBSCRIPT = 0.75
#: Pixels a point of a part: 9 points are the size of a phone's small print.
PART = 1.5

_CAPTION = re.compile(r"<(figcaption|caption)>(.*?)</\1>", re.DOTALL)
_DRAWING = re.compile(r"<svg\b.*?</svg>", re.DOTALL)
_WIDTH = re.compile(r'viewBox="0 0 ([\d.]+) ')
_PARTS = re.compile(r'data-parts="([^"]*)"')
_LETTERS = re.compile(r"\bscale\(([\d.]+) -\1\)")
_MARKUP = re.compile(r"<[^>]+>")


class output_figure(nodes.General, nodes.Element):
    """A figure that a cell shows."""

    kind, start = "figure", '<figure class="sos-figure"'


class output_table(nodes.General, nodes.Element):
    """A table with a caption that a cell shows."""

    kind, start = "table", '<div class="sos-table"'


KINDS = (output_figure, output_table)
PREFIXES = {"figure": "fig-", "table": "tab-"}


class Collect(SphinxTransform):
    """Wrap the outputs that are figures or tables, before Sphinx counts."""

    default_priority = 400

    def apply(self, **_):
        counts = dict.fromkeys(PREFIXES, 0)
        for cell in list(self.document.findall(_is("cell_code"))):
            names = list(cell.get("cell_metadata", {}).get("tags", []))
            for bundle in list(cell.findall(_is("mime_bundle"))):
                html = _html(bundle)
                for node in KINDS:
                    if html.startswith(node.start):
                        counts[node.kind] += 1
                        self.wrap(bundle, node, html, names, counts[node.kind])

    def wrap(self, bundle, node, html, names, count):
        """Put the output into an enumerated node with a name."""
        wanted = (name for name in names if name.startswith(PREFIXES[node.kind]))
        name = next(wanted, None)
        if name:
            names.remove(name)
        caption = _CAPTION.search(html)
        wrapped = node(
            names=[name] if name else [],
            ids=[name or f"{node.kind}-{count}"],
            title=_MARKUP.sub("", caption[2]) if caption else node.kind,
        )
        bundle.replace_self(wrapped)
        wrapped += bundle
        self.document.note_explicit_target(wrapped, wrapped)


def _is(element):
    return lambda node: (
        isinstance(node, nodes.container) and node.get("nb_element") == element
    )


def _html(bundle):
    """The HTML of an output; empty if it has none."""
    for part in bundle.children:
        if part.get("mime_type") == "text/html":
            return part.astext()
    return ""


def visit(translator, node):
    """Write the number and the id into the HTML of the output."""
    builder = translator.builder
    number = builder.fignumbers.get(node.kind, {}).get(node["ids"][0], ())
    words = translator.config.numfig_format[node.kind] % ".".join(map(str, number))
    for raw in list(node.findall(nodes.raw)):
        if raw.astext().startswith(node.start):
            text = _CAPTION.sub(
                lambda match: linked(match[0], builder, builder.current_docname),
                raw.astext(),
                count=1,
            )
            text = dressed(text, node.start, node["ids"][0], words)
            raw.replace_self(nodes.raw("", text, **raw.attributes))


def depart(translator, node):
    """Nothing is left to write."""


def dressed(html, start, place, words):
    """A figure or a table with its id, and its number before its caption."""
    label = (
        f'<span class="caption-number">{words}. </span>\\2'
        f'<a class="headerlink" href="#{place}" title="Link to this place">#</a>'
    )
    if start in output_figure.start and not _CAPTION.search(html):
        html = html.replace("</figure>", "<figcaption></figcaption></figure>")
    html = _CAPTION.sub(rf"<\1>{label}</\1>", html, count=1)
    html = html.replace(start, f'{start} id="{place}"', 1)
    return _DRAWING.sub(lambda match: _sheet(match[0], place), html)


def _sheet(drawing, place):
    """A drawing in a box that scrolls where its text would become too small.

    What can be cut is shown in parts on a phone, drawn from the same marks.
    """
    cut = _PARTS.search(drawing)
    if cut:
        name, start = f"{place}-marks", drawing.index(">") + 1
        inside = drawing[start:].removesuffix("</svg>")
        drawing = f'{drawing[:start]}<g id="{name}">{inside}</g></svg>'
        boxes = (list(map(float, box.split())) for box in cut[1].split(";"))
        parts = "".join(_part(box, name) for box in boxes)
        return (
            f'<div class="sos-sheet of-parts">{drawing}'
            f'<div class="sos-parts" aria-hidden="true">{parts}</div></div>'
        )
    letters = [100 * float(size) for size in _LETTERS.findall(drawing)]
    text = [size for size in letters if size > SUBSCRIPT * max(letters)]
    width = float(_WIDTH.search(drawing)[1])
    least = width * TEXT_HEIGHT / min(text) if text else 0
    return f'<div class="sos-sheet" style="--sos-least:{least:.0f}px">{drawing}</div>'


def _part(box, name):
    x, y, width, height = (round(v + m, 1) for v, m in zip(box, (-2, -2, 4, 4)))
    return (
        f'<svg viewBox="{x} {y} {width} {height}" style="width:{PART * width:.0f}px" '
        'stroke-linejoin="round" stroke-linecap="butt">'
        f'<use href="#{name}"/></svg>'
    )


def restart(app, env):
    """Pages outside the numbered chapters count from 1, each for itself."""
    for page, kinds in env.toc_fignumbers.items():
        if not env.toc_secnumbers.get(page, {}).get(""):
            for numbers in kinds.values():
                numbers.update({name: (k,) for k, name in enumerate(numbers, 1)})


def setup(app):
    """Tell Sphinx."""
    app.add_transform(Collect)
    for node in KINDS:
        app.add_enumerable_node(
            node,
            node.kind,
            lambda node: node["title"],
            html=(visit, depart),
            **dict.fromkeys(
                ("latex", "text", "man", "texinfo"), (lambda *_: None, depart)
            ),
        )
    app.connect("env-check-consistency", restart)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
