"""The explorer of linear-quadratic designs, against the Riccati equation."""

import re

import control
import numpy as np
import pytest
from sosbook.mip import Mip, polytope
from sosbook.widgets.lqr import SLACK, SLACK_EPSILON, explore_lqr

import sosbook as sos


@pytest.fixture
def explorer():
    return explore_lqr()


def robust(spread=4.0, R=1.0, theta=1.0, phi=1.0, **more):
    plants = polytope(Mip.printed(), spread / 100)
    return sos.design_lqr(plants, np.diag([theta, phi, 1, 1]), [[R]], **more)


def middle(R=1.0, theta=1.0, phi=1.0):
    """The gain of the pendulum in the middle, by python-control."""
    plant = Mip.printed().plant()
    A = np.block(
        [
            [np.zeros((2, 2)), np.eye(2)],
            [-np.linalg.solve(plant.M, plant.S), -np.linalg.solve(plant.M, plant.D)],
        ]
    )
    B = np.r_[np.zeros((2, 1)), np.linalg.solve(plant.M, plant.B)]
    K, _, _ = control.lqr(A, B, np.diag([theta, phi, 1, 1]), [[R]])
    return -K


def rows(explorer):
    """The gains shown, one row for each design."""
    table = re.search("<table class='gains'>(.*)</table>", explorer.picture.value)[1]
    found = [re.findall(r">([-\d.e+]+)</td>", row) for row in table.split("<tr>")]
    return [row for row in found if row]


def as_shown(*gains):
    return [[f"{k:.4g}" for k in K.ravel()] for K in gains]


def test_it_starts_with_the_printed_spread(explorer):
    design = robust()
    assert rows(explorer) == as_shown(middle(), design.K)
    shown = explorer.picture.value
    assert f"<strong>{design.request.cost.bound:.4g}</strong>" in shown
    worst = design.noise_cost(samples=30)
    assert f"robust: true worst cost {worst:.4g}" in shown
    assert worst < design.request.cost.bound


@pytest.mark.slow
@pytest.mark.parametrize(
    "slider, value, name",
    [("R", 10.0, "R"), ("q_theta", 10.0, "theta"), ("q_phi", 0.1, "phi")],
)
def test_each_weight_designs_again(explorer, slider, value, name):
    explorer.sliders[slider].value = value
    asked = {name: value}
    assert rows(explorer) == as_shown(middle(**asked), robust(**asked).K)


@pytest.mark.slow
def test_the_spread_and_the_coupling_design_again(explorer):
    explorer.sliders["spread"].value = 40.0
    assert rows(explorer)[1:] == as_shown(robust(40.0).K)
    explorer.sliders["coupling"].value = SLACK
    slack = robust(40.0, coupling=SLACK, slack=SLACK_EPSILON)
    assert rows(explorer)[1:] == as_shown(slack.K)


def test_without_spread_both_gains_are_the_riccati_gain(explorer):
    explorer.sliders["spread"].value = 0.0
    first, second = rows(explorer)
    assert first == second == as_shown(middle())[0]


def test_half_the_gain_is_the_end_of_an_expensive_design(explorer):
    """A Riccati gain of little effort has the gain margin 1/2, no more."""
    K = middle(R=100.0)
    for spread, stable in ((45.0, True), (60.0, False)):
        plants = polytope(Mip.printed(), spread / 100)
        poles = sos.analyse_pid(plants, K, coupling="vertices").poles()
        assert (poles.real.max() < 0) == stable
    explorer.sliders["R"].value = 100.0
    explorer.sliders["spread"].value = 60.0
    assert "LQR of the middle: UNSTABLE" in explorer.picture.value
    assert "Certified for all plants" in explorer.picture.value


def test_the_way_back_shows_the_first_picture_again(explorer):
    before = explorer.picture.value
    explorer.sliders["R"].value = 2.0
    explorer.sliders["R"].value = 1.0
    assert explorer.picture.value == before


def test_the_poles_of_both_designs_at_all_vertices_are_drawn(explorer):
    poles, cost = re.findall(
        "<svg role='img'.*?</svg>.*?</svg>", explorer.picture.value
    )
    assert poles.count("<circle") == poles.count("<path d='M") == 16
    assert cost.count("<circle") == cost.count("<path d='M") == 34
