"""Plants and polytopes."""

import numpy as np
import pytest
from scipy.linalg import eigvals

import sosbook as sos
from sosbook import Polytope, SecondOrderSystem
from sosbook.plants.descriptor import descriptors
from sosbook.studies.polytopes import verify_on_samples
from tests.cases import chain, random_plant

I2, ONE = np.eye(2), [[1.0]]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_poles_are_roots_of_the_characteristic_polynomial(seed):
    plant = random_plant(np.random.default_rng(seed), 3, 1)
    poles = plant.poles()
    assert len(poles) == 6
    for s in poles:
        pencil = plant.M * s**2 + plant.D * s + plant.S
        values = np.linalg.svd(pencil)[1]
        assert values[-1] < 1e-9 * values[0]


def test_poles_of_a_chain():
    """sin formula for equal masses and springs, no damping."""
    n = 5
    c = chain(n)
    plant = SecondOrderSystem(c.M, 0 * c.D, c.S, c.B)
    omega = 2 * np.sin(np.arange(1, n + 1) * np.pi / (2 * n + 2))
    found = np.sort(plant.poles().imag)
    assert np.allclose(found, np.sort([*omega, *-omega]))


def test_a_massless_coordinate_has_one_finite_pole():
    plant = SecondOrderSystem(
        np.diag([1.0, 0]), np.diag([3.0, 2]), np.diag([2.0, 1]), I2
    )
    assert np.allclose(plant.poles(), [-2, -1, -0.5])


def test_a_very_fast_pole_is_finite():
    plant = SecondOrderSystem([[1e-14]], ONE, ONE, ONE)
    assert np.allclose(plant.poles(), [-1e14, -1])


def test_systems_between_vertices_are_mixtures():
    """Of every matrix that may differ; of a `Polytope` in first order they are it."""
    rng = np.random.default_rng(6)
    plants = random_plant(rng, 2, 1, vertices=4, spread=0.2)
    parts = descriptors(plants)
    system = sos.DescriptorSystem(
        *([getattr(d, x) for d in parts] for x in ("E", "A", "Bu", "Bw")),
        C=np.eye(2, 4),
        D_u=[[0], [1]],
    )
    for seed, one in enumerate(system.sample(5, seed=2)):
        (d,), (e,) = one.vertices, descriptors(plants.sample(5, seed=2)[seed])
        for x in ("E", "A", "Bu", "Bw"):
            assert getattr(d, x) == pytest.approx(getattr(e, x), abs=1e-12)
        assert np.array_equal(d.C, np.eye(2, 4)) and d.Du[1] == 1
    with pytest.raises(ValueError, match="weights must be 4 non-negative numbers"):
        system.at([1, 0, 0])
    with pytest.raises(ValueError, match="count must be 0"):
        system.sample(-1, 0)


def test_a_first_order_polytope_has_plants_between_its_vertices():
    """Every truth of a design is asked of them, and the vertices' is no better."""
    rng = np.random.default_rng(7)
    plants = random_plant(rng, 2, 2, vertices=4, spread=0.1)
    parts = descriptors(plants)
    system = sos.DescriptorSystem(
        *([getattr(d, x) for d in parts] for x in ("E", "A", "Bu", "Bw")),
        C=np.eye(2, 4),
    )
    cost = sos.QuadraticCost(np.eye(4), np.eye(2), bound=1e6)
    asked = dict(saturation=sos.Saturation(1e4, [1, 0, 0, 0]), requirements=[cost])
    first, second = sos.design_pid(system, **asked), sos.design_pid(plants, **asked)
    second = sos.analyse_pid(plants, first.K, **asked)
    assert first.poles(samples=6, seed=3) == pytest.approx(
        second.poles(samples=6, seed=3), rel=1e-6
    )
    for name in ("hinf", "noise_cost", "peak_input", "sensitivity_peak"):
        truth = getattr(first, name)(samples=6)
        assert truth >= getattr(first, name)()
        assert truth == pytest.approx(getattr(second, name)(samples=6), rel=1e-6)
    assert first.disk_margin(samples=6).radius <= first.disk_margin().radius
    assert min(verify_on_samples(first).values()) > 0


