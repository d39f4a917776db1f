"""What a design of u = K x says of its gain, whatever the theorem."""

from typing import Any

import numpy as np

from ..plants.gain import Gain, signals
from ..plants.second_order import Polytope, SecondOrderSystem
from .result import Proven, Result

__all__ = ["Gains"]


class Gains(Result[Proven]):
    """K in parts, for results with a ``request``."""

    request: Any

    def __repr__(self):
        condition = "" if self.margins else getattr(self, "condition", "")
        return super().__repr__().replace(">", f" {condition}>" if condition else ">")

    @property
    def gain(self) -> Gain:
        """K with the names of what it multiplies.

        ``design.gain.but(design.certify().K)`` is the proven one.
        """
        return Gain(self._gain(), signals(self.request.plant, self.request.U))

    @property
    def K_P(self) -> np.ndarray:
        """Proportional gain, (m, n)."""
        return self._parts()[0]

    @property
    def K_D(self) -> np.ndarray:
        """Derivative gain, (m, n)."""
        return self._parts()[1]

    @property
    def K_I(self) -> np.ndarray:
        """Integral gain, (m, a)."""
        return self._parts()[2]

    def _matrices(self):
        if not isinstance(self.request.plant, (SecondOrderSystem, Polytope)):
            return (("K", self.K),)
        return tuple(zip(("K_P", "K_D", "K_I"), self._parts()))

    def _parts(self):
        n = self._second_order("K_P, K_D and K_I").n
        return np.split(self._gain(), [n, 2 * n], axis=1)

    def _second_order(self, wanted):
        """The plant, or a ValueError if it has no second-order form."""
        plant = self.request.plant
        if not isinstance(plant, (SecondOrderSystem, Polytope)):
            raise ValueError(
                f"a {type(plant).__name__} has no {wanted}: its state isn't "
                "[z; z'; x3]; use K and the matrices"
            )
        return plant
