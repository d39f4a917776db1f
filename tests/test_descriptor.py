"""The descriptor form and the coupling of vertex pairs."""

import control
import numpy as np
import pytest

import sosbook as sos
from sosbook.book import counterexamples, thesis
from sosbook.plants.coupled import Coupled
from sosbook.plants.coupling import coupling_of
from sosbook.plants.descriptor import descriptors
from tests.cases import norm_on_a_grid, random_plant


def test_matrices_of_2_8():
    rng = np.random.default_rng(1)
    v, U, K_A = random_plant(rng, 2, 1), [[1.0, 2.0]], [[0.3, -0.1]]
    (d,) = descriptors(v, U, K_A)
    Z, z = np.zeros((2, 2)), np.zeros((2, 1))
    one = np.eye(2)
    assert np.array_equal(
        d.E, np.block([[one, Z, z], [Z, v.M - v.B @ K_A, z], [z.T, z.T, np.eye(1)]])
    )
    assert np.array_equal(
        d.A,
        np.block([[Z, one, z], [-v.S, -v.D, z], [np.array(U), z.T, np.zeros((1, 1))]]),
    )
    assert np.array_equal(d.Bu, np.vstack([z, v.B, [[0]]]))
    assert np.array_equal(d.Bw, np.vstack([z, v.F, [[0]]]))
    assert np.array_equal(d.C, np.hstack([one, Z, z]))


def test_state_space_is_the_transfer_function_of_2_1():
    """z = (M s^2 + D s + S)^-1 B u at some points s."""
    v = random_plant(np.random.default_rng(2), 3, 2)
    A, B, Bw = descriptors(v)[0].state_space()
    loop = control.ss(A, B, np.eye(6)[:3], np.zeros((3, 2)))
    for s in (0.3j, 2.0, 1 + 5j):
        wanted = np.linalg.solve(v.M * s**2 + v.D * s + v.S, v.B)
        assert np.allclose(loop(s), wanted)


def test_the_sign_of_the_integrator():
    """With the minus that (2.7) prints, the printed gains are unstable."""
    ex = thesis.example_1()
    K = ex.K.copy()
    assert sos.analyse_pid(ex.plant, K, ex.U).poles().real.max() < -0.9
    K[:, 4:] *= -1
    assert sos.analyse_pid(ex.plant, K, ex.U).poles().real.max() > 0


def test_pairs():
    vertices = descriptors(counterexamples.actuated())
    assert coupling_of("vertices").pairs(vertices) == [(0, 0), (1, 1)]
    assert coupling_of("pairs").pairs(vertices) == [(0, 0), (1, 1), (0, 1)]
    seat = descriptors(thesis.example_2().plant)  # one uncertain mass
    assert coupling_of("pairs").pairs(seat) == [(0, 0), (1, 1)]
    assert coupling_of("pairs").pairs(seat, quotient=False) == [(0, 0), (1, 1), (0, 1)]


def test_pairs_with_one_mass_are_the_mean_of_their_vertices():
    """Where E is certain no pair is needed."""
    v = thesis.car_seat(100)
    stiff = sos.SecondOrderSystem(v.M, 2 * v.D, 3 * v.S, 0.5 * v.B, v.F)
    both = descriptors(sos.Polytope([v, stiff]))
    assert coupling_of("pairs").pairs(both) == [(0, 0), (1, 1)]
    rng = np.random.default_rng(4)
    P, Y = rng.standard_normal((4, 4)), rng.standard_normal((2, 4))
    P = P + P.T
    i, j, ij = (Coupled(both[a], both[b], P, Y) for a, b in [(0, 0), (1, 1), (0, 1)])
    for part in ("Theta", "EPE", "EPC", "Bw"):
        mean = (getattr(i, part) + getattr(j, part)) / 2
        assert np.allclose(getattr(ij, part), mean)


def test_very_different_masses_are_not_singular():
    plant = sos.SecondOrderSystem(np.diag([1e-9, 1e9]), np.eye(2), np.eye(2), np.eye(2))
    A, B, _ = descriptors(plant)[0].state_space()
    assert np.allclose(A[2:, :2], np.diag([-1e9, -1e-9]))


@pytest.mark.parametrize("coupling", ["pairs", "slack"])
def test_gamma_bounds_the_input_too(coupling):
    """y = C x + D_u u: the norm from w to [x; u / 2], on a fine grid."""
    E = [np.diag([1.0, 2.0]), np.diag([1.2, 2.0])]
    A, B, B_w = [[0, 1], [1, -1]], [[0], [1]], [[0], [1]]
    C, D_u = np.vstack([np.eye(2), [[0, 0]]]), [[0], [0], [0.5]]
    plant = sos.DescriptorSystem(E, A, B, B_w, C, D_u)
    design = sos.design_pid(plant, minimize="gamma", coupling=coupling)
    assert design.certify().proven
    loop, seen = A + B @ design.K, C + D_u @ design.K
    truth = max(
        norm_on_a_grid(np.linalg.solve(e, loop), np.linalg.solve(e, B_w), seen)
        for e in E
    )
    assert design.hinf() == pytest.approx(truth, rel=1e-4)
    assert truth < design.gamma < 3 * truth
    blind = sos.DescriptorSystem(E, A, B, B_w, C)
    free = sos.design_pid(blind, minimize="gamma", coupling=coupling, region=FAST)
    assert free.gamma < design.gamma  # the input costs nothing there


FAST = sos.PoleRegion(rho=50)


def test_the_norm_with_an_input_weight_in_closed_form():
    """x' = x + u + w, y = [x; u]: the largest gain stands at s = 0."""
    plant = sos.DescriptorSystem(1, 1, 1, 1, C=[[1], [0]], D_u=[[0], [1]])
    design = sos.design_pid(plant, minimize="gamma", search=sos.Search(backoff=1e-4))
    truth = np.sqrt(1 + design.K.item() ** 2) / abs(design.K.item() + 1)
    assert design.hinf() == pytest.approx(truth, rel=1e-6)
    bounded = sos.design_pid(plant, gamma=1.5)
    assert bounded.certify().proven and bounded.hinf() < 1.5