def test_poles_of_a_polytope_lie_where_its_plants_poles_lie():
    rng = np.random.default_rng(4)
    plants = random_plant(rng, 2, 1, vertices=3, spread=0.2)
    weights = np.array([0.2, 0.5, 0.3])
    mixed = plants.at(weights)
    for x in "MDSBF":
        parts = [getattr(v, x) for v in plants.vertices]
        assert np.allclose(getattr(mixed, x), np.tensordot(weights, parts, 1))
    A = np.block([[np.zeros((2, 2)), I2], [-mixed.S, -mixed.D]])
    E = np.block([[I2, np.zeros((2, 2))], [np.zeros((2, 2)), mixed.M]])
    apart = np.abs(np.subtract.outer(mixed.poles(), eigvals(A, E)))
    assert apart.min(axis=0).max() < 1e-8 and apart.min(axis=1).max() < 1e-8


def test_samples_are_repeatable_and_inside():
    light, heavy = (SecondOrderSystem([[m]], ONE, ONE, ONE) for m in (1, 3))
    plants = Polytope([light, heavy])
    masses = [v.M[0, 0] for v in plants.sample(20, seed=5)]
    assert masses == [v.M[0, 0] for v in plants.sample(20, seed=5)]
    assert 1 < min(masses) < max(masses) < 3
    assert plants.mean.M == 2
    assert plants.N == 2


