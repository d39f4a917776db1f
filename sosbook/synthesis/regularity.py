"""Exact proofs that M - B K_A is regular, or can't be (Lemma 2.1), as files."""

import numpy as np
from scipy.linalg import eigh

from ..exact.definite import exact, round_digits
from ..exact.proof import first_proven
from ..exact.proof_file import GainProof
from ..exact.rational import decimal, decimals, echelon, null_basis
from ..exact.refusal import MultiplierRefusal
from ..language import Unknown, eye, he
from ..plants.as_data import plant_data
from ..plants.checks import matrix, positive


class RegularityProof(GainProof):
    """An exact proof of (2.12) at all vertices, or its failure; ``text`` is that of the
    file.
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
    """Multipliers that exclude every K_A; ``text`` is that of the file. Z_k, (n, n) and
    positive semidefinite, with sum Z_k B_k = 0 and value = sum <M_k - beta^2 I, Z_k> <=
    0; a gain would make sum <M_k - B_k K_A - beta^2 I, Z_k> positive.
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
    ``digits``: without it 6, 8, 10, 12 and 17 are tried. Returns RegularityProof:
    its ``K`` is the rounded K_A.

    >>> from sosbook import SecondOrderSystem
    >>> plant = SecondOrderSystem([[0]], [[1]], [[1]], B=[[1]])
    >>> prove_regular(plant, [[-0.02]], beta=0.1).proven
    True
    """
    K_A, beta = matrix("K_A", K_A, (plant.m, plant.n)), positive("beta", beta)

    def attempt(digits, _):
        K = round_digits(K_A, digits)
        return RegularityProof.of(RegularityProof.contents(plant, K, beta))

    return first_proven(attempt, digits)


def mass_refusal(plant, beta, multipliers):
    """The file of rational ``multipliers`` that exclude every K_A of a ``plant`` and
    ``beta``.
    """
    data = MassRefusal.contents(plant, beta)
    return MassRefusal.of(MassRefusal.written_from(data, multipliers, str))


ABSENT = 1e-4  # of the largest multiplier: one below is what floats leave of zero
STILL = 1e-3  # of |Z| |b|: an input b below is one that the multiplier annihilates


def refuse_regular(plant, beta, multipliers):
    """Exact ``multipliers`` of all vertices of a ``plant`` and ``beta`` together, where
    they exist.
    """
    from ..exact.repair import repair_multipliers

    pairs, n = mass_pairs(plant), plant.n
    Z = {name: z[:n, :n] for name, z in zip(pairs, multipliers)}
    K_A = Unknown("K_A", plant.m, n)
    size = max(np.linalg.norm(z, 2) for z in Z.values())
    faces, blocks, W = {}, [], []
    for name, (M, B) in pairs.items():
        if np.linalg.norm(Z[name], 2) < ABSENT * size:
            continue
        # inputs that Z annihilates confine it to Z = U W U'
        push = np.linalg.norm(Z[name] @ B, axis=0)
        still = push <= STILL * np.linalg.norm(Z[name], 2) * np.linalg.norm(B, axis=0)
        U = null_basis(B[:, still].T)
        if U.shape[1]:
            faces[name] = U
            blocks.append(U.T @ least_mass(M, B, K_A, beta) @ U)
            back = np.linalg.pinv(U.astype(float))
            W.append(back @ Z[name] @ back.T)
    if not blocks:
        return None
    flat = np.hstack([g.jacobian(K_A).reshape(K_A.size, -1) for g in blocks])
    _, free = echelon(flat.T)  # independent entries of K_A
    repaired = repair_multipliers(blocks, [K_A], W, free=free)
    if repaired is None:
        return None
    Z = {name: u @ w @ u.T for (name, u), w in zip(faces.items(), repaired[0])}
    return mass_refusal(plant, beta, Z)


def unreached(plant):
    """Name, v, mass: a direction without an input at the worst vertex of a ``plant``
    and, nearly, the least v'Mv / v'v, in rationals; None where inputs reach all.
    """
    worst = None, None, None
    for name, (M, B) in mass_pairs(plant).items():
        N = null_basis(B.T)
        if N.shape[1]:
            near = N.astype(float)
            _, w = eigh(near.T @ (he(M) / 2) @ near, near.T @ near)
            w = w[:, 0] / np.abs(w[:, 0]).max()
            v = N @ exact(round_digits(w, 8) + 0.0)
            mass = v @ exact(M) @ v / (v @ v)
            if worst[2] is None or mass < worst[2]:
                worst = name, v, mass
    return worst
