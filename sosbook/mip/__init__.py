"""The mobile inverted pendulum of chapter 4."""

from .firmware import FAULTS, Controller, Firmware
from .law import SampledLaw
from .model import R_G, V_MAX, Mip
from .spread import polytope, reduced, vertices

__all__ = [
    "Controller",
    "FAULTS",
    "Firmware",
    "Mip",
    "R_G",
    "SampledLaw",
    "V_MAX",
    "polytope",
    "reduced",
    "vertices",
]
