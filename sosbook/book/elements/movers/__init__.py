"""Elements that compute in the page: closed forms and small eigenvalue problems."""

from .centre import centre
from .chain import chain
from .chirp import chirp
from .circulation import circulation
from .clock import clock
from .delayed import delayed
from .digits import digits
from .fall import fall
from .integral import integral
from .kalman import kalman
from .mass import mass
from .mover import Mover, choice, slider
from .regulator import regulator
from .segment import segment
from .trust import trust

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
    "fall",
    "integral",
    "kalman",
    "mass",
    "regulator",
    "segment",
    "slider",
    "trust",
]
