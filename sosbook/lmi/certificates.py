"""Proofs about LMIs of one's own, as files: a point inside, or that there is none."""

import json

from ..exact.definite import exact
from ..exact.proof import Examined
from ..exact.proof_file import ProofFile
from ..exact.rational import (
    decimals,
    fraction,
    fractions,
    rational_matrix,
    read_array,
    round_digits,
)
from ..exact.refusal import MultiplierRefusal
from ..language.expression import Affine, Term, Unknown
from ..runtime.names import sane_name

__all__ = ["LMIProof", "LMIRefusal"]

OF_AN_AUTHOR = "proven of an author's LMIs:"


class LMIProof(ProofFile):
    """An exact proof that a point lies inside some LMIs, or its failure.

    Its ``text`` is a file with the blocks as ``constant + sum of L X R`` in
    rationals and with the point. What is claimed is that these blocks are
    positive definite at that point. What it means is the author's
    ``statement``: nobody checks that the blocks say so.

    Examples
    --------
    >>> import numpy as np
    >>> from sosbook.lmi import he
    >>> from sosbook.lmi.problem import LMIProblem
    >>> A = np.array([[0.0, 1.0], [-2.0, -3.0]])
    >>> def lyapunov(values, number):
    ...     return {"P": values["P"], "decay": -he(number(A) @ values["P"])}
    >>> P = Unknown("P", 2, symmetric=True)
    >>> proof = LMIProblem(lyapunov, [P]).solve().prove(("A is stable",))
    >>> proof.verify(), proof.claims
    (True, ('these blocks are positive definite: P, decay',))
    >>> proof.statement
    ('A is stable',)
    """

    kind = "lmi"

    @property
    def values(self):
        """The point that was checked, by the unknowns' names: decimal floats."""
        data = self.data
        return {u.name: _value(data, u) for u in _unknowns(data)}

    @property
    def digits(self):
        """To so many significant digits the point was rounded."""
        return self.data["digits"]

    @property
    def statement(self):
        """What its author says that the blocks mean; empty without a proof."""
        return tuple(self.data["statement"]) if self.proven else ()

    def __str__(self):
        said = "\n  which say, by their author's word alone: "
        return super().__str__() + "".join(said + json.dumps(w) for w in self.statement)

    def _proven_words(self):
        return OF_AN_AUTHOR

    @classmethod
    def examine(cls, data):
        unknowns = _unknowns(data)
        expressions = _expressions(data, unknowns)
        values = {u.name: _value(data, u) for u in unknowns}
        statement = data["statement"]
        if not all(isinstance(words, str) for words in statement):
            raise ValueError("statement must be a list of words")
        digits = data["digits"]
        if any((round_digits(x, digits) != x).any() for x in values.values()):
            raise ValueError(f"the point has more than {digits} digits")
        again = cls.contents(expressions, unknowns, values, digits, statement)
        point = {u: exact(values[u.name]) for u in unknowns}
        for u in unknowns:
            if u.symmetric and (point[u] != point[u].T).any():
                return again, Examined.nothing(f"{u.name} isn't symmetric")
        blocks = {name: g.value(point) for name, g in expressions.items()}
        return again, Examined.of(blocks, again["claims"])

    @classmethod
    def contents(cls, expressions, unknowns, values, digits, statement=()):
        """The data of the file.

        Parameters
        ----------
        expressions : dict
            From a block's name to its `Affine` expression in rationals.
        unknowns : list of Unknown
            What they are affine in.
        values : dict
            The point, in floats to be read as decimals.
        digits : int
            To so many significant digits the point was rounded.
        statement : sequence of str
            What the blocks mean, in their author's words.
        """
        names = ", ".join(expressions)
        return {
            "claims": [f"these blocks are positive definite: {names}"],
            "statement": list(statement),
            **_written(expressions, unknowns),
            "digits": int(digits),
            "unknowns": {u.name: decimals(values[u.name]) for u in unknowns},
            "blocks": list(expressions),
        }


class LMIRefusal(MultiplierRefusal):
    """Multipliers that exclude every point of some LMIs; see `MultiplierRefusal`.

    ``text`` is that of the file.
    """

    kind = "infeasible lmi"

    def _proven_words(self):
        return OF_AN_AUTHOR

    @classmethod
    def rebuilt(cls, data):
        unknowns = _unknowns(data)
        expressions = _expressions(data, unknowns)
        return cls.contents(expressions, unknowns), expressions, unknowns, str

    @classmethod
    def contents(cls, expressions, unknowns):
        """The data of the file for ``expressions`` in unknowns, without multipliers."""
        names = ", ".join(expressions)
        return {
            "claims": [f"no point makes all these blocks positive definite: {names}"],
            **_written(expressions, unknowns),
        }


def _written(expressions, unknowns):
    return {
        "shapes": [[u.name, *u.shape, u.symmetric] for u in unknowns],
        "expressions": [
            [
                name,
                fractions(g.constant),
                [
                    [t.unknown.name, t.transposed]
                    + [fractions(x) for x in (t.left, t.right)]
                    for t in g.terms
                ],
            ]
            for name, g in expressions.items()
        ],
    }


def _unknowns(data):
    unknowns = []
    for name, rows, columns, symmetric in data["shapes"]:
        sizes = type(rows) is type(columns) is int and min(rows, columns) > 0
        if not (sizes and isinstance(symmetric, bool)):
            raise ValueError("an unknown is a name, rows, columns, and if symmetric")
        unknowns.append(Unknown(sane_name(name), rows, columns, symmetric))
    if len({u.name for u in unknowns}) < len(unknowns):
        raise ValueError("two unknowns have one name")
    return unknowns


def _expressions(data, unknowns):
    named, expressions = {u.name: u for u in unknowns}, {}
    for name, constant, terms in data["expressions"]:
        name, total = sane_name(name), Affine(_rationals(constant))
        rows, columns = total.shape
        if name in expressions or rows != columns:
            raise ValueError(f"the block {name!r} comes twice or isn't square")
        for unknown, transposed, left, right in terms:
            if not isinstance(transposed, bool):
                raise ValueError("whether an unknown is transposed: true or false")
            u, left, right = named[unknown], _rationals(left), _rationals(right)
            shape = u.shape[::-1] if transposed else u.shape
            if (len(left), *left.shape[1:], *right.shape) != (rows, *shape, columns):
                raise ValueError(f"a term of the block {name!r} has a wrong shape")
            total += Affine(0 * total.constant, [Term(left, u, transposed, right)])
        expressions[name] = total
    return expressions


def _rationals(rows):
    if len({len(row) for row in rows}) != 1 or not rows[0]:
        raise ValueError("a matrix has rows of different lengths, or none")
    return rational_matrix([[fraction(e) for e in row] for row in rows])


def _value(data, u):
    return read_array(data["unknowns"][u.name], *u.shape)
