"""The page of theorems: every numbered statement with its title and chapter.

The fence ``{statements}`` on a page becomes the list. Each statement with a
title is an entry of the index, too.
"""

import re

from docutils import nodes
from sphinx import addnodes
from sphinx.transforms import SphinxTransform
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util.docutils import SphinxDirective
from sphinx_proof import NODE_TYPES

KINDS = ("theorem", "lemma", "proposition", "corollary", "definition", "algorithm")
CLASSES = tuple(NODE_TYPES.values())
#: What a title of the index begins and ends without: brackets, articles, references.
ENDS = re.compile(r"^\W*((an?|the) )?|( *\(\[T [^]]*\]\))?\)?$", re.IGNORECASE)


class listing(nodes.General, nodes.Element):
    """Where the list goes when all pages are read."""


class Statements(SphinxDirective):
    """The list."""

    def run(self):
        return [listing()]


class Collected(SphinxTransform):
    """Keep the titles of a page's statements, and make entries of the index."""

    default_priority = 700

    def apply(self, **_):
        kept = self.env.__dict__.setdefault("sos_statements", {})
        rows = []
        for node in list(self.document.findall(lambda n: isinstance(n, CLASSES))):
            if not node["ids"] or node["realtype"] not in KINDS:
                continue
            title = ENDS.sub("", node["title"])
            # The title stands in the statement as text with formulas.
            inner = [child.deepcopy() for child in node[0].children]
            rows.append((node["label"], node["realtype"], inner))
            if title and "$" not in title:
                place = node["ids"][0]
                entry = ("single", title[0].upper() + title[1:], place, "", None)
                node.insert(1, addnodes.index(entries=[entry]))
        kept[self.env.docname] = rows


class Filled(SphinxPostTransform):
    """Write the list, chapter by chapter."""

    default_priority = 4  # before references are resolved

    def run(self, **_):
        for place in list(self.document.findall(listing)):
            place.replace_self(list(self.chapters()))

    def chapters(self):
        """A heading and a list for each chapter that has statements."""
        kept = getattr(self.env, "sos_statements", {})
        order = self.env.toctree_includes.get(self.env.config.root_doc, ())
        for docname in [*order, *sorted(kept.keys() - set(order))]:
            rows = kept.get(docname)
            if not rows:
                continue
            yield nodes.rubric("", "", self.reference("std", "doc", f"/{docname}"))
            items = []
            for label, _, inner in rows:
                line = nodes.paragraph("", "", self.reference("prf", "ref", label))
                if inner and (text := [n.deepcopy() for n in inner]):
                    line += [nodes.Text(" "), *text]
                items.append(nodes.list_item("", line))
            yield nodes.bullet_list("", *items)

    def reference(self, domain, role, target):
        """A reference that Sphinx resolves and names by itself."""
        return addnodes.pending_xref(
            "",
            nodes.inline("", target),
            refdomain=domain,
            reftype=role,
            reftarget=target,
            refexplicit=False,
            refwarn=True,
            refdoc=self.env.docname,
        )


def purge(app, env, docname):
    """Forget a page that is read again."""
    getattr(env, "sos_statements", {}).pop(docname, None)


def setup(app):
    """Tell Sphinx."""
    app.add_node(listing)
    app.add_directive("statements", Statements)
    app.add_transform(Collected)
    app.add_post_transform(Filled)
    app.connect("env-purge-doc", purge)
    return {"version": "1", "parallel_read_safe": False, "parallel_write_safe": True}
