"""What a loop truly does: poles, norms, peaks and simulations."""

from .linear import closed_loop, hinf_norm, loop_matrix, open_loop, peak_input, poles
from .nonlinear import Steps, arm_gravity, simulate_nonlinear
from .response import Response, Sine, simulate

__all__ = [
    "Response",
    "Sine",
    "Steps",
    "arm_gravity",
    "closed_loop",
    "hinf_norm",
    "loop_matrix",
    "open_loop",
    "peak_input",
    "poles",
    "simulate",
    "simulate_nonlinear",
]
