"""The vertices at which a request's blocks are written."""

from functools import cached_property

from ..exact.definite import exact
from ..plants.checks import is_word
from ..plants.near_box import NearBox
from .payments import pays


class Ground:
    """The part of a `Request` that knows where its blocks are written."""

    def _near_box(self):
        """The box near the vertices at whose corners the blocks are written, or None.

        That is where these speak for the plants between, and the vertices don't.
        """
        common = is_word(self.coupling, ("auto", "pairs", "vertices"))
        if not (common and self.law is None and all(map(pays, self.requirements))):
            return None
        near = NearBox.of(self.plant)
        return near and near.ground(self.vertices, self.described) and near

    @property
    def ground(self):
        """The vertices of the blocks: the plant's, or the corners near them."""
        if self.near is None:
            return self.vertices
        return self.near.ground(self.vertices, self.described)[0]

    @cached_property
    def certain(self):
        """The `ground`, such as E = diag(I, M - B K_A, I), free of rounding errors.

        Whether two of them are equal, floats can't tell.
        """
        rounded = any(d.rounded for d in self.ground)
        return [d.map(exact) for d in self.ground] if rounded else self.ground
