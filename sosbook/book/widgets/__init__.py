"""Sliders for Jupyter: a page's explorer, or a function of your own.

`live` gives an explorer of the pages the package behind it; `sliders` calls any
function of numbers again at each move. On the pages, where no kernel runs, both show
what they show at first.
"""

from ...runtime.libraries import library

library("ipywidgets")  # its extra has all that the sliders need

from .live import live
from .sliders import sliders

__all__ = ["live", "sliders"]
