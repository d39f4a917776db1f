"""LMIs as they are written: unknowns, affine expressions, blocks."""

from .expression import Affine, Unknown, block, eye, he
from .traced import Traced
from .words import kron, named, pick, tr, turned

__all__ = [
    "Affine",
    "Traced",
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
