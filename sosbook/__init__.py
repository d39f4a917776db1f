"""LMI design of second-order systems: PID control that is proven.

Reads M z'' + D z' + S z = B u + F w; follows D. S. Gontijo, "Control
Techniques for Uncertain Second Order Systems: An LMI Approach" (2023).
"""

from . import (
    atlas,
    counterexamples,
    couplings,
    delay,
    maps,
    mip,
    plots,
    reproduction,
    sampled,
    tables,
    thesis,
    widgets,
)
from .cost import QuadraticCost
from .delay import DelayDesign, analyse_delay, design_delay_pid
from .design import Design, analyse_loop, analyse_pid, design_pid
from .first_order import DescriptorSystem
from .integrators import IntegratorChoice, admissible_U
from .lqr import design_lqr
from .nonlinear import Steps, simulate_nonlinear
from .observer import ObserverDesign, design_observer, observer_loop
from .regions import LMIRegion, PoleRegion, Region
from .regularization import (
    InfiniteModes,
    Regularization,
    infinite_modes,
    regularize,
)
from .request import Saturation
from .sampled import SampledLQR, certify_sampled, design_sampled_lqr
from .simulate import Response, Sine
from .system import Polytope, SecondOrderSystem

__version__ = "0.1.0"
__all__ = [
    "DelayDesign",
    "Design",
    "DescriptorSystem",
    "InfiniteModes",
    "IntegratorChoice",
    "LMIRegion",
    "ObserverDesign",
    "PoleRegion",
    "Polytope",
    "QuadraticCost",
    "Region",
    "Regularization",
    "Response",
    "SampledLQR",
    "Saturation",
    "SecondOrderSystem",
    "Sine",
    "Steps",
    "admissible_U",
    "analyse_delay",
    "analyse_loop",
    "analyse_pid",
    "atlas",
    "certify_sampled",
    "counterexamples",
    "couplings",
    "delay",
    "design_delay_pid",
    "design_lqr",
    "design_observer",
    "design_pid",
    "design_sampled_lqr",
    "infinite_modes",
    "maps",
    "mip",
    "observer_loop",
    "plots",
    "regularize",
    "reproduction",
    "sampled",
    "simulate_nonlinear",
    "tables",
    "thesis",
    "widgets",
]
