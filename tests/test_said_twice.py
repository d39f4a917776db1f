"""No phrase of a page is said twice in a row, and no row of a table stands twice."""

import re

import pytest

from sosbook.book import notebooks

PAGES = [*notebooks.BOOK.glob("*.ipynb"), *notebooks.BOOK.glob("*.md")]
FORMULAS = re.compile(r"```.*?```|\$\$.*?\$\$|\$[^$]*\$|`[^`]*`", re.DOTALL)
AGAIN = re.compile(r"\b(\w[\w'’]*(?:[ \n]\w[\w'’]*){1,5})[\s:]+\1\b")
RULE = re.compile(r"\|[\s:|-]+\|")


def passages(path):
    """The prose of a page: its Markdown cells, or all of it."""
    if path.suffix == ".md":
        return [path.read_text("utf-8")]
    cells = notebooks.read(path).cells
    return [cell.source for cell in cells if cell.cell_type == "markdown"]


def phrases(text):
    """Phrases of two words and more that follow themselves; letters may."""
    prose = FORMULAS.sub("\N{SECTION SIGN}", text)
    found = [match[1] for match in AGAIN.finditer(prose)]
    return [phrase for phrase in found if max(map(len, phrase.split())) > 1]


def rows(text):
    """Rows that a table has twice; each table begins with its own header."""
    found, table, lines = [], set(), text.split("\n")
    for line, below in zip(lines, [*lines[1:], ""], strict=True):
        if not line.startswith("|") or RULE.fullmatch(below.strip()):
            table = set()
        elif line.strip("| ") and not RULE.fullmatch(line.strip()):
            found += [line] * (line in table)
            table.add(line)
    return found


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_nothing_is_said_twice(path):
    for text in passages(path):
        assert not phrases(text)
        assert not rows(text)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_a_reference_to_an_exercise_says_exercise_once(path):
    """Its own text is "Exercise 9.3"."""
    for text in passages(path):
        assert not re.search(r"exercise\s+\{ref\}`ex-", text, re.IGNORECASE)
