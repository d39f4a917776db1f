"""What the pages' other makers leave that a screen reader stumbles over.

Every id of a page names one place: the extensions for proofs and exercises
give all their contents the same id, and each of them gets its own here. And
entries of the bibliography lose a role that is no longer one.
"""

from itertools import count

from docutils import nodes
from sphinx.transforms import SphinxTransform

REPEATED = ("proof", "proof-content", "exercise-content", "solution-content")


class Distinguish(SphinxTransform):
    """Number the ids that occur more than once."""

    default_priority = 950  # after the extensions have built their nodes

    def apply(self, **_):
        counts = {name: count(1) for name in REPEATED}
        for node in self.document.findall(nodes.Element):
            if node.get("ids") and node["ids"][0] in counts:
                name = node["ids"][0]
                node["ids"] = [f"{name}-{next(counts[name])}"]


def drop_roles(app, page, template, context, doctree):
    """The bibliography's entries have a role that asks for a list's items."""
    for role in (' role="doc-biblioentry"', ' role="list"'):
        if 'class="citation-list"' in context.get("body", ""):
            context["body"] = context["body"].replace(role, "")


def setup(app):
    """Tell Sphinx."""
    app.add_transform(Distinguish)
    app.connect("html-page-context", drop_roles)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
