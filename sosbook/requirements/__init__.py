"""What can be asked of a loop: one file a requirement, one protocol for all.

`base` holds the protocol, `vocabulary` the bounds' names and directions,
`shorthand` what the keywords of the design functions stand for.
"""

from .base import Requirement
from .cost import QuadraticCost
from .h2 import H2
from .hinf import HInfinity
from .input_bound import Saturation
from .pole_region import LMIRegion, PoleRegion, Region
from .vocabulary import Parameter

__all__ = [
    "H2",
    "HInfinity",
    "LMIRegion",
    "Parameter",
    "PoleRegion",
    "QuadraticCost",
    "Region",
    "Requirement",
    "Saturation",
]
