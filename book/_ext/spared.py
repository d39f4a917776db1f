"""Work that Sphinx and its extensions do again at each page is done once here.

No page looks different for it; a build of the book takes half of the time.
"""

from functools import cache
from itertools import chain

import numpydoc.docscrape_sphinx
import pybtex.plugin
import sphinx.builders.html
from docutils import nodes
from jinja2.sandbox import SandboxedEnvironment
from sphinx import addnodes

findall = nodes.Node.findall
sidebar = sphinx.builders.html.global_toctree_for_doc


def walk(
    node, condition=None, include_self=True, descend=True, siblings=False, ascend=False
):
    """The nodes of a tree that `findall` of docutils finds, in its order.

    Its generators lie one in another, as deep as the tree, for each node. This is one.
    """
    if siblings or ascend or not descend:
        yield from findall(node, condition, include_self, descend, siblings, ascend)
        return
    kind = condition if isinstance(condition, type) else nodes.Node
    asked = condition if condition and kind is not condition else lambda node: True
    ways = [iter((node,) if include_self else node.children)]
    while ways:
        for child in ways[-1]:
            if isinstance(child, kind) and asked(child):
                yield child
            if child.children:
                ways.append(iter(child.children))
                break
        else:
            ways.pop()


class Compiled(SandboxedEnvironment):
    """numpydoc's template, which it compiles for each docstring and signature."""

    templates = {}

    def get_template(self, name, *args, **kwargs):
        if name not in self.templates:
            self.templates[name] = super().get_template(name, *args, **kwargs)
        return self.templates[name]


@cache
def titles(env):
    """The contents of all pages without their sections: titles, and pages below."""
    found = {name: contents.deepcopy() for name, contents in env.tocs.items()}
    for top in chain.from_iterable(contents.children for contents in found.values()):
        if len(top) > 1:
            if below := list(top.findall(addnodes.toctree)):
                top[1][:] = below
            else:
                top.pop(1)
    return found


def sidebar_of_titles(env, *args, titles_only=False, **options):
    """The list of all pages beside a page.

    Sphinx copies all sections of all pages, and names of the manual, to drop them.
    """
    whole = env.tocs
    try:
        env.tocs = titles(env) if titles_only else whole
        return sidebar(env, *args, titles_only=titles_only, **options)
    finally:
        env.tocs = whole


def adopt(app, page):
    """Make all nodes of a page its own, for those of the manual have another document.

    It leads to all that Sphinx knows, which would be stored with each such page.
    """
    for node in page.findall():
        node.document = page


def setup(app):
    """Tell Sphinx."""
    nodes.Node.findall = walk
    numpydoc.docscrape_sphinx.SandboxedEnvironment = Compiled
    pybtex.plugin.find_plugin = cache(pybtex.plugin.find_plugin)
    sphinx.builders.html.global_toctree_for_doc = sidebar_of_titles
    app.connect("doctree-read", adopt)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
