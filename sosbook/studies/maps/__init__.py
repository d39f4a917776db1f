"""Feasibility maps: how much can be asked, proven from both sides.

`edge` pushes one requirement, `frontier` two; `feasibility_map` decides a
grid of them. `farthest` pushes the range of a parameter. `designs` solves many
specifications, each from the last; `sweep` runs any function over many points
in parallel.
"""

from .edges import Edge, edge, request
from .farthest import Farthest, farthest
from .frontiers import Frontier, frontier
from .grid import FeasibilityMap, feasibility_map
from .parallel import sweep
from .search import requirements, shown
from .series import designs

__all__ = [
    "Edge",
    "Farthest",
    "FeasibilityMap",
    "Frontier",
    "designs",
    "edge",
    "farthest",
    "feasibility_map",
    "frontier",
    "request",
    "requirements",
    "shown",
    "sweep",
]
