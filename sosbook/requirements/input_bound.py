"""A bound of the input from a given initial state (Lemma 2.2)."""

from dataclasses import dataclass

import numpy as np

from ..plants.checks import matrix, positive

__all__ = ["Saturation"]


@dataclass(frozen=True, eq=False)
class Saturation:
    """The requirement |K x(t)| <= u_max from x(0) = x0 (Lemma 2.2).

    Parameters
    ----------
    u_max : float or None
        Bound of the Euclidean norm of K x, in the unit of u. None where
        it is to be minimised.
    x0 : (N,) array_like
        Initial state [z(0); z'(0); x3(0)].
    acceleration : bool
        Bound the whole signal u = K x + K_A z'' instead, which the
        lemma as printed doesn't. ``M - B K_A`` must be certain.
    """

    u_max: float
    x0: np.ndarray
    acceleration: bool = False

    def __post_init__(self):
        u_max = self.u_max
        if u_max is not None:
            u_max = positive("u_max", u_max)
        if np.ndim(self.x0) != 1:
            raise ValueError("x0 must be a vector of finite numbers")
        x0 = matrix("x0", [self.x0])[0]
        object.__setattr__(self, "x0", x0)
        object.__setattr__(self, "u_max", u_max)
        if not isinstance(self.acceleration, bool):
            raise ValueError(
                f"acceleration must be True or False, got "
                f"{self.acceleration!r}"
            )
