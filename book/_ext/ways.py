"""Tables of the book's pages with their minutes, which the build adds up.

``book/ways.toml`` has the ways through the book and the weeks of a course. The
directive ``pages`` makes the table of all chapters by parts, ``weeks`` that of the
course.
"""

import re
import tomllib
from functools import cache
from pathlib import Path

import yaml
from docutils import nodes
from sphinx import addnodes
from sphinx.util.docutils import SphinxDirective

from sosbook.book import minutes

BOOK = Path(__file__).resolve().parent.parent
TABLE, CONTENTS = BOOK / "ways.toml", BOOK.parent / "_toc.yml"
NUMBERED = re.compile(r"\d\d_")


def ways(kind="way"):
    """The ways through the book, or the weeks of the course."""
    return tomllib.loads(TABLE.read_text("utf-8"))[kind]


def path(page):
    """The file of a page by its name."""
    return next(x for x in (BOOK / f"{page}.ipynb", BOOK / f"{page}.md") if x.exists())


@cache
def time(page):
    """The minutes of a page."""
    return minutes.said(minutes.read(path(page)))


def parts():
    """The parts with chapters: a caption, and the names of the pages."""
    for part in yaml.safe_load(CONTENTS.read_text("utf-8"))["parts"]:
        names = [row["file"].removeprefix("book/") for row in part["chapters"]]
        if any(NUMBERED.match(name) for name in names):
            yield part["caption"], names


def hours(count):
    """Minutes as hours with one digit."""
    return f"{count / 60:.1f} h"


class Pages(SphinxDirective):
    """All chapters by parts, with minutes and the ways that lead through them."""

    def run(self):
        rows, whole = [], 0
        for caption, names in parts():
            sums = sum(map(time, names))
            whole += sums
            strong = nodes.paragraph("", "", nodes.strong("", caption))
            rows.append([strong, _text(f"{sums}"), _text("")])
            for name in names:
                marks = "".join(w["mark"] for w in ways() if name in w["pages"])
                rows.append([_link(self, name), _text(f"{time(name)}"), _text(marks)])
        rows.append([_text("Everything"), _text(hours(whole)), _text("")])
        table = _table(("Chapter", "Minutes", "Way"), (70, 15, 15), rows)
        sums = [[_text(w["mark"]), _text(w["name"]), _text(_sum(w))] for w in ways()]
        return [table, _table(("Way", "For", "Hours"), (15, 60, 25), sums)]


class Weeks(SphinxDirective):
    """The weeks of the course, with their minutes."""

    def run(self):
        rows, whole = [], 0
        for k, week in enumerate(ways("week"), 1):
            cell = nodes.paragraph()
            for name in week["pages"]:
                cell += [nodes.Text(", ")] * bool(len(cell)) + [*_link(self, name)]
            if "project" in week:
                cell += [nodes.Text("; "), nodes.strong("", week["project"])]
            count = sum(map(time, week["pages"]))
            whole += count
            rows.append([_text(f"{k}"), cell, _text(f"{count}")])
        rows.append([_text(""), _text("Everything"), _text(hours(whole))])
        return [_table(("Week", "Pages", "Minutes"), (12, 68, 20), rows)]


def _sum(way):
    return hours(sum(map(time, way["pages"])))


def _text(words):
    return nodes.paragraph("", words)


def _link(directive, name):
    """A paragraph with a link of the page's number and title."""
    number = f"{int(name[:2])}. " if NUMBERED.match(name) and int(name[:2]) else ""
    link = addnodes.pending_xref(
        "",
        nodes.inline("", ""),
        refdomain="std",
        reftype="doc",
        reftarget=f"/book/{name}",
        refexplicit=False,
        refwarn=True,
        refdoc=directive.env.docname,
    )
    return nodes.paragraph("", "", *([nodes.Text(number)] * bool(number)), link)


def _table(heads, widths, rows):
    group = nodes.tgroup(cols=len(heads))
    group += [nodes.colspec(colwidth=width) for width in widths]
    group += nodes.thead("", _row([_text(head) for head in heads]))
    group += nodes.tbody("", *map(_row, rows))
    return nodes.table("", group, classes=["sos-pages"])


def _row(cells):
    return nodes.row("", *(nodes.entry("", cell) for cell in cells))


def _again(app, env, docnames):
    """Read the tables' pages again at each build: any page may have changed."""
    for name in ("book/contents", "book/syllabus"):
        if name in env.found_docs and name not in docnames:
            docnames.append(name)


def setup(app):
    """Tell Sphinx."""
    app.add_directive("pages", Pages)
    app.add_directive("weeks", Weeks)
    app.connect("env-before-read-docs", _again)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
