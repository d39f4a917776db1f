"""Minutes and hours: each page's by one rule, the ways' as their sums."""

import re
import sys
from pathlib import Path

import pytest

from sosbook.book import minutes, notebooks
from tests.each import each

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "book" / "_ext"))
ways = pytest.importorskip("ways")
FILES = sorted((ROOT / "book").glob("*.ipynb"))
CHAPTERS = [path for path in FILES if re.match(r"\d\d_", path.stem)]


@each("path", FILES)
def test_a_page_says_its_minutes_in_one_form_and_by_the_rule(path):
    notebook = notebooks.read(path)
    text = "\n".join(c.source for c in notebook.cells if c.cell_type == "markdown")
    told = re.findall(r"\*\*Time:\*\*|\d+ min to read", text)
    assert len(told) == 2 * len(minutes.TIME.findall(text)) <= 2
    assert told or path not in CHAPTERS
    measured = minutes.measured(notebook)
    assert not told or abs(minutes.stored(notebook) - measured) <= 5 + 0.05 * measured


def page(*cells):
    made = [minutes.v4.new_markdown_cell(text) for text in cells]
    return minutes.v4.new_notebook(cells=made)


def test_the_rule_by_hand():
    words, formula = "word " * 180, "$$\nx + y\n$$"
    hidden = ":::{exercise} E\n:label: ex-a\n\n" + words + "\n:::"
    folded = ":::{admonition} A\n:class: dropdown\n\n" + words + "\n:::"
    assert minutes.measured(page(words)) == pytest.approx(1)
    assert minutes.measured(page(words + formula)) == pytest.approx(2)
    assert minutes.measured(page(words + "$x$ " * 20)) == pytest.approx(2)
    assert minutes.measured(page(words, hidden, folded)) == pytest.approx(1)
    assert minutes.measured(
        page("## For a second reading: more\n\n" + words, "## Last\n\n" + words)
    ) == pytest.approx(1, abs=0.01)
    code = minutes.v4.new_code_cell("a = 1\n\nb = 2")
    both = page(words)
    both.cells.append(code)
    assert minutes.measured(both) == pytest.approx(1 + 2 / 12)
    code.metadata["tags"] = ["hide-input"]
    assert minutes.measured(both) == pytest.approx(1)


def test_the_ways_and_weeks_lead_to_pages_in_the_order_of_the_book():
    order = re.findall(r"book/(\w+)", (ROOT / "_toc.yml").read_text("utf-8"))
    for way in ways.ways():
        places = [order.index(page) for page in way["pages"]]
        assert places == sorted(places), way["name"]
    weeks = [page for week in ways.ways("week") for page in week["pages"]]
    assert len(set(weeks)) == len(weeks) and set(weeks) <= set(order)
    assert len(ways.ways("week")) == 14


def test_the_first_page_names_each_way_s_pages_and_its_hours():
    nb = notebooks.read(ROOT / "book" / "intro.ipynb")
    text = "\n".join(cell.source for cell in nb.cells)
    rows = re.findall(r"^\| .*\*\* ?.*\| (\d+) \|$", text, re.MULTILINE)
    assert len(rows) == len(ways.ways())
    for way in ways.ways():
        (row,) = re.findall(rf"^\| .*\*\*{way['name']}\*\*.*$", text, re.MULTILINE)
        linked = re.findall(r"\]\((\w+)\.(?:ipynb|md)\)", row)
        assert linked == [p for p in way["pages"] if p != "intro"], way["name"]
        total = sum(map(ways.time, way["pages"])) / 60
        assert abs(int(row.split("|")[-2]) - total) <= 0.75, (way["name"], total)


def test_the_built_tables_add_up(site):
    """The sums that a reader sees, from the rows that a reader sees."""
    for name in ("contents", "syllabus"):
        html = (site / "book" / f"{name}.html").read_text("utf-8")
        table = re.search(r'<table class="sos-pages.*?</table>', html, re.S)[0]
        rows = re.findall(r"<tr.*?</tr>", table, re.S)
        last = [re.sub("<.*?>", "", x) for x in re.findall(r"<p>(.*?)</p>", rows[-1])]
        cells = [re.findall(r"<p>(.*?)</p>", row, re.S) for row in rows[1:-1]]
        place = 1 if name == "contents" else 2
        single = [c for c in cells if name == "syllabus" or "<strong>" not in c[0]]
        total = sum(int(c[place]) for c in single)
        assert f"{total / 60:.1f} h" in last


@each("path", CHAPTERS)
def test_a_file_has_the_number_and_words_of_its_title(path):
    title = notebooks.read(path).cells[0].source.split("\n")[0].lower()
    words = set(re.findall(r"\w+", title))
    assert set(path.stem[3:].split("_")) <= words, (path.stem, title)


def test_a_word_of_the_glossary_leads_to_a_chapter_that_has_it():
    glossary = (ROOT / "book" / "glossary.md").read_text("utf-8")
    entries = re.findall(r"^(\w[^\n]*)\n((?:  .*\n)+)", glossary, re.MULTILINE)
    for term, body in entries:
        for page in re.findall(r"\]\((\w+\.ipynb)\)", body)[:1]:
            text = (ROOT / "book" / page).read_text("utf-8").lower()
            assert term.lower().split()[0][:7] in text, (term, page)
    assert len(entries) > 70
