"""What a loop truly does: poles, norms, peaks and simulations."""

from ..plants.response import Response, simulate
from ..plants.signals import Sine, Step, Steps
from .linear import closed_loop, hinf_norm, loop_matrix, open_loop, peak_input, poles
from .margins import DiskMargin, disk_margin, sensitivity_peak
from .nonlinear import arm_gravity, simulate_nonlinear

__all__ = [
    "DiskMargin",
    "Response",
    "Sine",
    "Step",
    "Steps",
    "arm_gravity",
    "closed_loop",
    "disk_margin",
    "hinf_norm",
    "loop_matrix",
    "open_loop",
    "peak_input",
    "poles",
    "sensitivity_peak",
    "simulate",
    "simulate_nonlinear",
]
