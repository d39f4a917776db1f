"""Large loops with a pole outside are refused by a form that grows along them."""

import numpy as np
import pytest

import sosbook as sos
from sosbook import proofs
from sosbook.exact.checker import verdict
from sosbook.synthesis.growing import FROM_STATES, GrowingRefusal
from tests.cases import campaign

N = 13  # rows: just large enough


def structure(n=N, push=0.3, unit=1.0, bearings=1):
    """Masses on springs and dampers, turned, with a force that circulates in some
    bearings: it drives them.
    """
    rng = np.random.default_rng(n)
    S = unit * np.diag(np.linspace(1, 9.81, n) ** 2)
    for k in range(0, 2 * bearings, 2):
        S[k, k + 1], S[k + 1, k] = push * unit, -push * unit
    turn, _ = np.linalg.qr(np.eye(n) + 0.2 * rng.normal(size=(n, n)))
    S, D = turn.T @ S @ turn, 0.05 * np.sqrt(unit) * np.eye(n)
    return sos.SecondOrderSystem(np.eye(n), D, S, np.eye(n)[:, :1])


def loop(plant, K):
    """The loop's matrix."""
    n, (P, D) = plant.n, np.split(K, 2, axis=1)
    lower = np.linalg.solve(
        plant.M, np.hstack([plant.B @ P - plant.S, plant.B @ D - plant.D])
    )
    return np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), lower])


def refused(plant, K=None, **asked):
    K = np.zeros((1, 2 * plant.n)) if K is None else K
    d = sos.analyse_pid(plant, K, **asked)
    assert d.status == "infeasible" and isinstance(d.infeasibility, GrowingRefusal)
    assert d.infeasibility.proven
    return d


@pytest.mark.parametrize("unit", [0.3, 9.81e4, *campaign([1.0])])
def test_a_driven_pair_of_many_rows_is_refused(unit):
    plant = structure(push=2.0, unit=unit)
    poles = np.linalg.eigvals(loop(plant, np.zeros((1, 2 * N))))
    assert (poles.real > 0).sum() == 2  # one pair of 13
    d = refused(plant)
    s = poles[poles.real.argmax()]
    assert f"{s.real:.4g}±{abs(s.imag):.4g}j" in d.reason and "grows" in d.reason
    assert "Change the gain" in d.advice
    assert verdict.check(d.infeasibility.text) == list(d.infeasibility.claims)
    assert "breaks: its poles lie left of the imaginary axis" in str(d.infeasibility)


@pytest.mark.parametrize(
    "region",
    [
        sos.PoleRegion(sigma=0.0251),
        sos.PoleRegion(theta=np.arccos(0.026)),
        sos.LMIRegion.disk(9.5, -0.5),
        *campaign([sos.PoleRegion(rho=9.0)]),
    ],
    ids=repr,
)
def test_any_region_that_a_pole_leaves(region):
    """Forms are real for half-planes and twice as large elsewhere."""
    plant = structure(push=0.0)
    d = refused(plant, region=region)
    poles = np.linalg.eigvals(loop(plant, np.zeros((1, 2 * N))))
    assert poles.real.max() < 0
    assert verdict.check(d.infeasibility.text) == list(d.infeasibility.claims)


@pytest.mark.parametrize(
    "asked", [dict(gamma=1.0), dict(requirements=[sos.H2(9.81)])], ids=["gamma", "h2"]
)
def test_a_bound_of_a_norm_is_refused_before_a_search(asked, monkeypatch):
    """A loop with a pole on the right has no norm, whatever the bound."""
    monkeypatch.setattr("sosbook.synthesis.feasibility.search", None)
    plant = structure(push=2.0, unit=0.3)
    parts = plant.M, plant.D, plant.S, 9.81 * np.eye(N)[:, :2], 0.3 * np.eye(N)[:, :1]
    d = refused(sos.SecondOrderSystem(*parts), np.zeros((2, 2 * N)), **asked)
    assert "breaks stability" in d.reason


def test_a_gain_that_drives_some_and_integrates(tmp_path):
    plant = structure(push=0.0)
    K = np.zeros((1, 2 * N))
    K[0, N] = 9.81
    assert np.linalg.eigvals(loop(plant, K)).real.max() > 0
    refused(plant, K).infeasibility.save(tmp_path / "no.json")
    read = proofs.load(tmp_path / "no.json")
    assert isinstance(read, GrowingRefusal) and read.verify() and read.place == (0, 0)
    U = np.eye(N)[:1]
    d = sos.analyse_pid(plant, np.hstack([K, [[0.3]]]), U=U)
    assert isinstance(d.infeasibility, GrowingRefusal)
    first = sos.DescriptorSystem(np.eye(2 * N) * 3, 3 * loop(plant, K))
    assert isinstance(sos.analyse_pid(first).infeasibility, GrowingRefusal)


def test_several_plants_and_one_halfway():
    plants = sos.Polytope([structure(push=0.0), structure(push=2.0)])
    d = refused(plants)
    assert d.infeasibility.place == (1, 1) and "vertex 2" in d.reason
    K = np.zeros((1, 2 * N))
    of_vertices = sos.analyse_pid(plants, K, coupling="multipliers")
    assert of_vertices.status == "infeasible" and of_vertices.infeasibility.proven


def test_what_keeps_it_and_what_is_small_stay_as_they_were():
    kept = structure(push=0.0)
    assert sos.analyse_pid(kept, np.zeros((1, 2 * N))).status == "feasible"
    small = structure(n=FROM_STATES // 2, push=2.0)
    d = sos.analyse_pid(small, np.zeros((1, 2 * small.n)))
    assert d.status == "infeasible" and np.isclose(d.infeasibility.mode.real, 0, atol=1)


@pytest.mark.parametrize("n", [60, *campaign([100])])
def test_one_pair_of_a_hundred(n):
    """It takes a second of a processor; the polynomial of the loop took minutes."""
    plant = structure(n=n, push=3.0)
    poles = np.linalg.eigvals(loop(plant, np.zeros((1, 2 * n))))
    assert (poles.real > 0).sum() == 2
    refused(plant)
