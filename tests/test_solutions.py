"""The programs in the solutions of the exercises run as printed."""

import re

import matplotlib
import matplotlib.pyplot as plt
import pytest

from sosbook import notebooks
from tests import compiler

matplotlib.use("agg")
SOLUTION = re.compile(r":::\{solution\}(.*?)^:::$", re.DOTALL | re.MULTILINE)
PROGRAM = re.compile(r"```python\n(.*?)```", re.DOTALL)


def programs(notebook):
    """The Python blocks of all solutions, in order."""
    text = "\n".join(
        c.source for c in notebook.cells if c.cell_type == "markdown")
    return [p for s in SOLUTION.findall(text) for p in PROGRAM.findall(s)]


CHAPTERS = [
    path for path in sorted(notebooks.BOOK.glob("*.ipynb"))
    if programs(notebooks.read(path))
]


def test_there_are_programs_to_run():
    assert len(CHAPTERS) >= 5


@pytest.mark.parametrize("path", CHAPTERS, ids=lambda path: path.stem)
def test_solutions_run_after_the_chapter(path, capsys):
    if path.name in compiler.CHAPTERS and compiler.find() is None:
        compiler.refuse()
    chapter = notebooks.read(path)
    names = {}
    for cell in chapter.cells:
        live = notebooks.LIVE & set(cell.metadata.get("tags", []))
        if cell.cell_type == "code" and not live:
            if "_atlas(" not in cell.source:
                exec(cell.source, names)
    for program in programs(chapter):
        exec(program, names)
    plt.close("all")
    assert capsys.readouterr().err == ""
