"""The truth about a loop: poles, norms, peaks and simulations."""

from ..runtime.later import by_name

_NAMES = {
    "analysis.identification": ("Identification", "identify"),
    "analysis.linear": (
        "closed_loop",
        "hinf_norm",
        "loop_matrix",
        "open_loop",
        "peak_input",
        "poles",
    ),
    "analysis.margins": ("DiskMargin", "disk_margin", "sensitivity_peak"),
    "analysis.nonlinear": ("arm_gravity", "simulate_nonlinear"),
    "analysis.records": ("Record",),
    "plants.response": ("Response", "simulate"),
    "plants.signals": ("Ramps", "Sine", "Step", "Steps"),
}
_HOMES = {name: module for module, names in _NAMES.items() for name in names}
__all__ = sorted(_HOMES)
__getattr__ = by_name(__name__, _HOMES)
