"""Elements of the rendered page: they work without a server."""

from .delay import DelayAtlas, delay_atlas
from .designs import Atlas, Slider, design_atlas, record
from .maps import MapAtlas

__all__ = [
    "Atlas",
    "DelayAtlas",
    "MapAtlas",
    "Slider",
    "delay_atlas",
    "design_atlas",
    "record",
]
