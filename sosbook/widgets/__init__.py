"""Live sliders for Jupyter: each move solves the LMIs again.

The pictures are SVG strings in one HTML widget: drawing them takes a
millisecond, so a move costs what the design costs. One module for each
explorer.
"""

from .design import explore_design
from .explorer import Explorer
from .hinf import explore_hinf
from .region import explore_region
from .saturation import explore_saturation
from .segment import explore_segment

__all__ = [
    "Explorer",
    "explore_design",
    "explore_hinf",
    "explore_region",
    "explore_saturation",
    "explore_segment",
]
