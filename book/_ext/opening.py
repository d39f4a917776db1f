"""A page opens with what it is about, drawn or moving.

What a cell with the tag ``opening`` shows stands below the page's one sentence,
wherever the cell is: a picture can need numbers that the page computes later. The
paragraph before the cell, which introduces it, goes along and stands below it. In its
own place a link says where it went. Nothing stands above what a reader moves: the
folded code of an element comes below it.
"""

from docutils import nodes
from sphinx.transforms import SphinxTransform
from sphinx.transforms.post_transforms import SphinxPostTransform

TAG, PLACE = "opening", "opening"
INTRODUCES = "sos-introduces"  # a picture, not the page


class Open(SphinxTransform):
    """Move the output of the tagged cell up, after `captions` has wrapped it."""

    default_priority = 410

    def apply(self, **_):
        cells = list(self.document.findall(_tagged))
        if not cells:
            return
        (cell,) = cells
        page = self.document.next_node(nodes.section)
        (output,) = (
            c for c in cell.children if c.get("nb_element") != "cell_code_source"
        )
        link = nodes.reference(
            "", "at the top of this page", refid=PLACE, internal=True
        )
        text = (nodes.Text("Shown "), link, nodes.Text("."))
        words = nodes.paragraph("", "", *text, classes=["sos-moved"])
        output.replace_self(words)
        before = cell.parent.index(cell) - 1
        introduced = before >= 0 and isinstance(cell.parent[before], nodes.paragraph)
        sentences = [cell.parent.pop(before)] if introduced else []
        for paragraph in sentences:
            paragraph["classes"].append(INTRODUCES)
        first = nodes.container(
            "", output, classes=["cell", "sos-opening"], ids=[PLACE], names=[PLACE]
        )
        sentence = next((k for k, c in enumerate(page) if _one_sentence(c)), 0)
        page[sentence + 1 : sentence + 1] = [first, *sentences]
        self.document.note_explicit_target(first, first)


class Below(SphinxPostTransform):
    """Put the folded code of an element below it, once myst-nb has folded it."""

    default_priority = 200
    formats = ("html",)

    def run(self, **_):
        for cell in self.document.findall(_is_cell):
            shown = cell[-1].findall(nodes.raw)
            folded = "above-input" in cell[0].get("classes", ())
            if folded and any(raw.astext().startswith("<sos-") for raw in shown):
                cell.append(cell.pop(0))


def _is_cell(node):
    return isinstance(node, nodes.container) and node.get("nb_element") == "cell_code"


def _tagged(node):
    return _is_cell(node) and TAG in node.get("cell_metadata", {}).get("tags", [])


def _one_sentence(node):
    quoted = isinstance(node, (nodes.block_quote, nodes.Admonition))
    return quoted and node.astext().lower().startswith("in one sentence")


def setup(app):
    """Tell Sphinx."""
    app.add_transform(Open)
    app.add_post_transform(Below)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
