"""The printed statements, judged: rows for the book's tables and tests.

Every "ours" is computed when `rows` is called; the verdict follows from
it. `errata` lists corrections to the printed text, with their evidence.
What is written stands in three tables: ``rows.toml``, ``corrections.toml`` and
``assumptions.toml``; what is computed, in one module for each subject.
"""

from functools import cache

from ...runtime.later import by_name, later
from .table import KINDS, VERDICTS, Erratum, Row

__all__ = ["KINDS", "VERDICTS", "Erratum", "Row", "rows"]
_HOMES = dict.fromkeys(
    ("assumptions", "checked", "errata", "readings"), "book.reproduction.corrections"
)
__all__ += _HOMES
__getattr__ = by_name(__name__, _HOMES)
SUBJECTS = (
    "singular_mass",
    "vertices",
    "examples",
    "example_4",
    "integrators",
    "delay",
    "regulators",
    "observer",
    "mip",
    "sampled",
    "desk",
    "remarks",
)


@cache
def rows():
    """All rows, computed, in the order of the thesis; every room is needed for them."""
    subjects = [later(f"book.reproduction.{name}", "rows") for name in SUBJECTS]
    return tuple(row for subject in subjects for row in subject())
