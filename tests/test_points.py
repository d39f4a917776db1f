"""Points by equations: large plants, small gains, and what a gain asks."""

import json

import control
import numpy as np
import pytest
from scipy.linalg import block_diag

import sosbook as sos
from benchmarks import structures
from sosbook.synthesis import starting_points
from tests.cases import by_hand, campaign, chain, later, norm_on_a_grid

N_MODES = 24  # 48 states: above the size from which equations answer


def structure(seed=3, n=N_MODES, damping=0.005, inputs=2, unit=1.0, spread=2.6):
    """Free modes of a space structure with frequencies far apart, in any unit."""
    rng = np.random.default_rng(seed)
    w = np.sort(10 ** rng.uniform(0.3, spread, n))
    V = np.linalg.qr(rng.normal(size=(n, n)))[0]
    D, S = (V * (2 * damping * w)) @ V.T, (V * w**2) @ V.T
    B, F = 0.01 * rng.normal(size=(n, inputs)), 0.01 * rng.normal(size=(n, 1))
    matrices = np.eye(n), (D + D.T) / 2, (S + S.T) / 2, B, F
    return sos.SecondOrderSystem(*(unit * x for x in matrices))


def rotor(n=N_MODES, speed=30.0):
    """A shaft of discs between springs, gyroscopic and with damping at one end only."""
    k = 1e4 * (2 * np.eye(n // 2) - np.eye(n // 2, k=1) - np.eye(n // 2, k=-1))
    S, M = block_diag(k, k), 9.81 * np.eye(n)
    turn = np.kron([[0, 1], [-1, 0]], np.eye(n // 2))
    damping = 0.3 * np.eye(n) + 1e-3 * S
    B = np.zeros((n, 2))
    B[0, 0] = B[n // 2, 1] = 1.0
    return sos.SecondOrderSystem(M, damping + 0.1 * speed * turn, S, B, B)


@pytest.mark.parametrize("unit", [0.3, 9.81, *campaign([1.0])])
def test_a_stable_structure_needs_no_gain(unit):
    design = sos.design_pid(structure(unit=unit), region=sos.PoleRegion(1e-3))
    assert design.status == "feasible" and design.central is False
    assert not design.K.any() and "K = 0" in design.reason
    assert design.effort.needless and design.effort.moved == 0
    assert design.certify().proven


@pytest.mark.parametrize("plant", [structure(), structure(5), rotor()], ids=repr)
def test_the_least_effort_moves_what_it_must_and_no_more(plant):
    A, B = by_hand(plant)
    before = np.linalg.eigvals(A)
    sigma = np.quantile(-before.real, 0.3)
    design = sos.design_pid(plant, region=sos.PoleRegion(sigma))
    after = np.linalg.eigvals(A + B @ design.K)
    assert after.real.max() < -sigma
    out = before.real > -sigma * 1.001
    stay = np.abs(after[:, None] - before[~out]).min(axis=0)
    assert (stay < 1e-6 * np.abs(before[~out])).all()
    assert design.effort.moved <= out.sum() + 2 and design.effort.modes == len(A)
    proof = design.certify()
    assert proof.proven and proof.verify()
    assert np.linalg.eigvals(A + B @ proof.K).real.max() < -sigma


def test_regions_of_three_kinds_are_kept_at_once():
    plant = structure()
    A, B = by_hand(plant)
    w = np.abs(np.linalg.eigvals(A))
    region = sos.PoleRegion(0.02, np.arccos(0.0048), 3 * w.max())
    design = sos.design_pid(plant, region=region)
    assert design.status == "feasible"
    poles = np.linalg.eigvals(A + B @ design.K)
    assert poles.real.max() < -0.02 and np.abs(poles).max() < 3 * w.max()
    assert (-poles.real / np.abs(poles)).min() > 0.0048


@pytest.mark.parametrize("share, zero", [(1.2, True), (0.3, False)])
def test_an_h_infinity_bound_by_a_riccati_equation(share, zero):
    plant = structure()
    A, B = by_hand(plant)
    Bw = np.vstack([np.zeros((plant.n, 1)), plant.F])
    C = np.hstack([np.eye(plant.n), np.zeros((plant.n, plant.n))])
    open_loop = norm_on_a_grid(A, Bw, C)
    design = sos.design_pid(
        plant, gamma=share * open_loop, search=sos.Search(prefer="least")
    )
    assert design.status == "feasible"
    assert design.K.any() != zero
    assert norm_on_a_grid(A + B @ design.K, Bw, C) < share * open_loop
    assert design.certify().proven


def test_least_cost_and_observer_of_a_large_plant_are_proven():
    plant = structure(n=10)
    N, (A, B) = 2 * plant.n, by_hand(plant)
    design = sos.design_lqr(plant, np.eye(N), np.eye(plant.m))
    K, X, _ = control.lqr(A, B, np.eye(N), np.eye(plant.m))
    assert np.allclose(design.K, -K, rtol=1e-6, atol=1e-6 * np.abs(K).max())
    assert 1 < design.request.cost.bound / np.trace(X) < 1.001
    assert design.certify().proven
    seen, noise = np.eye(N)[:4], np.vstack([np.eye(N), 0.1 * np.eye(N)])
    observer = sos.design_observer(plant, design.K, noise, np.eye(4), C=seen)
    assert observer.status == "feasible" and observer.certify().proven


def test_a_descriptor_system_is_balanced_by_powers_of_two():
    A, B = by_hand(structure(n=20))
    E = np.diag(np.r_[np.full(20, 0.3), np.full(20, 9.81)])
    design = sos.design_pid(
        sos.DescriptorSystem(E, E @ A, E @ B), region=sos.PoleRegion(1e-4)
    )
    assert design.status == "feasible" and not design.K.any()


def test_modes_that_coincide_get_an_answer():
    """Jordan blocks have no independent eigenvectors."""
    n = 20
    E, A = np.eye(2 * n), -np.eye(2 * n) + np.eye(2 * n, k=1)
    design = sos.analyse_pid(
        sos.DescriptorSystem(E, A, np.zeros((2 * n, 1))),
        np.zeros((1, 2 * n)),
        search=sos.Search(time_limit=30),
    )
    assert design.status in ("feasible", "undecided") and design.K is not None


def test_a_negative_kinetic_energy_is_named():
    plant = structure()
    M = plant.M.copy()
    M[0, 0] = -1.0
    odd = sos.SecondOrderSystem(M, plant.D, plant.S, plant.B, plant.F)
    design = sos.design_pid(
        odd, region=sos.PoleRegion(5.0), search=sos.Search(time_limit=0.5)
    )
    assert design.status != "infeasible"
    assert design.status == "feasible" or "kinetic energy" in design.reason


@pytest.mark.parametrize("prefer", ["least", "centre", None])
def test_what_is_preferred_of_a_small_plant(prefer):
    plant = chain(2)
    region = sos.PoleRegion(0.3, rho=9.0)
    design = sos.design_pid(plant, search=sos.Search(prefer=prefer), region=region)
    other = sos.design_pid(plant, region=region)
    if prefer == "least":
        assert np.abs(design.K).max() < np.abs(other.K).max()
    else:
        assert np.allclose(design.K, other.K, rtol=1e-6)
    bound = sos.Saturation(99, [1] * 4)
    bounded = sos.design_pid(
        plant, search=sos.Search(prefer=prefer), region=region, saturation=bound
    )
    assert bounded.status == "feasible"


def test_what_is_preferred_is_one_of_two_words():
    with pytest.raises(ValueError, match='prefer must be None, "centre" or "least"'):
        sos.Search(prefer="small")


@pytest.mark.parametrize(
    "wrong, words",
    [
        (dict(backoff=0), "backoff must be positive"),
        (dict(start=[[1.0]]), "start must be a Design"),
        (dict(starts=0), "starts must be 1, 2"),
        (dict(seed=-1), "seed must be 0, 1"),
    ],
)
def test_a_search_checks_what_it_holds(wrong, words):
    with pytest.raises(ValueError, match=words):
        sos.Search(**wrong)


def test_what_a_search_holds_and_nobody_takes_is_refused():
    law, plant = sos.PIDLaw([[1]], [[1]]), sos.SecondOrderSystem(1, 1, 1, 1)
    with pytest.raises(ValueError, match="search has starts, .* without a law"):
        sos.design_pid(plant, search=sos.Search(starts=3))
    for search in (sos.Search(starts=2), sos.Search(prefer="least")):
        with pytest.raises(ValueError, match="which is not for a given gain"):
            sos.analyse_pid(plant, [[-1, -1]], search=search)
    with pytest.raises(ValueError, match="search has prefer, .* a law's gain"):
        sos.design_pid(plant, law=law, search=sos.Search(prefer="centre"))


def test_a_gain_that_no_actuator_gives_is_named():
    plant = chain(2)
    K = np.zeros((plant.m, 4))
    K[0, 0] = -1e9
    found = sos.analyse_pid(plant, K)
    assert found.effort.stiffness > 1e6 and "no actuator" in str(found.effort)


def test_of_several_plants_the_effort_speaks_of_the_vertices():
    plants = sos.Polytope([sos.SecondOrderSystem(1, 1, s, 1) for s in (1, 1.2)])
    found = sos.analyse_pid(plants, [[0, 0]]).effort
    assert found.needless and "already at each vertex" in str(found)


def test_stored_structures_are_answered_and_proven():
    stored = json.loads(structures.RESULTS.read_text("utf-8"))["records"]
    sizes = {(kind, n) for kind, (_, own, _) in structures.KINDS.items() for n in own}
    assert {(r["kind"], r["modes"]) for r in stored} == sizes
    assert all(r["status"] == "feasible" and r["proven"] for r in stored)
    assert not any(r["largest_gain"] for r in stored if r["asked"] == "stable")
    parts = [r["whole"] for r in stored if r["kind"] == "whole"]
    assert len(parts) == 2 and all(x.startswith("found: ") for x in parts)


@pytest.mark.parametrize("kind, size", [("station", 24), *later(("building", 20))])
def test_structures_are_measured_as_they_are_stored(kind, size):
    log, sizes = (lambda record: None), [size]
    again = structures.measured([kind], log, sizes)["records"]
    assert all(r["proven"] for r in again) and again[0]["moved"] == 0


def test_equations_do_what_they_promise():
    rng = np.random.default_rng(0)
    A, B = rng.normal(size=(6, 6)), rng.normal(size=(6, 2))
    K, count = starting_points.deflated(
        A, B, lambda s: s.real > -0.5, starting_points.least_effort(0.5)
    )
    before, after = np.linalg.eigvals(A), np.linalg.eigvals(A + B @ K)
    out = before.real > -0.5
    assert count == out.sum()
    expected = np.r_[before[~out], -1.0 - before[out].conj()]
    assert np.allclose(np.sort_complex(after), np.sort_complex(expected), atol=1e-8)
    K, _ = starting_points.deflated(
        A, B, lambda s: abs(s + 3) > 2, starting_points.in_disk(3.0, 2.0)
    )
    assert np.abs(np.linalg.eigvals(A + B @ K) + 3).max() < 2 + 1e-9
    stable = A - 4 * np.eye(6)
    P = starting_points.of_modes(stable)
    assert np.linalg.eigvalsh(P)[0] > 0
    assert np.linalg.eigvalsh(stable @ P + P @ stable.T)[-1] < 0
    B = rng.normal(size=(6, 6))  # as many as outputs: control's norm wants that
    norm = control.system_norm(control.ss(stable, B, np.eye(6), 0), "inf")
    P = starting_points.bounded_real(stable, B, np.eye(6), 1.01 * norm)
    block = stable @ P + P @ stable.T + B @ B.T + P @ P / (1.01 * norm) ** 2
    assert np.linalg.eigvalsh(P)[0] > 0 and np.linalg.eigvalsh(block)[-1] < 0
    assert starting_points.bounded_real(stable, B, np.eye(6), 0.99 * norm) is None


@pytest.mark.parametrize("unit", [0.3, *campaign([1.0])])
def test_the_point_of_the_mean_is_tried_at_several_vertices(unit):
    """Masses that differ by a part of the damping: pairs are needed, and kept."""
    one = structure(unit=unit)
    other = sos.SecondOrderSystem(1.002 * one.M, one.D, one.S, one.B, one.F)
    plants = sos.Polytope([one, other])
    before = max(p.poles().real.max() for p in plants.vertices)
    for sigma, still in ((-0.5 * before, True), (-1.5 * before, False)):
        design = sos.design_pid(plants, region=sos.PoleRegion(sigma))
        assert design.status == "feasible" and design.central is False
        assert "found by an equation" in design.reason and design.K.any() != still
        assert design.certify().proven
        assert design.poles(samples=5).real.max() < -sigma
