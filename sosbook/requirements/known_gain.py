"""The loop of a known gain at a vertex: what theorems with free multipliers read."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ..exact.rational import exact
from ..lmi.text import floats
from ..plants.descriptor import Descriptor, combined
from ..runtime.read_only import ReadOnly


@dataclass(frozen=True, eq=False)
class KnownLoop(ReadOnly):
    """The loop of one ``plant`` under u = ``K`` x, (m, N), both in rationals."""

    plant: Descriptor
    K: np.ndarray

    @cached_property
    def matrices(self):
        """E, A + B_u K, B_w, C + D_u K, D_w and C_a, in rationals."""
        d = self.plant
        C = d.C if d.Du is None else d.C + d.Du @ self.K
        D = exact(np.zeros((len(C), d.Bw.shape[1]))) if d.Dw is None else d.Dw
        rates = exact(np.zeros(C.shape)) if d.Ca is None else d.Ca
        return d.E, d.A + d.Bu @ self.K, d.Bw, C, D, rates

    @cached_property
    def in_floats(self):
        """The same matrices in floats."""
        return tuple(x.astype(float) for x in self.matrices)

    @cached_property
    def plant_in_floats(self):
        """The plant in floats."""
        return self.plant.map(lambda x: x.astype(float))

    def seen_by(self, requirement):
        """The loop with the outputs and disturbances that a requirement is about."""
        if not requirement.has_channel:
            return self
        return KnownLoop(requirement.seen(self.plant), self.K)

    def mixed(self, others, weights):
        """The loop of the mean of this and some ``others``, with rational weights."""

        weighed = [(k, w) for k, w in enumerate(weights) if w != 0]

        def mean(some):
            return sum(w * some[k] for k, w in weighed)

        plants = [d.plant for d in (self, *others)]
        return KnownLoop(combined(plants, mean), self.K)


@dataclass(frozen=True, eq=False)
class KnownVertex:
    """The matrices of a vertex with this ``loop`` in the theorems for a known gain: the
    Lyapunov function x' ``P`` x of its own, multipliers ``F`` and ``G``, (kN, kN),
    common to all vertices, and the requirement's ``own`` unknowns by name, "mu" among
    them. ``number`` brings data into the arithmetic; in coordinates x = ``T`` xi the
    rows are multiplied by ``left``, the plant's own without them.
    """

    loop: KnownLoop
    P: Any
    F: Any
    G: Any
    own: dict = field(default_factory=dict)
    number: Any = floats
    left: np.ndarray | None = None
    T: np.ndarray | None = None

    @property
    def exact(self):
        """True if the arithmetic is rational."""
        return self.number is exact

    @property
    def mu(self):
        """A positive scalar, the unit of P."""
        return self.own["mu"]

    @cached_property
    def matrices(self):
        """E, A, B, C, D and C_a of the loop, in this arithmetic and coordinates."""
        if self.exact:
            return self.loop.matrices
        E, A, B, C, D, rates = self.loop.in_floats
        if self.T is None:
            return E, A, B, C, D, rates
        left, T = self.left, self.T
        return left @ E @ T, left @ A @ T, left @ B, C @ T, D, rates @ T

    @property
    def E(self):
        """E of the loop."""
        return self.matrices[0]

    @property
    def A(self):
        """A + B_u K."""
        return self.matrices[1]

    @property
    def B(self):
        """B_w."""
        return self.matrices[2]

    @property
    def C(self):
        """C + D_u K."""
        return self.matrices[3]

    @property
    def D(self):
        """D_w, or 0."""
        return 0 if self.loop.plant.Dw is None else self.matrices[4]

    @property
    def rates(self):
        """C_a, or 0."""
        return 0 if self.loop.plant.Ca is None else self.matrices[5]

    @property
    def rate(self):
        """How large E^-1 A is, for units."""
        return np.linalg.norm(np.linalg.solve(self.E, self.A), 2)

    @property
    def reach(self):
        """How large E^-1 B is, for units."""
        return np.linalg.norm(np.linalg.solve(self.E, self.B), 2)

    def rows(self, X):
        """A rational matrix X that multiplies the state from the left."""
        if self.exact:
            return X
        X = X.astype(float)
        return X if self.T is None else X @ self.T

    def state(self, X):
        """States, the columns of a rational matrix X."""
        if self.exact:
            return X
        X = X.astype(float)
        return X if self.T is None else np.linalg.solve(self.T, X)

    def step(self, requirement):
        """The tick of a requirement's plant, zero in continuous time."""
        step = requirement.step
        return 0 if step is None else self.number(np.array(step)).item()

    def level(self, requirement):
        """The requirement's bound to the power of its level."""
        parameter = requirement.parameter
        value = exact(requirement.bound)
        return (value if self.exact else requirement.bound) ** parameter.power
