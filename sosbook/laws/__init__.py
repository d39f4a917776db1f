"""What a controller measures, what it remembers, and which of its gains are free."""

from .base import Law, LawGain, Parts, Structure
from .dynamic import DynamicLaw
from .full_state import FullState
from .pid import PIDLaw

__all__ = ["DynamicLaw", "FullState", "Law", "LawGain", "PIDLaw", "Parts", "Structure"]
