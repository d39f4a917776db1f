"""The thesis's theorems, each written once.

Each function returns the matrix that must be positive definite, laid
out as in the thesis (which prints the negative of most of them).
"""

from .any_order import unseen
from .delay import (
    MISPRINTS,
    Functional,
    Times,
    delay_decay,
    delay_functional,
    delay_stabilization,
)
from .h2 import h2_noise, h2_output, slack_h2_noise
from .hinf import bounded_real
from .interval import interval_decay, interval_functional, interval_kernel
from .legendre import legendre_decay, legendre_functional
from .lqr import lqr_cost, lqr_decay, slack_lqr_decay, trace_bound
from .multipliers import (
    free_bounded_real,
    free_gramian,
    free_lqr_decay,
    free_pole_region,
    free_stability,
)
from .observer import observer_cost, observer_decay
from .pole_region import pole_region, stability
from .regularization import regular_mass
from .saturation import control_bound, initial_state, whole_control_bound
from .slack import (
    slack_bounded_real,
    slack_initial_state,
    slack_pole_region,
    slack_stability,
)

__all__ = [
    "MISPRINTS",
    "Functional",
    "Times",
    "bounded_real",
    "control_bound",
    "delay_decay",
    "delay_functional",
    "delay_stabilization",
    "free_bounded_real",
    "free_gramian",
    "free_lqr_decay",
    "free_pole_region",
    "free_stability",
    "h2_noise",
    "h2_output",
    "initial_state",
    "interval_decay",
    "interval_functional",
    "interval_kernel",
    "legendre_decay",
    "legendre_functional",
    "lqr_cost",
    "lqr_decay",
    "observer_cost",
    "observer_decay",
    "pole_region",
    "regular_mass",
    "slack_bounded_real",
    "slack_h2_noise",
    "slack_initial_state",
    "slack_lqr_decay",
    "slack_pole_region",
    "slack_stability",
    "stability",
    "trace_bound",
    "unseen",
    "whole_control_bound",
]
