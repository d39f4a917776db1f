"""A requirement that the package doesn't know: one file is enough.

For a disturbance of unit energy the peak of |z| stays below a bound. With the
Lyapunov function x' P^-1 x: A P E' + E P A' + B_w B_w' < 0 and C P C' < bound^2.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from sosbook.analysis.linear import loop_matrix
from sosbook.lmi import block, eye, he
from sosbook.plants.checks import positive
from sosbook.requirements.base import Requirement
from sosbook.requirements.vocabulary import Parameter
from sosbook.theorems import control_bound

PEAK = Parameter("peak", "bound of the peak", "Peak of z", "ẑ", power=2)


@dataclass(frozen=True, eq=False)
class EnergyToPeak(Requirement):
    """|z(t)| < peak for every w of unit energy, from rest."""

    peak: float = None

    kind = name = promise = "peak"
    parameter = PEAK
    implies_stability = True
    titles = {"energy": "energy of w", "peak": "peak of z"}

    def __post_init__(self):
        if self.peak is not None:
            positive("peak", self.peak)

    @property
    def bound(self):
        return self.peak

    def with_bound(self, bound):
        return replace(self, peak=bound)

    def check(self, problem):
        if problem.plant.p == 0:
            raise ValueError("peak needs a plant with F")

    def level_unit(self, problem, frame):
        return np.linalg.norm(problem.vertices[0].C @ frame.T, 2) ** 2

    def pair(self, loop, c):
        yield "energy", block([[-he(c.Theta), c.Bw],
                               [c.Bw.T, eye(c.Bw.shape[1])]])

    def once(self, loop):
        if loop.epsilon is None:
            C = loop.vertices[0].C
            yield "peak", (), control_bound(
                loop.P, C @ loop.P, loop.level(self))

    def slack(self, loop, c, i):
        cross = c.EPE - c.EVE + loop.epsilon * c.Theta.T
        yield "energy", -block([
            [he(c.Theta), cross, c.Bw],
            [cross.T, -loop.epsilon * he(c.EVE), 0],
            [c.Bw.T, 0, -eye(c.Bw.shape[1])]])
        yield "peak", control_bound(c.P, c.i.C @ c.V.T, loop.level(self))

    def claim(self):
        return f"|z(t)| stays below {self.peak!r} for every w of unit energy"

    def truth(self, loops, K, K_A=None):
        return max(_peak(d, K) for d in loops)


def _peak(d, K):
    _, _, B = d.state_space()
    W = solve_continuous_lyapunov(loop_matrix(d, K), -B @ B.T)
    return np.sqrt(np.linalg.eigvalsh(d.C @ W @ d.C.T)[-1])
