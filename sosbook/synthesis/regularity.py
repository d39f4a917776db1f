"""Exact proofs that M - B K_A is regular, or can't be (Lemma 2.1), as files."""

import numpy as np

from ..exact.definite import exact, round_digits
from ..exact.gain_proof import GainProof
from ..exact.proof import first_proven
from ..exact.rational import decimal, decimals
from ..exact.refusal import MultiplierRefusal
from ..language import eye, he
from ..plants.as_data import plant_data
from ..plants.checks import matrix, positive


class RegularityCertificate(GainProof):
    """An exact proof of (2.12) at all vertices, or its failure.

    ``text`` is that of the file.
    """

    kind = "regularization"

    @classmethod
    def contents(cls, plant, K_A, beta):
        """The data of the file for a plant, K_A and beta."""
        return {
            "plant": plant_data(plant),
            "beta": decimal(beta),
            "K": decimals(K_A),
            "unknowns": {},
        }


class MassRefusal(MultiplierRefusal):
    """Multipliers that exclude every K_A; ``text`` is that of the file.

    Z_k, (n, n) and positive semidefinite, with sum Z_k B_k = 0 and
    value = sum <M_k - beta^2 I, Z_k> <= 0; a gain would make
    sum <M_k - B_k K_A - beta^2 I, Z_k> positive.
    """

    kind = "infeasible regularization"

    @classmethod
    def contents(cls, plant, beta):
        """The data of the file for a plant and beta, without the multipliers."""
        return {"plant": plant_data(plant), "beta": decimal(beta), "K": None}


def least_mass(M, B, K_A, beta):
    """The symmetric part of M - B K_A less beta^2, in rationals and an unknown K_A."""
    mass = exact(M) - exact(B) @ K_A
    return he(mass / 2) - exact(beta) ** 2 * eye(len(M))


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

    ``plant``: the plant, or the polytope of plants; ``K_A``, (m, n): rounded to
    ``digits`` significant digits before the proof; ``beta``: the bound of Lemma 2.1;
    ``digits``: without it 6, 8, 10, 12 and 17 are tried. Returns RegularityCertificate:
    its ``K`` is the rounded K_A.

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
    data = MassRefusal.contents(plant, beta)
    return MassRefusal.of(MassRefusal.written_from(data, multipliers, str))
