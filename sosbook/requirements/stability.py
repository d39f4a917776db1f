"""Stability, which is always demanded (Theorem 2.2 with sigma = 0)."""

import numpy as np

from .. import analysis, theorems
from ..exact.rational import exact
from .base import Requirement


class Stability(Requirement):
    """Re s < 0; joins a request where no other block demands it."""

    kind = name = "stability"
    promise = "poles"
    implies_stability = affine_in_quotient = True
    titles = {"stability": "stability"}

    def pair(self, loop, c):
        yield "stability", theorems.stability(c)

    def slack(self, loop, c, i):
        yield "stability", theorems.slack_stability(c, loop.epsilon)

    def known_gain(self, c):
        yield "stability", theorems.free_stability(c)

    def pole_matrices(self):
        return exact(np.zeros((1, 1))), exact(np.eye(1))

    def claim(self):
        return "its poles lie left of the imaginary axis"

    def truth(self, loops, K, K_A=None):
        """The distance of the worst pole from the imaginary axis, in rad/s.

        The poles are those of all ``loops`` under K and K_A.
        """
        return min(self.distance(analysis.poles(d, K)).min() for d in loops)

    def distance(self, s):
        """How far left of the imaginary axis each of some poles s lies."""
        return -s.real

    def kept(self, truth):
        return truth
