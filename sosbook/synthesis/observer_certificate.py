"""An exact proof of an observer at the vertices, as a file."""

from ..lmi.exact import exact
from ..lmi.gain_proof import significant
from ..lmi.proof import Examined, ProofFile
from ..lmi.rational import decimal, decimals, read_array, read_number

__all__ = ["ObserverCertificate"]


class ObserverCertificate(ProofFile):
    """An exact proof of Theorem 2.5 at the vertices, or its failure.

    ``text`` is that of the file.
    """

    kind = "observer"

    @property
    def L(self):
        """The gain that the proof is about, rounded to the printed digits."""
        return read_array(self.data["L"], None, None)

    @property
    def digits(self):
        """Significant digits of the gain's longest entry."""
        return significant(self.L)

    @classmethod
    def examine(cls, data):
        from .observer import ObserverProblem  # which makes designs, and they these

        problem = ObserverProblem.read(data)
        L, bound = read_array(data["L"], None, None), read_number(data["bound"])
        lmi = problem.bounded(L, bound)
        values = {
            u.name: read_array(data["unknowns"][u.name], *u.shape) for u in lmi.unknowns
        }
        numbers = {name: exact(x) for name, x in values.items()}
        if any((x != x.T).any() for x in numbers.values()):
            raise ValueError("an unknown isn't symmetric")
        blocks = lmi.blocks(numbers, exact)
        again = cls.contents(problem, L, bound, values, list(blocks))
        return again, Examined.of(blocks, again["claims"])

    @classmethod
    def contents(cls, problem, L, bound, values, names):
        """The data of the file for a problem, a rounded L and exact values.

        ``names`` are those of the blocks, and ``bound`` is what tr J is below.
        """
        return {
            "claims": [
                "at each vertex (not between them) the loop with the observer is "
                "stable",
                f"tr J is at most {decimal(bound)} there",
            ],
            **problem.data(),
            "L": decimals(L),
            "bound": decimal(bound),
            "unknowns": {name: decimals(x) for name, x in values.items()},
            "blocks": names,
        }
