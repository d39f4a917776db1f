"""Which requirements fix the size of P, and how their sizes hang together.

A requirement whose blocks aren't homogeneous fixes the size of its P. Where
several do, each has a P of its own: a multiple of the unknown P, which is that
of the leader. Theorem 2.1's mu is such a multiple.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np

from ..lmi.text import floats
from ..requirements.loop import Loop
from ..runtime.time_limit import check_time_of_eigenvalues


class Sizes:
    """The part of a `Request` that knows of the sizes of P, and of the loop's rate."""

    @cached_property
    def typical_rate(self):
        """A typical angular frequency of the closed loop, in rad/s."""
        rates = filter(None, (r.rate() for r in self.requirements))
        rank, rate = min(rates, default=(2, 1.0))
        if rank < 2:
            return rate
        A, _, _ = self.mean.state_space()
        check_time_of_eigenvalues(len(A))
        return np.abs(np.linalg.eigvals(A)).max() or rate

    @cached_property
    def sized(self):
        """The requirements that fix the size of P, lowest rank first.

        Their blocks aren't zero where P, Y and their own unknowns are.
        """
        if self.coupling == "multipliers":  # each requirement has a P of its own
            return ()
        if self.coupling == "slack" and self.slack is None:
            return replace(self, slack=1.0).sized
        P = V = np.zeros((self.order, self.order))
        Y = np.zeros((self.plant.m, self.order))
        if self.coupling == "slack":
            P = [P] * len(self.vertices)
        own = {
            u.name: np.zeros(u.shape) for r in self.demands for u in r.unknowns(self)
        }
        loop = Loop(self, floats, None, P, Y, V, (), own)
        first = self._coupled(loop, *self.pairs[0])

        def constants(r):
            yield from (g for _, _, g in r.once(loop))
            yield from (g for _, g in self._of_pair(r, loop, first, 0))

        sized = [r for r in self.requirements if any(g.any() for g in constants(r))]
        return tuple(sorted(sized, key=lambda r: (r.rank, r.key)))

    @property
    def ties(self):
        """What holds the sizes of P together, in words: ("mu = 1",) or nothing."""
        ties = tuple(r.tied for r in self.requirements if r.tied)
        return ties if len(self.sized) > 1 else ()

    @property
    def condition(self):
        """What a refusal is subject to: "for mu = 1"; else empty.

        The slack scalar is such a condition, too.
        """
        ties = self.ties
        if self.coupling == "slack" and self.slack is not None:
            ties += (f"slack = {self.slack:g} s",)
        return f"for {' and '.join(ties)}" if ties else ""

    def untied(self):
        """The request in which each requirement's P has its own size."""
        return replace(self, requirements=tuple(r.untied() for r in self.requirements))

    def leader(self, levels=()):
        """The requirement whose P is the unknown P; None if none fixes its size.

        ``levels``: parameters whose level is unknown: a level times an unknown size
        isn't affine, so the first one's owner leads.
        """
        order = {name: place for place, name in enumerate(levels)}
        return min(
            self.sized,
            key=lambda r: order.get(r.parameter and r.parameter.key, len(order)),
            default=None,
        )

    def followers(self, leader):
        """The requirements whose P is the leader's times an unknown size."""
        if self.ties:
            return ()
        return tuple(r for r in self.sized if r is not leader)
