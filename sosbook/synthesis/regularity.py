"""Exact proofs that M - B K_A is regular, or can't be (Lemma 2.1), as files."""

import numpy as np

from ..exact.definite import exact, round_digits
from ..exact.gain_proof import GainProof
from ..exact.proof import Examined, ProofFile, first_proven
from ..exact.rational import (
    decimal,
    decimals,
    expanded,
    fraction,
    rational_matrix,
    read_array,
    read_number,
)
from ..exact.refusal import semidefinite
from ..plants.as_data import plant_data, read_plant
from ..plants.checks import matrix, positive
from ..theorems.regularization import regular_mass

__all__ = [
    "MassRefusal",
    "RegularityCertificate",
    "mass_pairs",
    "mass_refusal",
    "prove_regular",
]


class RegularityCertificate(GainProof):
    """An exact proof of (2.12) at all vertices, or its failure.

    ``text`` is that of the file.
    """

    kind = "regularization"

    @classmethod
    def examine(cls, data):
        plant, beta = read_plant(data["plant"]), read_number(data["beta"])
        K_A = read_array(data["K"], plant.m, plant.n)
        again = cls.contents(plant, K_A, positive("beta", beta))
        blocks = {
            name: regular_mass(exact(M), exact(B), exact(K_A), exact(beta))
            for name, (M, B) in mass_pairs(plant).items()
        }
        return again, Examined.of(blocks, again["claims"])

    @classmethod
    def contents(cls, plant, K_A, beta):
        """The data of the file for a plant, K_A and beta."""
        return {
            "claims": claims(plant, beta),
            "plant": plant_data(plant),
            "beta": decimal(beta),
            "K": decimals(K_A),
            "unknowns": {},
            "blocks": list(mass_pairs(plant)),
        }


def claims(plant, beta):
    """What (2.12) proves, in words."""
    many = len(plant.vertices) > 1
    where = "every plant of the polytope" if many else "the plant"
    return [
        f"for {where}, M - B K_A is regular",
        "the eigenvalues of its symmetric part exceed beta^2 = "
        + expanded(exact(beta) ** 2),
    ]


class MassRefusal(ProofFile):
    """Multipliers that exclude every K_A; ``text`` is that of the file.

    Z_k, (n, n) and positive semidefinite, with sum Z_k B_k = 0 and
    value = sum <M_k - beta^2 I, Z_k> <= 0; a gain would make
    sum <M_k - B_k K_A - beta^2 I, Z_k> positive.
    """

    kind = "infeasible regularization"

    @property
    def value(self):
        """sum <M_k - beta^2 I, Z_k>, not positive."""
        return self.examined.value

    @property
    def multipliers(self):
        """dict from a block's name to Z_k, in rationals."""
        return _read_multipliers(self.data)

    @classmethod
    def examine(cls, data):
        plant = read_plant(data["plant"])
        beta = positive("beta", read_number(data["beta"]))
        Z, data = _read_multipliers(data), mass_pairs(plant)
        again = cls.contents(plant, beta, Z)
        value, push, size = 0, 0, 0
        for name, z in Z.items():
            M, B = map(exact, data[name])
            if z.shape != M.shape or not (z == z.T).all() or not semidefinite(z):
                why = f"the multiplier of {name} isn't positive semidefinite"
                return again, Examined.nothing(why)
            push = push + z @ B
            size += z.trace()
            value += (M * z).sum() - exact(beta) ** 2 * z.trace()
        if size == 0 or (push != 0).any():
            return again, Examined.nothing("the multipliers leave K_A a way out")
        if value > 0:
            return again, Examined.nothing("the multipliers exclude nothing")
        return again, Examined(tuple(again["claims"]), {}, (), float(value))

    @classmethod
    def contents(cls, plant, beta, multipliers):
        """The data of the file for a plant, beta and some multipliers."""
        return {
            "claims": [
                "no gain proves by these LMIs: " + "; ".join(claims(plant, beta))
            ],
            "plant": plant_data(plant),
            "beta": decimal(beta),
            "K": None,
            "multipliers": [
                [name, [[str(e) for e in row] for row in z.tolist()]]
                for name, z in multipliers.items()
            ],
        }


def _read_multipliers(data):
    return {
        name: rational_matrix([[fraction(e) for e in row] for row in rows])
        for name, rows in data["multipliers"]
    }


def mass_pairs(plant):
    """The different (M, B) of a plant's vertices, by the name of the block."""
    pairs = {}
    for k, v in enumerate(plant.vertices, 1):
        name = "mass" if len(plant.vertices) == 1 else f"mass {k}"
        if not any(
            np.array_equal(v.M, M) and np.array_equal(v.B, B) for M, B in pairs.values()
        ):
            pairs[name] = v.M, v.B
    return pairs


def prove_regular(plant, K_A, beta, digits=None):
    """Check (2.12) at all vertices in exact arithmetic.

    Parameters
    ----------
    plant : SecondOrderSystem or Polytope
        The plant, or the polytope of plants.
    K_A : (m, n) array
        Rounded to ``digits`` significant digits before the proof.
    beta : float
        The bound of Lemma 2.1.
    digits : int, optional
        Without it 6, 8, 10, 12 and 17 are tried.

    Returns
    -------
    RegularityCertificate
        Its ``K`` is the rounded K_A.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem
    >>> plant = SecondOrderSystem([[0]], [[1]], [[1]], B=[[1]])
    >>> prove_regular(plant, [[-0.02]], beta=0.1).proven
    True
    """
    K_A, beta = matrix("K_A", K_A, (plant.m, plant.n)), positive("beta", beta)

    def attempt(digits, _):
        K = round_digits(K_A, digits)
        return RegularityCertificate.of(RegularityCertificate.contents(plant, K, beta))

    return first_proven(attempt, digits)


def mass_refusal(plant, beta, multipliers):
    """The file of rational multipliers that exclude every K_A of a plant.

    ``beta`` is the bound of Lemma 2.1.
    """
    return MassRefusal.of(MassRefusal.contents(plant, beta, multipliers))
