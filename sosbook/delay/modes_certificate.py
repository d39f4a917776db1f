"""Exact proofs, as files, that a plant's slow modes have no solution."""

from ..exact.checker.verdict import law
from ..exact.definite import exact
from ..exact.proof import Examined
from ..exact.rational import (
    decimal,
    decimals,
    fraction,
    rational_matrix,
    read_array,
    read_number,
)
from ..exact.refusal import MultiplierRefusal
from ..plants.descriptor_system import DescriptorSystem
from ..synthesis.certificates import frame_data, read_frame
from .certificates import in_frame, problem_data, read_delay_request
from .modes import modes_near

BALLS = (
    "rationals alone can't redo this proof: it encloses eigenvalues in balls; "
    "python -m sosbook verify does"
)


class ModesRefusal(MultiplierRefusal):
    """Multipliers that exclude a design for some modes of a plant alone.

    Its ``text`` is a file with the plant, the modes in floats and multipliers for
    these. The modes themselves are irrational: `verify` encloses them in balls and
    mends the multipliers, see `Modes.refused`.
    """

    kind = "infeasible delay modes"

    @property
    def modes(self):
        """The `Modes` that the proof is about, enclosed again."""
        return _modes(self.data)

    @property
    def part(self):
        """Which part of the plant the multipliers are about, in words."""
        return f"the modes {self.modes} alone"

    @classmethod
    def rebuilt(cls, data):
        small, modes = _small(data), _modes(data)
        again = cls.contents(
            read_delay_request(data, framed=False), data["vertex"], modes, small
        )
        expressions, unknowns = small.in_unknowns(exact)
        return again, expressions, unknowns, str

    @classmethod
    def examine(cls, data):
        again, examined = super().examine(data)
        if examined.proven:
            small, modes = _small(data), _modes(data)
            names = list(map(str, small.in_unknowns()[0]))
            Z = {
                name: rational_matrix([[fraction(e) for e in row] for row in rows])
                for name, rows in again["multipliers"]
            }
            if Z.keys() != set(names):
                return again, Examined.nothing("a block has no multiplier")
            if not modes.refused(small, [Z[name] for name in names]):
                return again, Examined.nothing("the modes leave the unknowns a way out")
        return again, examined

    @classmethod
    def contents(cls, request, vertex, modes, small):
        """The data of a ``request``'s file for ``modes`` of a ``vertex``.

        It counts from 0; ``small`` is the same request for floats near the modes alone.
        """
        (d,) = small.vertices
        asked = {**problem_data(request), "K": None}
        _, said = law({"kind": "infeasible delay", **asked, "multipliers": []})
        return {
            "claims": list(said),
            **asked,
            "vertex": vertex,
            "modes": [
                [decimal(complex(s).real), decimal(complex(s).imag), k]
                for s, k in zip(modes.eigenvalues, modes.pivots)
            ],
            "near": {"A": decimals(d.A), "B": decimals(d.Bu)},
            "coordinates": frame_data(small.frame),
            "note": BALLS,
        }


def _modes(data):
    """The modes of a file, enclosed again."""
    request, places = read_delay_request(data, framed=False), data["modes"]
    vertex = request.vertices[range(len(request.vertices))[data["vertex"]]]
    values = [complex(read_number(re), read_number(im)) for re, im, _ in places]
    pivots = [k for *_, k in places]
    if any(type(k) is not int or k < 0 for k in [*pivots, data["vertex"]]):
        raise ValueError("vertex and pivots must be integers, 0 or more")
    return modes_near(vertex, values, pivots)


def _small(data):
    """The request of a file for the modes alone, at the floats."""
    size = len(data["near"]["A"])
    A = read_array(data["near"]["A"], size, size)
    B = read_array(data["near"]["B"], size, None)
    request = read_delay_request(data, framed=False)
    small = request.at(plant=DescriptorSystem(_one(size), A, B), U=None)
    return in_frame(small, read_frame(data["coordinates"], size))


def _one(size):
    return [[float(i == j) for j in range(size)] for i in range(size)]
