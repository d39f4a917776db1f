"""Stability, which is always demanded (Theorem 2.2 with sigma = 0)."""

import numpy as np

from .. import analysis, theorems
from ..exact.rational import exact
from ..runtime.read_only import put
from .base import Requirement
from .in_steps import InSteps
from .lmi_region import LMIRegion


class Stability(Requirement):
    """Re s < 0, or, of a plant of discrete time, the poles z in the unit circle, the
    `InSteps` that ``disk`` is; joins a request where no other block demands it.
    """

    kind = name = "stability"
    promise = "poles"
    implies_stability = affine_in_quotient = True
    titles = {"stability": "stability"}
    disk: InSteps | None = None

    def stepped(self, step):
        made = Stability()
        if step is not None:
            put(made, step=step, disk=InSteps(LMIRegion.disk(1.0), step))
        return made

    def pair(self, loop, c):
        if self.disk is not None:
            yield from _named(self.disk.pair(loop, c))
        else:
            yield "stability", theorems.stability(c)

    def slack(self, loop, c, i):
        if self.disk is not None:
            yield from _named(self.disk.slack(loop, c, i))
        else:
            yield "stability", theorems.slack_stability(c, loop.epsilon)

    def known_gain(self, c):
        if self.disk is not None:
            yield from _named(self.disk.known_gain(c))
        else:
            yield "stability", theorems.free_stability(c)

    def pole_matrices(self):
        if self.disk is not None:
            return self.disk.pole_matrices()
        return exact(np.zeros((1, 1))), exact(np.eye(1))

    def claim(self):
        if self.disk is not None:
            return self.disk.claim()
        return "its poles lie left of the imaginary axis"

    def truth(self, loops, K, K_A=None):
        """The distance of the worst pole from the imaginary axis, in rad/s, or from the
        unit circle.

        The poles are those of all ``loops`` under K and K_A.
        """
        return min(self.distance(analysis.poles(d, K)).min() for d in loops)

    def distance(self, s):
        """How far left of the imaginary axis each of some poles s lies, or how far
        inside the unit circle.
        """
        return -s.real if self.disk is None else self.disk.distance(s)

    def kept(self, truth):
        return truth


def _named(blocks):
    return (("stability", g) for _, g in blocks)
