"""LMI design of second-order systems: PID control that is proven.

Reads M z'' + D z' + S z = B u + F w; follows D. S. Gontijo, "Control
Techniques for Uncertain Second Order Systems: An LMI Approach" (2023).
"""

from importlib import import_module as _import_module

from . import aliases as _aliases, delay, sampled
from .analysis.nonlinear import Steps, simulate_nonlinear
from .analysis.response import Response, Sine
from .delay import DelayDesign, analyse_delay, design_delay_pid
from .plants.descriptor_system import DescriptorSystem
from .plants.second_order import Polytope, SecondOrderSystem
from .requirements.cost import QuadraticCost
from .requirements.input_bound import Saturation
from .requirements.pole_region import LMIRegion, PoleRegion, Region
from .sampled import SampledLQR, certify_sampled, design_sampled_lqr
from .synthesis.integrators import IntegratorChoice, admissible_U
from .synthesis.lqr import design_lqr
from .synthesis.observer import ObserverDesign, design_observer, observer_loop
from .synthesis.pid import Design, analyse_loop, analyse_pid, design_pid
from .synthesis.regularization import (
    InfiniteModes,
    Regularization,
    infinite_modes,
    regularize,
)

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


def __getattr__(name):
    """Rooms that most programs don't need are imported when they are asked for."""
    if name in _aliases.MODULES:
        return _import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__():
    return sorted({*globals(), *__all__})


_aliases.install()
