"""The firmware: what the motors get, whatever the sensors say."""

import numpy as np
import pytest
from sosbook.mip import FAULTS, Firmware, SampledLaw

from tests.gains import named

K = [[16.0, 0.5, 1.4, 0.7, 0.2]]
T = 0.01
LAW = SampledLaw.of_gain(named(K), T)
NAN = np.nan


def started(tilt=0.0, runs=1, kind=float, law=LAW, **asked):
    controller = Firmware(law, **asked).controller(runs, kind)
    controller.start(tilt)
    return controller


def why(controller):
    return [FAULTS[k] for k in controller.fault]


def test_the_estimate_is_the_trapezoid_of_the_gyro():
    t = np.arange(101) * T
    controller = started(0.1)
    for rate in -0.1 * np.sin(t):
        controller.step(rate, 0.0)
    assert abs(controller.theta[0] - 0.1 * np.cos(1.0)) < 1e-5


def test_a_good_reading_ends_the_count():
    controller = started(0.1, missing=1)
    for _ in range(5):
        controller.step(NAN, 0.0)
        controller.step(0.0, 0.0)
    assert why(controller) == ["running"]


def test_while_the_encoder_is_silent_the_wheels_roll_on():
    controller = Firmware(SampledLaw.of_gain(named([[0, 0, 0, 1]]), T)).controller()
    controller.start(0.0)
    rates = [controller.step(0.0, w)[0] for w in (0.02, 0.04, NAN, NAN, 0.10)]
    assert np.allclose(rates, 2.0)


@pytest.mark.parametrize("kind", [float, np.float32])
def test_robots_side_by_side_do_what_each_does_alone(kind):
    random = np.random.default_rng(3)
    gyro = random.normal(0, 2, (300, 7))
    wheels = np.cumsum(random.normal(0, 0.05, (300, 7)), 0)
    gyro[random.random((300, 7)) < 0.05] = NAN
    tilts = np.linspace(-0.3, 0.3, 7)
    fleet = started(tilts, 7, kind, missing=1)
    together = np.array([fleet.step(g, w) for g, w in zip(gyro, wheels)])
    for k, tilt in enumerate(tilts):
        one = started(tilt, 1, kind, missing=1)
        alone = [one.step(g, w)[0] for g, w in zip(gyro[:, k], wheels[:, k])]
        assert alone == together[:, k].tolist()
    assert len(set(fleet.fault)) > 1


@pytest.mark.parametrize(
    "asked, words",
    [
        (dict(limit=0), "limit"),
        (dict(tip=-1), "tip"),
        (dict(blend=1.5), "blend"),
        (dict(missing=-1), "missing"),
        (dict(stall=0.5), "stall"),
        (dict(frozen=-2), "frozen"),
        (dict(fastest=NAN), "fastest"),
    ],
)
def test_bad_settings_are_named(asked, words):
    with pytest.raises(ValueError, match=words):
        Firmware(LAW, **asked)
    with pytest.raises(ValueError, match="law"):
        Firmware(K)


def test_a_controller_that_is_not_started_says_so():
    with pytest.raises(ValueError, match="start"):
        Firmware(LAW).controller().step(0.0, 0.0)
