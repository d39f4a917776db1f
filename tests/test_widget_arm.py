"""The swing explorer designs again and shows the true arm."""

import numpy as np
import pytest
from sosbook.widgets.arm import REST, STEPS, explore_swing

import sosbook as sos
from sosbook.analysis.nonlinear import arm_gravity, simulate_nonlinear


@pytest.fixture
def explorer():
    return explore_swing()


def design(low, sigma=5.0, theta=np.pi / 3, rho=15.0):
    arms = sos.Polytope([sos.thesis.arm(1.0), sos.thesis.arm(low)])
    return sos.design_pid(arms, [[0, 1]], region=sos.PoleRegion(sigma, theta, rho))


def shows(explorer, gains):
    return all(f">{k:.4g}<" in explorer.picture.value for k in gains.ravel())


def test_it_starts_with_example_4(explorer):
    assert shows(explorer, design(2 / np.pi).K)
    assert "factors from 0.637 to 1" in explorer.picture.value
    assert explorer.picture.value.count("<polyline") == 5


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, value, asked",
    [
        ("phi_max", 60.0, dict(low=np.sinc(1 / 3))),
        ("sigma", 4.0, dict(low=2 / np.pi, sigma=4.0)),
        ("theta", 70.0, dict(low=2 / np.pi, theta=np.radians(70))),
        ("rho", 20.0, dict(low=2 / np.pi, rho=20.0)),
    ],
)
def test_each_slider_designs_again(explorer, name, value, asked):
    explorer.sliders[name].value = value
    assert shows(explorer, design(**asked).K)


@pytest.mark.slow
def test_set_points_need_the_cosine(explorer):
    explorer.sliders["task"].value = STEPS
    assert "<strong>infeasible</strong>" in explorer.picture.value
    assert "factors from 0.000 to 1" in explorer.picture.value
    assert "Relax the" in explorer.picture.value
    assert "url(#sos-hatch)" in explorer.picture.value
    explorer.sliders["rho"].value = 20.0
    assert shows(explorer, design(float(np.cos(np.pi / 2)), rho=20.0).K)


def test_the_peak_torque_is_that_of_the_nonlinear_arm(explorer):
    top = np.pi / 2
    answer = simulate_nonlinear(
        sos.thesis.arm(0.0),
        arm_gravity,
        design(2 / np.pi).K,
        np.linspace(0, 3, 241),
        [[0, 1]],
        x0=[top, top, 0, 0, 0],
    )
    peak = np.abs(answer.u).max()
    assert f"peak torque {peak:.3g} Nm" in explorer.picture.value
    assert "BEYOND" not in explorer.picture.value


def test_an_overshoot_out_of_the_range_is_said(explorer):
    explorer.sliders["rho"].value = 20.0
    explorer.sliders["task"].value = STEPS
    assert "BEYOND phi_max" in explorer.picture.value


def test_an_empty_region_is_explained(explorer):
    explorer.sliders["rho"].value = 10.0
    explorer.sliders["sigma"].value = 10.0
    assert "the region is empty" in explorer.picture.value


@pytest.mark.slow
def test_the_way_back_shows_the_first_picture_again(explorer):
    before = explorer.picture.value
    explorer.sliders["phi_max"].value = 45.0
    explorer.sliders["task"].value = STEPS
    explorer.sliders["task"].value = REST
    explorer.sliders["phi_max"].value = 90.0
    assert explorer.picture.value == before
