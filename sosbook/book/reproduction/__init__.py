"""The printed statements, judged: rows for the book's tables and tests.

Every "ours" is computed when `rows` is called; the verdict follows from
it. `errata` lists corrections to the printed text, with their evidence.
What is written stands in three tables: ``rows.toml``, ``corrections.toml`` and
``assumptions.toml``; what is computed, in one module for each subject.
"""

from functools import cache

from . import (
    delay,
    desk,
    example_4,
    examples,
    integrators,
    mip,
    observer,
    regulators,
    remarks,
    sampled,
    singular_mass,
    vertices,
)
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

_SUBJECTS = (
    singular_mass,
    vertices,
    examples,
    example_4,
    integrators,
    delay,
    regulators,
    observer,
    mip,
    sampled,
    desk,
    remarks,
)


@cache
def rows():
    """All rows, computed, in the order of the thesis."""
    return tuple(row for subject in _SUBJECTS for row in subject.rows())
