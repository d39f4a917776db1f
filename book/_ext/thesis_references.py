"""Numbers of the thesis, written [T 2.18] on the pages, as links of their own look.

The table ``book/thesis_references.toml`` says which place of the book belongs
to a number. A link leads there, or to the number's row on the page of the
directive ``thesis-references`` if the book has no place for it. That page
shows the table both ways: by the thesis's numbers and by the book's pages.
"""

import re
import tomllib
from functools import cache
from html import escape
from pathlib import Path

from docutils import nodes
from sphinx import addnodes
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

BOOK = Path(__file__).resolve().parent.parent
TABLE = BOOK / "thesis_references.toml"
#: The page of the table.
PAGE = "book/thesis_references"
FORM = re.compile(r"\[T ([^\[\]\n]+)\]")
#: The pages without a number, by the letters in their labels.
LETTERS = {"a": "appendix_a", "p": "performance", "s": "sharper_certificates"}
#: What stays as it is written: code, formulas, other links, headings.
VERBATIM = (
    nodes.literal,
    nodes.literal_block,
    nodes.math,
    nodes.math_block,
    nodes.reference,
    nodes.title,
    nodes.raw,
    addnodes.pending_xref,
)
log = logging.getLogger(__name__)


def table(path=TABLE):
    """The chapters of the thesis; each has its rows by their numbers."""
    return tomllib.loads(path.read_text("utf-8"))


@cache
def entries(path=TABLE):
    """The rows of all chapters by their numbers: what it is, and at which place."""
    return {
        number: row for rows in table(path).values() for number, row in rows.items()
    }


def name(number):
    """A number as the thesis writes it: (2.18), Theorem 2.2, Section 2.3."""
    return number[0].upper() + number[1:] if " " in number else f"({number})"


def anchor(number):
    """The id of a number's row."""
    return "t-" + re.sub(r"[^a-z0-9]+", "-", number.lower()).strip("-")


def page_of(place):
    """The page of a place: a page itself, or of a label by its chapter's name."""
    if chapter := re.match(r"[a-z]+-(\d\d|[a-z])-", place):
        stem = LETTERS.get(chapter[1], f"{chapter[1]}_*")
        return next(path.stem for path in BOOK.glob(f"{stem}.ipynb"))
    return place


def address(env, place):
    """The document and the id of a place; None if the book doesn't have it."""
    if f"book/{place}" in env.found_docs:
        return f"book/{place}", ""
    equation = env.get_domain("math").equations.get(place)
    if equation:
        return equation[0], f"equation-{place}"
    proof = getattr(env, "proof_list", {}).get(place)
    if proof:
        return proof["docname"], proof["ids"][0]
    return env.get_domain("std").anonlabels.get(place)


class Links(SphinxPostTransform):
    """Make links of the numbers in the text."""

    default_priority = 5  # before Sphinx looks for what it can't resolve

    def run(self, **_):
        known = entries()
        for text in list(self.document.findall(nodes.Text)):
            if FORM.search(text) and not _within(text, VERBATIM):
                text.parent.replace(text, list(self.pieces(str(text), known)))

    def pieces(self, text, known):
        """The words and the links of a text."""
        end = 0
        for match in FORM.finditer(text):
            if match[1] not in known:
                log.warning("no thesis number %s", match[0], location=self.env.docname)
                continue
            yield nodes.Text(text[end : match.start()])
            yield self.link(match[1], known[match[1]])
            end = match.end()
        yield nodes.Text(text[end:])

    def link(self, number, row):
        """The link of a number."""
        return nodes.reference(
            "",
            f"[T {number}]",
            internal=True,
            refuri=uri(self.app.builder, self.env.docname, number, row),
            reftitle=f"Thesis, {name(number)}: {row['is']}",
            classes=["thesis-reference"],
        )


