"""Linear matrix inequalities: expressions, centre, cones, exact proofs."""

from .expression import Affine, Unknown, block, eye, he

__all__ = ["Affine", "Unknown", "block", "eye", "he"]
