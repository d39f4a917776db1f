"""Lemma 2.1, and what Example 3 says about its singular mass."""

from functools import partial

import numpy as np

from ...plants.descriptor import descriptors
from ...plants.response import simulate
from ...plants.second_order import Polytope, SecondOrderSystem
from ...plants.signals import Sine
from ...synthesis.regularization import infinite_modes, prove_regular, regularize
from .. import thesis
from .table import Row, claim, proven

__all__ = ["rows"]

row = partial(Row, "08_singular_mass")


def rows():
    """Rows of section 2.3 and of Example 3's mass, computed."""
    ex = thesis.example_3()

    proof = prove_regular(ex.plant, ex.K_A, 0.1)
    mass = ex.plant.M - ex.plant.B @ ex.K_A
    least = np.linalg.eigvalsh((mass + mass.T) / 2)[0]
    masses = ", ".join(f"{m:.4f}" for m in mass.diagonal())
    yield row(
        "the printed K_A satisfies (2.12) with beta = 0.1",
        "Example 3",
        "designed to",
        "proven" if proof.proven else "no proof found",
        claim(proof.proven),
        f"exact rational arithmetic; M - B K_A = diag({masses}) would "
        f"satisfy it for every beta below {np.sqrt(least):.4g}",
    )
    yield row(
        "smallest eigenvalue of the symmetric part of M - B K_A exceeds beta^2",
        "Lemma 2.1",
        "> 0.01",
        f"{least:.4f}",
        claim(least > 0.01),
        "for the printed K_A",
    )
    ends = [
        SecondOrderSystem(np.diag([1, m]), np.eye(2), np.eye(2), np.eye(2))
        for m in (1.0, -1.0)
    ]
    segment = regularize(Polytope(ends)).regular
    between = [
        np.linalg.eigvalsh(segment.at([a, 1 - a]).M)[0] for a in np.linspace(0, 1, 101)
    ]
    yield row(
        "(2.12) at the vertices covers the polytope",
        "Lemma 2.1, proof",
        "it suffices to check the vertices",
        f"smallest eigenvalue {min(between):.2f} on a segment whose middle "
        "has a singular mass",
        claim(min(between) > 0.01),
        "for a fixed K_A (2.12) is affine in M and B: here the argument is right",
    )
    modes = infinite_modes(ex.plant)
    yield row(
        "impulsive behaviour due to the pole at infinity",
        "Example 3",
        "impulsive",
        f"index {modes.index}, impulsive modes: {modes.impulses}",
        claim(modes.impulsive),
        "by the test below (A.5), A22 = -b4 is regular: [z; z'] jumps "
        "without an impulse; the impulse is in the acceleration",
        "impulsive behaviour",
    )
    jump = _jump(ex.plant, 1e-6)
    yield row(
        "the massless coordinate is stressed to a jump in velocity",
        "Example 3",
        "jump",
        f"{jump:.4f} m/s for a step of 1 N",
        claim(abs(jump - 1 / 20) < 1e-4),
        "with m4 = 1e-6 kg, after 1e-6 s; 1 / b4 in the limit",
    )
    plants = _singular()
    gained = sum(proven(regularize(plant)) for plant in plants)
    yield row(
        "a K_A exists whenever (M, B) has full row rank",
        "Section 2.3",
        "possible",
        f"Lemma 2.1 finds one, proven, for {gained} of {len(plants)} random plants",
        claim(gained == len(plants)),
        "M symmetric, not negative, of rank 1 to 3 of 4, and as many inputs "
        "as needed; the lemma then has a solution for some beta",
    )


def _singular():
    """Random plants: M >= 0 singular, and [M B] of full row rank."""
    rng = np.random.default_rng(0)
    plants = []
    for rank in (1, 2, 3):
        for _ in range(3):
            root = rng.integers(-3, 4, (4, rank))
            B = rng.integers(-3, 4, (4, 4 - rank))
            if np.linalg.matrix_rank(np.hstack([root, B])) == 4:
                plants.append(SecondOrderSystem(root @ root.T, np.eye(4), np.eye(4), B))
    return plants


def _jump(plant, m4):
    """z4' just after a unit step on the last body of mass m4."""
    M = plant.M.copy()
    M[3, 3] = m4
    (d,) = descriptors(SecondOrderSystem(M, plant.D, plant.S, plant.B, plant.F))
    step = Sine(0, 1, offset=[0, 0, 0, 1])
    answer = simulate(d, np.zeros((2, 8)), [0, 1e-6, 2e-6], w=step)
    return answer.dz[3, 1]
