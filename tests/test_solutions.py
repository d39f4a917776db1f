"""Every exercise has a solution, whose program is cells between two gates::

:::{solution-start} ex-01-damping
:class: dropdown
:::
"""

import re

import nbformat.v4 as v4
import pytest

from sosbook.book import notebooks
from tests.each import each

MARKS = re.compile(
    r"^:::\{exercise\}.*\n:label: (?P<exercise>\S+)$"
    r"|^:::\{solution\} (?P<solution>\S+)\n:class: dropdown$"
    r"|^:::\{solution-start\} (?P<start>\S+)\n:class: dropdown\n:::$"
    r"|^:::\{(?P<end>solution-end)\}\n:::$"
    r"|^(?P<close>:::)$"
    r"|^ *(?P<program>(?:```+|~~~+) *\{?(?:code-block\} *|code\} *)?i?python)"
    r"|^ *(?P<stray>:::+\{(?:exercise|solution).*)$",
    re.MULTILINE,
)


def faults(notebook):
    """What is wrong with the exercises of a page, in words."""
    text = "\n\n".join(
        cell.source for cell in notebook.cells if cell.cell_type == "markdown"
    )
    asked, answered, found = [], [], []
    inside = gated = None
    for mark in MARKS.finditer(text):
        kind, label = mark.lastgroup, mark[mark.lastgroup]
        if kind == "stray":
            found.append(f"not understood: {label}")
        elif kind == "program" and inside:
            found.append(f"a program of {inside} isn't a cell")
        elif kind == "end" and not gated:
            found.append("an end without a start")
        elif kind in ("exercise", "solution", "start"):
            if gated:
                found.append(f"{gated} has no end before {label}")
            (asked if kind == "exercise" else answered).append(label)
            gated = label if kind == "start" else None
            inside = label if kind != "exercise" else None
        elif kind == "end" or (kind == "close" and not gated):
            inside = gated = None
    if gated:
        found.append(f"{gated} has no end")
    if asked != answered:
        found.append(f"exercises {asked}, but solutions {answered}")
    return found


@each("path", sorted(notebooks.BOOK.glob("*.ipynb")))
def test_exercises_and_solutions_match(path):
    notebook = notebooks.read(path)
    assert faults(notebook) == []
    chapter = re.match(r"\d\d_|performance|sharper_|second_", path.stem)
    assert ("{exercise}" in str(notebook.cells)) == bool(chapter)


@pytest.mark.parametrize(
    "solution, fault",
    [
        (":::{solution} ex-a\n:class: dropdown\n\nSo.\n:::", None),
        (":::{solution} ex-b\n:class: dropdown\n\nSo.\n:::", "ex-b"),
        (":::{solution} ex-a\n:class: dropdown\n\n```python\n1\n```\n:::", "a cell"),
        (":::{solution-start} ex-a\n:class: dropdown\n:::", "has no end"),
        ("So.", "but solutions []"),
    ],
)
def test_a_fault_is_named(solution, fault):
    exercise = ":::{exercise} More\n:label: ex-a\n\nWhy?\n:::"
    cells = [v4.new_markdown_cell(text) for text in (exercise, solution)]
    page = v4.new_notebook(cells=cells)
    assert fault is None if faults(page) == [] else fault in " ".join(faults(page))
