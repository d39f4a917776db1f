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
        if self._law is not None:
            return Gain(self.K, self.request.law_parts.signals)
        return Gain(self._gain(), signals(self.request.plant, self.request.U))

    @property
    def gains(self) -> dict[str, np.ndarray]:
        """The parts of K by name: K_P, K_D, K_I, or those of the law."""
        self._gain()
        return dict(self._matrices())

    @property
    def _law(self):
        return getattr(self.request, "law", None)

    def _gain(self):
        """The gain from the state to u; with a law its K is another one."""
        K = super()._gain()
        return K if self._law is None else self.request.state_gain

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
        if self._law is not None:
            form = self._law.structure(self.request.plant)
            return tuple(form.named(self.K).items())
        if not isinstance(self.request.plant, (SecondOrderSystem, Polytope)):
            return (("K", self.K),)
        return tuple(zip(("K_P", "K_D", "K_I"), self._parts()))

    def _parts(self):
        if self._law is not None:
            raise ValueError("the gains of a law are gains[name], or K whole")
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
