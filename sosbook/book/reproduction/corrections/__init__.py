"""Corrections to the thesis's text, and what was found right.

Our copy is a machine-read text: a correction of one character carries
the kind of a single character, for it may be the copy's.
"""

from functools import cache

from .delay import delayed
from .design import DESIGN_ERRATA
from .pendulum import pendulum
from .regulators import REGULATOR_ERRATA
from .right import CHECKED

__all__ = ["checked", "errata"]


@cache
def errata():
    """Corrections to the text that this edition relies on."""
    return (*DESIGN_ERRATA, *delayed(), *REGULATOR_ERRATA, *pendulum())


def checked():
    """Formulas of the thesis that were checked and found right."""
    return CHECKED
