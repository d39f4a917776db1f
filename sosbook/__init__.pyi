# For type checkers: the names that sosbook/__init__.py finds when asked.

from . import delay, sampled
from .analysis.identification import Identification, identify
from .analysis.infinite_modes import InfiniteModes, infinite_modes
from .analysis.nonlinear import simulate_nonlinear
from .analysis.records import Record
from .controllers.sampled_design import SampledDesign, design_sampled
from .delay import DelayDesign, analyse_delay, design_delay_pid
from .laws.dynamic import DynamicLaw
from .laws.full_state import FullState
from .laws.pid import PIDLaw
from .laws.scheduled import Scheduled
from .loops import Clock, Late, Loop, Signal
from .plants.descriptor_system import DescriptorSystem
from .plants.outputs import Output
from .plants.response import Response
from .plants.second_order import MassWarning, Polytope, SecondOrderSystem
from .plants.shaper import InputShaper
from .plants.signals import Ramps, Sine, Step, Steps
from .plants.uncertain import Uncertain
from .requirements.cost import QuadraticCost
from .requirements.h2 import H2
from .requirements.hinf import HInfinity
from .requirements.input_bound import Saturation
from .requirements.pole_region import LMIRegion, PoleRegion, Region
from .requirements.wish import Wish, read_wish
from .sampled import SampledLQR, certify_sampled, design_sampled_lqr, furthest_sampled
from .synthesis.design import Design
from .synthesis.error_loop import observer_loop
from .synthesis.integrators import IntegratorChoice, admissible_U
from .synthesis.lqr import design_lqr
from .synthesis.observer import design_observer
from .synthesis.observer_design import ObserverDesign
from .synthesis.pid import analyse_pid, design_pid
from .synthesis.placement import place_poles
from .synthesis.regularization import Regularization, regularize
from .synthesis.result import Result
from .synthesis.search import Search

__version__: str
__all__ = [
    "H2",
    "Clock",
    "DelayDesign",
    "DescriptorSystem",
    "Design",
    "DynamicLaw",
    "FullState",
    "HInfinity",
    "Identification",
    "InfiniteModes",
    "InputShaper",
    "IntegratorChoice",
    "LMIRegion",
    "Late",
    "Loop",
    "MassWarning",
    "ObserverDesign",
    "Output",
    "PIDLaw",
    "PoleRegion",
    "Polytope",
    "QuadraticCost",
    "Ramps",
    "Record",
    "Region",
    "Regularization",
    "Response",
    "Result",
    "SampledDesign",
    "SampledLQR",
    "Saturation",
    "Scheduled",
    "Search",
    "SecondOrderSystem",
    "Signal",
    "Sine",
    "Step",
    "Steps",
    "Uncertain",
    "Wish",
    "admissible_U",
    "analyse_delay",
    "analyse_pid",
    "certify_sampled",
    "delay",
    "design_delay_pid",
    "design_lqr",
    "design_observer",
    "design_pid",
    "design_sampled",
    "design_sampled_lqr",
    "furthest_sampled",
    "identify",
    "infinite_modes",
    "observer_loop",
    "place_poles",
    "read_wish",
    "regularize",
    "sampled",
    "simulate_nonlinear",
]
