"""The sizes of P: which requirements fix one, and which P each of them has.

A requirement whose blocks aren't homogeneous fixes the size of its P. Where several do,
each has a P of its own: a multiple of the unknown P, which is that of the leader.
Theorem 2.1's mu is such a multiple.
"""

from functools import cached_property

import numpy as np

from ..lmi.text import floats
from ..requirements.posed import PosedLoop


class Sizes:
    """The sizes of P in a ``request``."""

    def __init__(self, request):
        self.request = request

    @cached_property
    def fixing(self):
        """The requirements that fix the size of P, lowest rank first: their blocks
        aren't zero where P, Y and their own unknowns are.
        """
        request, coupling = self.request, self.request.coupling
        if coupling.free:  # each requirement has a P of its own
            return ()
        if coupling.open:
            return request.with_slack(1.0).sizes.fixing
        V = np.zeros((request.order, request.order))
        Y = np.zeros((request.plant.m, request.order))
        P = coupling.given([V] * len(request.lyapunov))
        own = {u.name: np.zeros(u.shape) for _, u in request.owned}
        loop = PosedLoop(request, floats, None, P, Y, V, (), own)
        first = coupling.coupled(loop, *request.pairs[0])

        def constants(r):
            yield from (g for _, _, g in r.once(loop))
            yield from (g for _, g in coupling.asked(r, loop, first, 0))

        fixing = [r for r in request.requirements if any(g.any() for g in constants(r))]
        return tuple(sorted(fixing, key=lambda r: (r.rank, r.key)))

    @property
    def ties(self):
        """The ties between the sizes of P, in words: ("mu = 1",) or nothing."""
        ties = tuple(r.tied for r in self.request.requirements if r.tied)
        return ties if len(self.fixing) > 1 else ()

    @property
    def condition(self):
        """The condition of a refusal, also a slack: "for mu = 1"; else empty."""
        ties = self.ties + self.request.coupling.condition
        return f"for {' and '.join(ties)}" if ties else ""

    def subject(self, text):
        """A ``text`` with the `condition` at its end."""
        return " ".join(filter(None, (text, self.condition)))

    def leader(self, levels=()):
        """The requirement whose P is the unknown P; None if none fixes its size. A
        level times an unknown size isn't affine, so with unknown ``levels``, by the
        parameters' names, the first one's owner leads.
        """
        order = {name: place for place, name in enumerate(levels)}
        return min(
            self.fixing,
            key=lambda r: order.get(r.parameter and r.parameter.key, len(order)),
            default=None,
        )

    def followers(self, leader):
        """The requirements whose P is the leader's times an unknown size."""
        return () if self.ties else tuple(r for r in self.fixing if r is not leader)
