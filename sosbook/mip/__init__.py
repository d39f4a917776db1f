"""The mobile inverted pendulum of chapter 4."""

from .model import R_G, V_MAX, Mip
from .spread import polytope, vertices

__all__ = ["Mip", "R_G", "V_MAX", "polytope", "vertices"]
