"""Controllers with memory, limits and set points, and their programs."""

from ..runtime.later import by_name
from .bounded import Bounded
from .code import code_fault, read_gains
from .compiled import CompiledCode
from .controller import Controller
from .describing import Cycle, predicted_cycles
from .frequency import OpenLoop
from .limits import FAULTS, Faults, Limits
from .margins import Margin, Margins
from .motions import Motions, Move
from .of_design import controller_of
from .output_bounds import OutputBounds
from .profile import Profile
from .program import Code
from .replay import Replay
from .report import write_report
from .signals import Readings, Signal
from .simulation import Backlash, Run
from .step_bounds import StepBounds
from .step_limits import StepLimits
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
    "Margin",
    "Margins",
    "Motions",
    "Move",
    "OpenLoop",
    "OutputBounds",
    "Profile",
    "Reach",
    "Readings",
    "Replay",
    "Run",
    "Signal",
    "StepBounds",
    "StepLimits",
    "code_fault",
    "controller_of",
    "predicted_cycles",
    "read_gains",
    "write_report",
]
_HOMES = dict.fromkeys(  # gains that the room of a law's search finds
    ("SampledDesign", "design_sampled"), "controllers.sampled_design"
)
__all__ += _HOMES
__getattr__ = by_name(__name__, _HOMES)
