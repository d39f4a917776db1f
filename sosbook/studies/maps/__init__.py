"""Feasibility maps: how much can be asked, proven from both sides.

`edge` pushes one requirement, `frontier` two; `feasibility_map` decides a
grid of them. `designs` solves many specifications, each from the last;
`sweep` runs any function over many points in parallel.
"""

from .edges import Edge, edge, request
from .frontiers import Frontier, frontier
from .grid import FeasibilityMap, feasibility_map
from .parallel import sweep
from .search import requirements, shown
from .series import designs

__all__ = [
    "Edge",
    "FeasibilityMap",
    "Frontier",
    "designs",
    "edge",
    "feasibility_map",
    "frontier",
    "request",
    "requirements",
    "shown",
    "sweep",
]
