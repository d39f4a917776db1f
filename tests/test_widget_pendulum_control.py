"""The explorer of the pendulum's controllers, against other integrators."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from sosbook.mip import V_MAX, Mip, polytope, vertices
from sosbook.widgets.pendulum_control import (
    PID,
    ROBUST,
    explore_pendulum_control,
    recover,
)

import sosbook as sos
from sosbook.analysis.linear import loop_matrix
from sosbook.plants.descriptor import descriptors

PRINT = sos.thesis.mip()
ROBOTS = vertices(Mip.printed(), 0.2)
T = np.linspace(0, 1, 401)


@pytest.fixture(scope="module")
def explorer():
    return explore_pendulum_control()


def shows(explorer, K):
    return all(f">{k:.4g}<" in explorer.picture.value for k in K.ravel())


@pytest.mark.slow
@pytest.mark.parametrize("angle, limit", [(0.1, V_MAX), (0.5, 3.0)])
def test_the_recovery_is_that_of_an_adaptive_integrator(angle, limit):
    """With and without saturation, vertex by vertex."""
    K = PRINT.pid[5]
    x, V = recover(ROBOTS, K, angle, T, limit)
    for k, robot in enumerate(ROBOTS):

        def rate(now, s):
            volts = np.clip(K[0] @ s, -limit, limit)
            fall = robot.acceleration(s[:2], s[2:4], volts)
            return [*s[2:4], *fall, s[1]]

        true = solve_ivp(
            rate,
            (0, 1),
            [angle, 0, 0, 0, 0],
            "DOP853",
            T,
            rtol=1e-10,
            atol=1e-12,
            max_step=0.0025,
        ).y
        assert np.allclose(x[:, k], true, rtol=1e-3, atol=1e-3)
        assert np.allclose(V[k], np.clip(K[0] @ true, -limit, limit), atol=0.05)
    assert (abs(V) == limit).any() == (angle > 0.4)


def test_small_tilts_are_linear():
    robot, K = Mip.printed(), PRINT.pd[1]
    x, _ = recover([robot], K, 1e-4, T)
    (d,) = descriptors(robot.plant())
    line = expm(loop_matrix(d, K)) @ [1e-4, 0, 0, 0]
    assert np.allclose(x[:, 0, -1], line, atol=1e-9)


def test_it_starts_with_table_4_1(explorer):
    K = sos.design_lqr(vertices(Mip.printed())[0].plant(), np.eye(4), [[1]]).K
    assert shows(explorer, K)
    assert np.allclose(K, PRINT.pd[1], rtol=2e-4)
    assert "regulator of vertex 1" in explorer.picture.value
    assert "Peak voltage 3.35 V. " in explorer.picture.value


@pytest.mark.slow
@pytest.mark.parametrize("R", [1.0, 2.0])
def test_the_integral_and_the_robust_design(explorer, R):
    start = {n: s.value for n, s in explorer.sliders.items()}
    explorer.sliders["R"].value = R
    explorer.sliders["law"].value = PID
    explorer.sliders["design"].value = ROBUST
    found = sos.design_lqr(
        polytope(Mip.printed()), np.eye(5), [[explorer.sliders["R"].value]], [[0, 1]]
    )
    assert shows(explorer, found.K)
    assert f"{found.request.cost.bound:.4g}" in explorer.picture.value
    for name, value in start.items():
        explorer.sliders[name].value = value


def test_a_steep_start_is_said(explorer):
    before = explorer.picture.value
    explorer.sliders["tilt"].value = 13.0
    assert "the motors' LIMIT" in explorer.picture.value
    explorer.sliders["tilt"].value = 80.0
    assert "FALLS at 4 of 4 vertices" in explorer.picture.value
    explorer.sliders["tilt"].value = 5.0
    assert explorer.picture.value == before


@pytest.mark.slow
def test_a_large_spread_needs_the_robust_design(explorer):
    """Seventy percent: the regulator of vertex 4 loses a plant."""
    start = {n: s.value for n, s in explorer.sliders.items()}
    explorer.sliders["R"].value = 5.0
    explorer.sliders["law"].value = PID
    explorer.sliders["spread"].value = 70.0
    plants, U = polytope(Mip.printed(), 0.7), [[0, 1]]
    K = sos.design_lqr(plants.vertices[3], np.eye(5), [[5]], U).K
    right = sos.analyse_pid(plants, K, U, coupling="vertices").poles().real.max()
    assert right > 0
    assert f"Rightmost pole {right:.2f}" in explorer.picture.value
    explorer.sliders["design"].value = ROBUST
    assert "Certified for all plants" in explorer.picture.value
    assert "Rightmost pole -" in explorer.picture.value
    for name, value in start.items():
        explorer.sliders[name].value = value
