"""Linear matrix inequalities, posed, solved and proven: an `LMIProblem`."""

from ..language import Affine, Unknown, block, eye, he
from .problem import LMIProblem
from .written import matrix, pairs, symmetric

__all__ = [
    "Affine",
    "LMIProblem",
    "Unknown",
    "block",
    "eye",
    "he",
    "matrix",
    "pairs",
    "symmetric",
]
