"""The log of a robot that steers: its heading, and how it turns."""

from dataclasses import replace

import numpy as np
import pytest

from sosbook.pendulum.comparison import compare, heading_bounds
from sosbook.pendulum.drive import Drive
from sosbook.pendulum.modelled import Model
from sosbook.pendulum.steering import Steering
from sosbook.pendulum.ticks import START, STEER_COLUMNS, TickLog
from tests.cases import campaign
from tests.six_robots import advance
from tests.test_mip_compare import first
from tests.test_mip_steering import FIRMWARE, MACHINE, MIP, ROBOT, STEERING
from tests.turning import TURNER, ramp

MODEL = Model(
    MIP, ROBOT.but(delay=0.005, jitter=0.0005), 0.04, FIRMWARE.law, STEERING.K
)
LATE, BATTERY = 0.003, 7.8


def run(turner=TURNER, speed=4.0, turn=1.5, seconds=16.0, seed=1, steering=None):
    """What a program that steers logs; it rolls to and fro and turns."""
    random, T = np.random.default_rng(seed), turner.machine.T
    steering = steering or MODEL.steering
    controller, steered = MODEL.firmware.controller(), steering.controller()
    x, volts, now, bias = np.zeros(6), np.zeros(2), 0.0, 0.008
    x[0] = 0.03
    one, per = 2 * np.pi / turner.machine.counts, steering.per_radian
    controller.start(0.03, 0.0, bias)
    steered.start(0.0, 0.0)
    rows = [[-T, bias, 0, 0.03, 0, 0, 0, 0.03, BATTERY, START, 0, 0, 0, 0, 0]]
    rolls, turns, point, heading = Drive(speed, 6.0), Drive(turn, 6.0), (0, 0), (0, 0)
    for k in range(round(seconds / T)):
        at = k * T + 0.0003 * random.random()
        x = advance(turner.rate, x, volts, max(at - now, 1e-9), 3)
        left, right = one * np.floor(turner.wheels(x[:3]) / one)
        gyro = x[3] + bias + 0.002 * random.standard_normal()
        tilt = x[0] + 0.01 * random.standard_normal()
        point = ramp(rolls, speed if at % 4 > 2 else -speed, T, 1, point)[-1]
        heading = ramp(turns, turn if at % 3 > 1.5 else -turn, T, 1, heading)[-1]
        V = controller.step(gyro, (left + right) / 2, tilt, *point)
        motors = steered.step(
            V, controller.fault, left, right, per * heading[0], per * heading[1]
        )
        fault, theta = int(controller.fault[0]), float(controller.theta[0])
        motors = [float(m[0]) for m in motors]
        rows.append([at, gyro, (left + right) / 2, tilt, *point, float(V[0]), theta])
        rows[-1] += [BATTERY, fault, left, right, *motors, heading[0]]
        now = at + LATE
        x, volts = advance(turner.rate, x, volts, LATE, 2), np.array(motors)
    return TickLog(*np.array(rows).T)


@pytest.fixture(scope="module")
def same():
    return compare(run(), MODEL)


def truth(turner):
    """a_d / e and f / e of a machine."""
    m, per = turner.machine, turner.machine.r / turner.track
    wheels = 2 * m.M_w * m.r**2 + 2 * m.I_w + m.J
    return (4 * per**2 * turner.upright + wheels) / m.e, m.f / m.e


@pytest.mark.slow
def test_the_same_robot_turns_as_the_model_does(same):
    assert same.heading_within is True and same.within is True, same.report
    for name, value in zip(("inertia", "damping"), truth(TURNER)):
        assert same.turning.values[name] == pytest.approx(value, rel=0.03)
        low, high = heading_bounds(same.model)[name]
        assert low < value < high
    for name in ("stronger", "braking", "friction"):
        assert abs(same.turning.values[name]) < 0.02
    assert [str(f) for f in same.findings] == []
    assert "degrees from its set point" in same.report


@pytest.mark.slow
def test_unequal_motors_are_found_and_allowed():
    more, brake = 0.06, -0.04
    found = compare(run(replace(TURNER, more=more, brake=brake)), MODEL)
    assert found.turning.values["stronger"] == pytest.approx(more, abs=0.015)
    assert found.turning.values["braking"] == pytest.approx(brake, abs=0.015)
    assert found.heading_within is True, found.report


@pytest.mark.slow
@pytest.mark.parametrize("change", [dict(upright=6e-4), *campaign([dict(more=0.2)])])
def test_motors_that_differ_too_much_and_a_wide_body_are_outside(change):
    found = compare(run(replace(TURNER, **change)), MODEL)
    assert found.heading_within is False and found.within is False, found.report
    assert "outside of what was proven" in found.report


@pytest.mark.slow
def test_gears_that_rub_are_found_in_the_turn_too():
    rubs = replace(TURNER, machine=replace(MACHINE, friction=0.3))
    found = compare(run(rubs), MODEL)
    assert found.turning.values["friction"] == pytest.approx(0.3, rel=0.2)
    assert found.turning.values["inertia"] == pytest.approx(truth(TURNER)[0], rel=0.08)


@pytest.mark.slow
def test_a_robot_that_goes_straight_leaves_its_turning_open():
    found = compare(run(turn=0.0, seconds=12.0), MODEL)
    assert found.balance_within is True and found.within is None
    assert "let it turn left and right" in found.report


@pytest.mark.slow
def test_another_steering_law_is_named(same):
    log = first(same.log)
    other = Steering(FIRMWARE, 1.02 * STEERING.K, 0.25, 0.07, 0.034)
    wrong = compare(run(seconds=4.0, steering=other), MODEL)
    assert "its motors' volts differ" in wrong.report
    plain = replace(log, **dict.fromkeys(STEER_COLUMNS))
    assert "lacks the columns" in compare(plain, MODEL).report
    without = replace(MODEL, K_steering=None)
    assert "has the columns" in compare(log, without).report


@pytest.mark.slow
def test_the_page_and_the_file_have_the_heading(same, tmp_path):
    same.log.write(tmp_path / "log.csv")
    again = TickLog.read(tmp_path / "log.csv")
    assert again.steers and np.allclose(again.turned, same.log.turned)
    assert same.page.count("<svg") == 7
    assert "heading beyond its set point" in same.page
    (tmp_path / "model_balance.json").write_text(MODEL.text, "utf-8")
    read = Model.read(tmp_path)
    assert np.array_equal(read.K_steering, MODEL.K_steering)
    assert read.text == MODEL.text


@pytest.mark.slow
def test_half_of_steerings_columns_are_refused(same):
    with pytest.raises(ValueError, match="a log of steering lacks heading"):
        replace(same.log, heading=None)
