"""Linear matrix inequalities, posed, solved and proven: an `LMIProblem`."""

from ..language import Affine, Unknown, block, eye, he
from .problem import LMIProblem

__all__ = ["Affine", "LMIProblem", "Unknown", "block", "eye", "he"]
