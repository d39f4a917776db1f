"""LMIs as they are written: unknowns, affine expressions, blocks."""

from ..runtime.later import by_name
from .expression import Affine, Unknown, eye, he
from .layout import block
from .words import kron, named, pick, tr, turned

__all__ = [
    "Affine",
    "Unknown",
    "block",
    "eye",
    "he",
    "kron",
    "named",
    "pick",
    "tr",
    "turned",
]
_HOMES = {"Traced": "language.traced"}
__all__ += _HOMES
__getattr__ = by_name(__name__, _HOMES)
