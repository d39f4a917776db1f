"""How large the unknowns of a requirement must be, read from its blocks.

In coordinates x = T xi a loop is taken that decays evenly, xi' = -omega xi, with P = p
I, a gain of size one and the requirement's own unknowns t I. Its blocks are affine in
p, t and the level: the least ones for which they hold, one after the other, have the
units of what the blocks are made of.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy.linalg import eigh

from ..lmi.text import floats
from ..plants.coupled import Coupled
from ..solver.primal_dual import positive
from .posed import PosedLoop

LARGEST = 60.0  # a power of ten; nothing is sought beyond
HOLDS = 1e-9  # the least eigenvalue of a block whose diagonal is one
MOST_NOISE = 1e-12  # of a constant; a smaller slope is the rounding of a difference


class Magnitudes:
    """The least p, t and level, each zero where nothing bounds it from below: the sizes
    of P, of the own unknowns of a ``requirement``, which writes the blocks, and of its
    level, for a ``request``, whose coupling doesn't matter, in a ``frame``.
    """

    def __init__(self, requirement, request, frame):
        """Split the blocks into a constant and the slopes of p, t and the level."""
        if request.coupling.own_P:
            request = request.apart
        even = _even(requirement.seen(request.mean), request, frame)

        def blocks(p, t, level):
            return _blocks(requirement, request, frame, even, p, t, level)

        zero = blocks(0.0, 0.0, 0.0)
        there = True, requirement.unknowns(request), _has_level(requirement)
        parts = [
            [g - g0 for g, g0 in zip(blocks(*at), zero)]
            if some
            else [np.zeros_like(g) for g in zero]
            for some, at in zip(there, np.eye(3))
        ]
        self._blocks = [_Block(*block) for block in zip(zero, *parts)]

    @cached_property
    def P(self):
        """That of P."""
        return self._least()

    @cached_property
    def own(self):
        """That of the requirement's own unknowns."""
        # beside others' P, which is near I, its own may be far larger than it must
        return self._least(max(2 * self.P, 1.0))

    @cached_property
    def level(self):
        """That of its level."""
        return self._least(max(2 * self.P, 1.0), 2 * self.own or 1.0)

    def _least(self, *known):
        return max((b.least(known) for b in self._blocks), default=0.0)


class _Block:
    """A block, affine in p, t and the level; those that aren't given are infinite."""

    def __init__(self, constant, *slopes):
        noise = MOST_NOISE * np.abs(constant)
        self.constant = constant
        self.slopes = [np.where(np.abs(g) > noise, g, 0.0) for g in slopes]

    def least(self, known):
        """The next value's least at which it holds, after those that are ``known``,
        while the later ones are infinite; 0 if each will do, or none.
        """
        k = len(known)
        fixed = self.constant + sum(x * s for x, s in zip(known, self.slopes))
        raised = np.any([s.diagonal() > 0 for s in self.slopes[k + 1 :]], axis=0)
        used = (fixed != 0) | (self.slopes[k] != 0)
        rows = np.flatnonzero(used.any(axis=1) & ~raised)
        fixed, slope = (g[np.ix_(rows, rows)] for g in (fixed, self.slopes[k]))
        if not len(rows) or not slope.any():
            return 0.0
        low, high = -LARGEST, LARGEST
        if _definite(fixed + 10.0**low * slope):
            return 0.0
        if not _definite(fixed + 10.0**high * slope):
            return 0.0
        while high - low > 1:
            middle = (low + high) / 2
            good = _definite(fixed + 10.0**middle * slope)
            low, high = (low, middle) if good else (middle, high)
        # g - y slope stays definite until 1 / y is the largest eigenvalue of the pair
        g = fixed + 10.0**high * slope
        scale = 1 / np.sqrt(g.diagonal())
        largest = eigh(_scaled(slope, scale), _scaled(g, scale), eigvals_only=True)[-1]
        return max(10.0**high - 1 / largest, 10.0**low)


def _has_level(requirement):
    return requirement.parameter is not None and bool(requirement.parameter.power)


def _scaled(g, scale):
    return g * scale * scale[:, None]


def _definite(g):
    """True if a matrix is positive definite, its diagonal scaled to one."""
    diagonal = g.diagonal()
    if not diagonal.min() > 0:
        return False
    scaled = _scaled(g, 1 / np.sqrt(diagonal))
    scaled[np.diag_indices(len(g))] -= HOLDS
    return positive([scaled])


def _even(mean, request, frame):
    """The loop that decays evenly, with the outputs and disturbances of a ``mean``."""
    N, m = request.order, request.plant.m
    mean = mean.change(frame.left, frame.T, frame.scale)
    rate = -request.typical_rate * np.eye(N)
    return replace(mean, E=np.eye(N), A=rate, Bu=np.zeros((N, m))).explicit()


def _blocks(requirement, request, frame, even, p, t, level):
    """The blocks of the ``even`` loop at p, t and a level, as arrays."""
    N, m = request.order, request.plant.m
    own = {
        u.name: t * np.eye(*u.shape) if u.symmetric else np.zeros(u.shape)
        for u in requirement.unknowns(request)
    }
    levels = {requirement.parameter.key: level} if _has_level(requirement) else {}
    P, Y = p * np.eye(N), p * np.eye(m, N)
    loop = PosedLoop(request, floats, frame, P, Y, None, levels, own)
    loop.vertices = [even] * len(request.vertices)
    named = [g for _, _, g in requirement.once(loop)]
    named += [g for _, g in requirement.pair(loop, Coupled(even, even, P, Y))]
    return [np.asarray(g, float) for g in named]
