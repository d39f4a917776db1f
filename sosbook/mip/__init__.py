"""The mobile inverted pendulum of chapter 4."""

from .model import R_G, V_MAX, Mip
from .spread import polytope, reduced, vertices

__all__ = ["Mip", "R_G", "V_MAX", "polytope", "reduced", "vertices"]
