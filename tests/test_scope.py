"""Of which plants a claim speaks: of constant ones alone, or also while they change.

The truth is Floquet's: the product of exponentials of a loop over one period.
"""

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.exact.checker import verdict
from sosbook.plants.descriptor import descriptors
from tests.cases import seeds

CONSTANT, CHANGING = "every constant plant ", "every constant or changing plant "
I2 = np.eye(2)


def spring(swing, damping=0.1):
    """z'' + damping z' + (1 + p) z = u with p in [-swing, swing]."""
    ends = (-swing, swing)
    return sos.Polytope([sos.SecondOrderSystem(1, damping, 1 + p, 1) for p in ends])


def floquet(loop, period, steps=400):
    """By how much E(t) x' = A(t) x grows in a period; ``loop(t)`` is E, A."""
    whole = np.eye(len(loop(0.0)[1]))
    for k in range(steps):
        E, A = loop(period * (k + 0.5) / steps)
        whole = expm(np.linalg.solve(E, A) * period / steps) @ whole
    return abs(np.linalg.eigvals(whole)).max()


def scope(claim):
    """The words of a claim that say of which plants it speaks."""
    (found,) = (x for x in (CONSTANT, CHANGING) if x in claim)
    return found


def test_a_swing_that_pumps_itself_up_is_proven_while_it_is_constant():
    """Mathieu's plant: at each stiffness it is stable, and with 1 + 0.4 cos 2t not."""

    def loop(t):
        return I2, np.array([[0, 1], [-1 - 0.4 * np.cos(2 * t), -0.1]])

    assert floquet(loop, np.pi) == pytest.approx(1.169, abs=1e-3)
    for coupling in ("auto", "multipliers", "slack"):
        found = sos.analyse_pid(spring(0.4), [[0, 0]], coupling=coupling)
        assert found.certify().claims[0].startswith(CONSTANT)
        mine, theirs = str(found.certify()), verdict.check(found.certify().text)
        assert CONSTANT in mine and theirs == list(found.certify().claims)
    common = sos.analyse_pid(spring(0.4), [[0, 0]], coupling="pairs")
    assert common.status == "infeasible"


@pytest.mark.parametrize("seed", seeds(4))
def test_what_is_proven_of_changing_plants_survives_their_changes(seed):
    """Random loads with an uncertain mass, changed at frequencies near every mode's."""
    rng = np.random.default_rng(seed)
    B, S0 = rng.uniform(0.3, 1, (2, 2)), [[9.81, -0.3], [0.2, 2.2]]
    plants = sos.Polytope(
        [
            sos.SecondOrderSystem(
                np.diag(rng.uniform(0.8, 1.2, 2)),
                0.3 * I2,
                S0 + rng.uniform(-0.5, 0.5, (2, 2)),
                B,
            )
            for _ in range(3)
        ]
    )
    design = sos.design_pid(plants, region=sos.PoleRegion(sigma=0.2), coupling="pairs")
    assert scope(design.certify().claims[0]) == CHANGING
    loops = [(d.E, d.A + d.Bu @ design.K) for d in descriptors(plants)]
    modes = [np.linalg.eigvals(np.linalg.solve(*x)) for x in loops]
    worst = 0.0
    for w in 2 * abs(np.concatenate(modes)):
        angles = 2 * np.pi * np.arange(3) / 3

        def loop(t, w=w):
            weights = (1 + np.cos(w * t + angles)) / 3
            return [np.tensordot(weights, [x[k] for x in loops], 1) for k in (0, 1)]

        worst = max(worst, floquet(loop, 2 * np.pi / w) ** (w / 2 / np.pi))
    assert worst < np.exp(-0.2)


def asked(coupling):
    """A proof of each coupling, with the words that the package itself makes."""
    design = sos.analyse_pid(spring(0.01), [[-0.3, -0.2]], coupling=coupling)
    return [words for words, _ in design.request.claims.statements()], design.certify()


@pytest.mark.parametrize(
    "coupling, words",
    dict(pairs=CHANGING, slack=CONSTANT, multipliers=CONSTANT, auto=CHANGING).items(),
)
def test_package_and_checker_say_the_same_of_each_coupling(coupling, words):
    mine, proof = asked(coupling)
    assert mine == list(proof.claims) == verdict.check(proof.text)
    assert scope(mine[0]) == words


def test_a_clock_is_proven_of_constant_plants_and_a_late_input_of_changing_ones():
    plants, K = spring(0.01), [[-0.3, -0.2]]
    assert scope(sos.certify_sampled(plants, K, 0.1).claims[0]) == CONSTANT
    late = sos.analyse_delay(plants, K, tau=0.1, mu=0.05)
    assert scope(late.certify().claims[0]) == CHANGING


def test_one_plant_alone_and_a_mass_speak_of_no_change():
    one = sos.analyse_pid(spring(0.01).vertices[0], [[-0.3, -0.2]])
    heavy = sos.Polytope([sos.SecondOrderSystem(m, 1, 1, 1) for m in (0, 1)])
    for claim in (one.certify().claims[0], sos.regularize(heavy).certify().claims[0]):
        assert "constant" not in claim
