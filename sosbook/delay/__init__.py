"""PID control through a varying input delay, and the truth beside it."""

from .design import (
    DelayCertificate,
    DelayDesign,
    analyse_delay,
    design_delay_pid,
    solve_delay,
)
from .largest import Largest, largest
from .lyapunov import lyapunov_values
from .profiles import (
    ConstantDelay,
    RandomDelay,
    SawtoothDelay,
    SineDelay,
    SwitchingDelay,
)
from .request import DelayedLoop, DelayRequest
from .simulation import DelayedResponse, simulate_delay
from .spectrum import (
    characteristic_roots,
    delay_margin,
    delayed_loop,
    slowest_decay,
    spectral_abscissa,
    stable_delays,
)

__all__ = [
    "ConstantDelay",
    "DelayCertificate",
    "DelayDesign",
    "DelayRequest",
    "DelayedLoop",
    "DelayedResponse",
    "Largest",
    "RandomDelay",
    "SawtoothDelay",
    "SineDelay",
    "SwitchingDelay",
    "analyse_delay",
    "characteristic_roots",
    "delay_margin",
    "delayed_loop",
    "design_delay_pid",
    "largest",
    "lyapunov_values",
    "simulate_delay",
    "slowest_decay",
    "solve_delay",
    "spectral_abscissa",
    "stable_delays",
]
