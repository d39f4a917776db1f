"""How large unknowns must be, read from blocks: against the closed forms."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.requirements.magnitudes import Magnitudes
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaling import Frame
from tests.cases import falling_plant, seeds
from tests.random_plants import ODD_POWERS, as_units

POWERS = [(0,) * 5, ODD_POWERS, (3, 6, -4, 5, 0), (-6, -9, 2, -5, 0)]


def request(seed, powers, name):
    """A random plant in other units, and one requirement of it."""
    plant = falling_plant(seed, 2)
    there = as_units(plant, powers, 0)
    x0 = np.random.default_rng(seed).standard_normal(2 * plant.n)
    asked = {"gamma": {"gamma": 2.0}, "u_max": {"saturation": sos.Saturation(3.0, x0)}}[
        name
    ]
    return Request(there.plant(plant), **there.requirements(asked))


@pytest.mark.parametrize("name", ["gamma", "u_max"])
@pytest.mark.parametrize("powers", POWERS)
@pytest.mark.parametrize("seed", seeds(3))
def test_the_package_s_requirements_have_the_same_in_closed_form(seed, powers, name):
    asked = request(seed, powers, name)
    (r,), frame = asked.requirements, Frame.of(asked)
    found = Magnitudes(r, asked, frame)
    if name == "u_max":
        start = np.linalg.solve(frame.T, r.x0)
        P, level = 2 * start @ start, frame.scale**2
    else:
        Bw = np.linalg.solve(frame.T, asked.mean.state_space()[2])
        P, level = (
            np.linalg.norm(x, 2) ** 2 / asked.typical_rate
            for x in (Bw, asked.mean.C @ frame.T)
        )
    assert 2 * found.P == pytest.approx(P, rel=0.01)
    assert 0.05 * level < found.level < 20 * level


@pytest.mark.parametrize("noise", ["F", "states"])
def test_the_own_unknown_of_a_cost_has_the_size_of_the_noise(noise):
    plant = falling_plant(1)
    N = 2 * plant.n
    cost = sos.QuadraticCost(np.eye(N), np.eye(plant.m), noise, bound=1.0)
    for powers in POWERS:
        asked = Request(as_units(plant, powers, 0).plant(plant), requirements=[cost])
        frame = Frame.of(asked)
        found = Magnitudes(cost, asked, frame)
        share = np.linalg.norm(frame.back @ cost.noise_input(asked.mean), 2) ** 2
        assert found.P == 0  # any will do
        assert 1e-2 * share < found.own < 1e2 * share


def test_what_nothing_bounds_is_zero():
    asked = Request(falling_plant(2), region=sos.PoleRegion(sigma=0.3))
    (region,) = asked.requirements
    found = Magnitudes(region, asked, Frame.of(asked))
    assert (found.P, found.own, found.level) == (0.0, 0.0, 0.0)
