"""Feasibility maps, proven from both sides: `edge` pushes one requirement, `frontier`
two: its ``status`` decides every cell. `farthest` pushes the range of a parameter,
`designs` solves many specifications, `sweep` runs any function over many points.
"""

from .edges import Edge, edge, request
from .farthest import Farthest, farthest
from .frontiers import Frontier, frontier
from .parallel import sweep
from .search import requirements, shown
from .series import designs

__all__ = [
    "Edge",
    "Farthest",
    "Frontier",
    "designs",
    "edge",
    "farthest",
    "frontier",
    "request",
    "requirements",
    "shown",
    "sweep",
]
