"""Live sliders for Jupyter: each move solves the LMIs again.

The pictures are SVG strings in one HTML widget: drawing them takes a
millisecond, so a move costs what the design costs. One module for each
explorer.
"""

from ...runtime.libraries import library

library("ipywidgets")  # its extra has all that the sliders need

from .arm import explore_swing
from .car_seat import explore_mass_range
from .coupling import explore_coupling
from .delay import explore_delay
from .design import explore_design
from .explorer import Explorer
from .gamma import explore_mu
from .hinf import explore_hinf
from .identification import explore_identification
from .integrators import explore_integrators
from .live import live
from .lqr import explore_lqr
from .observer import explore_observer
from .pendulum import explore_fall
from .pendulum_control import explore_pendulum_control
from .region import explore_region
from .regularization import explore_regularization
from .robot import explore_robot
from .sampling import explore_sampling
from .saturation import explore_saturation
from .segment import explore_segment
from .steps import explore_steps

__all__ = [
    "Explorer",
    "explore_coupling",
    "explore_delay",
    "explore_design",
    "explore_fall",
    "explore_hinf",
    "explore_identification",
    "explore_integrators",
    "explore_lqr",
    "explore_mass_range",
    "explore_mu",
    "explore_observer",
    "explore_pendulum_control",
    "explore_region",
    "explore_regularization",
    "explore_robot",
    "explore_sampling",
    "explore_saturation",
    "explore_segment",
    "explore_steps",
    "explore_swing",
    "live",
]
