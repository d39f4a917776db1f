"""The law of the thesis: all of z and z' measured, some errors integrated."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exact.rational import exact
from ..plants.checks import matrix
from ..plants.gain import signals
from ..plants.outputs import Output
from .base import Law, Parts
from .structure import Structure, placed


@dataclass(frozen=True, eq=False)
class FullState(Law):
    """u = K [z; z'; x3], the law of a design without a ``law``: its LMIs are convex.

    Parameters
    ----------
    U : (a, n) array_like, optional
        Which displacement errors are integrated, as in `design_pid`.

    Examples
    --------
    >>> import sosbook as sos
    >>> plant = sos.SecondOrderSystem(1, 1, 1, 1)
    >>> sos.design_pid(plant, law=FullState([[1]])).K.shape
    (1, 3)
    >>> FullState([[1]]).words(plant)
    "u depends on all of z1, z1', integral of z1"
    """

    U: Any = None

    searched = False
    sensors = Output(state=1.0)

    def parts(self, plant: Any) -> Parts:
        seen, names = self.readings(plant), signals(plant, self.U)
        N = len(seen)
        a = len(names) - N
        B = np.zeros((a, N))
        if a:
            B[:, : plant.n] = matrix("U", self.U, (a, plant.n))
        one, none = np.eye(N + a), np.zeros((a, a))
        rows, noise, take, stay = map(exact, (seen.C, seen.Dw, one[:, :N], one[:, N:]))
        E, A, B = map(exact, (np.eye(a), none, B))
        said = seen.names, names[N:], names
        return Parts(rows, noise, E, A, B, take, stay, 0, *said, a)

    def structure(self, plant: Any) -> Structure:
        N, width = len(self.readings(plant)), len(signals(plant, self.U))
        ends = {"K": (0, N)}
        if hasattr(plant, "coordinates"):
            ends = {"K_P": (0, plant.n), "K_D": (plant.n, N), "K_I": (N, width)}
        rows = 0, plant.m
        places = {k: (rows, span) for k, span in ends.items() if span[1] > span[0]}
        return placed((plant.m, width), places, None, {})

    def words(self, plant: Any) -> str:
        """All signals by the names of a ``plant``."""
        return f"u depends on all of {', '.join(signals(plant, self.U))}"
