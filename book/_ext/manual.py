"""The package's manual: pages from docstrings, and code that leads to them.

A page of ``book/api`` has prose and one fence, ``{room}``, with modules: their
public names follow in a table, then each with its docstring and the chapters
that use it. In the chapters' code every public name links to its entry, and at
a chapter's end stands what it used. The fence ``{names}`` is the table of the
root's names.
"""

import ast
import html
import inspect
import json
import re
from functools import cache

from docutils import nodes
from manual_names import (
    BOOK,
    FENCE,
    ROOT,
    entries,
    escaped,
    exists,
    lookup,
    pages,
    resolve,
)
from sphinx import addnodes
from sphinx.transforms import SphinxTransform

NAMES = ":::{names}\n:::"
#: Bases whose members are no news to a reader.
PLAIN = "ReadOnly, object, tuple, dict, Warning, UserWarning, OnPage, VBox"
MOST = 6  # chapters to name with a function


# What the chapters use


def used(source):
    """The package's names in a program, imports and short forms written out."""
    known, found = {}, []
    try:
        tree = ast.parse(re.sub(r"^[%!].*$", "", source, flags=re.MULTILINE))
    except SyntaxError:
        return []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for name in node.names:
                if name.name.split(".")[0] == ROOT:
                    known[name.asname or ROOT] = name.name if name.asname else ROOT
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            if node.module.split(".")[0] == ROOT:
                for name in node.names:
                    known[name.asname or name.name] = f"{node.module}.{name.name}"
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute | ast.Name):
            parts = _dotted(node)
            if parts and parts[0] in known:
                found.append(".".join([known[parts[0]], *parts[1:]]))
    return found


def _dotted(node):
    parts = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    return [node.id, *reversed(parts)] if isinstance(node, ast.Name) else None


@cache
def chapters():
    """How often each chapter uses each entry: {chapter: {entry's name: times}}."""
    result = {}
    for path in sorted(BOOK.glob("*.ipynb")):
        cells = json.loads(path.read_text("utf-8"))["cells"]
        code = "\n".join(
            "".join(c["source"]) + "\n" for c in cells if c["cell_type"] == "code"
        )
        counts = {}
        for name in used(code):
            if found := lookup(name):
                counts[found[0].name] = counts.get(found[0].name, 0) + 1
        result[f"book/{path.stem}"] = counts
    return result


def where(name):
    """The chapters that use an entry, those that use it most, in the book's order."""
    counts = {page: uses[name] for page, uses in chapters().items() if name in uses}
    most = sorted(counts, key=lambda page: (-counts[page], page))[:MOST]
    return sorted(most), len(counts) - len(most)


# The pages' text


class Straight(SphinxTransform):
    """A prime and a quoted word of the manual stay as they are typed."""

    default_priority = 100  # before quotation marks are curled

    def apply(self, **_):
        if self.env.docname in pages():
            self.document.settings.smart_quotes = False


def source_read(app, docname, source):
    """Write the fences of the manual out as reStructuredText."""
    text = source[0]
    if docname in pages():
        if match := FENCE.search(text):
            room = [e for e in entries().values() if e.page == docname]
            there = f"{match[1]}".split()
            body = [_table(room), *_also(docname, there), *map(_entry, room)]
            text = text.replace(match[0], _rst("\n\n".join(body)))
        if NAMES in text:
            text = text.replace(NAMES, _rst(_root_table()))
        source[0] = text


def _rst(text):
    return f"````{{eval-rst}}\n{text}\n````"


def _list_table(rows, widths):
    lines = [".. list-table::", f"   :widths: {' '.join(map(str, widths))}"]
    lines += ["   :class: sos-names", ""]
    for row in rows:
        for k, cell in enumerate(row):
            lines.append(f"   {'*' if k == 0 else ' '} - {cell}")
    return "\n".join(lines)


def _table(room):
    return _list_table([(_link(e), e.summary) for e in room], (38, 62))


def _link(entry):
    return f":py:obj:`{entry.name.removeprefix(ROOT + '.')} <{entry.name}>`"


def _also(docname, modules):
    """Public names of a page's modules that another page documents."""
    rows = {
        e.name: _link(e)
        for e in entries().values()
        if e.page != docname and any(a.rpartition(".")[0] in modules for a in e.aliases)
    }
    return ["Also here: " + ", ".join(rows.values()) + "."] if rows else []


def _entry(entry):
    lines = [f".. auto{entry.kind}:: {entry.name}"]
    if entry.kind == "data":
        value = repr(entry.thing)
        lines = [f".. py:data:: {entry.name}"]
        if isinstance(entry.thing, str | int | float | tuple) and len(value) < 60:
            lines.append(f"   :value: {value}")
    if entry.kind in ("class", "exception"):
        lines += ["   :members:", f"   :inherited-members: {PLAIN}"]
    lines.append("")
    if also := sorted(_short(entry)):
        lines += ["   Also " + ", ".join(f"``{a}``" for a in also) + ".", ""]
    most, more = where(entry.name)
    if most:
        links = ", ".join(f":doc:`/{page}`" for page in most)
        end = f", and {more} more" if more else ""
        lines += [f"   In the book: {links}{end}.", ""]
    return "\n".join(lines)


def _short(entry):
    """The names that a user can write besides the first one."""
    public = {a for a in entry.aliases if a != entry.name and a in _importable()}
    return {a for a in public if a.count(".") <= 2}


