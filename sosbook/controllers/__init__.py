"""What runs: a controller with its memory, limits and set points, and its programs."""

from .code import code_fault, read_gains
from .compiled import CompiledCode
from .controller import FAULTS, Controller
from .limits import Faults, Limits
from .of_design import controller_of
from .program import Code
from .replay import Replay
from .signals import Signal
from .simulation import Backlash, Run

__all__ = [
    "FAULTS",
    "Backlash",
    "Code",
    "CompiledCode",
    "Controller",
    "Faults",
    "Limits",
    "Replay",
    "Run",
    "Signal",
    "code_fault",
    "controller_of",
    "read_gains",
]
