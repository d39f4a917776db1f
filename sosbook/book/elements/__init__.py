"""Elements of the rendered page: they work without a server."""

from .bench import Bench, bench
from .delay import DelayAtlas, delay_atlas
from .designs import Atlas, Slider, design_atlas
from .explorer import Explorer, design_explorer
from .maps import MapAtlas
from .own_theorem import OwnTheorem, own_theorem
from .records import record
from .stopwatch import Stopwatch, stopwatch

__all__ = [
    "Atlas",
    "Bench",
    "DelayAtlas",
    "Explorer",
    "MapAtlas",
    "OwnTheorem",
    "Slider",
    "Stopwatch",
    "bench",
    "delay_atlas",
    "design_atlas",
    "design_explorer",
    "own_theorem",
    "record",
    "stopwatch",
]
