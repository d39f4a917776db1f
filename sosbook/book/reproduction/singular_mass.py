"""Lemma 2.1, and what Example 3 says about its singular mass."""

import numpy as np

from ...analysis.infinite_modes import infinite_modes
from ...plants.descriptor import descriptors
from ...plants.response import simulate
from ...plants.second_order import Polytope, SecondOrderSystem
from ...plants.signals import Sine
from ...synthesis.regularization import prove_regular, regularize
from .. import thesis
from .table import evaluate, proven


def rows():
    """Rows of section 2.3 and of Example 3's mass, computed."""
    ex = thesis.example_3()
    mass = ex.plant.M - ex.plant.B @ ex.K_A
    least = np.linalg.eigvalsh((mass + mass.T) / 2)[0]
    yield evaluate(
        "K_A-lemma",
        prove_regular(ex.plant, ex.K_A, 0.1).proven,
        masses=", ".join(f"{m:.4f}" for m in mass.diagonal()),
        beta=np.sqrt(least),
    )
    yield evaluate("K_A-eigenvalue", least > 0.01, least=least)
    ends = [
        SecondOrderSystem(np.diag([1, m]), np.eye(2), np.eye(2), np.eye(2))
        for m in (1.0, -1.0)
    ]
    segment = regularize(Polytope(ends)).regular
    between = min(
        np.linalg.eigvalsh(segment.at([a, 1 - a]).M)[0] for a in np.linspace(0, 1, 101)
    )
    yield evaluate("K_A-vertices", between > 0.01, least=between)
    modes = infinite_modes(ex.plant)
    yield evaluate("impulsive", modes.impulsive, modes=modes)
    jump = _jump(ex.plant, 1e-6)
    yield evaluate("jump", abs(jump - 1 / 20) < 1e-4, jump=jump)
    plants = _singular()
    gained = sum(proven(regularize(plant)) for plant in plants)
    yield evaluate("K_A-exists", gained == len(plants), gained=gained, n=len(plants))


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
