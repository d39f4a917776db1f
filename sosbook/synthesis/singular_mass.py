"""A mass matrix that becomes singular between two vertices, as an exact proof."""

from itertools import combinations, islice

import numpy as np

from ..exact.definite import exact
from ..exact.refusal import Refusal
from ..plants.controllability import is_singular, matrix_of
from .fixed_mode import MOST_MIDPOINTS
from .request_as_data import loop_data


class SingularMassRefusal(Refusal):
    """Two vertices between which the matrix E becomes singular.

    ``text`` is that of a file with the plant and the two. Halfway det E is
    zero, or it has other signs at the two: then it is zero in between.
    """

    kind = "singular mass"

    @property
    def vertices(self):
        """The two, from 0."""
        return tuple(self.data["between"])

    @classmethod
    def of_pair(cls, request, i, j):
        """The file for the vertices i and j of a request, from 0."""
        return cls.of({**loop_data(request), "between": [i, j]})


def refuse_by_mass(request):
    """The `SingularMassRefusal` of a request, or None without one.

    A proof for the whole polytope would make a plant without mass there
    stable; where only the vertices count, nothing is excluded.
    """
    vertices = request.vertices
    if request.coupling == "vertices" or all(
        np.array_equal(d.E, vertices[0].E) for d in vertices
    ):
        return None
    exactly = [matrix_of(d.E) for d in request.vertices_in(exact)]
    signs = [E.det() > 0 for E in exactly]
    if len(set(signs)) > 1:
        places = [sorted((signs.index(True), signs.index(False)))]
    else:
        pairs = islice(combinations(range(len(exactly)), 2), MOST_MIDPOINTS)
        places = [(i, j) for i, j in pairs if is_singular(exactly[i] + exactly[j])]
    proofs = (SingularMassRefusal.of_pair(request, *place) for place in places)
    return next((proof for proof in proofs if proof.proven), None)
