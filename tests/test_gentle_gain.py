"""Where the input is bounded, a gentle gain is the start that lies inside."""

import numpy as np
import pytest

import sosbook as sos
from sosbook.solver.newton import newton_of
from sosbook.synthesis.gentle_gain import start_of
from sosbook.synthesis.request import Request
from sosbook.synthesis.scaled_lmis import ScaledLMIs
from sosbook.synthesis.scaling import Frame
from tests.random_plants import ODD


def modes(seed, n, m, unit=1.0):
    """Lightly damped modes, m forces, a bound of the input; another unit of time."""
    rng = np.random.default_rng([seed, n, m])
    Q = np.linalg.qr(rng.standard_normal((n, n)))[0]
    rates = rng.uniform(1, 5, n) / unit
    plant = sos.SecondOrderSystem(
        np.eye(n),
        Q * (0.02 * rates) @ Q.T,
        Q * rates**2 @ Q.T,
        rng.standard_normal((n, m)) / unit**2,
        np.eye(n, 1),
    )
    x0 = np.append(rng.standard_normal(n) / 9, np.zeros(n))
    bound = sos.Saturation(30.0, x0)
    return plant, dict(
        region=sos.PoleRegion(0.03 / unit, rho=30 / unit), saturation=bound
    )


def lmis_of(plant, **asked):
    request = Request(plant, **asked)
    return ScaledLMIs(request, Frame.of(request))


def least(lmis, values):
    return newton_of(lmis.compiled).least(lmis.packed(values)).min()


@pytest.mark.parametrize("n, m", [(1, 1), (2, 1), (2, 2), (4, 1), (4, 2)])
@pytest.mark.parametrize("unit", [1.0, 1e-4, *ODD])
def test_a_gentle_gain_lies_inside_where_the_frames_own_asks_too_much(n, m, unit):
    inside = 0
    for seed in range(6):
        plant, asked = modes(seed, n, m, unit)
        lmis = lmis_of(plant, **asked)
        if least(lmis, lmis.guess()) < 0:
            start = start_of(lmis)
            K, own = lmis.gain(start), lmis.gain(lmis.guess())
            assert np.linalg.norm(K) <= np.linalg.norm(own)
            inside += least(lmis, start) > 0
    assert inside >= 4


def test_with_a_slack_matrix_and_for_two_plants_too():
    plant, asked = modes(1, 2, 1)
    other = sos.SecondOrderSystem(
        1.02 * plant.M, plant.D, 1.01 * plant.S, plant.B, plant.F
    )
    both = sos.Polytope([plant, other])
    for more in ({}, dict(coupling="slack", slack=0.05)):
        lmis = lmis_of(both, **asked, **more)
        assert least(lmis, lmis.guess()) < 0 < least(lmis, start_of(lmis))


def test_phase_one_is_left_out_and_the_centre_is_the_same(monkeypatch):
    plant, asked = modes(0, 2, 1)
    design = sos.design_pid(plant, **asked)
    with monkeypatch.context() as without:
        without.setattr(
            "sosbook.synthesis.feasibility.start_of", lambda lmis: lmis.guess()
        )
        slowly = sos.design_pid(plant, **asked)
    monkeypatch.setattr("sosbook.solver.phase_one.maximize_t", lambda *_: pytest.fail())
    assert sos.design_pid(plant, **asked).status == "feasible"
    assert np.allclose(design.K, slowly.K, rtol=0, atol=1e-8 * np.abs(slowly.K).max())


def test_what_no_gentle_gain_reaches_is_left_to_the_search():
    plant, asked = modes(0, 2, 1)
    for more in (
        dict(saturation=sos.Saturation(1e-6, asked["saturation"].x0)),  # too little
        dict(gamma=0.5),  # asks for more than decay
        dict(saturation=None),
    ):
        lmis = lmis_of(plant, **asked | more)
        assert start_of(lmis).keys() == lmis.guess().keys()
        assert all((start_of(lmis)[k] == x).all() for k, x in lmis.guess().items())
    lmis = lmis_of(plant, **asked, gain=np.zeros((1, 4)))
    assert start_of(lmis) is None or least(lmis, start_of(lmis)) < 0
