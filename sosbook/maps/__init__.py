"""Feasibility maps: how much can be asked, proven from both sides.

`edge` pushes one requirement, `frontier` two; `sweep` runs any function
over many points in parallel; `MapAtlas` shows frontiers in a page.
"""

from .atlas import MapAtlas
from .edges import Edge, Frontier, edge, frontier, request
from .parallel import sweep
from .search import requirements, shown

__all__ = [
    "Edge",
    "Frontier",
    "MapAtlas",
    "edge",
    "frontier",
    "request",
    "requirements",
    "shown",
    "sweep",
]
