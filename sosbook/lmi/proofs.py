"""Proofs about LMIs of one's own, as files: a point inside, or that there is none."""

import json

from ..exact.proof_file import ProofFile
from ..exact.rational import decimals, read_array
from ..exact.refusal import MultiplierRefusal, written_lmis

OF_AN_AUTHOR = "proven of an author's LMIs:"


class LMIProof(ProofFile):
    """An exact proof that a point lies inside some LMIs, or its failure.

    Its ``text`` is a file with the blocks as ``constant + sum of L X R`` in
    rationals and with the point. What is claimed is that these blocks are
    positive definite at that point. What it means is the author's
    ``statement``: nobody checks that the blocks say so.

    Examples
    --------
    >>> from sosbook.lmi import LMIProblem, he, symmetric
    >>> P, A = symmetric("P", 2), [[0, 1], [-2, -3]]
    >>> problem = LMIProblem({"P": P, "decay": -he(A @ P)})
    >>> proof = problem.solve().prove(("A is stable",))
    >>> proof.verify(), proof.claims
    (True, ('these blocks are positive definite: P, decay',))
    >>> proof.statement
    ('A is stable',)
    """

    kind = "lmi"

    @property
    def values(self):
        """The point that was checked, by the unknowns' names: decimal floats."""
        known = self.data["unknowns"]
        return {
            name: read_array(known[name], *shape)
            for name, *shape, _ in self.data["shapes"]
        }

    @property
    def digits(self):
        """To so many significant digits the point was rounded."""
        return self.data["digits"]

    @property
    def statement(self):
        """The author's words for the meaning of the blocks; empty without a proof."""
        return tuple(self.data["statement"]) if self.proven else ()

    def __str__(self):
        said = "\n  which say, by their author's word alone: "
        return super().__str__() + "".join(said + json.dumps(w) for w in self.statement)

    def _proven_words(self):
        return OF_AN_AUTHOR

    @classmethod
    def contents(cls, expressions, unknowns, values, digits, statement=()):
        """The data of the file.

        ``expressions``: from a block's name to its `Affine` expression in rationals;
        ``unknowns``: what they are affine in; ``values``: the point, in floats to be
        read as decimals; ``digits``: to so many significant digits the point was
        rounded; ``statement``: what the blocks mean, in their author's words.
        """
        return {
            "statement": list(statement),
            **written_lmis(expressions, unknowns),
            "digits": int(digits),
            "unknowns": {u.name: decimals(values[u.name]) for u in unknowns},
        }


class LMIRefusal(MultiplierRefusal):
    """Multipliers that exclude every point of some LMIs; see `MultiplierRefusal`.

    ``text`` is that of the file.
    """

    kind = "infeasible lmi"
    may_be_singular = True

    def _proven_words(self):
        return OF_AN_AUTHOR

    @classmethod
    def contents(cls, expressions, unknowns):
        """The data of the file for ``expressions`` in unknowns, without multipliers."""
        return written_lmis(expressions, unknowns)
