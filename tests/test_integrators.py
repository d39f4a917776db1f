"""The choice of U: rank condition, distance, proof over a polytope."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import sosbook as sos
from benchmarks.robustness import SYSTEMS, in_units
from sosbook import proofs
from sosbook.book import thesis
from sosbook.plants.checks import rank_deficient
from sosbook.plants.descriptor import descriptors
from sosbook.synthesis import integrators
from sosbook.synthesis.integrators import admissible_U, proven_everywhere
from tests.cases import by_hand, campaign, examples, random_plant, seeds
from tests.random_plants import ODD, random_case
from tests.test_proof_files import checker

EXAMPLES = [thesis.example_1, thesis.example_2, thesis.example_3, thesis.example_4]


def robot(d=0.1066, e=0.0294):
    """The thesis's mobile inverted pendulum, (4.15)."""
    a, b, c, f = 0.4747e-3, 0.3482e-3, 0.9641e-3, 0.0069
    return sos.SecondOrderSystem(
        [[c, b], [b, a]],
        f * np.array([[1, -1], [-1, 1]]),
        np.diag([-d, 0]),
        [[-e], [e]],
    )


def two_masses(s22):
    return sos.SecondOrderSystem(np.eye(2), np.eye(2), [[2, -1], [-1, s22]], [[1], [0]])


def integer_plant(seed):
    """Small integers: rank deficiencies happen, and are exact."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    m = int(rng.integers(1, n + 1))
    M = np.eye(n) + np.diag(rng.integers(0, 3, n))
    D, S = rng.integers(-2, 3, (2, n, n))
    B = rng.integers(-1, 2, (n, m))
    return sos.SecondOrderSystem(M, D, S, B)


def augmented(plant, U):
    """x' = A x + B u of plant and integrators, made by hand."""
    (A, B), a = by_hand(plant), len(U)
    rows = np.hstack([U, np.zeros((a, plant.n + a))])
    return np.vstack([np.pad(A, ((0, 0), (0, a))), rows]), np.pad(B, ((0, a), (0, 0)))


def unreached(A, B):
    """Uncontrollable eigenvalues, by Hautus's test."""
    found = []
    for s in np.linalg.eigvals(A):
        pencil = np.hstack([A - s * np.eye(len(A)), B])
        if np.linalg.svd(pencil, compute_uv=False)[-1] < 1e-6:
            found.append(s)
    return np.array(found)


@settings(max_examples=examples(40, 80), deadline=None, derandomize=True)
@given(st.integers(0, 10**6))
def test_condition_is_stabilisability_of_the_augmented_pair(seed):
    plant = integer_plant(seed)
    alone = unreached(*augmented(plant, np.zeros((0, plant.n))))
    if (alone.real > -1e-4).any():
        with pytest.raises(ValueError, match="can't be stabilised"):
            admissible_U(plant)
        return
    for choice in admissible_U(plant):
        lost = unreached(*augmented(plant, choice.U))
        assert choice.admissible == (not (lost.real > -1e-4).any())
        assert choice.admissible == (choice.distance > 0)


@pytest.mark.parametrize("make", EXAMPLES)
def test_the_core_refuses_exactly_the_inadmissible(make):
    example = make()
    for choice in admissible_U(example.plant):
        if choice.admissible:
            descriptors(example.plant, choice.U, example.K_A)
        else:
            with pytest.raises(ValueError, match="uncontrollable"):
                descriptors(example.plant, choice.U, example.K_A)


@pytest.mark.parametrize("seed", seeds(5))
def test_mass_damping_and_acceleration_gain_play_no_part(seed):
    rng = np.random.default_rng(seed)
    plant = random_plant(rng, 3, 2)
    other = sos.SecondOrderSystem(
        plant.M - plant.B @ rng.standard_normal((2, 3)),
        rng.standard_normal((3, 3)),
        plant.S,
        plant.B,
    )
    for here, there in zip(admissible_U(plant), admissible_U(other)):
        assert here.channels == there.channels
        assert here.distance == there.distance


