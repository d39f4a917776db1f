"""Numbers of the thesis in the book: in one table, of one form, with a place.

``python -m tests.test_thesis_references`` lists rows that no page mentions.
"""

import re
import sys
import tomllib
from functools import cache
from pathlib import Path

import nbformat
import pytest

from sosbook.book import reproduction
from tests.each import each
from tests.prose import markup

BOOK = Path(__file__).resolve().parent.parent / "book"
sys.path.append(str(BOOK / "_ext"))
references = pytest.importorskip("thesis_references")
ROWS = references.entries()
PAGES = sorted([*BOOK.glob("*.ipynb"), *BOOK.glob("*.md")])
WORDS = Path(__file__).with_name("thesis_words.toml")
EQUATION = re.compile(r"\(((?:[1-5]|[AB])\.\d+(?:\.\d)?)\)")
#: Pages whose numbers have another form: tables that the package makes.
TABLES = {"errata", "reproduction", "thesis_references"}
#: Pages that mention numbers of all chapters.
OVERVIEWS = TABLES | {"bibliography", "intro", "notation", "where_this_stands"}
#: Pages whose numbers have no T.
OTHER_FORM = TABLES | {"bibliography"}
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


@each("path", PAGES)
def test_each_number_is_in_the_table(path):
    assert [number for number in forms(path) if number not in ROWS] == []


@each("path", [path for path in PAGES if path.stem not in OTHER_FORM])
def test_a_number_of_the_thesis_is_marked(path):
    assert list(bare(path)) == []


def test_each_row_leads_to_a_place_of_the_book():
    for number, row in ROWS.items():
        assert row.keys() <= {"is", "at"}, number
        assert row["is"], number
        assert exists(row.get("at", "notation")), number


@cache
def citing():
    """The chapters that cite each number, in their text or in captions."""
    found = {}
    for path in (page for page in PAGES if page.stem not in OVERVIEWS):
        text = path.read_text("utf-8")
        if path.suffix == ".ipynb":
            cells = nbformat.reads(text, as_version=4).cells
            text = "\n".join(cell.source for cell in cells)
        text = re.sub(r'"\n\s*f?"', "", text)  # a caption over two lines
        for number in references.FORM.findall(text):
            found.setdefault(number, set()).add(path.stem)
    return found


def astray(rows):
    """Numbers that are cited, and whose row leads to a page that doesn't cite them."""
    return [
        number
        for number, row in rows.items()
        if number in citing() and references.page_of(row["at"]) not in citing()[number]
    ]


def words():
    """The second table: a word that stands near each number in the thesis."""
    table = tomllib.loads(WORDS.read_text("utf-8"))
    return {number: word for rows in table.values() for number, word in rows.items()}


def misread(rows):
    """Numbers whose row lacks the word that stands near them in the thesis."""
    return [n for n, word in words().items() if word not in rows[n]["is"].lower()]


def test_a_number_leads_to_a_page_that_cites_it():
    assert astray(ROWS) == []


def test_both_readings_of_a_number_agree():
    assert list(words()) == list(ROWS)
    assert misread(ROWS) == []


def test_a_number_of_another_equation_is_noticed():
    """Numbers that were once invented for examples that have none."""
    invented = {
        "3.2": {"is": "Example 2, the car seat", "at": "eq-12-motion"},
        "3.3": {"is": "Example 3, the chain", "at": "13_chain"},
        "3.5": {"is": "the sine as an uncertain factor", "at": "14_flexible_arm"},
        "3.6": {"is": "the vertices of Example 4", "at": "14_flexible_arm"},
    }
    assert set(astray(ROWS | invented)) == set(invented)
    assert set(misread(ROWS | invented)) == set(invented)


def test_errata_and_rows_name_numbers_of_their_pages(rows, errata):
    """One number at least that stands in a row's place leads to its page."""
    printed = errata, reproduction.checked(), rows
    for one in (one for table in printed for one in table):
        numbers = EQUATION.findall(one.place)
        assert set(numbers) <= set(ROWS), one.place
        pages = [
            {references.page_of(ROWS[n]["at"])} | citing().get(n, set())
            for n in numbers
        ]
        assert not pages or one.chapter in set.union(*pages), one


def test_a_label_of_the_appendix_belongs_to_its_page():
    assert references.page_of("thm-a-impulse") == "appendix_a"
    assert {references.page_of(row["at"]) for row in ROWS.values()} <= {
        path.stem for path in PAGES
    }


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
