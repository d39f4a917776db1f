"""Plants: second-order systems, their polytopes and descriptor forms."""

from ..runtime.later import by_name
from .coupled import Coupled, SlackVertex
from .descriptor import Descriptor, descriptors, mean_descriptor
from .descriptor_system import DescriptorSystem
from .gain import Gain
from .outputs import Output
from .reduction import Reduction
from .second_order import Polytope, SecondOrderSystem

__all__ = [
    "Coupled",
    "Descriptor",
    "DescriptorSystem",
    "Gain",
    "Output",
    "Polytope",
    "Reduction",
    "SecondOrderSystem",
    "SlackVertex",
    "descriptors",
    "mean_descriptor",
]
_HOMES = {
    "InputShaper": "plants.shaper",
    "MeasuredResponse": "plants.measured",
    "condense": "plants.condensing",
    "filtered": "plants.filters",
    "load_plant": "plants.files",
}
__all__ += _HOMES
__getattr__ = by_name(__name__, _HOMES)
