"""Elements of the rendered page: they work without a server."""

from .bench import Bench, bench
from .delay import DelayAtlas, delay_atlas
from .explorer import Explorer, design_explorer
from .maps import MapAtlas
from .own_theorem import OwnTheorem, own_theorem

__all__ = [
    "Bench",
    "DelayAtlas",
    "Explorer",
    "MapAtlas",
    "OwnTheorem",
    "bench",
    "delay_atlas",
    "design_explorer",
    "own_theorem",
]
