"""The nonlinear loop of pendulums, sensors and a sampled controller."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from sosbook.book import thesis
from sosbook.pendulum import FAULTS, V_MAX, Firmware, Mip, SampledLaw, vertices
from sosbook.pendulum.fleet import Fleet, Push
from sosbook.pendulum.recovery import largest_tilt, recover
from sosbook.pendulum.rig import COUNTS_PER_TURN, GYRO_STEP
from sosbook.pendulum.sensors import Sensors
from sosbook.pendulum.simulator import Drivetrain, Run, simulate
from tests.cases import later
from tests.gains import named

T = 0.01
MIP = Mip.printed()
GAIN = thesis.mip().pd[5]
FIRMWARE = Firmware(SampledLaw.of_gain(named(GAIN), T))
IDEAL = Sensors(ideal=True)


class Source:
    """A controller that gives V and keeps what it's told."""

    def __init__(self, V=0.0):
        self.T, self.V, self.gyro, self.wheels, self.tilt = T, V, [], [], []
        self.target = []

    def start(self, tilt, wheels=0.0, bias=0.0):
        self.begin = tilt, wheels, bias

    def step(self, gyro, wheels, tilt, target, rate):
        self.gyro.append(gyro)
        self.wheels.append(wheels)
        self.tilt.append(tilt)
        self.target.append((target, rate))
        return np.full(np.shape(gyro), self.V)


def flow(mip, x, time, V=0.0, w=(0.0, 0.0)):
    """scipy's solution of the model, from its mass matrix."""

    def rate(_, x):
        both = mip.b * np.cos(x[0]) - mip.J
        mass = [[mip.c, both], [both, mip.a]]
        ddz = mip.acceleration(x[:2], x[2:], V) + np.linalg.solve(mass, w)
        return np.concatenate([x[2:], ddz])

    how = dict(method="DOP853", rtol=1e-12, atol=1e-13)
    return solve_ivp(rate, (0, time), x, **how).y[:, -1]


