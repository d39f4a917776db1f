"""The simulated rig: its motion, its sensors, its logs and their files."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.signal
from scipy.integrate import solve_ivp

from sosbook.pendulum import Mip, Robot
from sosbook.pendulum import rig as rigs
from sosbook.pendulum.experiments import chirp, motion
from sosbook.pendulum.log import Log
from sosbook.pendulum.rig import (
    COUNTS_PER_TURN,
    DATA,
    GYRO_STEP,
    Rig,
    gear_motors,
    shipped,
)
from tests.six_robots import SIX

T = 0.01


def held(acceleration, start, V):
    """scipy's solution of q'' = acceleration(q, q', V), V held."""
    x, path = np.array(start, dtype=float), []
    for volt in V:
        path.append(x)
        how = dict(method="DOP853", rtol=1e-11, atol=1e-12)
        x = solve_ivp(lambda _, x: [x[1], acceleration(*x, volt)], (0, T), x, **how)
        x = x.y[:, -1]
    return np.array(path).T


@pytest.fixture(scope="module")
def ideal():
    rig = Rig(ideal=True)
    return rig, rig.body(), rig.wheels()


def test_the_body_swings_as_the_nonlinear_model_under_held_wheels(ideal):
    """Wheels too heavy to move hold the body; it hangs at theta = pi."""
    rig, log, _ = ideal
    heavy = replace(rig.mip, a=1e9)
    V = log.V[:150]
    theta, rate = held(
        lambda q, w, V: heavy.acceleration([q, 0], [w, 0], V)[0], [np.pi, 0], V
    )
    assert abs(rate).max() > 5  # far beyond small angles
    assert np.allclose(log.gyro[:150], rate, atol=1e-6)


def test_the_wheels_turn_as_the_nonlinear_model_with_a_body_at_rest(ideal):
    """A body too heavy to move, without weight on its wheels."""
    rig, _, log = ideal
    still = replace(rig.mip, a=2 * rig.mip.I_w, b=0, c=1e9, d=0)
    phi, _ = held(
        lambda q, w, V: still.acceleration([0, q], [0, w], V)[1], [0, 0], log.V[:100]
    )
    turns = log.encoder1[:100] / COUNTS_PER_TURN
    assert abs(turns).max() > 0.1
    assert np.allclose(2 * np.pi * turns, phi, atol=1e-6)


def test_friction_is_a_voltage_that_is_lost():
    """Against scipy; and under it a steady voltage ends slower."""
    V = np.repeat([3.0, -2.0], 50)
    _, w = motion(50.0, 10.0, 0.0, V, T, friction=0.5, steps=20)
    _, free = held(
        lambda q, w, V: 50 * (V - 0.5 * np.tanh(w / 0.5)) - 10 * w, [0, 0], V
    )
    assert np.allclose(w, free, atol=1e-5)
    q, w = motion(50.0, 10.0, 0.0, np.full(300, 2.0), T, friction=0.5)
    assert w[-1] == pytest.approx(50 * (2 - 0.5) / 10)


@pytest.mark.parametrize("first, last", [(1, 20), (0.3, 30)])
def test_chirps_are_those_of_the_text(first, last):
    """A quarter of 7.4 V; there in 30 s as scipy's chirp, and back."""
    t, V = chirp(first, last)
    there = t <= 30
    same = scipy.signal.chirp(t[there], first, 30, last, phi=-90)
    assert np.allclose(V[there], 0.25 * 7.4 * same, atol=5.1e-4)
    back = scipy.signal.chirp(60 - t[~there], first, 30, last, phi=-90)
    turns = (first + last) * 30  # a whole number: the way back mirrors
    assert turns == round(turns)
    assert np.allclose(V[~there], -0.25 * 7.4 * back, atol=5.1e-4)
    assert t[1] == T and len(t) == 6000


def test_the_shipped_logs_are_made_again_byte_for_byte(tmp_path):
    rigs.main(tmp_path)
    for name in ("body.csv", "wheels.csv"):
        made = (tmp_path / name).read_bytes()
        assert made == (DATA / name).read_bytes()
        assert len(made) < 150_000


