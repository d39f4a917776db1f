"""The plants at which a request's blocks are written."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..exact.definite import exact
from ..lmi.text import floats
from ..plants.near_box import NearBox
from ..requirements.posed import OnDemand
from ..runtime.read_only import ReadOnly
from .payments import pays


@dataclass(frozen=True, eq=False)
class Ground(ReadOnly):
    """The ``vertices`` of the blocks: the plant's, or the corners of a box ``near``
    them where these speak for the plants between and the vertices don't.
    """

    vertices: tuple
    near: Any = None

    @classmethod
    def of(cls, request):
        """That of a ``request``; a file's box has matrices of x(k+1) at ticks."""
        common = request.coupling.one_P and request.law.whole and request.step is None
        if common and all(map(pays, request.requirements)):
            near = NearBox.of(request.plant)
            found = near and near.ground(request.vertices, request.described)
            if found:
                return cls(found[0], near)
        return cls(request.vertices)

    @cached_property
    def certain(self):
        """The vertices free of rounding errors: floats can't tell if two are equal."""
        rounded = any(d.rounded for d in self.vertices)
        return [d.map(exact) for d in self.vertices] if rounded else self.vertices

    def at(self, frame, number=floats):
        """The vertices in the coordinates of a ``frame``, or in the plant's own: in
        floats made once for each frame, in another arithmetic of ``number`` those that
        are asked for.
        """
        if number is floats and frame in self._moved:
            return self._moved[frame]
        factors = () if frame is None else (frame.left, frame.T, frame.scale)
        factors = [number(np.array(f)) for f in factors]

        def make(k):
            d = self.vertices[k].map(number)
            if frame is None:
                return d
            left, T, scale = factors
            return d.change(left, T, scale.item())

        made = OnDemand(make, len(self.vertices))
        return self._moved.setdefault(frame, list(made)) if number is floats else made

    @cached_property
    def _moved(self):
        return {}

    def __getstate__(self):  # what is made again isn't stored
        return {k: x for k, x in vars(self).items() if k != "_moved"}
