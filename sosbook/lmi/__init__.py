"""Linear matrix inequalities: expressions, centre, cones, exact proofs."""

from .expression import Affine, Unknown, block, eye, he
from .problem import LMIProblem

__all__ = ["Affine", "LMIProblem", "Unknown", "block", "eye", "he"]
