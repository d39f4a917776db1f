"""Elements that compute in the page: closed forms and small eigenvalue problems."""

from .lmis import centre, landscape, ranges, segment, trust
from .loops import circulation, delayed, integral, kalman, mass
from .mover import Mover, choice, slider, tick
from .pendulum import chain, chirp, clock, digits, fall, regulator
from .program import drive
from .reach import reach
from .ride import ride
from .sensors import sensors

__all__ = [
    "Mover",
    "centre",
    "chain",
    "chirp",
    "choice",
    "circulation",
    "clock",
    "delayed",
    "digits",
    "drive",
    "fall",
    "integral",
    "kalman",
    "landscape",
    "mass",
    "ranges",
    "reach",
    "regulator",
    "ride",
    "segment",
    "sensors",
    "slider",
    "tick",
    "trust",
]
