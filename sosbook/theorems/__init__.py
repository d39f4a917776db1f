"""The thesis's theorems, each written once.

Each function returns the matrix that must be positive definite, laid
out as in the thesis (which prints the negative of most of them). Those of
an optional room are found there by name.
"""

from ..runtime.later import by_name

_NAMES = {
    "delay.interval": ("interval_decay", "interval_functional", "interval_kernel"),
    "delay.legendre": ("legendre_decay", "legendre_functional"),
    "delay.theorems": (
        "MISPRINTS",
        "Functional",
        "Times",
        "delay_decay",
        "delay_functional",
        "delay_stabilization",
    ),
    "synthesis.structured.any_order": ("unseen",),
    "theorems.h2": ("h2_noise", "h2_output", "slack_h2_noise"),
    "theorems.hinf": ("bounded_real",),
    "theorems.lqr": ("lqr_cost", "lqr_decay", "slack_lqr_decay", "trace_bound"),
    "theorems.multipliers": (
        "free_bounded_real",
        "free_gramian",
        "free_lqr_decay",
        "free_pole_region",
        "free_stability",
    ),
    "theorems.observer": ("observer_cost", "observer_decay"),
    "theorems.poles": ("pole_region", "stability"),
    "theorems.regularization": ("regular_mass",),
    "theorems.saturation": ("control_bound", "initial_state", "whole_control_bound"),
    "theorems.slack": (
        "slack_bounded_real",
        "slack_initial_state",
        "slack_pole_region",
        "slack_stability",
    ),
}
_HOMES = {name: module for module, names in _NAMES.items() for name in names}
__all__ = sorted(_HOMES)
__getattr__ = by_name(__name__, _HOMES)
