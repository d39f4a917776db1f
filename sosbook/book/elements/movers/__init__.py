"""Elements that compute in the page: closed forms and small eigenvalue problems."""

from ....runtime.later import by_name
from .arm import arm
from .lmis import centre, landscape, ranges, segment, trust
from .loops import circulation, delayed, integral, kalman, mass
from .mover import Mover, choice, slider, tick
from .program import drive
from .reach import reach
from .ride import ride
from .sensors import noises, sensors
from .shaft import shaft

__all__ = [
    "Mover",
    "arm",
    "centre",
    "choice",
    "circulation",
    "delayed",
    "drive",
    "integral",
    "kalman",
    "landscape",
    "mass",
    "noises",
    "ranges",
    "reach",
    "ride",
    "segment",
    "sensors",
    "shaft",
    "slider",
    "tick",
    "trust",
]
_HOMES = dict.fromkeys(
    ("chain", "chirp", "clock", "digits", "fall", "regulator"),
    "book.elements.movers.pendulum",
)
__all__ += _HOMES
__getattr__ = by_name(__name__, _HOMES)