def test_a_plant_cannot_be_changed():
    M = np.eye(2)
    plant = SecondOrderSystem(M, I2, I2, I2)
    M[0, 0] = 7
    assert plant.M[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        plant.M[0, 0] = 7


def bad(**changes):
    parts = dict(M=I2, D=I2, S=I2, B=I2) | changes
    return lambda: SecondOrderSystem(**parts)


nan = [[np.nan, 0], [0, 1]]
PLANTS = {
    "M isn't square": (bad(M=np.ones((2, 3))), "M has 3 columns, needs 2"),
    "M is empty": (bad(M=np.zeros((0, 0))), "M is empty"),
    "D has one row": (bad(D=[[1, 0]]), "D has 1 rows, needs 2"),
    "S has three columns": (bad(S=np.ones((2, 3))), "S has 3 columns"),
    "B has three rows": (bad(B=np.ones((3, 1))), "B has 3 rows, needs 2"),
    "B has no column": (bad(B=np.zeros((2, 0))), "B has no column"),
    "F has one row": (bad(F=[[1.0]]), "F has 1 rows, needs 2"),
    "NaN in M": (bad(M=nan), "M has NaN"),
    "NaN in D": (bad(D=nan), "D has NaN"),
    "infinite S": (bad(S=[[np.inf, 0], [0, 1]]), "S has NaN or infinite"),
    "NaN in B": (bad(B=nan), "B has NaN"),
    "NaN in F": (bad(F=nan), "F has NaN"),
    "rank of [M B]": (bad(M=np.diag([1, 0]), B=[[1], [0]]), r"\[M B\] lacks"),
}


@pytest.mark.parametrize("name", PLANTS)
def test_bad_plants_are_refused(name):
    make, words = PLANTS[name]
    with pytest.raises(ValueError, match=words):
        make()


def test_bad_polytopes_are_refused():
    small, large = SecondOrderSystem(ONE, ONE, ONE, ONE), bad()()
    for vertices, words in [
        ([], "vertices is empty"),
        (small, "vertices must be a sequence"),
        ([small, large], "vertices differ in size"),
        ([small, "plant"], "vertices must be SecondOrderSystem"),
    ]:
        with pytest.raises(ValueError, match=words):
            Polytope(vertices)


@pytest.mark.parametrize(
    "weights", [[1.0], [0.5, 0.6], [-0.5, 1.5], [np.nan, 1.0], [[0.5, 0.5]]]
)
def test_bad_weights_are_refused(weights):
    v = SecondOrderSystem(ONE, ONE, ONE, ONE)
    with pytest.raises(ValueError, match="weights must be 2"):
        Polytope([v, v]).at(weights)


def test_masses_of_very_different_size_have_full_rank():
    plant = SecondOrderSystem(np.diag([1e-12, 1e12]), I2, I2, [[1.0], [0]])
    assert len(plant.poles()) == 4


PLANT = bad(F=I2)()
START = np.full(4, 0.1)
REQUESTS = {
    "plant is a matrix": (dict(plant=I2), "plant must be"),
    "U has three columns": (dict(U=[[1, 0, 0]]), "U has 3 columns"),
    "U has NaN": (dict(U=nan), "U has NaN"),
    "U repeats a row": (dict(U=[[1, 0], [2, 0]]), "U has linearly dep"),
    "U is out of reach": (dict(plant=bad(B=[[1], [0]])(), U=I2), "U is uncontrollable"),
    "a zero at s = 0": (
        dict(plant=bad(S=np.diag([0, 1]), B=[[0], [1]])(), U=[[1, 0]]),
        "U is uncontrollable",
    ),
    "K_A has one row": (dict(K_A=[[1, 0]]), "K_A has 1 rows"),
    "K_A has NaN": (dict(K_A=nan), "K_A has NaN"),
    "singular M": (dict(plant=bad(M=np.diag([1, 0]))()), "K_A that makes"),
    "K_A makes M singular": (dict(K_A=I2), "M - B K_A is singular"),
    "region is a number": (dict(region=0.7), "region must be"),
    "gamma is zero": (dict(gamma=0), "gamma must be positive"),
    "gamma is negative": (dict(gamma=-1.0), "gamma must be positive"),
    "gamma is NaN": (dict(gamma=np.nan), "gamma must be"),
    "gamma is text": (dict(gamma="1"), "gamma must be"),
    "gamma without F": (dict(plant=bad()(), gamma=1.0), "gamma.*no F"),
    "saturation is a number": (dict(saturation=150), "saturation must be"),
    "x0 is short": (dict(saturation=sos.Saturation(1, [1, 0])), "x0 has 2 entries"),
    "x0 lacks x3": (dict(U=I2, saturation=sos.Saturation(1, START)), "2n . a = 6"),
    "minimize": (dict(minimize="norm"), "minimize must be None"),
    "two gammas": (dict(gamma=1, minimize="gamma"), "give gamma or minimize"),
    "minimize without F": (dict(plant=bad()(), minimize="gamma"), "gamma.*no F"),
}


@pytest.mark.parametrize("name", REQUESTS)
def test_bad_requests_are_refused(name):
    changes, words = REQUESTS[name]
    with pytest.raises(ValueError, match=words):
        sos.design_pid(**dict(plant=PLANT) | changes)


@pytest.mark.parametrize(
    "u_max, x0, words",
    [
        (0, START, "u_max must be positive"),
        (-1.0, START, "u_max must be positive"),
        (np.nan, START, "u_max must be"),
        (np.inf, START, "u_max must be"),
        ([1, -2], START, r"u_max\[1\] must be positive, got -2.0"),
        ([], START, "u_max must be"),
        (1, 5, "x0 must be a vector"),
        (1, [np.nan, 1], "x0 has NaN"),
    ],
)
def test_bad_saturations_are_refused(u_max, x0, words):
    with pytest.raises(ValueError, match=words):
        sos.Saturation(u_max, x0)


@pytest.mark.parametrize(
    "K, words",
    [
        (None, "K is missing"),
        ({"K_P": [[-1, 0]]}, "K is a dict of gains by name, which a law has"),
        (np.zeros((2, 2)), "K has 2 columns, needs 4"),
        (np.zeros(4), "K must be a matrix"),
        (np.full((2, 4), np.nan), "K has NaN"),
    ],
)
def test_bad_gains_are_refused(K, words):
    with pytest.raises(ValueError, match=words):
        sos.analyse_pid(PLANT, K)
