"""Plants: second-order systems, their polytopes and descriptor forms."""

from .condensing import condense
from .coupled import Coupled, SlackVertex
from .descriptor import Descriptor, descriptors, mean_descriptor
from .descriptor_system import DescriptorSystem
from .files import load_plant
from .filtered import filtered
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
    "condense",
    "descriptors",
    "filtered",
    "load_plant",
    "mean_descriptor",
]
