"""The linear sampled loop: against the firmware itself, and closed forms."""

import control
import numpy as np
import pytest
from scipy.linalg import expm

from sosbook.book import thesis
from sosbook.pendulum import Firmware, Mip, SampledLaw
from sosbook.pendulum.margins import SENSING, SampledLoop, lowest_rate, sensing
from tests.gains import named

PRINTED = thesis.mip()
ROBOT = Mip.printed()
T = 0.01
RECOMMENDED = SampledLaw.of_gain(named([[15.78, 0.49, 1.42, 0.69, 0.22]]), T)


def one_tick(robot, T):
    """Exact [z; z'] to [z; z'] and V to [z; z'] of the linear plant."""
    p = robot.plant()
    A = np.zeros((5, 5))
    A[:2, 2:4] = np.eye(2)
    A[2:4, :2], A[2:4, 2:4] = (
        -np.linalg.solve(p.M, np.hstack([p.S, p.D])).reshape(2, 2, 2).transpose(1, 0, 2)
    )
    A[2:4, 4:] = np.linalg.solve(p.M, p.B)
    e = expm(A * T)
    return e[:4, :4], e[:4, 4]


def run(firmware, robot, tilt, ticks, late):
    """theta at each tick: the real Controller on the linear plant."""
    forward, push = one_tick(robot, T)
    controller, x = firmware.controller(), np.array([tilt, 0, 0, 0.0])
    controller.start(tilt)
    queue, found = [0.0] * late, []
    for _ in range(ticks):
        found.append(x[0])
        queue.append(controller.step(x[2], x[1] - x[0] + tilt, tilt=x[0])[0])
        x = forward @ x + push * queue.pop(0)
    return np.array(found)


@pytest.mark.parametrize("late", [0, 1, 2])
@pytest.mark.parametrize("blend", [0.0, 0.05])
def test_the_loop_is_that_of_the_real_firmware(late, blend):
    firmware = Firmware(RECOMMENDED, blend=blend, stall=999)
    loop = SampledLoop(ROBOT, RECOMMENDED, late * T, "firmware", blend)
    found = run(firmware, ROBOT, 1e-3, 200, late)
    # Cayley and Hamilton: any output obeys the characteristic polynomial
    law = np.poly(loop.matrix)
    n = len(law)
    rest = [law @ found[k : k + n][::-1] for k in range(5, 180)]
    assert np.abs(rest).max() < 1e-9 * np.abs(found).max()


def test_measured_exactly_it_is_the_textbook_loop():
    forward, push = one_tick(ROBOT, T)
    K = PRINTED.pd[5]
    direct = np.linalg.eigvals(forward + push[:, None] @ K)
    loop = SampledLoop(ROBOT, SampledLaw.of_gain(named(K), T))
    assert np.isclose(loop.radius, np.abs(direct).max(), rtol=1e-9)
    assert loop.constants == 0


def test_an_ideal_controller_of_rates_leaves_constants():
    pd, pid = (
        SampledLoop(ROBOT, SampledLaw.appendix_b(named(K), T))
        for K in (PRINTED.pd[5], PRINTED.pid[5])
    )
    assert (pd.constants, pid.constants) == (2, 1)
    assert pd.radius < 1 and pid.radius < 1


def test_the_sensitivity_agrees_with_python_control():
    loop = SampledLoop(ROBOT, RECOMMENDED, T, "firmware", 0.002)
    S = control.feedback(1, loop.open_loop, sign=1)
    peak = np.abs(S(np.exp(1j * np.linspace(1e-4, np.pi, 20001)))).max()
    assert np.isclose(loop.sensitivity, peak, rtol=1e-3)


def test_an_unstable_loop_has_no_margin():
    loop = SampledLoop(
        ROBOT, SampledLaw.of_gain(named(PRINTED.pid[1]), T), 0.0, "differenced"
    )
    assert loop.radius > 1 and loop.sensitivity == np.inf


def test_the_lowest_rate_is_where_stability_ends():
    K = PRINTED.pd[2]

    def law_of(T):
        return SampledLaw.of_gain(named(K), T)

    rates = np.linspace(200, 20, 91)
    found = lowest_rate([ROBOT], law_of, 1, "differenced", rates)
    radius = [
        SampledLoop(ROBOT, law_of(1 / f), 1 / f, "differenced").radius
        for f in (found, found - 2)
    ]
    assert radius[0] < 1 <= radius[1]
    assert lowest_rate([ROBOT], law_of, 1, "differenced", [20]) == np.inf


def test_sensors_at_rest_say_the_truth():
    for kind in SENSING:
        told = sensing(kind, T)
        steady = np.array([0.1, 0.3, 0, 0])
        x = np.zeros(told.nstates)
        if kind == "firmware":  # it starts with the right tilt
            x = np.array([0.1, 0, 0.3])
        for _ in range(3):
            y = told.C @ x + told.D @ steady
            x = told.A @ x + told.B @ steady
        wheels = 0.2 if kind == "raw" else 0.3
        assert np.allclose(y, [0.1, wheels, 0, 0])


def test_bad_input_is_named():
    with pytest.raises(ValueError, match="sensing"):
        sensing("guess", T)
    with pytest.raises(ValueError, match="delay"):
        SampledLoop(ROBOT, RECOMMENDED, -0.1)


def test_a_slow_growth_is_no_constant():
    law = SampledLaw.of_gain(named([[1e-9, 0, 0, 0]]), 1e-7)
    assert SampledLoop(ROBOT, law).radius > 1
