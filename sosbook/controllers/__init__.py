"""What runs: a controller with its memory, limits and set points, and its programs."""

from .bounded import Bounded
from .code import code_fault, read_gains
from .compiled import CompiledCode
from .controller import Controller
from .describing import Cycle
from .limits import FAULTS, Faults, Limits
from .of_design import controller_of
from .program import Code
from .replay import Replay
from .report import write_report
from .sampled_design import SampledDesign, design_sampled
from .signals import Signal
from .simulation import Backlash, Run
from .windup import Reach

__all__ = [
    "FAULTS",
    "Backlash",
    "Bounded",
    "Code",
    "CompiledCode",
    "Controller",
    "Cycle",
    "Faults",
    "Limits",
    "Reach",
    "Replay",
    "Run",
    "SampledDesign",
    "Signal",
    "code_fault",
    "controller_of",
    "design_sampled",
    "read_gains",
    "write_report",
]
