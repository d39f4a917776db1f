"""The minutes that a page takes to read, by one rule for all pages.

180 words of prose take a minute. A formula that stands alone takes a minute, one within
a line three seconds, a line of code in sight five seconds, a figure, a table or an
element a minute. Exercises and their solutions, boxes that are folded, and sections for
readers of the thesis or for a second reading aren't counted. The sum is rounded to five
minutes.

``python -m sosbook.book.minutes`` writes the minutes of each chapter into its line
"**Time:** 40 min to read"; the tests compare the two.
"""

import re
import sys
from pathlib import Path

from ..runtime.libraries import library
from ..runtime.reading import read_text
from ..runtime.writing import write_file
from . import notebooks

v4 = library("nbformat.v4")

WORDS, ALONE, WITHIN, LINE, SHOWN = 180, 1, 1 / 20, 1 / 12, 1
STEP = 5
NOT_READ = (
    r"(?s):::+\{solution-start\}.*?:::+\{solution-end\}",
    r"(?ms)^(:::+)\{(?:exercise|solution)\}.*?^\1\s*$",
    r"(?ms)^(:::+)\{admonition\}[^\n]*\n:class: [^\n]*dropdown.*?^\1\s*$",
    r"(?ms)^(:::+)\{dropdown\}.*?^\1\s*$",
    r"(?ms)^#+ For (?:readers of the thesis|a second reading).*?(?=^#{1,2} |\Z)",
)
FORMULAS = ((r"(?s)\$\$.*?\$\$", ALONE), (r"\$[^$]+\$", WITHIN))
ASIDE = (r"(?<=\])\([^)]*\)", r"\{[\w:]+\}", r"^\|[-| :]+\|$")
WORD = re.compile(r"[A-Za-z][\w'’-]*")
TIME = re.compile(r"(\*\*Time:\*\* )(\d+)( min to read\b)")
CODE = "\N{OBJECT REPLACEMENT CHARACTER}"


def read(path):
    """The notebook at a ``path``, or a page of Markdown as one of a single cell."""
    if path.suffix == ".ipynb":
        return notebooks.read(path)
    text = read_text(path)
    return v4.new_notebook(cells=[v4.new_markdown_cell(text)])


def measured(notebook):
    """The minutes of a ``notebook`` by the rule, not rounded; cells of parts that
    aren't read don't count.
    """
    cells, text = notebook.cells, ""
    for k, cell in enumerate(cells):
        text += "\n\n" + (cell.source if cell.cell_type != "code" else f"{CODE}{k}.")
    for part in NOT_READ:
        text = re.sub(part, " ", text)
    minutes = 0
    for formula, each in FORMULAS:
        text, count = re.subn(formula, " ", text)
        minutes += each * count
    for k in re.findall(CODE + r"(\d+)\.", text):
        minutes += _code(cells[int(k)])
    text = re.sub(CODE + r"\d+\.", " ", text)
    for part in ASIDE:
        text = re.sub(part, " ", text, flags=re.MULTILINE)
    return minutes + len(WORD.findall(text)) / WORDS


def _code(cell):
    """The minutes of a cell of code: its lines in sight, and what it draws."""
    tags = cell.metadata.get("tags", [])
    seen = not {"hide-input", "remove-input"} & set(tags)
    lines = sum(bool(line.strip()) for line in cell.source.split("\n"))
    shown = sum("text/html" in out.get("data", {}) for out in cell.outputs)
    return LINE * lines * seen + SHOWN * shown


def stored(notebook):
    """The minutes that the line of a ``notebook`` says, or None."""
    found = TIME.search("\n".join(c.source for c in notebook.cells))
    return found and int(found[2])


def said(notebook):
    """The minutes that the line of a ``notebook`` should say."""
    return max(STEP, STEP * round(measured(notebook) / STEP))


def main(paths):
    """Write the minutes into each notebook of ``paths``, or all, that has that line."""
    for path in map(Path, paths or sorted(notebooks.BOOK.glob("*.ipynb"))):
        notebook = notebooks.read(path)
        if stored(notebook) in (None, said(notebook)):
            continue
        for cell in notebook.cells:
            cell.source = TIME.sub(rf"\g<1>{said(notebook)}\g<3>", cell.source, 1)
        write_file(path, notebooks.text(notebooks.canonical(notebook)))
        print(f"{path.name}: {said(notebook)} min")


if __name__ == "__main__":
    main(sys.argv[1:])
