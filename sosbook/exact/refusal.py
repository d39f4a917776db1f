"""Multipliers that exclude every point of LMIs, in exact arithmetic."""

from math import inf, nextafter, sqrt

import numpy as np

from .checker.arithmetic import Beyond
from .checker.verdict import text_of
from .definite import exact, positive, round_digits
from .proof import Examined
from .proof_file import ProofFile
from .rational import fractions, read_fractions


class Refusal(ProofFile):
    """A proof, ``text``, that there is none of what is asked, by its own theorem."""


def written_lmis(expressions, unknowns):
    """The data of blocks, Affine ``expressions`` by name in some unknowns."""
    written = []
    for name, g in expressions.items():
        terms = [
            [t.unknown.name, t.transposed, fractions(t.left), fractions(t.right)]
            for t in g.terms
        ]
        written.append([str(name), fractions(g.constant), terms])
    shapes = [[u.name, *u.shape, u.symmetric] for u in unknowns]
    return {"shapes": shapes, "expressions": written}


class MultiplierRefusal(Refusal):
    """Multipliers that exclude every point of some LMIs, by duality: a ``text``.

    Z_k >= 0 for blocks G_k, not all zero, sum <G_k, Z_k> is the same number at every
    point, and it isn't positive: so the G_k aren't all positive definite.
    ``may_be_singular``: whether Z_k without full rank are looked for, too.
    """

    may_be_singular = False

    @classmethod
    def written_from(cls, data, multipliers, keyed):
        """The file of a problem's data and of multipliers ``keyed`` by block."""
        Z = [[keyed(name), fractions(z)] for name, z in multipliers.items()]
        return {**data, "multipliers": Z}

    @classmethod
    def rebuilt(cls, data):
        """(data without multipliers, expressions, unknowns, keyed) again."""
        raise Beyond("no text says it, and nothing else decides")

    @classmethod
    def mended(cls, data, expressions, unknowns, Z, keyed):
        """The file of float multipliers Z of the ``expressions`` made exact, or None.

        They are in ``unknowns``; ``data`` and ``keyed`` are the file's data and blocks'
        keys.
        """
        from .repair import repair_multipliers
        from .singular import singular_multipliers

        if len(Z) != len(expressions) or not all(np.isfinite(z).all() for z in Z):
            raise ValueError(
                f"multipliers must be {len(expressions)} matrices of finite numbers"
            )
        blocks = list(expressions.values())
        repaired = repair_multipliers(blocks, unknowns, Z)
        found = repaired and repaired[0]
        if found is None and cls.may_be_singular:
            found = singular_multipliers(blocks, unknowns, Z)
        if found is None:
            return None
        exactly = dict(zip(expressions, found))
        proof = cls.of(cls.written_from(data, exactly, keyed))
        return proof if proof.proven else None

    @classmethod
    def examine(cls, data):
        again, expressions, unknowns, keyed = cls.rebuilt(data)
        named = {str(keyed(name)): name for name in expressions}
        Z = {named[str(key)]: read_fractions(rows) for key, rows in data["multipliers"]}
        blocks = written_lmis(expressions, unknowns) | {"kind": "infeasible lmi"}
        text, _ = text_of(cls.written_from(blocks, Z, str))
        again = cls.written_from(again, Z, keyed)
        return again, Examined.by_kernel(text.file(), again["claims"], {})

    @property
    def value(self):
        """sum <G_k0, Z_k>, not positive. A point inside would need it positive."""
        return self.examined.value

    @property
    def multipliers(self):
        """From a block's name to Z_k in rationals, in the solution's coordinates."""
        data = self.data
        keys, Z = zip(*data["multipliers"])
        return dict(zip(self.named(data, keys), map(read_fractions, Z), strict=True))


def excluded_radius(expressions, unknowns, Z, digits=17):
    """A norm that points of ``expressions`` in ``unknowns`` have at least, by Z.

    At a point x the sum of all <G_k(x), Z_k> would be positive, and it is value + r.x
    with value = sum <G_k0, Z_k>, r_a = sum <G_ka, Z_k>. So no point is shorter than
    -value / |r|. Where every block is homogeneous a point may be scaled: then the first
    one, G > 0, is read as G > I. Z is rounded to ``digits``; the norm is the 2-norm of
    free entries, rounded down from an exact figure; 0 where the multipliers say
    nothing.
    """
    from .adjoint import adjoint

    Z = [exact(round_digits((z + z.T) / 2, digits)) for z in Z]
    if not all(map(positive, Z)):
        return 0.0
    constants = [g.constant for g in expressions.values()]
    value = sum((c * z).sum() for c, z in zip(constants, Z))
    if not any(c.any() for c in constants):
        value = -Z[0].trace()
    residual = adjoint(list(expressions.values()), unknowns, Z)
    square = sum(r * r for r in residual)
    if value >= 0:
        return 0.0
    return nextafter(sqrt(value * value / square), 0) if square else inf
