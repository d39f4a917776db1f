"""A bound of the H-infinity norm from w to z (Theorem 2.1)."""

from dataclasses import dataclass, replace

import numpy as np

from ..analysis.linear import hinf_norm
from ..exact.rational import decimal
from ..language import Unknown
from ..plants.checks import positive
from ..theorems import bounded_real, free_bounded_real, slack_bounded_real
from .base import Requirement
from .vocabulary import GAMMA

__all__ = ["HInfinity"]


@dataclass(frozen=True, eq=False)
class HInfinity(Requirement):
    """The H-infinity norm from w to z stays below gamma (Theorem 2.1).

    Parameters
    ----------
    gamma : float or None
        The bound; None where it is to be minimised.
    mu : float, optional
        The P of the theorem is mu times the P of the other requirements.
        Any positive value keeps the theorem true; 1 is the printed one.
        Without it mu is free: where another requirement fixes the size of P,
        mu is one more unknown.
    """

    gamma: float
    mu: float | None = None

    kind = name = promise = "gamma"
    parameter = GAMMA
    implies_stability = needs_disturbance = True
    affine_in_quotient = True
    rank = 20
    titles = {"hinf": "H∞ bound γ"}

    def __post_init__(self):
        super().__post_init__()
        if self.mu is not None:
            object.__setattr__(self, "mu", positive("mu", self.mu))

    @property
    def tied(self):
        return "" if self.mu is None else f"mu = {decimal(self.mu)}"

    def untied(self):
        return replace(self, mu=None)

    @property
    def _mu(self):
        return 1.0 if self.mu is None else self.mu

    def check(self, request):
        super().check(request)
        if request.plant.n == 0:
            raise ValueError(
                f"{self.name} needs a plant with outputs, but the plant has no C: say "
                "which of its states, or mixtures of them, must answer little"
            )

    def pair(self, loop, c):
        yield "hinf", bounded_real(c, loop.level(self), loop.scalar(self._mu))

    def slack(self, loop, c, i):
        mu = loop.scalar(self._mu)
        yield "hinf", slack_bounded_real(c, loop.level(self), mu, loop.epsilon)

    def known(self, c):
        yield "mu", c.mu
        yield "hinf", free_bounded_real(c, c.level(self))

    def known_unknowns(self, c):
        rate = np.linalg.norm(np.linalg.solve(c.E, c.A), 2)
        reach = np.linalg.norm(np.linalg.solve(c.E, c.B), 2)
        return {Unknown("mu", 1, symmetric=True): reach**2 / rate or 1.0}

    def claim(self):
        gamma = decimal(self.gamma)
        return f"its H-infinity norm is below {gamma}"

    def truth(self, loops, K, K_A=None):
        return max(hinf_norm(d, K) for d in loops)

    def bounds_response(self):
        return self.gamma
