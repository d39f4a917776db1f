"""The explorer of the robot, against the linear loop and the formulas."""

import re

import numpy as np
import pytest
from sosbook.mip import V_MAX, Mip, SampledLaw, polytope, vertices
from sosbook.mip.margins import SampledLoop
from sosbook.mip.sensors import Sensors
from sosbook.widgets.robot import PD, PID, SINGLE, explore_robot

import sosbook as sos
from tests.gains import named

PRINT = sos.thesis.mip()


@pytest.fixture(scope="module")
def start():
    return explore_robot()


@pytest.fixture
def explorer(start):
    """One explorer for all; each test finds it as it was at first."""
    before = {name: s.value for name, s in start.sliders.items()}
    yield start
    move(start, **before)


def move(explorer, **values):
    for name, value in values.items():
        explorer.sliders[name].value = value
    return explorer.picture.value


def shows(page, K):
    return all(f">{k:.4g}<" in page for k in np.ravel(K))


def said(page, words):
    """The number that stands behind the words."""
    return float(re.search(words + r" (-?[\d.]+)", page)[1])


def test_it_starts_with_the_robust_design_and_stands(explorer):
    K = sos.design_lqr(polytope(Mip.printed()), np.eye(5), [[20]], [[0, 1]]).K
    page = explorer.picture.value
    assert shows(page, K)
    assert "<strong>stand</strong>" in page
    assert said(page, "Peak voltage") == pytest.approx(
        K[0, 0] * np.radians(10), abs=0.2
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "law, R, table", [(PD, 1.0, PRINT.pd), (PID, 1.0, PRINT.pid), (PID, 5.0, PRINT.pid)]
)
def test_it_chatters_where_the_sampled_loop_is_unstable(explorer, law, R, table):
    """The tables' gains; the radius is that of the linear loop."""
    for delay in (0.0, 5.0, 10.0):
        page = move(explorer, law=law, design=SINGLE, R=R, delay=delay)
        value = explorer.sliders["R"].value
        K = sos.design_lqr(
            vertices(Mip.printed())[0 if law == PD else 3].plant(),
            np.eye(table[1].size),
            [[value]],
            [[0, 1]] if law == PID else None,
        ).K
        assert shows(page, K)
        assert np.allclose(K, table[int(R)], rtol=0.03)
        radius = max(
            SampledLoop(
                robot, SampledLaw.of_gain(named(K), 0.01), delay / 1000, "firmware"
            ).radius
            for robot in vertices(Mip.printed())
        )
        assert ("chatters" in page) == (radius > 1)


def test_too_steep_a_start_is_a_fall(explorer):
    assert "FALLS at 4 of 4" in move(explorer, tilt=70.0)
    assert said(explorer.picture.value, "Peak voltage") == V_MAX


@pytest.mark.slow
def test_noise_and_an_offset_are_seen(explorer):
    """V has at least what the rate's gain makes of the gyro's noise; the
    PD drives away with (1 + K_theta / K_phi) times the offset."""
    quiet = said(move(explorer, noise=0.0, tilt=0.0), "at rest")
    loud = said(move(explorer, noise=20.0), "at rest")
    K = sos.design_lqr(polytope(Mip.printed()), np.eye(5), [[20]], [[0, 1]]).K[0]
    assert loud > 1.2 * quiet and loud > K[2] * 20 * Sensors.noise
    near = said(move(explorer, noise=0.0, law=PD), "wheels turn")
    far = said(move(explorer, offset=1.0), "wheels turn")
    K = sos.design_lqr(
        polytope(Mip.printed()), np.eye(4), [[explorer.sliders["R"].value]]
    ).K[0]
    speed = 1 + K[0] / K[1]  # degrees/s; it takes a second to get there
    assert near < 3 and speed / 2 < far < 2 * speed


@pytest.mark.slow
def test_it_returns_to_where_it_was(explorer):
    before = explorer.picture.value
    assert move(explorer, tilt=30.0, delay=20.0) != before
    assert move(explorer, tilt=10.0, delay=5.0) == before
