"""Families of plants: they are what they claim, and answers are judged."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.spatial import ConvexHull

from benchmarks import continua, elements, machines, masses
from benchmarks.catalogue import FAMILIES, case
from benchmarks.questions import KINDS, right
from sosbook.plants.descriptor import descriptors
from sosbook.studies import polytopes


def rates(M, S):
    """Undamped natural frequencies, rad/s."""
    return np.sqrt(eigh(S, M, eigvals_only=True).clip(0))


def middle(name):
    """The second of a family's sizes."""
    return FAMILIES[name].sizes[1]


def test_both_halves_have_every_kind_of_request():
    asked = {
        half: {f.asks for f in FAMILIES.values() if f.half == half}
        for half in ("tuning", "held back")
    }
    assert asked["tuning"] == asked["held back"]
    assert len(FAMILIES) >= 12
    assert {f.kind for f in FAMILIES.values()} == set(KINDS)
    for f in FAMILIES.values():
        assert f.half in asked and f.why
        assert all(a < b for a, b in pairwise(f.sizes))


@pytest.mark.parametrize("name", FAMILIES)
def test_the_same_size_makes_the_same_plant(name):
    one, two = (FAMILIES[name].make(middle(name))[0] for _ in range(2))
    for v, w in zip(one.vertices, two.vertices, strict=True):
        for part in "MDSBF":
            np.testing.assert_array_equal(getattr(v, part), getattr(w, part))
        assert np.array_equal(v.M, v.M.T)
        assert np.linalg.eigvalsh(v.M)[0] > 0


@pytest.mark.parametrize("name", FAMILIES)
def test_an_input_reaches_every_mode(name):
    """Popov, Belevitch and Hautus, with equations of one size."""
    plant, _ = FAMILIES[name].make(middle(name))
    for d in descriptors(plant):
        A, B, _ = d.state_space()
        for s in np.linalg.eigvals(A):
            rows = np.hstack([s * np.eye(len(A)) - A, B])
            rows = rows / np.linalg.norm(rows, axis=1, keepdims=True)
            assert np.linalg.svd(rows, compute_uv=False)[-1] > 1e-9


