"""Sections that are folded on the page: their titles begin with the words below.

What is for readers of the thesis says which sign is right, whose digits are met. Who
unfolds it by the box in it has all of those unfolded, on every page. What is for a
second reading nothing later needs.
"""

from docutils import nodes

#: How such a title begins, and its box.
BOXES = {
    "For readers of the thesis": '<details class="sos-thesis"><summary>What is printed '
    'there, and what holds</summary><label class="sos-thesis-all"><input '
    'type="checkbox"> unfold such sections on every page</label>',
    "For a second reading": '<details class="sos-second"><summary>Show it</summary>',
}


class folded(nodes.General, nodes.Element):
    """What stands below the title of such a section."""


def fold(app, doctree, page):
    """After Sphinx has counted and listed the sections."""
    if app.builder.format == "html":
        for section in list(doctree.findall(nodes.section)):
            title, *rest = section.children
            words, _, _ = title.astext().partition(":")
            if rest and words in BOXES:
                section.children = [title]
                section += folded("", *rest, box=BOXES[words])


def visit(translator, node):
    """Open the box; the script of the pages knows it by its class."""
    translator.body.append(node["box"])


def depart(translator, node):
    """Close it."""
    translator.body.append("</details>")


def setup(app):
    """Tell Sphinx."""
    app.add_node(folded, html=(visit, depart))
    app.connect("doctree-resolved", fold, priority=900)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
