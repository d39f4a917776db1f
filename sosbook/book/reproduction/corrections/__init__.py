"""Corrections to the thesis's text, and what was found right.

Our copy is a machine-read text: a correction of one character carries
the kind of a single character, for it may be the copy's.
"""

from functools import cache

from .delay import delay
from .design import design
from .pendulum import pendulum
from .regulators import regulators
from .right import checked

__all__ = ["checked", "errata"]


@cache
def errata():
    """Corrections to the text that this edition relies on."""
    return (*design(), *delay(), *regulators(), *pendulum())
