"""Elements that compute in the page: closed forms and small eigenvalue problems."""

from .mover import Mover, choice, slider
from .regulator import regulator

__all__ = ["Mover", "choice", "regulator", "slider"]
