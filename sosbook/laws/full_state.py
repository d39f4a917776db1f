"""The law of the thesis: all of z and z' measured, some errors integrated."""

from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exact.checker.families import under
from ..exact.rational import exact
from ..plants.checks import matrix
from ..plants.descriptor import Descriptor, descriptors
from ..plants.gain import gain_of, signals, states_data
from ..plants.outputs import Output
from ..runtime.read_only import put
from .applied import Applied
from .base import Law, Parts
from .structure import Structure, placed

NO_MATRICES = "a DescriptorSystem takes no U and no K_A: put them into its matrices"
LATE_SENSORS = (
    "K_A feeds z'' back at once, but a plant with late sensors is one of first order, "
    "which has no z'': give it the mass M - B K_A and add K_A z'' to u, or measure the "
    "acceleration by a late sensor, too"
)


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
    whole = True
    sensors = Output(state=1.0)

    def on(self, plant: Any) -> tuple:
        """The ``plant``, and the law with U as a checked matrix."""
        if self.U is None:
            return plant, self
        if not hasattr(plant, "coordinates"):
            raise ValueError(NO_MATRICES)
        new = copy(self)
        put(new, U=matrix("U", self.U, (None, plant.n)))
        return plant, new

    def on_part(self, basis: np.ndarray, halves: int) -> Law:
        """The law of the part's state; ``basis`` and ``halves`` as in `Law.on_part`."""
        new = FullState(None if self.U is None else matrix("U", self.U) @ basis)
        put(new, of_whole=self)
        return new

    def applied(self, plant: Any) -> Applied:
        return OfState(self, plant)

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


class OfState(Applied):
    """That law on a plant: K is the gain of the state, so there is a loop without it,
    and nothing is joined before somebody asks.
    """

    @property
    def under(self):
        return under(states_data(self.plant))

    @property
    def signals(self):
        return signals(self.plant, self.law.U)

    def gain(self, K):
        """K as a checked matrix, or None where it is sought."""
        if K is not None:
            shape = self.plant.m, len(self.signals)
            return matrix("K", gain_of(K, self.plant, self.law.U), shape)
        if self.plant.m or hasattr(self.plant, "coordinates"):
            return None
        raise ValueError(
            "plant has no B, so there is nothing to design: give B, "
            "or analyse the loop as it is, analyse_pid(plant)"
        )

    def named(self, K):
        if not hasattr(self.plant, "coordinates"):
            return {"K": K}
        n = self.plant.n
        return dict(zip(("K_P", "K_D", "K_I"), np.split(K, [n, 2 * n], axis=1)))

    def exact_gain(self, K):
        return exact(K)

    def state_gain(self, K):
        return K

    def vertices(self, plant, K, K_A=None):
        if isinstance(plant, Descriptor):
            return (plant,)
        if not hasattr(plant, "coordinates"):
            return plant.vertices
        return descriptors(plant, self.law.U, K_A)

    def asked(self, r):
        return r

    def start(self, x0):
        return x0

    states = "2n + a", "[z(0); z'(0); x3(0)]"
