"""What holds of what is printed: rows for the book's tables and tests.

Every "ours" is computed when `rows` is called; the verdict follows from
it. `errata` lists corrections to the printed text, with their evidence.
What is written stands in three tables: ``rows.toml``, ``corrections.toml`` and
``assumptions.toml``; what is computed, in one module for each subject.
"""

from functools import cache
from importlib import import_module

from .corrections import assumptions, checked, errata, readings
from .table import KINDS, VERDICTS, Erratum, Row

__all__ = [
    "KINDS",
    "VERDICTS",
    "Erratum",
    "Row",
    "assumptions",
    "checked",
    "errata",
    "readings",
    "rows",
]

#: The modules of this folder that compute rows, in the order of the thesis.
_SUBJECTS = (
    *("singular_mass", "vertices", "examples", "example_4", "integrators", "delay"),
    *("regulators", "observer", "mip", "sampled", "desk", "remarks"),
)


@cache
def rows():
    """All rows, computed, in the order of the thesis."""
    subjects = (import_module(f".{name}", __name__) for name in _SUBJECTS)
    return tuple(row for subject in subjects for row in subject.rows())
