"""Code that draws, imports or tests is folded; what states and proves is in sight."""

import ast
import re
from pathlib import Path

import pytest

from sosbook.book.notebooks import BOOK, read

NOTEBOOKS = sorted(BOOK.glob("*.ipynb"))
DRAWN = ('<figure class="sos-figure"', "<sos-")
AGREES = re.compile(r"\b(allclose|isclose|array_equal|same)\(")
CONTROL = re.compile(r"\bsos\.design_\w+\(|\.(certify|prove|refuse)\(")


def cells(path):
    """The cells of code that are on the page, each with the text before it."""
    before = ""
    for cell in read(path).cells:
        if cell.cell_type == "markdown":
            before = cell.source
        elif "remove-input" not in cell.metadata.get("tags", []):
            yield cell, before


def folded(cell):
    return "hide-input" in cell.metadata.get("tags", [])


def draws(cell):
    """Whether the cell shows a figure or an element of the page."""
    shown = (output.get("data", {}).get("text/html", "") for output in cell.outputs)
    return any(html.startswith(DRAWN) for html in shown)


def imports(cell):
    """Whether the cell does nothing but import, and set the style of figures."""
    return all(
        isinstance(line, (ast.Import, ast.ImportFrom))
        or "use_book_style" in ast.unparse(line)
        for line in ast.parse(cell.source).body
    )


def agrees(cell):
    """Whether all that the cell shows is that two computations agree."""
    said = "".join(output.get("text", "") for output in cell.outputs).strip()
    true = all(line.endswith("True") for line in said.split("\n"))
    claims = CONTROL.search(cell.source) or "proven" in cell.source
    return bool(AGREES.search(cell.source)) and true and not claims


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: Path(path).stem)
def test_what_draws_or_imports_is_folded_and_control_is_not(path):
    for cell, before in cells(path):
        solution = "{solution" in before
        said = "".join(output.get("text", "") for output in cell.outputs)
        assert said.strip() not in ("True", "False"), cell.source
        if draws(cell) or imports(cell) or (agrees(cell) and not solution):
            assert folded(cell), cell.source
        if folded(cell) and not solution and not cell.source.count("_atlas("):
            assert not CONTROL.search(cell.source), cell.source
