"""Figures of the book: accessible inline SVG, the same bytes on every run.

Small functions draw into Axes; `show` turns a Figure into an output with
an alternative text and a caption. Colours are Okabe and Ito's, which stay
apart for colour-blind readers; marks and dashes differ too.
"""

from ...runtime.later import by_name
from . import mechanisms, sketches
from .bands import envelope, frequency_band, pole_cloud, track_poles
from .ellipsoids import ellipse_outline, ellipsoid
from .identified import identified
from .margins import margins, smallest_of_each
from .output import Figure, show
from .regions import (
    pole_map,
    poles,
    region_outline,
    region_parts,
    shade_region,
    window_of,
)
from .signals import input_limit, response, signal
from .spectra import largest_singular_value, singular_values
from .style import (
    BLUE,
    COLOURS,
    DASHES,
    GREEN,
    GREY,
    INK,
    MARKERS,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    use_book_style,
)

__all__ = [
    "BLUE",
    "COLOURS",
    "DASHES",
    "GREEN",
    "GREY",
    "INK",
    "MARKERS",
    "ORANGE",
    "PURPLE",
    "SKY",
    "VERMILLION",
    "Figure",
    "ellipse_outline",
    "ellipsoid",
    "envelope",
    "frequency_band",
    "identified",
    "input_limit",
    "largest_singular_value",
    "margins",
    "mechanisms",
    "pole_cloud",
    "pole_map",
    "poles",
    "region_outline",
    "region_parts",
    "response",
    "shade_region",
    "show",
    "signal",
    "singular_values",
    "sketches",
    "smallest_of_each",
    "track_poles",
    "use_book_style",
    "window_of",
]
_HOMES = dict.fromkeys(("decay_curve", "delay_signal", "root_map"), "book.plots.delay")
__all__ += _HOMES
__getattr__ = by_name(__name__, _HOMES)