@cache
def _importable():
    return {
        alias
        for entry in entries().values()
        for alias in entry.aliases
        if alias.rpartition(".")[0].count(".") <= 1
        and alias.rpartition(".")[2] in _public(alias.rpartition(".")[0])
    }


@cache
def _public(module):
    from importlib import import_module

    try:
        return frozenset(getattr(import_module(module), "__all__", ()))
    except ImportError:
        return frozenset()


def _root_table():
    rows = [
        (_link(e), e.summary)
        for e in sorted(entries().values(), key=lambda e: e.name.lower())
        if e.name.count(".") == 1
    ]
    return _list_table(rows, (34, 66))


# Docstrings


def plain_bars(app, what, name, thing, options, lines):
    """Let |x| be a norm: in reStructuredText bars mean something else."""
    lines[:] = [
        line if line.lstrip().startswith((">>>", "...")) else escaped(line)
        for line in lines
    ]


def skip(app, what, name, thing, is_skipped, options):
    """Leave out former names and what has no docstring of its own."""
    doc = inspect.getdoc(thing) or ""
    return True if doc.startswith("The former name of") else None


def missing(app, env, node, contnode):
    """Resolve a docstring's word; what is no page of the manual stays plain code.

    A word that names nothing in the package isn't answered here: Sphinx warns.
    """
    if node.get("refdomain") != "py":
        return None
    owner = ".".join(filter(None, (node.get("py:module"), node.get("py:class"))))
    if name := resolve(node["reftarget"], owner):
        objects = env.get_domain("py").objects
        entry, _ = lookup(name)
        anchor = name if name in objects else entry.name
        uri = app.builder.get_relative_uri(node["refdoc"], entry.page)
        link = nodes.reference("", "", internal=True, refuri=f"{uri}#{anchor}")
        link += contnode
        return link
    return contnode if exists(node["reftarget"], owner) else None


# Chapters


class Used(SphinxTransform):
    """At a chapter's end, the names of the package that its code uses."""

    default_priority = 800

    def apply(self, **_):
        uses = chapters().get(self.env.docname, {})
        if not uses or self.env.docname == "book/intro":
            return
        line = nodes.paragraph("", "In the package: ", classes=["sos-used"])
        for k, name in enumerate(sorted(uses, key=str.lower)):
            line += nodes.Text(", ") if k else nodes.Text("")
            line += addnodes.pending_xref(
                "",
                nodes.literal("", name.removeprefix(ROOT + ".")),
                refdomain="py",
                reftype="obj",
                reftarget=name,
                refdoc=self.env.docname,
                refwarn=True,
                refexplicit=True,
            )
        sections = [n for n in self.document.children if isinstance(n, nodes.section)]
        (sections[-1] if sections else self.document).append(line)


CELL = re.compile(r'(<div class="highlight-i?python3? [^>]*>.*?</pre>)', re.DOTALL)
TOKEN = r'<span class="(?:n|nn|nc|nf)">'
CHAIN = re.compile(rf'{TOKEN}\w+</span>(?:<span class="o">\.</span>{TOKEN}\w+</span>)*')
TAG = re.compile(r"<[^>]+>")


def link_code(app, pagename, templatename, context, doctree):
    """Make links of the package's names in a page's code."""
    body = context.get("body")
    if not body or app.builder.name != "html" or pagename in pages():
        return
    known = {}

    def cell(match):
        text = html.unescape(TAG.sub("", match[1]))
        known.update(_imports(text))
        return CHAIN.sub(link, match[1])

    def link(match):
        parts = TAG.sub("", match[0]).split(".")
        if parts[0] not in known:
            return match[0]
        found = lookup(".".join([known[parts[0]], *parts[1:]]))
        if found is None:
            return match[0]
        entry, rest = found
        objects = app.env.get_domain("py").objects
        whole = f"{entry.name}.{rest}"
        target = whole if rest and whole in objects else entry.name
        uri = app.builder.get_relative_uri(pagename, entry.page)
        title = html.escape(entry.summary.replace("`", ""), quote=True)
        return (
            f'<a class="sos-code" href="{uri}#{target}" title="{title}">{match[0]}</a>'
        )

    context["body"] = CELL.sub(cell, body)


def _imports(text):
    """What names of a program mean, by its imports."""
    known = {}
    for module, short in re.findall(
        rf"^\s*import ({ROOT}[\w.]*)(?: as (\w+))?", text, re.MULTILINE
    ):
        known[short or ROOT] = module if short else ROOT
    pattern = rf"^\s*from ({ROOT}[\w.]*) import (\([^)]*\)|[^\n]*)"
    for module, listed in re.findall(pattern, text, re.MULTILINE):
        for part in listed.strip("()").split(","):
            if words := re.match(r"\s*(\w+)(?: as (\w+))?", part):
                known[words[2] or words[1]] = f"{module}.{words[1]}"
    return known


def setup(app):
    """Tell Sphinx."""
    app.setup_extension("sphinx.ext.autodoc")
    app.setup_extension("numpydoc")
    app.connect("source-read", source_read)
    app.connect("autodoc-process-docstring", plain_bars, priority=400)
    app.connect("autodoc-skip-member", skip)
    app.connect("missing-reference", missing)
    app.connect("html-page-context", link_code)
    app.add_transform(Straight)
    app.add_transform(Used)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
