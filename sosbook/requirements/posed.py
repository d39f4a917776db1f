"""The loop in one arithmetic and one set of coordinates, for its blocks."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import numpy as np


class PosedLoop:
    """The parts of a requirement's blocks: ``request``, ``frame`` (None for the plant's
    own coordinates), ``P``, ``Y``, ``V``, the unknowns of every request in these (P one
    for each vertex where there is a slack matrix V), and the requirements' ``own`` by
    name.

    ``number`` brings data into the arithmetic of the blocks; ``levels`` are those that
    are sought, by the key of their requirement. Has ``plain``, ``vertices``: the
    vertices in the plant's own coordinates and in these; ``epsilon``: the scalar of the
    slack LMIs, or None.
    """

    def __init__(self, request, number, frame, P, Y, V, levels, own):
        """Bring the vertices, P, Y and V into the frame and the number type."""
        self.request, self.frame = request, frame
        self.number, self.P, self.Y, self.V = number, P, Y, V
        self.levels, self.own = dict(levels), dict(own)
        self.plain = request.ground.at(None, number)
        self.vertices = request.ground.at(frame, number)
        self.E0 = number(request.mean.E)
        self.T = self.back = self.left = None
        self.scale = 1
        slack = request.coupling.slack
        self.epsilon = None if slack is None else self.scalar(slack)
        if frame is not None:
            self.left, self.T, self.back, scale = (
                number(np.array(f))
                for f in (frame.left, frame.T, frame.back, frame.scale)
            )
            self.scale = scale.item()
            self.E0 = self.left @ self.E0 @ self.T

    @property
    def exact(self):
        """True if the arithmetic is rational."""
        return self.number(np.array([1.0])).dtype == object

    def seen_by(self, requirement):
        """The loop with the outputs and disturbances that a ``requirement`` is about.
        With a common P the output has no x': the equation of the plant gives it.
        """
        rates = not self.request.coupling.one_P
        as_it_is = rates or self.plain[0].Ca is None
        if as_it_is and not requirement.has_channel:
            return self

        def make(k):
            d = requirement.seen(self.plain[k])
            d = d if rates else d.explicit()
            return d if self.T is None else d.change(self.left, self.T, self.scale)

        if not (rates or requirement.fits_one_P(self.request)):
            raise ValueError(
                f"{requirement.name} weighs an acceleration, and its mass is "
                'uncertain: take coupling="slack" or "multipliers"'
            )
        loop = copy(self)
        loop.vertices = OnDemand(make, len(self.vertices))
        return loop

    def measured(self, unit=1.0, size=None):
        """The loop for a requirement whose P is measured apart: in coordinates x = T
        ``unit`` xi its P is near the identity, and its P, V and Y are those of the
        loop, divided by ``size``.
        """
        loop = copy(self)
        if unit != 1.0:
            c = self.scalar(unit)
            loop.frame = self.frame.times(unit)
            loop.T, loop.back = self.T * c, self.back / c
            loop.scale = self.scale * c

            def make(k):
                d = self.vertices[k]
                more = {"Du": _times(d.Du, c), "Ca": _times(d.Ca, c)}
                return replace(d, Bw=d.Bw / c, C=d.C * c, **more)

            loop.vertices = OnDemand(make, len(self.vertices))
        if size is not None:
            loop.P = _divided(self.P, size)
            loop.V, loop.Y = _divided(self.V, size), _divided(self.Y, size)
        return loop

    def scalar(self, value):
        """A float ``value`` in this arithmetic."""
        return self.number(np.array(value)).item()

    def state(self, x):
        """A state x, or a matrix of them, in these coordinates."""
        x = self.number(x)
        return x if self.back is None else self.back @ x

    def row(self, G):
        """A row G that multiplies the state, in units of u."""
        return G if self.T is None else G @ self.T / self.scale

    def near(self, P):
        """P where states are compared with it."""
        if self.T is None:
            return P
        turn = self.back @ self.T  # the identity, up to rounding
        return turn @ P @ turn.T

    def step(self, requirement):
        """The tick of a requirement's plant, zero in continuous time."""
        return 0 if requirement.step is None else self.scalar(requirement.step)

    def level(self, requirement):
        """The requirement's level: its own, or the one that is sought."""
        free = self.levels.get(requirement.parameter.key)
        if free is not None:
            return free
        return self.scalar(requirement.bound) ** requirement.parameter.power


class OnDemand(Sequence):
    """As many items as ``count``, which ``make`` makes of their index when they are
    asked for.
    """

    def __init__(self, make, count):
        self._make, self._count, self._made = make, count, {}

    def __len__(self):
        return self._count

    def __getitem__(self, k):
        if not 0 <= k < self._count:
            raise IndexError(k)
        if k not in self._made:
            self._made[k] = self._make(k)
        return self._made[k]


def _divided(x, size):
    if x is None:
        return None
    return [p / size for p in x] if isinstance(x, (list, tuple)) else x / size


def _times(x, factor):
    return None if x is None else x * factor