@pytest.mark.parametrize("seed", seeds(10))
def test_distance_is_that_of_the_nearest_inadmissible_plant(seed):
    rng = np.random.default_rng(seed)
    plant = random_plant(rng, 3, 2)
    S, B = plant.S, plant.B
    size_S, size_B = np.linalg.norm(S, 2), np.linalg.norm(B, 2)
    for choice in admissible_U(plant):
        rest = np.delete(np.eye(3), choice.channels, axis=1)
        both = np.hstack([S @ rest / size_S, B / size_B])
        left, sizes, right = np.linalg.svd(both)
        step = -sizes[2] * np.outer(left[:, 2], right[2])
        k = rest.shape[1]
        change_S = size_S * step[:, :k] @ rest.T
        change_B = size_B * step[:, k:]
        size = np.linalg.norm(np.hstack([change_S / size_S, change_B / size_B]), 2)
        assert size == pytest.approx(choice.distance)
        near = sos.SecondOrderSystem(plant.M, plant.D, S + change_S, B + change_B)
        (there,) = admissible_U(near, [choice.U])
        assert not there.admissible and there.distance == 0
        almost = sos.SecondOrderSystem(
            plant.M, plant.D, S + 0.99 * change_S, B + 0.99 * change_B
        )
        assert admissible_U(almost, [choice.U])[0].admissible


def test_every_example_of_the_thesis():
    for make in EXAMPLES:
        example = make()
        found = admissible_U(example.plant)
        assert all(c.admissible for c in found)
        assert any(np.array_equal(c.U, example.U) for c in found)
        if isinstance(example.plant, sos.Polytope):
            assert all(c.certified for c in found)
        else:
            assert all(c.certified is None for c in found)


def test_the_mobile_inverted_pendulum_admits_the_wheel_only():
    wheel, body = admissible_U(robot())
    assert wheel.channels == (1,) and wheel.admissible
    assert body.channels == (0,) and not body.admissible
    (both,) = admissible_U(robot(), [np.eye(2)])
    assert not both.admissible
    (summed,) = admissible_U(robot(), [[[1, 1]]])
    assert summed.admissible and summed.channels == (0, 1)


def test_followed_without_error_and_never_without():
    plant = two_masses(1)
    t = np.linspace(0, 60, 601)
    constant = sos.Sine(0, 1, offset=[0.3, -0.7])
    pushed = sos.SecondOrderSystem(plant.M, plant.D, plant.S, plant.B, np.eye(2))
    for choice in admissible_U(plant):
        design = sos.design_pid(
            pushed, choice.U, region=sos.PoleRegion(sigma=0.3, rho=3)
        )
        answer = design.simulate(t, r=[0.5, 0.5], w=constant)
        assert np.abs(choice.U @ answer.e[:, -1]).max() < 1e-5


def test_dependent_rows_and_too_many_integrators_are_inadmissible():
    plant = two_masses(1)
    for U in ([[1, 0], [1, 0]], [[0, 0]], np.eye(2)):
        (choice,) = admissible_U(plant, [U])
        assert not choice.admissible
        assert choice.distance == 0


def test_a_singular_mass_is_no_obstacle():
    plant = sos.SecondOrderSystem([[0]], [[0]], [[0]], [[1]])
    (choice,) = admissible_U(plant)
    assert choice.admissible


@pytest.mark.parametrize(
    "low, high, proven",
    [
        (1, 2, True),
        (0.01, 3, True),
        (-2, -0.1, True),
        (1, -1, False),
        (0, 1, False),
        (1e-3, -5, False),
    ],
)
def test_proof_over_a_polytope(low, high, proven):
    plants = sos.Polytope([two_masses(low), two_masses(high)])
    assert bool(proven_everywhere(plants, np.array([[1, 0]]))) == proven


