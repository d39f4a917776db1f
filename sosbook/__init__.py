"""LMI design of second-order systems: PID control that is proven.

Reads M z'' + D z' + S z = B u + F w; follows D. S. Gontijo, "Control
Techniques for Uncertain Second Order Systems: An LMI Approach" (2023).
"""

import sys as _sys
from importlib import import_module as _import_module

__version__ = "1.0.0"

# Nothing is imported before it is asked for (PEP 562). Type checkers read
# the same names in __init__.pyi.
_NAMES = {
    "analysis.identification": ("Identification", "identify"),
    "analysis.infinite_modes": ("InfiniteModes", "infinite_modes"),
    "analysis.nonlinear": ("simulate_nonlinear",),
    "analysis.records": ("Record",),
    "controllers.sampled_design": ("SampledDesign", "design_sampled"),
    "delay": ("DelayDesign", "analyse_delay", "design_delay_pid"),
    "laws.dynamic": ("DynamicLaw",),
    "laws.full_state": ("FullState",),
    "laws.pid": ("PIDLaw",),
    "laws.scheduled": ("Scheduled",),
    "loops": ("Clock", "Late", "Loop", "Signal"),
    "plants.descriptor_system": ("DescriptorSystem",),
    "plants.outputs": ("Output",),
    "plants.response": ("Response",),
    "plants.second_order": ("MassWarning", "Polytope", "SecondOrderSystem"),
    "plants.shaper": ("InputShaper",),
    "plants.signals": ("Ramps", "Sine", "Step", "Steps"),
    "plants.uncertain": ("Uncertain",),
    "requirements.cost": ("QuadraticCost",),
    "requirements.h2": ("H2",),
    "requirements.hinf": ("HInfinity",),
    "requirements.input_bound": ("Saturation",),
    "requirements.pole_region": ("LMIRegion", "PoleRegion", "Region"),
    "requirements.wish": ("Wish", "read_wish"),
    "sampled": (
        "SampledLQR",
        "certify_sampled",
        "design_sampled_lqr",
        "furthest_sampled",
    ),
    "synthesis.design": ("Design",),
    "synthesis.error_loop": ("observer_loop",),
    "synthesis.integrators": ("IntegratorChoice", "admissible_U"),
    "synthesis.lqr": ("design_lqr",),
    "synthesis.observer": ("design_observer",),
    "synthesis.observer_design": ("ObserverDesign",),
    "synthesis.pid": ("analyse_pid", "design_pid"),
    "synthesis.placement": ("place_poles",),
    "synthesis.regularization": ("Regularization", "regularize"),
    "synthesis.result": ("Result",),
    "synthesis.search": ("Search",),
}
_HOMES = {name: module for module, names in _NAMES.items() for name in names}
_ROOMS = (
    "analysis",
    "book",
    "controllers",
    "delay",
    "display",
    "exact",
    "laws",
    "lmi",
    "loops",
    "pendulum",
    "plants",
    "proofs",
    "requirements",
    "runtime",
    "sampled",
    "solver",
    "studies",
    "synthesis",
    "theorems",
)

__all__ = sorted({*_HOMES, "delay", "sampled"})


def __getattr__(name):
    """Import what is asked for: a public name or a room."""
    if name in _HOMES:
        value = _import_module(f"{__name__}.runtime.later").later(_HOMES[name], name)
    elif name in _ROOMS:
        value = _import_module(f"{__name__}.runtime.later").later(name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *__all__})


if _sys.argv[:1] == ["-m"]:  # Python looks for a program, perhaps that of a room
    _package, _room, *_ = f"{_sys.orig_argv[-len(_sys.argv)]}.".split(".")
    if _package == __name__ and _room in _ROOMS:
        _import_module(f"{__name__}.runtime.later").or_exit(_room)
