"""Examples 2 and 3: the chapters' statements, from first principles."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.analysis.linear import poles
from sosbook.book import thesis
from sosbook.plants.descriptor import descriptors
from sosbook.plants.response import simulate


@pytest.fixture(scope="module")
def seat():
    return thesis.example_2()


@pytest.fixture(scope="module")
def chain():
    return thesis.example_3()


def divided(mass):
    """Example 2, its first equation divided by the mass."""
    c, rows = thesis.car_seat(mass), np.diag([1 / mass, 1])
    return sos.SecondOrderSystem(
        rows @ c.M, rows @ c.D, rows @ c.S, rows @ c.B, rows @ c.F
    )


@pytest.mark.parametrize("k22, effort", [(45000, 40000), (40500, 35500)])
def test_the_steady_effort_tells_which_stiffness_was_used(k22, effort):
    """Fig. 3.8's u2 at rest is the second entry of S r, whatever K is."""
    ex = thesis.example_2()
    (d,) = descriptors(thesis.car_seat(100, k22), ex.U)
    run = simulate(d, ex.K, np.linspace(0, 30, 301), ex.set_point)
    assert abs(run.u[1, -1] - effort) < 1


def test_one_uncertain_mass_needs_no_pair(seat):
    """The blocks at any mass are the mean of those at the ends."""
    ends = sos.Polytope([divided(70), divided(400)])
    design = sos.design_pid(ends, **seat.requirements)
    assert design.certify().proven
    assert design.request.claims.covers_polytope and len(design.request.pairs) == 2
    for mass in (71, 95, 150, 280, 399):
        weight = (1 / mass - 1 / 400) / (1 / 70 - 1 / 400)
        between = ends.at([weight, 1 - weight])
        there = divided(mass)
        for name in "MDSBF":
            assert np.allclose(getattr(between, name), getattr(there, name))
        (loop,) = descriptors(thesis.car_seat(mass), seat.U)
        assert seat.region.contains(poles(loop, design.K))


def test_the_mass_divided_or_not_is_the_same_design(seat):
    """Their blocks are congruent, so that they have one centre."""
    ends = [thesis.car_seat(m) for m in (70, 400)]
    whole = sos.design_pid(sos.Polytope(ends), **seat.requirements)
    quotient = sos.design_pid(
        sos.Polytope([divided(70), divided(400)]), **seat.requirements
    )
    assert whole.certify().proven and len(whole.request.pairs) == 2
    assert np.allclose(whole.K, quotient.K, rtol=1e-6)


def test_set_points_that_the_chain_can_hold(chain):
    design = sos.analyse_pid(
        chain.plant, chain.K, chain.U, region=chain.region, K_A=chain.K_A
    )
    S, t = chain.plant.S, np.linspace(0, 25, 251)
    inner = -np.linalg.solve(S[1:3, 1:3], S[1:3, [0, 3]] @ [1, -0.5])
    held = np.r_[1, inner, -0.5]
    other = held + [0, 0.2, 0, 0]
    assert np.abs(design.simulate(t, held).e[:, -1]).max() < 1e-6
    error = design.simulate(t, other).e[:, -1]
    assert np.abs(error[[0, 3]]).max() < 1e-6
    assert np.abs(error[[1, 2]]).max() > 0.1


def test_the_chain_with_a_light_last_mass(chain):
    def loaded(mass):
        v = chain.plant
        M = v.M + np.diag([0, 0, 0, mass])
        return sos.SecondOrderSystem(M, v.D, v.S, v.B, v.F)

    ends = sos.Polytope([loaded(0), loaded(0.3)])
    found = sos.analyse_pid(ends, chain.K, **chain.requirements)
    assert found.certify(7).proven
    for mass, inside in ((0.3, True), (0.33, True), (0.34, False)):
        (loop,) = descriptors(loaded(mass), chain.U, chain.K_A)
        assert chain.region.contains(poles(loop, chain.K)) == inside
    (bare,) = descriptors(loaded(0.01), chain.U)  # without K_A
    assert poles(bare, chain.K).real.max() > 1000
