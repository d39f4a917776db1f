"""Why no acceleration gain meets Lemma 2.1, in exact arithmetic."""

import numpy as np
from scipy.linalg import eigh

from ..exact.definite import exact, round_digits
from ..exact.rational import echelon, null_basis
from ..exact.repair import repair_multipliers
from ..language import Unknown, he
from .regularity import least_mass, mass_pairs, mass_refusal

ABSENT = 1e-4  # of the largest multiplier: one below is what floats leave of zero
STILL = 1e-3  # of |Z| |b|: an input b below is one that the multiplier annihilates


def refuse_regular(plant, beta, multipliers):
    """Exact multipliers of all vertices of a plant together, where they exist.

    ``beta`` is the bound of Lemma 2.1.
    """
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
    """A direction of a plant with no input and, nearly, the least v'Mv / v'v.

    Returns name, v, mass: of the worst vertex, in rationals; None where inputs reach
    all.
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
