"""Laws: the sensors of a controller, its memory, and its free gains."""

from ..runtime.later import by_name
from .base import Law, Parts, Structure
from .full_state import FullState

__all__ = ["FullState", "Law", "Parts", "Structure"]
_HOMES = {"DynamicLaw": "laws.dynamic", "PIDLaw": "laws.pid"}
_HOMES["Scheduled"] = "laws.scheduled"
_HOMES |= dict.fromkeys(("Filter", "ShapedLaw"), "laws.shaped")
__all__ += _HOMES
__getattr__ = by_name(__name__, _HOMES)
