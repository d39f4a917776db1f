"""A bound of the H-infinity norm from w to z (Theorem 2.1)."""

from dataclasses import dataclass, replace

import numpy as np

from ..analysis.linear import hinf_norm
from ..lmi.exact import round_digits
from ..plants.checks import positive
from ..theorems import bounded_real, slack_bounded_real
from .base import Requirement
from .vocabulary import GAMMA

__all__ = ["HInfinity"]


@dataclass(frozen=True, eq=False)
class HInfinity(Requirement):
    """The H-infinity norm from w to z stays below gamma (Theorem 2.1).

    Parameters
    ----------
    gamma : float or None
        None where it is to be minimised.
    mu : float
        Any positive value keeps the theorem true; 1 is the printed one.
    """

    gamma: float
    mu: float = 1.0

    kind = name = promise = "gamma"
    parameter = GAMMA
    implies_stability = True
    rank = 20
    titles = {"hinf": "H∞ bound γ"}

    def __post_init__(self):
        if self.gamma is not None:
            object.__setattr__(self, "gamma", positive("gamma", self.gamma))
        object.__setattr__(self, "mu", positive("mu", self.mu))

    @property
    def bound(self):
        return self.gamma

    def with_bound(self, bound):
        return replace(self, gamma=bound)

    def check(self, problem):
        if problem.plant.p == 0:
            raise ValueError(
                "gamma needs a plant with F, but the plant has no F: say "
                "where the disturbance enters"
            )
        if self.gamma is None:
            raise ValueError(
                'gamma is None: give a number, or let minimize="gamma" find it')

    def level_unit(self, problem, frame):
        C = problem.vertices[0].C @ frame.T
        return self.mu * np.linalg.norm(C, 2) ** 2

    def pair(self, loop, c):
        yield "hinf", bounded_real(c, loop.level(self), loop.scalar(self.mu))

    def slack(self, loop, c, i):
        yield "hinf", slack_bounded_real(
            c, loop.level(self), loop.scalar(self.mu), loop.epsilon)

    def claim(self):
        gamma = repr(self.gamma).removesuffix(".0")
        return f"its H-infinity norm is below {gamma}"

    def truth(self, loops, K, K_A=None):
        return max(hinf_norm(d, K) for d in loops)

    def tuned(self, smallest):
        """With the mu of the smallest gamma; None where there is no gamma."""
        known = {}

        def gamma(mu):
            if mu not in known:
                known[mu] = smallest(replace(self, mu=mu))
            return known[mu]

        mu = 1.0
        while gamma(mu) == np.inf:  # a large mu asks nothing of w
            mu *= 256
            if mu > 1e24:
                return None
        for ratio in (16.0, 4.0, 1.6, 1.2):
            for step in (ratio, 1 / ratio):
                while gamma(_short(mu * step)) < 0.99 * gamma(mu):
                    mu = _short(mu * step)
        return replace(self, mu=mu)

    def reach(self, T, Bw, omega):
        push = np.linalg.solve(T, Bw)
        push = np.linalg.norm(push, 2) ** 2 / self.mu
        return push / omega


def _short(mu):
    return float(round_digits(mu, 2))
