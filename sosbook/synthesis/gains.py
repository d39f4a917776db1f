"""What a design of u = K x says of its gain, whatever the theorem."""

import numpy as np

from ..plants.second_order import Polytope, SecondOrderSystem

__all__ = ["Gains"]


class Gains:
    """K in parts, for designs with ``request``, ``margins``, ``_gain``."""

    def __repr__(self):
        name = type(self).__name__
        if self.margins is None:
            return f"<{name}: {self.status}>"
        worst = min(self.margins, key=self.margins.get)
        return (
            f"<{name}: {self.status}, smallest margin "
            f"{self.margins[worst]:.2g} ({worst})>"
        )

    @property
    def K_P(self):
        """Proportional gain, (m, n)."""
        return self._parts()[0]

    @property
    def K_D(self):
        """Derivative gain, (m, n)."""
        return self._parts()[1]

    @property
    def K_I(self):
        """Integral gain, (m, a)."""
        return self._parts()[2]

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
