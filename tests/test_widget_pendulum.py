"""The explorer of the falling pendulum, against scipy's integrator."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from sosbook.mip import Mip
from sosbook.widgets.pendulum import FULL, explore_fall, falls

ROTORS = Mip.from_ratios(30.52, 7.133, 110.6, 208.8, rotors=True)


def exact(mip, angle, volts, pulse, t):
    def rates(s, x):
        return [*x[2:], *mip.acceleration(x[:2], x[2:], volts)]

    def free(s, x):
        return [*x[2:], *mip.acceleration(x[:2], x[2:], 0.0)]

    how = dict(method="DOP853", rtol=1e-10, atol=1e-12)
    push = solve_ivp(rates, (0, pulse), [angle, 0, 0, 0], **how).y[:, -1]
    return solve_ivp(free, (pulse, t), push, **how).y[:, -1]


@pytest.mark.parametrize("mip", [Mip.printed(), ROTORS])
def test_the_nonlinear_fall(mip):
    V = np.where(np.arange(160) < 40, -3.0, 0.0)
    true, _ = falls(mip, 0.4, V, 0.005)
    assert np.allclose(true[:, -1], exact(mip, 0.4, -3.0, 0.2, 0.8), rtol=1e-4)


@pytest.mark.parametrize("mip", [Mip.printed(), ROTORS])
def test_the_linear_fall(mip):
    """It is the limit of small nonlinear ones, scaled."""
    V = np.where(np.arange(80) < 20, 1.0, 0.0)
    _, line = falls(mip, 0.3, V, 0.005)
    small, _ = falls(mip, 0.3e-5, 1e-5 * V, 0.005)
    assert np.allclose(line, 1e5 * small, rtol=1e-3, atol=1e-3)


def seconds(explorer):
    return float(re.search(r"apart at ([\d.]+) s", explorer.picture.value)[1])


def test_a_steeper_start_parts_the_models_sooner():
    explorer = explore_fall()
    ten = seconds(explorer)
    explorer.sliders["angle"].value = 45
    assert 0 < seconds(explorer) < ten


def test_upright_without_voltage_nothing_happens():
    explorer = explore_fall()
    explorer.sliders["angle"].value = 0
    assert "stay within" in explorer.picture.value
    assert explorer.picture.value.count("<svg role='img'") == 2


def test_the_rotors_change_the_picture():
    explorer = explore_fall()
    before = explorer.picture.value
    explorer.sliders["rotors"].value = FULL
    assert explorer.picture.value != before
    low, high = (
        falls(m, 0.2, np.zeros(60), 0.005)[0][0, -1] for m in (Mip.printed(), ROTORS)
    )
    assert high > low  # the fall is a little faster
