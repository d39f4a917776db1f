"""What runs: a controller with its memory, limits and set points, and its programs."""

from .controller import FAULTS, Controller
from .limits import Faults, Limits
from .of_design import controller_of
from .replay import Replay
from .signals import Signal
from .simulation import Backlash, Run

__all__ = [
    "FAULTS",
    "Backlash",
    "Controller",
    "Faults",
    "Limits",
    "Replay",
    "Run",
    "Signal",
    "controller_of",
]