def test_sensors_say_the_truth_up_to_noise_and_steps(ideal):
    _, body, wheels = ideal
    log = shipped("body")
    error = log.gyro - body.gyro
    assert np.rad2deg(error.mean()) == pytest.approx(0.5, abs=0.01)
    step = 2000 / 2**15
    assert np.rad2deg(error.std()) == pytest.approx(
        np.hypot(0.1, step / 12**0.5), rel=0.05
    )
    gyro = Rig().body().gyro
    assert (Rig(seed=3).body().gyro != gyro).any()
    steps = gyro / GYRO_STEP
    assert np.allclose(steps, steps.round(), atol=1e-9)
    log = shipped("wheels")
    for name in ("encoder1", "encoder2"):
        count = getattr(log, name)
        assert (count == count.round()).all()
        error = count - getattr(wheels, name)
        assert error.min() > -1 and error.max() < 1
        assert error.std() == pytest.approx(1 / 12**0.5, rel=0.05)


@pytest.mark.parametrize(
    "bad, message",
    [
        (dict(mip=replace(Mip.printed(), I_w=None)), "mip has no I_w"),
        (dict(noise=-1), "noise can't be negative"),
        (dict(friction=float("nan")), "friction can't be negative"),
        (dict(amplitude=0), "amplitude must be positive"),
        *(({x: 0.0}, x) for x in ("rate", "seconds", "counts", "gyro_step")),
    ],
)
def test_bad_rigs(bad, message):
    with pytest.raises(ValueError, match=message):
        Rig(**bad)


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "first row must name t, V"),
        ("0,0,0\n0.01,1,1\n", "first row must name t, V"),
        ("t,gyro\n0,1\n", "first row must name t, V"),
        ("t,V,speed\n0,0,0\n", "first row must name t, V.*speed"),
        ("t,V,V\n0,0,0\n", "each once"),
        ("t,V,gyro\n0,0,0\n0.01,,0\n", "line 3 lacks a value"),
        ("t,V,gyro\n0,0,0\n0.01,1\n", "line 3 lacks a value"),
        ("t,V\n0,zero\n", "line 2: 'zero' is no number"),
        ("t,V\n0,0\n0.01,nan\n0.02,0\n", "V isn't finite at row 2"),
        ("t,V\n", "t has 0 samples"),
        ("t,V\n0,0\n0.01,0\n0.01,0\n", "t must increase.* row 2"),
        ("t,V\n0,0\n.01,0\n.02,0\n.05,0\n.06,0\n", "2 samples missing .*0.02"),
        ("t,V\n0,0\n.01,0\n.02,0\n.038,0\n.048,0\n", "1 sample missing .*0.02"),
    ],
)
def test_bad_files(tmp_path, text, message):
    path = tmp_path / "log.csv"
    path.write_text(text, "utf-8")
    with pytest.raises(ValueError, match=message):
        Log.read(path)


def test_bad_columns():
    with pytest.raises(ValueError, match="V has 2 samples, t has 3"):
        Log([0, 1, 2], [0, 1])
    with pytest.raises(ValueError, match="gyro must be a list"):
        Log([0, 1, 2], [0, 1, 2], gyro=[[0], [1], [2]])
    with pytest.raises(ValueError, match="V must be real numbers: "):
        Log([0, 1, 2], [0, 1, 1j])
    with pytest.raises(ValueError, match="no column encoder1"):
        shipped("body").need("encoder1")


@pytest.fixture(scope="module")
def machine():
    """The second robot in equations that share nothing with the package."""
    (known,) = (m for m in SIX if m.name == "gear motors 200 Hz")
    robot = Robot.shipped("gearmotors")
    assert (known.T, known.counts, known.V_n) == (robot.T, robot.counts, robot.limit)
    return replace(known, M_b=robot.M_b)


def test_the_second_robot_moves_as_its_parts_do(machine):
    mip, random = gear_motors(), np.random.default_rng(0)
    assert mip.I_w == pytest.approx(machine.I_w + machine.J / 2)
    for _ in range(20):
        x, V = random.uniform(-1, 1, 4) * [1, 9, 5, 20], random.uniform(-12, 12)
        ours = mip.acceleration(x[:2], x[2:], V)
        assert np.allclose(ours, machine.rate(x, V)[2:], rtol=1e-9)
