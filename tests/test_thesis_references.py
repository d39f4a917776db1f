"""Numbers of the thesis in the book: in one table, of one form, with a place.

``python -m tests.test_thesis_references`` lists rows that no page mentions, and
numbers that stand on a page without their T.
"""

import re
import sys
from functools import cache
from pathlib import Path

import nbformat
import pytest

from tests.prose import markup

BOOK = Path(__file__).resolve().parent.parent / "book"
sys.path.append(str(BOOK / "_ext"))
references = pytest.importorskip("thesis_references")
ROWS = references.entries()
PAGES = sorted([*BOOK.glob("*.ipynb"), *BOOK.glob("*.md")])
#: Pages whose numbers have another form: tables that the package makes.
TABLES = {"errata", "reproduction", "thesis_references"}
#: Pages whose numbers have no T yet.
NOT_YET = ("bibliography",)
KIND = r"(?:Theorem|Lemma|Procedure|Definition|Table|Figs?\.?|[Ss]ection)"
BARE = re.compile(
    rf"(?<!\w)\((?:[1-5]|[AB])\.\d+(?:\.\d)?\)|{KIND}\s(?:[2-4]|[AB])\.\d+(?:\.\d)?"
)


@cache
def texts(path):
    """The Markdown of a page, cell by cell."""
    if path.suffix == ".md":
        return (path.read_text("utf-8"),)
    cells = nbformat.read(path, as_version=4).cells
    return tuple(cell.source for cell in cells if cell.cell_type == "markdown")


def forms(path):
    """The numbers of the thesis on a page."""
    return [number for text in texts(path) for number in references.FORM.findall(text)]


def bare(path):
    """Numbers of the table that stand in a page's sentences without a T."""
    for text in texts(path):
        text = re.sub(r"^(?:#+|:{3,}\{).*$", "", text, flags=re.MULTILINE)
        text = references.FORM.sub("", markup.FENCE.sub("", text))
        text = re.sub(r"`[^`\n]*`|\$\$.*?\$\$|\$[^$]*\$", "", text, flags=re.DOTALL)
        for match in BARE.finditer(text):
            number = re.sub(r"^Figs?\.?|^Section", _kind, match[0].strip("()"))
            if number in ROWS:
                yield match[0]


def _kind(match):
    return "Fig." if match[0].startswith("Fig") else "section"


def exists(place):
    """Whether a page or a label of the book has this name."""
    if any((BOOK / f"{place}{suffix}").exists() for suffix in (".ipynb", ".md")):
        return True
    label = re.compile(rf"\({place}\)|:label: {place}\b")
    return any(label.search(text) for path in PAGES for text in texts(path))


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_each_number_is_in_the_table(path):
    assert [number for number in forms(path) if number not in ROWS] == []


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_a_number_of_the_thesis_is_marked(path):
    if path.stem in TABLES or path.stem.startswith(NOT_YET):
        pytest.skip("its numbers have another form")
    assert list(bare(path)) == []


def test_each_row_leads_to_a_place_of_the_book():
    for number, row in ROWS.items():
        assert row.keys() <= {"is", "at"}, number
        assert row["is"], number
        assert exists(row.get("at", "notation")), number


def test_rows_are_told_apart():
    anchors = [references.anchor(number) for number in ROWS]
    assert len(anchors) == len(set(anchors))
    chapters = references.table().values()
    assert len(ROWS) == sum(len(rows) for rows in chapters)


def test_the_form_is_read_as_it_is_written():
    text = "see [T 2.8.1], [T Theorem A.3]–[T Fig. 3.2] and [T](x)"
    assert references.FORM.findall(text) == ["2.8.1", "Theorem A.3", "Fig. 3.2"]
    assert references.name("2.18") == "(2.18)"
    assert references.name("A.9") == "(A.9)"
    assert references.name("section 2.3") == "Section 2.3"
    assert references.page_of("eq-04-block") == "04_lmi_regions"
    assert references.page_of("notation") == "notation"


if __name__ == "__main__":
    mentioned = {number for path in PAGES for number in forms(path)}
    print("on no page:", ", ".join(n for n in ROWS if n not in mentioned))
    for path in PAGES:
        if path.stem not in TABLES and (numbers := list(bare(path))):
            print(f"{path.name}, without a T:", ", ".join(numbers))
