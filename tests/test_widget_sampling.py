"""The explorer of sampled loops, against integrators and closed forms."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from sosbook.mip import Mip, SampledLaw, vertices
from sosbook.mip.margins import SampledLoop
from sosbook.widgets.pendulum_control import PID, ROBUST
from sosbook.widgets.sampling import explore_sampling, kick

import sosbook as sos
from tests.gains import named

PRINT = sos.thesis.mip()
ROBOTS = vertices(Mip.printed())


@pytest.fixture(scope="module")
def explorer():
    return explore_sampling()


@pytest.fixture
def moved(explorer):
    """Sets sliders by name, and puts them back."""
    start = {name: s.value for name, s in explorer.sliders.items()}

    def move(**values):
        for name, value in values.items():
            explorer.sliders[name].value = value
        return explorer.picture.value

    yield move
    move(**start)


def simulated(robot, K, T, delay, differenced, rate, count):
    """Between ticks by an adaptive integrator; the computer by hand."""
    plant = robot.plant()
    M, x, sums, volts, old = plant.M, np.zeros(4), 0.0, [0.0, 0.0], 0.0
    x[2], seen = rate, []

    def fall(now, x, V):
        return [
            *x[2:],
            *np.linalg.solve(M, plant.B[:, 0] * V - plant.D @ x[2:] - plant.S @ x[:2]),
        ]

    for _ in range(count):
        seen.append(x)
        y, wheels = x.copy(), x[1] - x[0]
        if differenced:
            y[3] = (wheels - old) / T + x[2]
        old = wheels
        volts = [volts[-1], K[0, :4] @ y]
        if K.shape[1] == 5:
            volts[1] += K[0, 4] * sums
        sums += T * y[1]
        for V, span in zip(volts, (delay, T - delay)):
            if span > 0:
                x = solve_ivp(
                    fall, (0, span), x, "DOP853", args=(V,), rtol=1e-9, atol=1e-12
                ).y[:, -1]
    return np.array(seen).T


@pytest.mark.parametrize("sensing", ["exact", "differenced"])
@pytest.mark.parametrize("K, ticks", [(PRINT.pd[5], 0.0), (PRINT.pid[5], 0.5)])
def test_the_kick_is_that_of_an_adaptive_integrator(sensing, K, ticks):
    T, delay = 0.01, 0.01 * ticks
    loop = SampledLoop(ROBOTS[2], SampledLaw.of_gain(named(K), T), delay, sensing)
    true = simulated(ROBOTS[2], K, T, delay, sensing == "differenced", 0.5, 25)
    assert np.allclose(kick(loop, 0.5, 25), true, rtol=1e-6, atol=1e-7)


def test_the_kick_starts_with_the_plant_alone():
    """A tick late, nothing but the plant acts during the first one."""
    law = SampledLaw.of_gain(named(PRINT.pd[1]), 0.01)
    x = kick(SampledLoop(ROBOTS[0], law, 0.01, "firmware"), 1.0, 2)
    A, _, _ = sos.plants.descriptors(ROBOTS[0].plant())[0].state_space()
    assert np.allclose(x[:, 1], expm(0.01 * A) @ [0, 0, 1, 0])


def test_it_starts_with_table_4_1(explorer):
    K = PRINT.pd[5]
    cells = re.findall(r"text-align:right'>([-\d.]+)<", explorer.picture.value)
    assert np.allclose([float(c) for c in cells], K[0], rtol=1e-3)
    law = SampledLaw.of_gain(named(K), 0.01)
    radius = max(SampledLoop(r, law, sensing="firmware").radius for r in ROBOTS)
    shown = float(re.search(r"Radius ([\d.]+)", explorer.picture.value)[1])
    assert abs(shown - radius) < 2e-4
    assert "stable at all four vertices" in explorer.picture.value


@pytest.mark.slow
def test_one_tick_late_r_equal_to_one_is_lost(moved):
    """The printed regulators at 100 Hz, measured exactly."""
    said = moved(sensing="exact", R=1.0)
    assert "stable at all four vertices" in said
    assert "UNSTABLE" in moved(ticks=1.0)
    assert "stable at all four" in moved(R=5.0)


@pytest.mark.slow
def test_half_a_tick_heals_what_differencing_breaks(moved):
    said = moved(sensing="differenced", R=2.0)
    assert "UNSTABLE at 4 of 4 vertices" in said
    assert "stable at all four vertices" in moved(ticks=0.5)


@pytest.mark.slow
def test_the_peak_is_that_of_a_dense_sweep(moved):
    """The robust PID for R = 20, two ticks late."""
    said = moved(R=20.0, law=PID, design=ROBUST, ticks=2.0)
    shown = float(re.search(r"<strong>([\d.]+)</strong>: Nyq", said)[1])
    K = sos.design_lqr(sos.mip.polytope(Mip.printed()), np.eye(5), [[20]], [[0, 1]]).K
    law, peak = SampledLaw.of_gain(named(K), 0.01), 0.0
    for robot in ROBOTS:
        loop = SampledLoop(robot, law, 0.02, "firmware")
        L, eye = loop.open_loop, np.eye(loop.open_loop.nstates)
        z = np.exp(1j * np.linspace(0.01, np.pi, 1500))[:, None, None]
        value = L.C @ np.linalg.solve(z * eye - L.A, L.B[None])
        peak = max(peak, (1 / abs(1 - value)).max())
    assert abs(shown - peak) < 0.03 * peak
    assert shown < 2


def test_a_slow_clock_is_said(moved):
    assert "25 Hz. Radius" in moved(T=40.0)
    assert "UNSTABLE" in moved(sensing="differenced")
