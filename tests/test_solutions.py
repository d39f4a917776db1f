"""Every exercise has a solution, and the programs of solutions are cells.

A solution with a program stands between gates, in cells of its own::

    :::{solution-start} ex-01-damping
    :class: dropdown
    :::

so its output is stored, shown and derived again as that of any other cell.
"""

import re

import nbformat.v4 as v4
import pytest

from sosbook import notebooks

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


@pytest.mark.parametrize(
    "path", sorted(notebooks.BOOK.glob("*.ipynb")), ids=lambda path: path.stem
)
def test_exercises_and_solutions_match(path):
    notebook = notebooks.read(path)
    assert faults(notebook) == []
    chapter = re.match(r"\d\d_", path.stem)
    assert ("{exercise}" in str(notebook.cells)) == bool(chapter)


EXERCISE = ":::{exercise} More\n:label: ex-a\n\nWhy?\n:::"
SOLUTION = ":::{solution} ex-a\n:class: dropdown\n\nSo.\n:::"
START = ":::{solution-start} ex-a\n:class: dropdown\n:::"
END = ":::{solution-end}\n:::"
PROGRAM = "```python\nprint(1)\n```"


def page(*sources):
    return v4.new_notebook(cells=[v4.new_markdown_cell(s) for s in sources])


@pytest.mark.parametrize(
    "notebook",
    [
        page("# Title", PROGRAM),
        page(EXERCISE, SOLUTION),
        page(EXERCISE, START, "So.", "```text\nx\n```", END, PROGRAM),
        page(f"{EXERCISE}\n\n{START}", f"{END}\n\n## Sources"),
    ],
)
def test_a_good_page_has_no_fault(notebook):
    assert faults(notebook) == []


@pytest.mark.parametrize(
    "notebook, fault",
    [
        (page(EXERCISE), "but solutions []"),
        (page(SOLUTION), "exercises []"),
        (page(EXERCISE, SOLUTION.replace("ex-a", "ex-b")), "['ex-b']"),
        (page(EXERCISE, START.replace("ex-a", "ex-b"), END), "['ex-b']"),
        (page(EXERCISE, SOLUTION, SOLUTION), "['ex-a', 'ex-a']"),
        (page(EXERCISE, SOLUTION.replace("So.", PROGRAM)), "isn't a cell"),
        (page(EXERCISE, START, PROGRAM, END), "isn't a cell"),
        (page(EXERCISE, START, "```{code-block} python\n1\n```", END), "isn't a cell"),
        (page(EXERCISE, START), "ex-a has no end"),
        (page(EXERCISE, START, EXERCISE.replace("ex-a", "ex-b")), "no end before ex-b"),
        (page(EXERCISE, START, START, END), "no end before ex-a"),
        (page(EXERCISE, SOLUTION, END), "end without a start"),
        (page(EXERCISE, START, END, END), "end without a start"),
        (page(":::{exercise} No label\n\nWhy?\n:::"), "not understood"),
        (page(EXERCISE, ":::{solution} ex-a\nOpen.\n:::"), "not understood"),
        (page(EXERCISE, ":::{solution-start} ex-a\n:::", END), "not understood"),
    ],
)
def test_a_fault_is_named(notebook, fault):
    assert any(fault in problem for problem in faults(notebook))
