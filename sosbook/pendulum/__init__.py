"""The mobile inverted pendulum of chapter 4, from its logs to its program."""

from ..plants.gain import Gain
from .deployment import Deployment, deploy, recommend
from .firmware import FAULTS, Controller, Firmware
from .law import PD_SIGNALS, PID_SIGNALS, SampledLaw
from .margins import SampledLoop, lowest_rate
from .model import R_G, V_MAX, Mip
from .recovery import largest_tilt
from .robot import Robot
from .simulator import Drivetrain, Push, Run, Sensors, simulate
from .spread import polytope, reduced, triangles, vertices

__all__ = ["FAULTS", "PD_SIGNALS", "PID_SIGNALS", "R_G", "V_MAX", "Controller",
           "Deployment", "Drivetrain", "Firmware", "Gain", "Mip", "Push", "Robot",
           "Run", "SampledLaw", "SampledLoop", "Sensors", "deploy", "largest_tilt",
           "lowest_rate", "polytope", "recommend", "reduced", "simulate", "triangles",
           "vertices"]  # fmt: skip
