"""PID control through a varying input delay: certificates, spectra, simulations."""

from .crossings import delay_margin, stable_delays
from .design import DelayDesign
from .largest import Largest, largest
from .lyapunov import lyapunov_values
from .pid import analyse_delay, design_delay_pid
from .profiles import (
    ConstantDelay,
    RandomDelay,
    SawtoothDelay,
    SineDelay,
    SwitchingDelay,
)
from .proofs import DelayProof
from .request import DelayedLoop, DelayRequest
from .rising import ConstantDelays, constant_delays
from .simulation import DelayedResponse, simulate_delay
from .solve import solve_delay
from .spectrum import (
    characteristic_roots,
    delayed_loop,
    slowest_decay,
    spectral_abscissa,
)

__all__ = [
    "ConstantDelay",
    "ConstantDelays",
    "DelayDesign",
    "DelayProof",
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
    "constant_delays",
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