def test_what_is_certified_is_a_file(tmp_path):
    plants = sos.Polytope([two_masses(1), two_masses(2)])
    choices = admissible_U(plants)
    assert any(c.certified for c in choices)
    for choice in choices:
        if not choice.certified:
            continue
        proof = choice.certify()
        proof.save(tmp_path / "proof.json")
        again = proofs.load(tmp_path / "proof.json")
        assert again.proven and again.verify()
        assert "full row rank at every plant" in again.statement[0]
        assert checker.check(again.text) == list(again.claims)
    with pytest.raises(ValueError, match="nothing to certify"):
        admissible_U(plants.mean)[0].certify()
    (never,) = admissible_U(sos.Polytope([two_masses(1), two_masses(-1)]), [[[1, 0]]])
    with pytest.raises(ValueError, match="isn't proven"):
        never.certify()


def test_admissible_vertices_with_an_inadmissible_middle():
    plants = sos.Polytope([two_masses(1), two_masses(-1)])
    (choice,) = admissible_U(plants, [[[1, 0]]])
    assert choice.admissible and choice.certified is False
    assert not admissible_U(plants.mean, [[[1, 0]]])[0].admissible
    with pytest.raises(ValueError, match="uncontrollable"):
        descriptors(plants.mean, [[1, 0]])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, *campaign(range(2, 12))])
def test_what_is_proven_holds_at_sampled_plants(seed):
    rng = np.random.default_rng(seed)
    plants = random_plant(rng, 3, 2, vertices=3, spread=0.5)
    choices = {choice.U.tobytes(): choice for choice in admissible_U(plants)}
    candidates = [choice.U for choice in choices.values()]
    for v in plants.sample(60, seed):
        for inside in admissible_U(v, candidates):
            if choices[inside.U.tobytes()].certified:
                assert inside.distance > 1e-6


def test_halving_proves_what_one_matrix_cannot(monkeypatch):
    stiffness = [
        [[-1, -2, -2, 0], [-2, 1, 0, -2], [-1, 1, 0, 1], [0, 1, 2, 2]],
        [[0, -1, -1, 1], [-1, -1, 2, 0], [2, 2, 1, -2], [0, -1, 1, 1]],
        [[-2, 2, -2, -1], [0, 1, -1, 0], [1, 2, 0, 2], [0, -2, 0, 0]],
        [[-2, 1, 2, 2], [0, -1, 1, 2], [2, 0, 2, 0], [1, -1, -2, 0]],
    ]
    inputs = [[1, 0, 0, 0], [1, 1, -1, 1], [0, 1, 0, 1], [0, 1, 1, -1]]
    plants = sos.Polytope(
        [
            sos.SecondOrderSystem(np.eye(4), np.eye(4), S, np.array([B]).T)
            for S, B in zip(stiffness, inputs)
        ]
    )
    U = np.array([[1, 0, 0, 0]])
    assert proven_everywhere(plants, U)
    monkeypatch.setattr(integrators, "MOST_PIECES", 1)
    assert not proven_everywhere(plants, U)


def test_a_proof_of_integrators_knows_no_units():
    """In newtons or meganewtons, one X shows the rank everywhere."""
    S = [[[0, -2, 0], [1, 0, 0], [1, 1, -1]], [[1, -2, -1], [2, -2, -1], [-1, 1, 1]]]
    inputs = [[[0], [1], [0]], [[1], [0], [-1]]]
    for force in (1e-9, 1, 1e9):
        plants = sos.Polytope(
            [
                sos.SecondOrderSystem(np.eye(3), np.eye(3), np.array(s) * force, B)
                for s, B in zip(S, inputs)
            ]
        )
        assert proven_everywhere(plants, np.array([[1, 0, 0]]))


@pytest.mark.parametrize(
    "plant, message",
    [
        (two_masses, "plant must be a SecondOrderSystem"),
        (
            sos.SecondOrderSystem(np.eye(2), 0 * np.eye(2), np.eye(2), [[1], [0]]),
            r"can't be stabilised: u doesn't reach its mode at s = .*1j",
        ),
        (
            sos.SecondOrderSystem(np.eye(2), np.eye(2), np.diag([1, 0]), [[1], [0]]),
            r"can't be stabilised: .* s = 0",
        ),
        (
            sos.SecondOrderSystem(np.eye(13), np.eye(13), np.eye(13), np.eye(13)),
            "13 displacements and 2.13 choices: pass the candidates",
        ),
    ],
)
def test_bad_plants_are_named(plant, message):
    with pytest.raises(ValueError, match=message):
        admissible_U(plant)


