"""LMIs as they are written: unknowns, affine expressions, blocks."""

from .expression import Affine, Unknown, block, eye, he

__all__ = ["Affine", "Unknown", "block", "eye", "he"]
