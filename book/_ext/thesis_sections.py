"""Sections for readers of the thesis, folded for everybody else.

A section whose title begins with the words below is about what is printed in the
thesis: which sign is right, whose digits are met. It is folded on the page. Who
unfolds it by the box in it has all of them unfolded, on every page.
"""

from docutils import nodes

WORDS = "For readers of the thesis"


class folded(nodes.General, nodes.Element):
    """What stands below the title of such a section."""


def fold(app, doctree, page):
    """After Sphinx has counted and listed the sections."""
    if app.builder.format == "html":
        for section in list(doctree.findall(nodes.section)):
            title, *rest = section.children
            if rest and title.astext().startswith(WORDS):
                section.children = [title]
                section += folded("", *rest)


def visit(translator, node):
    """Open the box; the script of the pages knows it by its class."""
    translator.body.append(
        '<details class="sos-thesis"><summary>What is printed there, and what '
        'holds</summary><label class="sos-thesis-all"><input type="checkbox"> '
        "unfold such sections on every page</label>"
    )


def depart(translator, node):
    """Close it."""
    translator.body.append("</details>")


def setup(app):
    """Tell Sphinx."""
    app.add_node(folded, html=(visit, depart))
    app.connect("doctree-resolved", fold, priority=900)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