def uri(builder, docname, number, row):
    """The address of a number's place, from a page."""
    page, place = address(builder.env, row.get("at", "")) or (PAGE, "")
    if page == PAGE or (page == docname and not place):
        page, place = PAGE, anchor(number)  # not to the page that is open
    found = builder.get_relative_uri(docname, page)
    return found + (f"#{place}" if place else "")


def linked(html, builder, docname):
    """HTML, such as a caption of an output, with links of the numbers in it."""
    known = entries()

    def link(match):
        if match[1] not in known:
            log.warning("no thesis number %s", match[0], location=docname)
            return match[0]
        row = known[match[1]]
        words = escape(f"Thesis, {name(match[1])}: {row['is']}")
        return (
            '<a class="thesis-reference" '
            f'href="{escape(uri(builder, docname, match[1], row))}" '
            f'title="{words}">{match[0]}</a>'
        )

    return FORM.sub(link, html)


def _within(node, kinds):
    while node.parent is not None:
        node = node.parent
        if isinstance(node, kinds):
            return True
    return False


class Table(SphinxDirective):
    """The table, by the thesis's numbers or, as ``book``, by the book's pages."""

    optional_arguments = 1

    def run(self):
        if self.arguments == ["book"]:
            return [self.by_page()]
        result = []
        for chapter, rows in table().items():
            result.append(nodes.rubric("", chapter))
            result.append(self.by_number(rows))
        return result

    def by_number(self, rows):
        """The rows of a chapter: number, what it is, where it is in the book."""
        body = []
        for number, row in rows.items():
            first = nodes.paragraph("", name(number), ids=[anchor(number)])
            where = nodes.paragraph()
            if "at" in row:
                page = page_of(row["at"])
                where += _reference(page, self.env.docname)
                if page != row["at"]:
                    where += [nodes.Text(", "), _reference(row["at"], self.env.docname)]
            body.append([first, nodes.paragraph("", row["is"]), where])
        return _table(("Thesis", "What it is", "In the book"), (18, 40, 42), body)

    def by_page(self):
        """The pages of the book and the thesis's numbers that they treat."""
        pages = {}
        for number, row in entries().items():
            if "at" in row:
                pages.setdefault(page_of(row["at"]), []).append(f"[T {number}]")
        body = [
            [
                nodes.paragraph("", "", _reference(page, self.env.docname)),
                nodes.paragraph("", " ".join(numbers)),
            ]
            for page, numbers in sorted(pages.items())
        ]
        return _table(("In the book", "Thesis"), (40, 60), body)


def _reference(place, docname):
    """A reference that Sphinx resolves and names by itself."""
    kind = place.split("-")[0]
    if "-" not in place:
        domain, role, place = "std", "doc", f"/book/{place}"
    elif kind == "eq":
        domain, role = "math", "eq"
    elif kind == "sec":
        domain, role = "std", "ref"
    else:
        domain, role = "prf", "ref"
    return addnodes.pending_xref(
        "",
        nodes.inline("", place),
        refdomain=domain,
        reftype=role,
        reftarget=place,
        refexplicit=False,
        refwarn=True,
        refdoc=docname,
    )


def _table(heads, widths, rows):
    group = nodes.tgroup(cols=len(heads))
    group += [nodes.colspec(colwidth=width) for width in widths]
    group += nodes.thead("", _row([nodes.paragraph("", head) for head in heads]))
    group += nodes.tbody("", *map(_row, rows))
    return nodes.table("", group, classes=["thesis-references"])


def _row(cells):
    return nodes.row("", *(nodes.entry("", cell) for cell in cells))


def setup(app):
    """Tell Sphinx."""
    app.add_post_transform(Links)
    app.add_directive("thesis-references", Table)
    app.connect("env-before-read-docs", _depend)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}


def _depend(app, env, docnames):
    """Read the table's page again at each build: the table may have changed."""
    if PAGE in env.found_docs and PAGE not in docnames:
        docnames.append(PAGE)
