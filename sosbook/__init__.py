"""LMI design of second-order systems: PID control that is proven.

Reads M z'' + D z' + S z = B u + F w; follows D. S. Gontijo, "Control
Techniques for Uncertain Second Order Systems: An LMI Approach" (2023).
"""

from . import (
    atlas,
    counterexamples,
    plots,
    reproduction,
    tables,
    thesis,
    widgets,
)
from .design import Design, analyse_pid, design_pid
from .regions import LMIRegion, PoleRegion, Region
from .request import Saturation
from .simulate import Response, Sine
from .system import Polytope, SecondOrderSystem

__version__ = "0.1.0"
__all__ = [
    "Design",
    "LMIRegion",
    "PoleRegion",
    "Polytope",
    "Region",
    "Response",
    "Saturation",
    "SecondOrderSystem",
    "Sine",
    "analyse_pid",
    "atlas",
    "counterexamples",
    "design_pid",
    "plots",
    "reproduction",
    "tables",
    "thesis",
    "widgets",
]
