"""Designs: what they promise is true, and doesn't depend on units."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.book import thesis
from sosbook.solver.blocks import Blocks
from tests.cases import GRADIENTS, examples, random_request

ONE = [[1.0]]


@pytest.fixture(scope="module")
def example():
    ex = thesis.example_1()
    return ex.plant, ex.requirements


@pytest.fixture(scope="module")
def design(example):
    return sos.design_pid(example[0], **example[1])


def test_example_1(design):
    assert design.status == "feasible"
    assert min(design.margins.values()) > 0.01
    assert design.request.region.contains(design.poles())
    assert design.hinf() < design.gamma
    assert design.peak_input() < 150
    assert np.hstack([design.K_P, design.K_D, design.K_I]).shape == (2, 6)
    assert np.allclose(design.Y, design.K @ design.P)
    assert design.advice == ""
    assert design.infeasibility is None


def test_a_polytope_of_one_plant_is_that_plant(example, design):
    plant, asked = example
    other = sos.design_pid(sos.Polytope([plant]), **asked)
    assert np.array_equal(other.K, design.K)
    assert other.poles().shape == (1, 6)


@pytest.mark.slow
def test_analysis_finds_a_proof_for_every_design():
    for seed in range(examples(4, 7)):
        asked = random_request(seed)
        d = sos.design_pid(**asked)
        if d.status == "feasible":
            again = sos.analyse_pid(K=d.K, **asked)
            assert again.status == "feasible", seed
            assert np.array_equal(again.K, d.K)
            assert again.certify(17).proven, seed


def test_a_stiff_beam():
    """Eigenfrequencies over three decades."""
    n = 4
    S = np.diag([1.0, 1e2, 1e4, 1e6])
    S[0, 3] = S[3, 0] = 10
    plant = sos.SecondOrderSystem(
        np.eye(n), 0.02 * np.sqrt(S), S, np.eye(n)[:, :2], np.eye(n)[:, :1]
    )
    d = sos.design_pid(plant, [[1, 0, 0, 0]])
    assert d.certify().proven


def test_more_inputs_than_degrees_of_freedom():
    plant = sos.SecondOrderSystem(ONE, ONE, ONE, [[1.0, 2.0, 0.0]])
    assert sos.design_pid(plant, ONE).certify().proven


def test_the_smallest_gamma_is_kept(example):
    plant, asked = example
    rest = {k: v for k, v in asked.items() if k != "gamma"}
    least = rest | dict(gamma=sos.HInfinity(mu=1.0), minimize="gamma")
    d = sos.design_pid(plant, **least)
    assert d.certify().proven
    assert d.gamma < asked["gamma"].gamma
    lower = sos.design_pid(plant, gamma=sos.HInfinity(d.gamma * 0.98, mu=1.0), **rest)
    assert lower.status == "infeasible"
    loose = sos.design_pid(plant, **least, search=sos.Search(backoff=0.5))
    assert np.isclose(loose.gamma / d.gamma, 1.5 / 1.01, rtol=5e-3)


def test_what_a_design_without_the_data_cannot_say():
    d = sos.design_pid(sos.SecondOrderSystem(ONE, ONE, ONE, ONE))
    with pytest.raises(ValueError, match="no F"):
        d.hinf()
    with pytest.raises(ValueError, match="no saturation"):
        d.peak_input()
    assert repr(d).startswith("<Design: feasible")


def test_asking_for_less_is_never_harder():
    """A design of bad condition is found in coordinates of its own."""
    ex = thesis.example_3()
    fast = sos.PoleRegion(8.6, ex.region.theta, 20)
    asked = dict(U=ex.U, K_A=ex.K_A)
    d = sos.design_pid(ex.plant, region=fast, **asked)
    assert d.status == "feasible"
    assert d.certify(17).proven and fast.contains(d.poles())
    given = sos.analyse_pid(ex.plant, ex.K, saturation=ex.saturation, **asked)
    assert given.status == "feasible" and given.certify(8).proven


@pytest.mark.slow
def test_an_idle_direction_does_not_hide_the_smallest_gamma():
    """Without sigma a part of P may grow without bound."""
    robot = thesis.example_1()
    d = sos.design_pid(
        robot.plant, robot.U, region=sos.PoleRegion(rho=5), minimize="gamma"
    )
    assert d.status == "feasible" and d.hinf() < d.gamma
    assert d.certify(12).proven


def test_a_size_of_its_own_is_no_trouble_for_conjugate_gradients(monkeypatch):
    """gamma and u_max make a block of one scalar, which has no P and no Y."""
    example = thesis.example_1()
    asked = example.requirements | {"gamma": example.gamma}
    dense = sos.design_pid(example.plant, **asked)
    monkeypatch.setattr(Blocks, "settings", GRADIENTS)
    design = sos.design_pid(example.plant, **asked)
    assert design.status == "feasible" and design.certify().proven
    assert np.abs(design.K - dense.K).max() < 1e-6 * np.abs(dense.K).max()
