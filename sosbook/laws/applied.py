"""A law on a plant: what its numbers mean there."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..exact.checker.families import under
from ..exact.rational import exact
from ..plants.gain import Gain, named, states_data
from ..plants.sensed import asked_of
from ..runtime.names import claimed
from ..runtime.read_only import ReadOnly


@dataclass(frozen=True, eq=False)
class Applied(ReadOnly):
    """A ``law`` on a ``plant`` that has its sensors: its loop, and its gain."""

    law: Any
    plant: Any

    @cached_property
    def parts(self):
        """The matrices that the law joins to the plant."""
        return self.law.parts(self.plant)

    @property
    def signals(self):
        """The names of what K multiplies."""
        return self.parts.signals

    @property
    def under(self):
        """The law in the words of a claim."""
        law = dict(states=self.parts.states, signals=self.parts.signals)
        law = {x: claimed(names) for x, names in law.items()}
        return under(states_data(self.plant), law, self.parts.free)

    def gain(self, K):
        """K as a checked matrix, of numbers by name, a `Gain` or a matrix. None is K_0:
        a loop with memory always has a gain, which is zero where it is sought.
        """
        K = K if isinstance(K, dict) else named(K)
        if isinstance(K, Gain):
            if sorted(self.signals) != sorted(K.signals):
                raise ValueError(
                    f"K is a gain of {', '.join(K.signals)}, but the law's is of "
                    f"{', '.join(self.signals)}"
                )
            K = K.columns(self.signals)
        return self.law.structure(self.plant).matrix(K)

    def named(self, K):
        """The parts of K by name."""
        return self.law.structure(self.plant).named(K)

    def exact_gain(self, K):
        """The gain from the state to u, in rationals, for the law's ``K``."""
        return self.parts.state_gain(exact(K))

    def state_gain(self, K):
        """The gain from the state to u, in floats, for the law's ``K``."""
        return self.exact_gain(K).astype(float)

    def vertices(self, plant, K, K_A=None):
        """The `Descriptor` of each vertex of a ``plant`` of these shapes, whose gain of
        accelerations is ``K_A``, with the law's states, whose dynamics ``K`` closes.
        """
        return self.parts.vertices(plant, K, K_A)

    def asked(self, r):
        """The requirement on the loop that a requirement ``r`` of the plant makes."""
        return asked_of(self.plant, r).joined(self.parts)

    def start(self, x0):
        """x(0) of the loop for an ``x0`` of the plant: the law's states are at rest."""
        rest = self.parts.rest.astype(float)
        return rest @ x0 if x0 is not None and len(x0) == rest.shape[1] else x0

    @property
    def states(self):
        """How many states an x(0) has, and which, in words."""
        return (
            f"the plant's {self.parts.rows.shape[1]}, or with the law's",
            "those of the law are the last, and by themselves at rest on what is "
            "measured",
        )
