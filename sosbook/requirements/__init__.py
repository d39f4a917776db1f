"""Requirements on a loop: one file for each, one protocol for all.

`base` holds the protocol, `vocabulary` the bounds' names and directions,
`shorthand` what the keywords of the design functions stand for.
"""

from ..runtime.later import by_name
from .base import Requirement
from .cost import QuadraticCost
from .hinf import HInfinity
from .input_bound import Saturation
from .pole_region import LMIRegion, PoleRegion, Region
from .vocabulary import Parameter

__all__ = [
    "HInfinity",
    "LMIRegion",
    "Parameter",
    "PoleRegion",
    "QuadraticCost",
    "Region",
    "Requirement",
    "Saturation",
]
_HOMES = {"H2": "requirements.h2"}
__all__ += _HOMES
__getattr__ = by_name(__name__, _HOMES)
