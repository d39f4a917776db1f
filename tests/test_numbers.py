"""The numbers of chapters, theorems, equations, exercises, figures and tables."""

import json
import re
from html import unescape
from pathlib import Path

import pytest

from tests.each import each

ROOT = Path(__file__).resolve().parent.parent
CHAPTERS = sorted(path.stem for path in (ROOT / "book").glob("[0-9][0-9]_*.ipynb"))
THINGS = "Theorem|Lemma|Proposition|Corollary|Definition|Exercise|Figure|Table"
CAPTION = re.compile(rf'caption-number">(?:\s*)({THINGS}) ([\d.]+?)\.? *<')
EQUATION = re.compile(r'class="eqno">\(([\d.]+)\)')
LINK = re.compile(r'<a class="reference internal" href="([^"]*)"[^>]*>(.*?)</a>', re.S)
PLACE = re.compile(r'\bid="([^"]+)"')
CITED = re.compile(rf"^(?:({THINGS}) )?\(?(\d+\.\d+)\)?$")
each_chapter = each("chapter", CHAPTERS)


@pytest.fixture(scope="module")
def pages(site):
    """The HTML of the pages by their names."""
    return {path.stem: path.read_text("utf-8") for path in site.glob("book/*.html")}


@pytest.fixture(scope="module")
def places(pages):
    """Of each page where its places begin, by their names; of two alike the first."""
    return {
        name: {m[1]: m.start() for m in reversed([*PLACE.finditer(html)])}
        for name, html in pages.items()
    }


def number(chapter):
    """The number of a chapter; the first pages, which teach nothing yet, have none."""
    return int(chapter[:2]) or None


def numbered(html):
    """(kind, number) of what has a number on a page, in the order of the page."""
    found = [(m.start(), m[1], m[2]) for m in CAPTION.finditer(html)]
    found += [(m.start(), "equation", m[1]) for m in EQUATION.finditer(html)]
    return [(kind, text) for _, kind, text in sorted(found)]


def test_chapters_have_the_numbers_of_their_files(pages):
    contents = pages["intro"]
    for chapter in CHAPTERS:
        heading = re.search(r"<h1>(.*?)<", pages[chapter] + "<")[1]
        title = re.search(r"<title>(.*?)&#8212;", pages[chapter], re.S)[1].strip()
        section = re.search(r'<h1><span class="section-number">(\d+)\.', pages[chapter])
        in_contents = re.search(rf'href="{chapter}.html">(\d+)?', contents)[1]
        if number(chapter):
            assert int(section[1]) == int(in_contents) == number(chapter)
            assert title.startswith(f"{number(chapter)}. ")
        else:
            assert section is in_contents is None and heading


@each_chapter
def test_things_count_by_chapter(pages, chapter):
    counts = {}
    for kind, text in numbered(pages[chapter]):
        counts[kind] = counts.get(kind, 0) + 1
        count = str(counts[kind])
        whole = f"{number(chapter)}.{count}" if number(chapter) else count
        assert text == whole, kind


def test_pages_outside_the_chapters_count_from_one(pages):
    for page in set(pages) - set(CHAPTERS):
        counts = {}
        for kind, text in numbered(pages[page]):
            counts[kind] = counts.get(kind, 0) + 1
            assert text == str(counts[kind]), (page, kind)


@each_chapter
def test_each_figure_and_table_of_a_cell_has_a_number_and_a_place(pages, chapter):
    cells = json.loads((ROOT / f"book/{chapter}.ipynb").read_text("utf-8"))["cells"]
    shown = [
        "".join(output.get("data", {}).get("text/html", ""))
        for cell in cells
        if "remove-output" not in cell["metadata"].get("tags", [])
        for output in cell.get("outputs", [])
    ]
    html = pages[chapter]
    for start, kind in (
        ('<figure class="sos-figure"', "Figure"),
        ('<div class="sos-table"', "Table"),
    ):
        there = sum(text.startswith(start) for text in shown)
        assert len(re.findall(rf'{start} id="[^"]+"', html)) == there
        assert sum(what == kind for what, _ in numbered(html)) == there


@each_chapter
def test_a_citation_leads_to_what_has_its_number(pages, places, chapter):
    for address, words in LINK.findall(pages[chapter]):
        text = unescape(re.sub(r"<[^>]+>", "", words)).strip()
        cited = CITED.match(text)
        page, _, place = address.partition("#")
        if not cited or not place:
            continue
        name = page.removesuffix(".html") if page else chapter
        start = places[name].get(place)
        assert start is not None, address
        here = (CAPTION if cited[1] else EQUATION).search(pages[name], start)
        assert here[here.lastindex] == cited[2], (text, address)
        assert not cited[1] or here[1] == cited[1]


@each_chapter
def test_chapters_that_the_text_names_are_those_that_it_links(chapter):
    cells = json.loads((ROOT / f"book/{chapter}.ipynb").read_text("utf-8"))["cells"]
    text = "\n".join(
        "".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown"
    )
    for named, linked in re.findall(r"\[[Cc]hapter (\d+)\]\((\d\d)_", text):
        assert int(named) == int(linked)