def test_the_vertex_that_cannot_be_stabilised_is_named():
    stuck = sos.SecondOrderSystem(np.eye(2), np.eye(2), np.diag([1, -1]), [[1], [0]])
    plants = sos.Polytope([two_masses(1), stuck])
    with pytest.raises(ValueError, match="stabilised at vertex 2"):
        admissible_U(plants)


@pytest.mark.parametrize(
    "candidates, message",
    [
        ([[[1, 0, 0]]], r"candidates\[0\] has 3 columns, needs 2"),
        ([[[1, 0]], [[np.nan, 0]]], r"candidates\[1\] has NaN"),
        ([np.zeros((0, 2))], "no row"),
        ([[1, 0]], r"candidates\[0\] must be a matrix"),
    ],
)
def test_bad_candidates_are_named(candidates, message):
    with pytest.raises(ValueError, match=message):
        admissible_U(two_masses(1), candidates)


def test_words():
    plants = sos.Polytope([two_masses(1), two_masses(-1)])
    assert repr(admissible_U(plants, [[[1, 0]]])[0]).endswith("not proven>")
    assert repr(admissible_U(robot())[1]) == ("<1 on z1: inadmissible, distance 0>")


@pytest.mark.parametrize("seed", seeds(6))
def test_units_of_rows_and_columns_hide_no_rank(seed):
    """[-S B; U 0] with as many inputs as errors: alternating scaling is slow."""
    rng = np.random.default_rng(seed)
    n, a = 6, 5
    S, B, U = (rng.normal(size=size) for size in ((n, n), (n, a), (a, n)))
    plain = np.block([[-S, B], [U, np.zeros((a, a))]])
    lacking = plain.copy()
    lacking[0] = lacking[1:n].sum(axis=0)
    for powers in (0, 3, 9):
        rows, columns = 10.0 ** rng.integers(-powers, powers + 1, (2, n + a))
        assert not rank_deficient(rows[:, None] * plain * columns)
        assert rank_deficient(rows[:, None] * lacking * columns)


@pytest.mark.parametrize("tiny", [0, 1e-60, 5e-324])
def test_an_entry_that_is_next_to_nothing_hides_no_rank(tiny):
    S = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1) + tiny * np.eye(3, k=2)
    plant = sos.SecondOrderSystem(np.eye(3), S, S, [[1], [0], [0]])
    assert len(descriptors(plant, [[0, 0, 1]])[0].E) == 7


@pytest.mark.parametrize(
    "unit", ["uN, mm, ms", *campaign(x for x in ["odd", *SYSTEMS] if x != "uN, mm, ms")]
)
def test_integrators_are_within_reach_in_any_units(unit):
    """Stiffness of 1e-6 beside forces of 1e5: it was refused in some units."""
    case = random_case(11601, 6)
    plant, asked = in_units(case, *SYSTEMS.get(unit, ODD))
    design = sos.design_pid(plant, **asked)
    assert design.status == "feasible" and design.certify().proven


@pytest.mark.parametrize("seed", seeds(30))
def test_the_first_choice_is_one_that_a_design_can_take(seed):
    """Of plants with fewer inputs than coordinates, too; integers hide integrators."""
    plant = integer_plant(seed)
    try:
        choices = admissible_U(plant)
    except ValueError as error:
        assert "can't be stabilised" in str(error)
        return
    good = [c for c in choices if c.admissible]
    assert list(choices[: len(good)]) == good
    if good:
        assert choices[0].a == max(c.a for c in good)
        assert sos.design_pid(plant, choices[0].U).status == "feasible"


def test_the_first_choice_of_a_polytope_is_proven():
    """Both vertices let z1 be integrated, a plant between them doesn't."""
    carts = [two_masses(s) for s in (1, -1)]
    choices = admissible_U(sos.Polytope(carts))
    assert [c.channels for c in choices] == [(1,), (0,)]
    assert [(c.admissible, c.certified) for c in choices] == [
        (True, True),
        (True, False),
    ]
