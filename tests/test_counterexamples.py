"""Both vertices pass, a plant between them is unstable, pairs refuse."""

from dataclasses import replace

import numpy as np
import pytest

import sosbook as sos
from sosbook import theorems
from sosbook.book import counterexamples
from sosbook.exact.definite import exact, pivots
from sosbook.plants.coupled import Coupled
from sosbook.plants.descriptor import Descriptor
from sosbook.synthesis.request import Request
from tests.test_certificate import positive_definite


def test_rotation():
    (first, second), P = counterexamples.rotation()
    Y = np.zeros((1, 2))
    for v in (first, second):
        g = theorems.stability(Coupled(v, v, P, Y))
        assert np.allclose(g, 0.2 * np.eye(2))
    assert first.Du is None and second.Du is None
    halfway = Descriptor(
        **{
            name: (x + getattr(second, name)) / 2
            for name, x in vars(first).items()
            if x is not None
        }
    )
    poles = np.linalg.eigvals(np.linalg.solve(halfway.E, halfway.A))
    assert np.allclose(poles, [4.9 + 5j, 4.9 - 5j])
    pair = theorems.stability(Coupled(first, second, P, Y))
    assert np.linalg.eigvalsh(pair)[0] < 0


def test_mechanical_vertices_hold_exactly():
    plants, P = counterexamples.mechanical()
    request = Request(plants, coupling="vertices", gain=np.zeros((1, 4)))
    P, Y = exact(P), exact(np.zeros((1, 4)))
    blocks = request.blocks(P, Y, exact)
    assert set(blocks) == {"P", "stability 1", "stability 2"}
    assert all(positive_definite(g) for g in blocks.values())
    whole = replace(request, coupling="pairs").blocks(P, Y, exact)
    assert pivots(whole["stability 1,2"])[-1] < 0


def test_mechanical_masses_are_positive_and_the_middle_is_unstable():
    plants, _ = counterexamples.mechanical()
    for v in plants.vertices:
        assert np.linalg.eigvalsh(v.M)[0] > 0
        assert v.poles().real.max() < 0
    assert np.isclose(plants.mean.poles().real.max(), 3.91, atol=0.005)


def test_mechanical_verdicts():
    plants, _ = counterexamples.mechanical()
    K = np.zeros((1, 4))
    vertices = sos.analyse_pid(plants, K, coupling="vertices")
    pairs = sos.analyse_pid(plants, K, coupling="pairs")
    assert vertices.certify().proven
    assert "not the plants between" in vertices.certify().claims[0]
    assert pairs.status == "infeasible"


def test_turn_fails_the_disk_though_only_E_varies():
    (first, second), P = counterexamples.turn()
    assert np.array_equal(first.A, second.A)
    disk = sos.LMIRegion.disk(1.01)
    Y = np.zeros((1, 2))
    for v in (first, second):
        for g in (
            theorems.pole_region(Coupled(v, v, P, Y), disk.alpha, disk.beta),
            theorems.stability(Coupled(v, v, P, Y)),
        ):
            assert np.linalg.eigvalsh(g)[0] > 0
    E = (first.E + second.E) / 2
    poles = np.linalg.eigvals(np.linalg.solve(E, first.A))
    assert np.allclose(abs(poles), np.sqrt(5) / 2)
    pair = theorems.pole_region(Coupled(first, second, P, Y), disk.alpha, disk.beta)
    assert np.linalg.eigvalsh(pair)[0] < 0


def test_slower_corners_leave_the_disk_between_proven_vertices():
    plants = counterexamples.slower_corners()
    first, second = plants.vertices
    assert np.array_equal(first.S, second.S)
    assert np.array_equal(first.D, second.D)
    K, region = np.zeros((1, 4)), sos.PoleRegion(rho=17)
    corners = sos.analyse_pid(plants, K, region=region, coupling="vertices")
    assert corners.certify().proven
    assert region.contains(corners.poles())
    for v in plants.vertices:
        assert np.linalg.eigvalsh(v.M)[0] > 0
    assert abs(plants.at([0.3, 0.7]).poles()).max() > 18
    pairs = sos.analyse_pid(plants, K, region=region)
    assert pairs.status == "infeasible"


def test_actuated_is_mechanical_with_a_force_on_each_mass():
    plain, _ = counterexamples.mechanical()
    driven = counterexamples.actuated()
    for v, w in zip(plain.vertices, driven.vertices):
        assert np.array_equal(v.M, w.M) and np.array_equal(v.S, w.S)
        assert np.array_equal(w.B, np.eye(2))


def test_with_an_input_bound_the_vertices_go_wrong_and_the_pairs_do_not():
    limit = sos.Saturation(10, [1, 0, 0, 0])
    for coupling, stable in (("vertices", False), ("pairs", True)):
        design = sos.design_pid(
            counterexamples.actuated(), saturation=limit, coupling=coupling
        )
        assert design.certify().proven
        assert (design.poles(samples=50).real.max() < 0) == stable


def test_random_chain():
    box = counterexamples.random_chain(4, masses=3, spread=0.25)
    assert box.N == 8
    masses = np.array([v.M.diagonal() for v in box.vertices])
    nominal = masses.mean(axis=0)
    assert np.allclose(abs(masses / nominal - 1), 0.25)
    assert len({tuple(m) for m in masses.round(6)}) == 8
    ends = counterexamples.random_chain(4, 3, 0.25, box=False)
    assert ends.N == 2
    assert np.allclose(ends.mean.M, np.diag(nominal))
    for v in (*box.vertices, *ends.vertices):
        assert np.array_equal(v.S, v.S.T)
        assert np.linalg.eigvalsh(v.S)[0] > 0
        assert v.poles().real.max() < 0


def test_random_pair():
    plants = counterexamples.random_pair(7, ratio=9)
    again = counterexamples.random_pair(7, ratio=9)
    for v, w in zip(plants.vertices, again.vertices):
        assert np.array_equal(v.M, v.M.T)
        low, high = np.linalg.eigvalsh(v.M)
        assert np.isclose(high / low, 9, rtol=0.1)
        assert np.array_equal(v.D, w.D)


@pytest.mark.parametrize("bad", [0, -0.1, 1.0, np.nan])
def test_random_chain_refuses_a_spread(bad):
    with pytest.raises(ValueError, match="spread must be"):
        counterexamples.random_chain(0, spread=bad)
