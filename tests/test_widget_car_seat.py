"""The mass range moves, the design follows."""

import numpy as np
import pytest
from sosbook.widgets.car_seat import explore_mass_range

import sosbook as sos


@pytest.fixture
def explorer():
    return explore_mass_range()


def designed(low=70, high=120, sigma=0.9, theta=60, rho=15, gamma=0.1732, u_max=4e4):
    seats = sos.Polytope([sos.thesis.car_seat(m) for m in (low, high)])
    x0 = sos.thesis.example_2().saturation.x0
    return sos.design_pid(
        seats,
        np.eye(2),
        region=sos.PoleRegion(sigma, np.radians(theta), rho),
        gamma=gamma,
        saturation=sos.Saturation(u_max, x0),
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, value",
    [("low", 50), ("high", 200), ("sigma", 0.5), ("theta", 70), ("rho", 20)],
)
def test_each_slider_shows_the_gains_of_a_new_design(explorer, name, value):
    before = explorer.picture.value
    explorer.sliders[name].value = value
    after = explorer.picture.value
    assert after != before
    assert "<strong>feasible</strong>" in after
    for gain in designed(**{name: value}).K.ravel():
        assert f">{gain:.4g}<" in after


@pytest.mark.parametrize("name, value", [("gamma", 0.5), ("u_max", 2e4)])
def test_the_bounds_move_the_gains(explorer, name, value):
    explorer.sliders[name].value = value
    taken = explorer.sliders[name].value  # on the slider's own grid
    for gain in designed(**{name: taken}).K.ravel():
        assert f">{gain:.4g}<" in explorer.picture.value


def test_the_range_is_named_and_both_ends_are_drawn(explorer):
    explorer.sliders["high"].value = 200
    page = explorer.picture.value
    assert "One controller for 70 to 200 kg" in page
    assert ">70 kg<" in page and ">200 kg<" in page
    assert page.count("<circle") == 6  # poles of the lightest
    assert page.count("l8 8m0-8l-8 8") == 6  # and of the heaviest
    assert page.count("<polyline") == 6 + 3


@pytest.mark.slow
def test_an_impossible_wish_is_refused_with_advice(explorer):
    explorer.sliders["sigma"].value = 4
    explorer.sliders["rho"].value = 4.5
    explorer.sliders["u_max"].value = 400
    page = explorer.picture.value
    assert "<strong>infeasible</strong>" in page
    assert "elax" in page
    assert "K_P" not in page


def test_an_empty_region_is_explained(explorer):
    explorer.sliders["sigma"].value = 4
    explorer.sliders["rho"].value = 3
    assert "the region is empty" in explorer.picture.value
