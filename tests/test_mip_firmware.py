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


def test_the_wheels_angle_is_absolute_and_starts_at_zero():
    controller = Firmware(SampledLaw.of_gain(named([[0, 1, 0, 0]]), T)).controller()
    controller.start(tilt=0.2, wheels=30.0)
    assert controller.step(0.0, 30.0) == 0  # where it stands is zero
    turned = controller.step(2.0, 30.05)  # the body turns the wheels along
    assert np.isclose(turned, 0.05 + T / 2 * 2.0)
    assert np.isclose(
        controller.step(2.0, 30.05, target=0.5), 0.05 + 3 * T / 2 * 2.0 - 0.5
    )


def test_the_wheels_rate_is_the_difference_of_absolute_angles():
    controller = Firmware(SampledLaw.of_gain(named([[0, 0, 0, 1]]), T)).controller()
    controller.start(0.0)
    assert np.isclose(controller.step(1.0, 0.02), 0.02 / T + 0.5)
    assert np.isclose(controller.step(1.0, 0.05, rate=0.25), 0.03 / T + 1.0 - 0.25)


def test_the_bias_is_taken_off():
    controller = Firmware(SampledLaw.of_gain(named([[0, 0, 1, 0]]), T)).controller()
    controller.start(0.0, bias=0.3)
    assert np.isclose(controller.step(0.5, 0.0), 0.2)


def test_the_accelerometers_tilt_is_blended_in():
    controller = started(0.0, blend=0.1)
    for _ in range(100):
        controller.step(0.0, 0.0, tilt=0.02)
    assert np.isclose(controller.theta[0], 0.02 * (1 - 0.9**100))
    before = controller.theta[0]
    controller.step(0.0, 0.0, tilt=NAN)  # none at this tick: no fault
    controller.step(0.0, 0.0, tilt=9.0)  # nonsense: as if there were none
    assert controller.theta[0] == before and why(controller) == ["running"]


def test_the_voltage_is_limited():
    assert started(0.84).step(0.0, 0.0) == 7.4
    assert started(-0.84, limit=5.0).step(0.0, 0.0) == -5.0


def test_the_integral_stops_winding_up():
    wound = started(
        0.0, law=SampledLaw.of_gain(named(K), T, tracking_time=1e9), stall=999
    )
    held = started(0.0, stall=999)
    for controller in (wound, held):
        for _ in range(300):
            controller.step(0.0, 0.0, target=-40.0)
    assert wound.x[0][0] > 100
    assert abs(K[0][4] * held.x[0][0]) < 20


@pytest.mark.parametrize(
    "gyro, wheels",
    [(NAN, 0.0), (0.0, NAN), (np.inf, 0.0), (0.0, -np.inf), (500.0, 0.0), (0.0, 77.0)],
)
def test_bad_readings_are_bridged_and_then_stop_the_motors(gyro, wheels):
    controller = started(0.1, missing=3)
    good = controller.step(0.0, 0.0)
    for _ in range(3):
        assert controller.step(gyro, wheels) == pytest.approx(good, abs=0.01)
    assert why(controller) == ["running"]
    assert controller.step(gyro, wheels) == 0
    assert why(controller) == ["sensor"]
    assert controller.step(0.0, 0.0) == 0  # until it's started again
    controller.start(0.1)
    assert controller.step(0.0, 0.0) == good


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


def test_after_a_gap_the_wheels_may_have_turned_further():
    one = 100.0 * T  # rad in a tick at the fastest rate
    controller = started(missing=5)
    controller.step(0.0, NAN)
    controller.step(0.0, 1.5 * one)
    assert controller.lost[0] == 0
    controller.step(0.0, 3.0 * one)
    assert controller.lost[0] == 1


def test_a_gyro_that_repeats_itself_is_dead():
    noise = np.random.default_rng(5).normal(0, 0.01, 100)
    living, dead = started(0.0, frozen=10), started(0.0, frozen=10)
    for k, gyro in enumerate(noise):
        living.step(gyro, 0.0)
        dead.step(noise[min(k, 49)], 0.0)
        assert (k > 59) == (why(dead) == ["sensor"])
    assert why(living) == ["running"]
    trusting = started(0.0)
    for _ in range(500):
        trusting.step(0.0, 0.0)
    assert why(trusting) == ["running"]


@pytest.mark.parametrize(
    "steps, reason",
    [([(50.0, 0.0)] * 4, "fall"), ([(30.0, 0.0), (-30.0, 0.0)] * 30, "stall")],
)
def test_falls_and_stalls_stop_the_motors(steps, reason):
    controller = started(0.0)
    for gyro, wheels in steps:
        V = controller.step(gyro, wheels)
    assert V == 0 and why(controller) == [reason]


def test_a_command_that_is_no_number_stops_the_motors():
    for target in (NAN, np.inf, 1e9):
        controller = started(0.1)
        assert controller.step(0.0, 0.0, target=target) == 0
        assert why(controller) == ["command"]


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


def test_single_precision_stays_single():
    controller = started(0.1, kind=np.float32)
    V = controller.step(0.1, 0.01)
    assert V.dtype == controller.theta.dtype == np.float32
    assert abs(V[0] - started(0.1).step(0.1, 0.01)[0]) < 1e-4


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
