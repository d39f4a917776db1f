"""A bound of the whole signal u = K x + K_A z'', and not of K x alone."""

from dataclasses import replace

import numpy as np
import pytest

import sosbook as sos
from sosbook.analysis.linear import peak_input
from sosbook.book import thesis
from sosbook.plants.descriptor import descriptors
from sosbook.synthesis.request import Request


@pytest.fixture(scope="module")
def chain():
    return thesis.example_3()


@pytest.fixture(scope="module")
def whole(chain):
    asked = chain.requirements
    asked["saturation"] = replace(asked["saturation"], acceleration=True)
    return sos.design_pid(chain.plant, **asked)


def test_peak_with_acceleration_is_the_simulated_one(chain):
    (d,) = descriptors(chain.plant, chain.U, chain.K_A)
    x0, t = chain.saturation.x0, np.linspace(0, 8, 8001)
    loop = sos.analyse_pid(chain.plant, chain.K, **chain.requirements)
    u = np.linalg.norm(loop.simulate(t, x0=x0).u, axis=0).max()
    found = peak_input(d, chain.K, x0, chain.K_A)
    assert u <= found * (1 + 1e-9) and abs(u - found) < 1e-3 * found
    assert found > 1.2 * peak_input(d, chain.K, x0)


def test_the_whole_signal_is_bounded_and_proven(chain, whole):
    proof = whole.certify()
    assert proof.proven and "K_A z''" in proof.claims[-1]
    assert whole.peak_input() <= 120


def test_the_bound_is_tight_enough_to_refuse(chain):
    """Half of the true peak can't be proven."""
    given = sos.analyse_pid(chain.plant, chain.K, **chain.requirements)
    (d,) = given.request.vertices
    peak = peak_input(d, chain.K, chain.saturation.x0, chain.K_A)
    asked = chain.requirements
    asked["saturation"] = sos.Saturation(
        0.5 * peak, chain.saturation.x0, acceleration=True
    )
    assert sos.analyse_pid(chain.plant, chain.K, **asked).status == "infeasible"


def test_without_K_A_nothing_changes():
    robot = thesis.example_1()
    asked = robot.requirements
    plain = sos.design_pid(robot.plant, **asked)
    asked["saturation"] = replace(asked["saturation"], acceleration=True)
    assert np.allclose(sos.design_pid(robot.plant, **asked).K, plain.K)


def test_uncertain_mass_is_refused():
    seat = thesis.example_2()
    asked = seat.requirements
    asked["saturation"] = replace(asked["saturation"], acceleration=True)
    asked["K_A"] = -0.1 * np.ones((seat.plant.m, seat.plant.n))
    with pytest.raises(ValueError, match="same M - B K_A"):
        sos.design_pid(seat.plant, **asked)


@pytest.mark.parametrize("coupling", ["pairs", "slack"])
def test_the_block_holds_the_signal_of_the_loop(chain, coupling):
    """Its corner is (K + K_A [z'' per x]) P, or V' with a slack matrix."""
    asked = chain.requirements
    asked["saturation"] = replace(asked["saturation"], acceleration=True)
    request = Request(
        chain.plant,
        **asked,
        coupling=("slack", 0.1) if coupling == "slack" else coupling,
    )
    (d,), N = request.vertices, request.order
    V = np.random.default_rng(1).standard_normal((N, N))
    P = V + V.T
    right = P if coupling == "pairs" else V.T
    found = request.blocks(P if coupling == "pairs" else [P], chain.K @ right, V=V)
    rate = np.linalg.solve(d.E, d.A + d.Bu @ chain.K)
    n = chain.plant.n
    whole = chain.K + chain.K_A @ rate[n : 2 * n]
    assert np.allclose(found["u_max"][N:, :N], whole @ right)


def test_without_a_gain_on_accelerations_different_masses_are_no_hindrance():
    """Then K_A z'' is nothing, and the bound is that of K x: the same design."""
    plant = sos.Polytope([sos.SecondOrderSystem(m, 0.3, 9.81, 1) for m in (0.3, 0.5)])
    gains = [
        sos.design_pid(
            plant,
            region=sos.PoleRegion(1.0),
            saturation=sos.Saturation(40.0, [0.1, 0], acceleration=acceleration),
        ).K
        for acceleration in (False, True)
    ]
    np.testing.assert_array_equal(*gains)