@pytest.mark.parametrize("n", [2, 5, 12])
def test_the_free_chain_vibrates_as_in_books(n):
    plant, _ = masses.free_chain(n)
    wanted = np.sqrt(0.1 + 4 * np.sin(np.arange(n) * np.pi / (2 * n)) ** 2)
    np.testing.assert_allclose(rates(plant.M, plant.S), wanted, rtol=1e-9)
    assert plant.m == max(1, n // 4)


@pytest.mark.parametrize("n", [3, 5])
def test_the_chain_between_walls_vibrates_as_in_books(n):
    plant, _ = masses.delayed_chain(n)
    S = np.linalg.solve(plant.M, plant.S) - np.eye(n)
    wanted = np.sort(4 * np.sin(np.arange(n) * np.pi / (2 * n)) ** 2)
    np.testing.assert_allclose(np.linalg.eigvalsh(S), wanted, atol=1e-12)


def test_springs_between_masses_leave_a_rigid_motion():
    for plant in (masses.grid(12)[0], masses.tree(7)[0].vertices[0]):
        n = plant.n
        ground = plant.S @ np.ones(n)  # what a unit motion of all is held with
        assert (ground > -1e-12).all() and ground.max() > 0.3
        rest = np.linalg.eigvalsh(plant.S - np.diag(ground))
        assert abs(rest[0]) < 1e-12 < rest[1]


def test_signs_are_all_combinations():
    rows = masses.signs(8, 4)
    assert len({tuple(r) for r in rows}) == 8 and not rows[:, 3].any()
    with pytest.raises(ValueError, match="power of two"):
        masses.signs(6, 4)
    with pytest.raises(ValueError, match="power of two"):
        masses.signs(32, 4)
    M = [v.M for v in masses.uncertain_masses(4)[0].vertices]
    assert len({m.tobytes() for m in M}) == 4
    tied = masses.tied_masses(8)[0]
    total = [np.trace(v.M) for v in tied.vertices]
    assert len({v.M.tobytes() for v in tied.vertices}) == 8
    np.testing.assert_allclose(total, 4)
    assert not polytopes.vertices_suffice(tied)
    assert polytopes.vertices_suffice(masses.uncertain_masses(16)[0])
    springs = masses.uncertain_springs(16)[0].vertices
    assert len({v.S.tobytes() for v in springs}) == 16
    assert len({v.M.tobytes() for v in springs}) == 1


def test_beams_vibrate_as_in_books():
    M, S = elements.beam_matrices(10)
    wanted = np.array([1.8751040687, 4.6940911330, 7.8547574382]) ** 2
    np.testing.assert_allclose(rates(M, S)[:3], wanted, rtol=1e-3)
    with pytest.raises(ValueError, match="multiple of 2"):
        continua.cantilever(7)


def test_plates_vibrate_as_in_books():
    """Simply supported: pi^2 (i^2 + j^2 / 4) for two metres by one, turned."""
    columns, rows = 16, 8
    M, S = elements.plate_matrices(columns, rows, 2.0, 1.0)
    free = rates(M, S)
    assert (free[:3] < 1e-3).all() and free[3] > 1  # moves and turns as a body
    held = []
    for c in range(columns + 1):
        for r in range(rows + 1):
            node = 3 * (c * (rows + 1) + r)
            on_x, on_y = r in (0, rows), c in (0, columns)
            held += [node] * (on_x or on_y) + [node + 1] * on_x + [node + 2] * on_y
    rest = np.setdiff1d(np.arange(len(M)), held)
    found = rates(M[np.ix_(rest, rest)], S[np.ix_(rest, rest)])[:3]
    wanted = np.pi**2 * np.array([1 / 4 + 1, 4 / 4 + 1, 9 / 4 + 1])
    np.testing.assert_allclose(found, wanted, rtol=0.02)


def test_gyroscopic_forces_do_no_work():
    still, turning = (continua.rotor(8, speed=v)[0] for v in (0.0, 3.0))
    gyro = turning.D - still.D
    assert np.array_equal(gyro, -gyro.T) and np.abs(gyro).max() > 0
    assert np.array_equal(still.D, still.D.T)
    slow, fast = np.sort(abs(turning.poles().imag))[::2][:2]  # they split
    assert fast > slow * (1 + 1e-6)
    same = np.sort(abs(still.poles().imag))[:4]
    np.testing.assert_allclose(same, same[0], rtol=1e-6)
    wire, _ = continua.observed_wire(5)
    skew = wire.D - np.diag(np.diag(wire.D))
    np.testing.assert_allclose(skew, -skew.T, rtol=1e-14)
    assert np.abs(skew).max() > 1


def test_a_pendulum_falls_as_in_books():
    plant, _ = machines.pendulums(2)
    free = replace(plant, D=0 * plant.D)
    m = plant.M[1, 1] / 0.5**2
    wanted = np.sqrt(machines.G / 0.5 * (1 + m))  # on a cart of 1 kg
    assert free.poles().real.max() == pytest.approx(wanted)


def test_the_bicycle_has_its_published_eigenvalues():
    """Meijaard et al. 2007, Table 2, at 5 m/s."""
    wanted = [
        -14.07838969279822,
        -0.77534188219585 - 4.46486771378823j,
        -0.77534188219585 + 4.46486771378823j,
        -0.32286642900409,
    ]
    found = np.sort_complex(machines.bicycle_at(5.0).poles())
    np.testing.assert_allclose(found, wanted, rtol=1e-11)


@pytest.mark.parametrize("count", [3, 6, 24])
def test_the_hull_holds_all_speeds(count):
    points = np.array(machines.hull(4.0, 6.0, count))
    assert len(points) == count
    faces = ConvexHull(points).equations
    v = np.linspace(4, 6, 101)
    inside = faces[:, :2] @ np.array([v, v**2]) + faces[:, 2:]
    assert inside.max() < 1e-9


@pytest.mark.parametrize(
    "name", ["free chain", "tree", "arm", "pendulums", "delayed modes", "observed wire"]
)
def test_wrong_answers_are_caught(name):
    question = case(name, FAMILIES[name].sizes[0], True)
    answer = question.design()
    assert right(question.judge(answer))
    spoiled = {
        key: {k: -x for k, x in x.items()}
        if key == "values"
        else -x
        if key in ("Y", "K", "L")
        else x
        for key, x in answer.items()
    }
    assert not right(question.judge(spoiled))