def test_a_robot_without_voltage_falls_as_scipy_says():
    start = [[1.0, -2.0], [0.5, -1.0], [-3.0, 2.0]]
    robots = [MIP, replace(MIP, J=1e-4)]
    how = dict(sensors=IDEAL, start=start, substeps=100)
    run = simulate(robots, Source(), [0.4, -0.3], 0.2, **how)
    assert abs(run.x[0]).max(axis=1).min() > 0.8  # far from linear
    assert not run.fell.any()
    for k, robot in enumerate(robots):
        true = flow(robot, run.x[:, k, 0], 0.2)
        assert np.allclose(run.x[:, k, -1], true, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("delay", [0.0, 0.0037, 0.01, 0.0262])
def test_a_tiny_tilt_follows_the_sampled_linear_loop(delay):
    """Exact steps by matrix exponentials; the estimate as the firmware
    has it: the gyro's trapezoid, and phi's difference."""
    plant, K = MIP.plant(), GAIN[0]
    M = np.linalg.inv(plant.M)
    F = np.zeros((5, 5))  # of [x; V]
    F[:2, 2:4] = np.eye(2)
    F[2:4, :2], F[2:4, 2:4] = -M @ plant.S, -M @ plant.D
    F[2:4, 4] = (M @ plant.B)[:, 0]
    whole, part = divmod(round(delay / T, 9), 1)
    before, after = expm(F * part * T), expm(F * (1 - part) * T)
    tilt, count = 1e-6, 40
    x, sent = np.array([tilt, 0, 0, 0]), [0.0] * (int(whole) + 2)
    hat, gyro, phi, path = tilt, 0.0, tilt - tilt, []
    for _ in range(count):
        path.append(x)
        hat, gyro = hat + T / 2 * (x[2] + gyro), x[2]
        new = x[1] - x[0] + hat
        sent.append(K @ [hat, new, gyro, (new - phi) / T])
        phi = new
        old, young = sent[-2 - int(whole)], sent[-1 - int(whole)]
        x = (before @ [*x, old])[:4]
        x = (after @ [*x, young])[:4]
    run = simulate(MIP, FIRMWARE, tilt, (count - 1) * T, delay, IDEAL, substeps=40)
    scale = abs(np.array(path)).max(axis=0)
    assert (abs(run.x[:, 0].T - path) < 1e-6 * scale).all()


def test_a_delayed_voltage_acts_when_it_is_due():
    run = simulate(MIP, Source(1.0), 0.0, 0.03, delay=0.0137, substeps=50)
    assert (run.V == 1).all()
    assert (run.x[..., :2] == 0).all()
    late = flow(MIP, np.zeros(4), 0.02 - 0.0137, V=1.0)
    assert np.allclose(run.x[:, 0, 2], late, rtol=1e-9, atol=1e-12)


def test_a_voltage_that_is_overtaken_never_acts():
    class Steps(Source):
        def step(self, gyro, *others):
            self.V += 1
            return super().step(gyro, *others)

    delay = [0.025, 0.008, 0.004, 1, 1]  # 1 V would come after 2 V and 3 V
    run = simulate(MIP, Steps(), 0.0, 0.04, delay, substeps=50)
    x = flow(MIP, np.zeros(4), 0.006, V=2.0)
    x = flow(MIP, x, 0.016, V=3.0)
    assert np.allclose(run.x[:, 0, -1], x, rtol=1e-8, atol=1e-11)


def test_a_push_is_two_torques_for_a_while():
    push = Push(at=0.0123, length=0.011, body=0.05, wheels=-0.02)
    run = simulate(MIP, Source(), 0.0, 0.03, push=push, substeps=50)
    x = flow(MIP, np.zeros(4), 0.011, w=(0.05, -0.02))
    assert (run.x[..., :2] == 0).all()
    end = flow(MIP, x, 0.03 - 0.0233)
    assert np.allclose(run.x[:, 0, 3], end, rtol=1e-8, atol=1e-10)


def test_encoders_and_gyro_give_whole_steps():
    seen = Source()
    simulate(MIP, seen, 0.1, 0.2, seed=3)
    counts = np.ravel(seen.wheels) * COUNTS_PER_TURN / (2 * np.pi)
    assert np.ptp(counts) > 20
    assert np.allclose(counts, np.round(counts), atol=1e-9)
    steps = np.ravel(seen.gyro) / GYRO_STEP
    assert np.ptp(steps) > 20
    assert np.allclose(steps, np.round(steps), atol=1e-9)


def test_encoders_start_somewhere_between_two_counts():
    seen = Source()
    simulate([MIP] * 200, seen, 0.0, T, start=[np.pi / COUNTS_PER_TURN, 0, 0])
    up = np.mean(seen.wheels[0] > 0)  # half a count on
    assert 0.35 < up < 0.65


def test_the_gyro_ends_at_its_range():
    gyro = Sensors(noise=0.0, offset=0.0).gyro(np.array([-1e3, 1e3]))
    assert np.allclose(np.rad2deg(gyro), [-2000, 2000 * (1 - 2**-15)])


def test_ideal_sensors_tell_the_truth():
    seen = Source()
    run = simulate(MIP, seen, 0.1, 0.1, sensors=IDEAL)
    assert (np.ravel(seen.gyro) == run.x[2, 0]).all()
    assert (np.ravel(seen.wheels) == run.x[1, 0] - run.x[0, 0]).all()
    assert np.isnan(seen.tilt).all()
    assert seen.begin[0] == 0.1 and seen.begin[2] == 0


def test_the_offset_at_rest_is_measured_with_the_noise_there_is():
    seen = Source()
    simulate([MIP] * 400, seen, 0.0, T, sensors=Sensors(noise=0.01, offset=0.02))
    bias = seen.begin[2]
    assert abs(bias.mean() - 0.02) < 3 * 0.001 / 20
    assert 0.0008 < bias.std() < 0.0012  # noise / sqrt(100)


def test_they_feel_the_second_difference_of_their_place():
    sensors, x, step = Sensors(height=0.07), [0.4, 1.0, 3.0, -6.0], 1e-3

    def place(t):
        theta, phi, _, _ = flow(MIP, x, t, V=2.0)
        return np.array([-0.032 * phi - 0.07 * np.sin(theta), 0.07 * np.cos(theta)])

    x_middle = flow(MIP, x, step, V=2.0)
    bend = (place(2 * step) - 2 * place(step) + place(0)) / step**2
    force = bend + [0, 9.8]
    sin, cos = np.sin(x_middle[0]), np.cos(x_middle[0])
    along, up = cos * force[0] + sin * force[1], -sin * force[0] + cos * force[1]
    expected = np.arctan2(along, up)
    ddz = MIP.acceleration(x_middle[:2], x_middle[2:], 2.0)
    assert abs(sensors.tilt(x_middle, ddz) - expected) < 1e-4
    assert abs(expected - x_middle[0]) > 0.05  # not small


@pytest.mark.parametrize("push", [(0.0, 0.0), (0.02, -0.01)])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_robots_move_alike_one_by_one_and_side_by_side(friction, push):
    """Those that fall and those that lie, too."""
    random = np.random.default_rng(8)
    x = random.uniform(-1, 1, (4, 100)) * [[1.7], [5.0], [20.0], [30.0]]
    robots = [Mip.printed(), replace(MIP, J=1e-4)] * 50
    volts = random.uniform(-7, 7, 100)
    many = Fleet(robots, friction).advance(x, volts, push, 0.1, 20)
    alone = [
        Fleet([robot], friction).advance(x[:, [k]], volts[k], push, 0.1, 20)
        for k, robot in enumerate(robots)
    ]
    assert np.allclose(many, np.hstack(alone), rtol=1e-9, atol=1e-9)
    lies = abs(many[0]) == np.pi / 2
    assert 10 < lies.sum() < 90 and not many[2:, lies].any()


@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid")
@pytest.mark.parametrize("runs", [1, 30])
def test_a_motion_that_overflows_is_no_number(runs):
    x = np.tile([[0.1], [0.0], [1e200], [0.0]], runs)
    assert np.isnan(Fleet([MIP]).advance(x, 0.0, (0.0, 0.0), 1.0, 1)).all()


def test_the_seed_decides_every_run():
    first, same, other = (simulate(MIP, FIRMWARE, 0.1, 0.3, seed=s) for s in (5, 5, 6))
    assert (first.x == same.x).all() and (first.V == same.V).all()
    assert (first.V != other.V).any()


def test_a_robot_at_fault_gets_no_voltage_and_lies_where_it_falls():
    lost = np.arange(101) >= 20
    run = simulate(MIP, FIRMWARE, 0.2, 1.0, sensors=Sensors(dropouts=lost))
    at = np.argmax(run.fault[0] > 0)
    assert at == 20 + FIRMWARE.missing
    assert FAULTS[run.fault[0, -1]] == "sensor"
    assert run.V[0, at - 1] != 0 and (run.V[0, at:] == 0).all()
    assert run.fell and not run.settled


def test_dropouts_may_differ_between_runs_or_be_a_function():
    count = 51
    lost = np.zeros((2, count), bool)
    lost[1, 30:33] = True
    both = simulate(MIP, FIRMWARE, [0.1, 0.1], 0.5, sensors=Sensors(dropouts=lost))
    three = Sensors(dropouts=lambda k: 30 <= k < 33)
    second = simulate(MIP, FIRMWARE, 0.1, 0.5, seed=1, sensors=three)
    never = simulate(MIP, FIRMWARE, 0.1, 0.5)
    assert np.allclose(both.x[:, 1], second.x[:, 0], atol=1e-9)
    assert np.allclose(both.x[:, 0], never.x[:, 0], atol=1e-9)
    assert (both.x[:, 1] != both.x[:, 0]).any()


def test_an_offset_the_controller_doesnt_know_tilts_its_estimate():
    """The gyro's integral errs by offset times t."""
    wrong = 8 * GYRO_STEP
    sensors = Sensors(noise=0.0, offset=wrong, bias=0.0)
    run = simulate(MIP, FIRMWARE, 0.0, 2.0, sensors=sensors)
    error = (run.estimate - run.x[0])[0]
    assert np.allclose(error, wrong * (run.t + T / 2), rtol=0, atol=2e-4)


@pytest.mark.slow
def test_a_set_point_moves_the_wheels():
    still = simulate(MIP, FIRMWARE, 0.0, 6.0, sensors=IDEAL, target=1.0)
    assert abs(still.x[1, 0, -1] - 1) < 0.02
    run = Source()
    simulate(MIP, run, 0.0, 0.02, target=lambda t: (2 * t, 2.0))
    assert run.target == [(0.0, 2.0), (0.02, 2.0), (0.04, 2.0)]


@pytest.mark.slow
def test_the_largest_tilt_stands_and_a_little_more_falls():
    far = replace(FIRMWARE, tip=1.5, limit=4.0)
    options = dict(t_end=1.5, sensors=IDEAL)
    high, points, rounds = np.pi / 2, 6, 3
    tilt = largest_tilt(MIP, far, high=high, points=points, rounds=rounds, **options)
    step = high / points**rounds
    assert 0.1 < tilt < 1.4
    run = simulate(MIP, far, [tilt[0], tilt[0] + step], **options)
    assert run.settled.tolist() == [True, False]


@pytest.mark.slow
@pytest.mark.parametrize("angle, limit", [(0.5, 3.0), *later((0.1, V_MAX))])
def test_the_continuous_law_recovers_as_an_adaptive_integrator_says(angle, limit):
    """With and without saturation, at two vertices."""
    K, t, robots = thesis.mip().pid[5], np.linspace(0, 1, 401), vertices(MIP, 0.2)[::3]
    x, V = recover(robots, K, angle, t, limit)
    for k, robot in enumerate(robots):

        def rate(now, s, robot=robot):
            volts = np.clip(K[0] @ s, -limit, limit)
            return [*s[2:4], *robot.acceleration(s[:2], s[2:4], volts), s[1]]

        how = dict(method="DOP853", rtol=1e-10, atol=1e-12, max_step=0.0025)
        true = solve_ivp(rate, (0, 1), [angle, 0, 0, 0, 0], t_eval=t, **how).y
        assert np.allclose(x[:, k], true, rtol=1e-3, atol=1e-3)
        assert np.allclose(V[k], np.clip(K[0] @ true, -limit, limit), atol=0.05)
    assert (abs(V) == limit).any() == (angle > 0.4)


def test_what_a_run_says_of_itself():
    t = np.arange(10) * 0.1
    x = np.zeros((4, 3, 10))
    x[0, 1, -1], x[0, 2] = np.pi / 2, 0.1
    V = np.zeros((3, 10))
    V[0, :4] = V_MAX, -V_MAX, 1, -1
    run = Run(t, x, V, x[0], np.zeros((3, 10), int))
    assert (run.fell == [False, True, False]).all()
    assert (run.settled == [True, False, False]).all()
    assert np.allclose(run.peak_voltage, [V_MAX, 0, 0])
    assert np.allclose(run.full, [0.2, 0, 0])


@pytest.mark.parametrize(
    "change, words",
    [
        (dict(tilt=2.0), "tilt must lie"),
        (dict(tilt=[0.1, 0.2], robots=[MIP] * 3), "tilt has 2 entries"),
        (dict(robots=[]), "robots must be"),
        (dict(delay=-0.1), "delay must be"),
        (dict(delay=[0, 0]), "delay must be"),
        (dict(t_end=0), "t_end must be positive"),
        (dict(substeps=0), "substeps must be"),
        (dict(sensors=Sensors(dropouts=[True])), "dropouts ends"),
        (dict(controller=object()), "firmware or a T"),
        (dict(controller=Source(np.nan)), "must be finite"),
        (dict(controller=FIRMWARE.controller(3)), "is for 3 runs"),
        (dict(drivetrain=Drivetrain(battery=0.0)), "battery must"),
        (dict(drivetrain=Drivetrain(battery=lambda t: -1.0)), "battery must"),
    ],
)
def test_bad_input_is_named(change, words):
    given = dict(robots=MIP, controller=FIRMWARE, tilt=0.1, t_end=0.1)
    with pytest.raises(ValueError, match=words):
        simulate(**given | change)


@pytest.mark.parametrize(
    "change, words",
    [
        (dict(noise=-1.0), "noise"),
        (dict(counts=0), "counts"),
        (dict(accelerometer=-1.0), "accelerometer"),
        (dict(offset=np.nan), "offset"),
        (dict(friction=-1.0), "friction must"),
        (dict(backlash=np.nan), "backlash must"),
        (dict(nominal=7.4), "give battery"),
        (dict(battery=7.4, nominal=-1.0), "nominal must"),
    ],
)
def test_bad_sensors_and_drives_are_named(change, words):
    kind = Sensors if hasattr(Sensors, next(iter(change))) else Drivetrain
    with pytest.raises(ValueError, match=words):
        kind(**change)


def test_an_edge_just_after_a_tick_is_a_step_of_its_own():
    plain, hair = (
        simulate(MIP, FIRMWARE, 0.1, 0.3, late, push=Push(0.1 + late, 0.05, 0.01))
        for late in (0.0, 5e-10)
    )
    assert np.allclose(plain.x, hair.x, atol=1e-6)


def test_a_battery_gives_what_it_has():
    """A constant command is cut to the battery, or scaled where it isn't measured."""
    cases = (
        (6.0, dict(battery=5.0), 5.0),
        (-6.0, dict(battery=5.0), -5.0),
        (6.0, dict(battery=lambda t: 5.0), 5.0),
        (4.0, dict(battery=5.0), 4.0),
        (4.0, dict(battery=5.0, nominal=8.0), 2.5),
        (4.0, dict(battery=12.0, nominal=8.0), 6.0),
    )
    for asked, supply, got in cases:
        how = dict(tilt=0.1, t_end=0.05, sensors=IDEAL)
        run = simulate(MIP, Source(asked), drivetrain=Drivetrain(**supply), **how)
        same = simulate(MIP, Source(got), **how)
        assert np.array_equal(run.x, same.x) and (run.V == asked).all()
