"""Elements of the rendered page: they work without a server."""

from ...runtime.later import by_name
from .bench import Bench, bench
from .explorer import Explorer, design_explorer
from .maps import MapAtlas
from .own_theorem import OwnTheorem, own_theorem

__all__ = [
    "Bench",
    "Explorer",
    "MapAtlas",
    "OwnTheorem",
    "bench",
    "design_explorer",
    "own_theorem",
]
_HOMES = dict.fromkeys(("DelayAtlas", "delay_atlas"), "book.elements.delay")
__all__ += _HOMES
__getattr__ = by_name(__name__, _HOMES)
