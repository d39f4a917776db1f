"""Every number of a program does what its unit and its comment say.

The generated C is compiled with its numbers open to be changed. The statements
below are about behaviour, in SI units and by closed forms: what the motors get,
which reading is believed, when they go off, what happens at the limit. All are true
of the program as it is; a number with another sign, or half as large again or two
thirds as large, must break one of them.
"""

import ctypes
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm

from sosbook.pendulum import (
    FAULTS,
    PID_SIGNALS,
    Firmware,
    Gain,
    Mip,
    Robot,
    SampledLaw,
    Sensors,
    simulate,
)
from sosbook.pendulum.compiled import Compiled
from sosbook.pendulum.export import Program
from sosbook.pendulum.firmware import COUNTERS, NUMBERS
from sosbook.pendulum.optimal import optimal_law
from sosbook.pendulum.steering import Steering
from tests.compiler import run
from tests.turning import steer_functions

T, LIMIT = 0.01, 3.0
K = np.array([15.78, 0.49, 1.42, 0.69, 0.22])
TRACKING_TIME = 0.5  # s, of `SampledLaw.of_gain` and `Steering`
NUMBERED = dict(limit=LIMIT, tip=0.85, blend=0.02, missing=5, frozen=12, stall=50)
NUMBERED |= dict(fastest=60.0, gyro_range=8.0, deaf=30, compensation=0.4)
FULL = Firmware(SampledLaw.of_gain(Gain([K], PID_SIGNALS), T), **NUMBERED)
TURN = np.array([-0.93, -0.29, -0.52])
STEERING = Steering(FULL, [TURN], share=0.25, track=0.07, r=0.034)
FACTORS = (-1.0, 1.5, 2 / 3)
DECLARED = re.compile(r"^static const \w+ (\w+)[^=;]*= BALANCE_(\w+);", re.M)


class Open:
    """A program whose numbers can be changed while it is loaded."""

    def __init__(self, gcc, folder, name, texts, known, declared):
        for file, text in texts.items():
            text = re.sub(r"^static const ", "", text, flags=re.M)
            (folder / file).write_text(text, "utf-8")
        library = folder / f"{name}.so"
        flags = ["-std=c99", "-O1", "-ffp-contract=off", "-shared", "-fPIC"]
        run(*gcc, *flags, folder / name, "-o", library)
        self.library, self.numbers = ctypes.CDLL(str(library)), {}
        for label, source in DECLARED.findall(declared):
            value = known[source]
            real = ctypes.c_int if isinstance(value, int) else ctypes.c_double
            if np.any(value):  # what is zero isn't changed, or isn't built
                kind = real * np.size(value)
                self.numbers[label] = kind.in_dll(self.library, label)

    def changes(self):
        """Every number that isn't zero, with each of `FACTORS`; then as it was."""
        for label, values in self.numbers.items():
            for k, value in enumerate(values):
                for factor in FACTORS:
                    if not value:
                        continue
                    changed = value * factor
                    if isinstance(value, int):  # ticks: one more, one less, none
                        changed = value + {-1.0: -value, 1.5: 1}.get(factor, -1)
                    values[k] = changed
                    yield f"{label}[{k}] {factor:+.2f}"
                    values[k] = value


class Balance(Open):
    """balance.c of a firmware."""

    def __init__(self, gcc, folder, firmware):
        texts = Program(firmware).law
        declared = texts["balance_tick.h"] + texts["balance.c"]
        known = firmware.numbers
        if not known["RUB"]:
            known["STEEP"] = 0.0  # isn't built
        super().__init__(gcc, folder, "balance.c", texts, known, declared)
        program = Compiled.__new__(Compiled)
        program.firmware, program.runs, program.states = firmware, 1, None
        program.kind = np.dtype(float)
        program._load(self.library)
        self.start, self._program = program.start, program

    def step(self, *seen, **asked):
        return float(self._program.step(*seen, **asked)[0])

    @property
    def state(self):
        return self._program.states[0]

    @property
    def fault(self):
        return FAULTS[self.state.fault]


class Steers(Open):
    """balance_steer.c of a steering, beside a robot whose balance is told."""

    def __init__(self, gcc, folder, steering):
        texts = Program(steering.firmware, steering=steering).law
        name, known = "balance_steer.c", steering.firmware.numbers | steering.numbers
        super().__init__(gcc, folder, name, texts, known, texts[name])
        functions = steer_functions(self.library, ctypes.c_double)
        self.state, self.volts, self._start, self._step = functions
        self.robot = Robots()

    def start(self, left=0.0, right=0.0):
        self._start(self.state, left, right)

    def step(self, V, left, right, target=0.0, rate=0.0):
        """Volts left and right."""
        self.robot.volts = V
        robot = ctypes.byref(self.robot)
        self._step(self.state, robot, left, right, target, rate, self.volts)
        return tuple(self.volts)


COUNTS = (*COUNTERS, "fault")


class Robots(ctypes.Structure):
    """balance_state of a law with one state."""

    _fields_ = [
        *[(x, ctypes.c_double) for x in NUMBERS],
        ("x", ctypes.c_double),
        *[(x, ctypes.c_int) for x in COUNTS],
    ]


def added(u):
    """A command with friction's compensation: .4 V from .8 V on, half below."""
    return u + np.clip(u / 2, -0.4, 0.4)


def noise(k):
    """Of a gyro that works: never the same twice."""
    return 1e-7 * (-1) ** k


# What balances


def a_smooth_motion_is_answered_by_the_gain_of_it(p):
    """theta = .01 sin 3t, phi = .4 sin 2t: V is K [theta, phi, rates, integral]."""
    p.start(0.0, wheels=0.0, bias=0.25)
    for k in range(400):
        t = k * T
        theta, rate = 0.01 * np.sin(3 * t), 0.03 * np.cos(3 * t)
        phi, speed = 0.4 * np.sin(2 * t), 0.8 * np.cos(2 * t)
        V = p.step(0.25 + rate, phi - theta)
        if k < 5:  # it believes that it begins at rest
            continue
        total = 0.2 * (1 - np.cos(2 * t))
        true = K @ [theta, phi, rate, speed, total]
        assert V == pytest.approx(added(true), abs=0.03)
    assert p.fault == "running"


def set_points_are_taken_off(p):
    p.start(0.0, wheels=30.0)
    V = p.step(0.0, 30.05, target=0.3, rate=4.0)
    assert V == pytest.approx(added(K[1] * (0.05 - 0.3) + K[3] * (0.05 / T - 4.0)))


def the_accelerometers_have_the_last_word_after_their_time(p):
    """2 % a tick: after a second 1 - .98^100 of the tilt."""
    p.start(0.0)
    for k in range(100):
        p.step(noise(k), 0.0, 0.02)
    assert p.state.theta == pytest.approx(0.02 * (1 - 0.98**100), rel=1e-4)
    before = p.state.theta
    p.step(0.0, 0.0, 0.86)  # a tilt at which it would lie
    assert p.state.theta == pytest.approx(before, abs=1e-6)


def friction_is_compensated_as_it_is_said(p):
    for u in (-2.0, -1.0, -0.81, -0.3, 0.2, 0.79, 1.1, 2.5):
        p.start(u / K[0])
        assert p.step(0.0, 0.0) == pytest.approx(added(u), abs=1e-9)


def the_motors_get_the_limit_and_no_more(p):
    for side in (-1, 1):
        p.start(side * 0.7)
        assert p.step(0.0, 0.0) == side * LIMIT


def a_robot_that_lies_gets_nothing(p):
    for tilt, fault in ((0.84, "running"), (0.86, "fall"), (-0.86, "fall")):
        p.start(tilt)
        V = p.step(0.0, 0.0)
        assert p.fault == fault and (V != 0) == (fault == "running")


def a_gyro_beyond_its_range_is_not_believed(p):
    for rate, good in ((7.9, True), (-7.9, True), (8.1, False), (-8.1, False)):
        p.start(0.0)
        p.step(rate, 0.0)
        assert (p.state.gyro == rate) == good


def wheels_turn_so_fast_and_no_faster(p):
    """60 rad/s at most, also over a tick that was lost."""
    for lost, turned, good in ((0, 0.59, 1), (0, 0.61, 0), (1, 1.19, 1), (1, 1.21, 0)):
        p.start(0.0)
        for _ in range(lost):
            p.step(0.0, np.nan)
        p.step(0.0, turned)
        assert (p.state.lost == 0) == good


def so_many_ticks_are_bridged(p):
    for bad in ((np.nan, 0.0), (0.0, np.nan)):
        p.start(0.0)
        for k in range(6):
            p.step(bad[0] + noise(k), bad[1])
            assert p.fault == ("running" if k < 5 else "sensor")


def a_gyro_that_repeats_itself_is_dead(p):
    p.start(0.0)
    for k in range(14):
        p.step(0.001, 0.0)
        assert p.fault == ("running" if k < 13 else "sensor")


def wheels_that_rest_under_a_quarter_of_the_limit_are_dead(p):
    """.77 V stall them perhaps; .73 V may be less than friction."""
    for volts, dead in ((0.77, True), (0.73, False)):
        p.start(volts / 1.5 / K[0])
        faults = []
        for k in range(40):
            p.step(noise(k), 0.0)
            faults.append(p.fault)
        assert faults[30] == "running"
        assert (faults[31] == "sensor") == (faults[-1] == "sensor") == dead


def a_robot_that_pushes_in_vain_gives_up(p):
    """After .5 s at the limit, of either sign."""
    for side in (-1, 1):
        p.start(side * 0.5)
        for k in range(51):
            p.step(noise(k), 0.01 * k)
            assert p.fault == ("running" if k < 50 else "stall")


def a_command_of_a_million_volts_is_a_fault(p):
    for u, fault in ((0.9e6, "running"), (1.1e6, "command"), (-1.1e6, "command")):
        p.start(0.0)
        p.step(0.0, 0.0, target=-u / K[1])
        assert p.fault == fault


def the_sum_follows_what_the_limit_withholds(p):
    """Within half a second: u settles at V + .5 K_I phi, whatever it was."""
    e, x = 6.3, []
    p.start(0.0)
    for k in range(50):
        p.step(noise(k), noise(k), target=-e)
        x.append(p.state.x[0] * K[4])
    first = K[1] * e + 0.4 - LIMIT  # V that are withheld at once
    end = 0.5 * K[4] * e - first
    expected = end * (1 - np.exp(-T / TRACKING_TIME * np.arange(1, 51)))
    assert p.fault == "running"
    assert x == pytest.approx(expected, rel=0.02)


BALANCE = (
    a_smooth_motion_is_answered_by_the_gain_of_it,
    set_points_are_taken_off,
    the_accelerometers_have_the_last_word_after_their_time,
    friction_is_compensated_as_it_is_said,
    the_motors_get_the_limit_and_no_more,
    a_robot_that_lies_gets_nothing,
    a_gyro_beyond_its_range_is_not_believed,
    wheels_turn_so_fast_and_no_faster,
    so_many_ticks_are_bridged,
    a_gyro_that_repeats_itself_is_dead,
    wheels_that_rest_under_a_quarter_of_the_limit_are_dead,
    a_robot_that_pushes_in_vain_gives_up,
    a_command_of_a_million_volts_is_a_fault,
    the_sum_follows_what_the_limit_withholds,
)


# What steers


def turns(p, target, seconds=25.0, V=0.0):
    """The wheels' difference of a robot that turns: .1 delta'' + delta' = 3 W."""
    p.start()
    path, delta, speed = [], 0.0, 0.0
    for _ in range(round(seconds / T)):
        left, right = p.step(V, -delta / 2, delta / 2, target)
        settled = 3.0 * (right - left)
        fade = np.exp(-T / 0.1)
        delta += settled * T + (speed - settled) * 0.1 * (1 - fade)
        speed = settled + (speed - settled) * fade
        path.append(delta)
    return np.array(path)


def a_turn_of_12_rad_peaks_a_little_above_and_settles(p):
    path = turns(p, 12.0)
    assert 12.0 <= path.max() < 13.0 and path.min() >= 0
    assert abs(path[-300:] - 12.0).max() < 0.05


def a_smooth_turn_is_answered_by_the_gain_of_it(p):
    p.start(left=0.3, right=0.1)
    for k in range(400):
        t = k * T
        delta, rate = 0.4 * np.sin(2 * t), 0.8 * np.cos(2 * t)
        left, right = p.step(0.5, 0.3 - delta / 2, 0.1 + delta / 2, 0.1, 0.2)
        if k < 5:
            continue
        true = TURN @ [delta - 0.1, rate - 0.2, 0.2 * (1 - np.cos(2 * t)) - 0.1 * t]
        assert right - left == pytest.approx(true, abs=0.015)
        assert left + right == pytest.approx(1.0)


def it_takes_its_share_of_what_balance_leaves(p):
    for V, most in ((0.0, 0.75), (1.0, 0.75), (2.6, 0.4), (-2.9, 0.1), (3.0, 0.0)):
        for target in (50.0, -50.0):
            p.start()
            left, right = p.step(V, 0.0, 0.0, target)
            assert (right - left) / 2 == pytest.approx(np.sign(target) * most)
            assert max(abs(left), abs(right)) <= LIMIT


def both_wheels_turn_so_fast_and_no_faster(p):
    """60 rad/s each: 1.2 rad of their difference in a tick."""
    for lost, turned, good in ((0, 1.19, 1), (0, 1.21, 0), (1, 2.39, 1), (1, 2.41, 0)):
        p.start()
        for _ in range(lost):
            assert p.step(0.5, 0.0, np.nan) == (0.5, 0.5)
        p.step(0.5, 0.0, turned)
        assert (p.state.lost == 0) == good


def a_turn_of_a_million_volts_is_none(p):
    for W, good in ((0.9e6, True), (1.1e6, False)):
        p.start()
        left, right = p.step(0.0, 0.0, 0.0, target=W / -TURN[0])
        assert (right != left) == good


def its_sum_follows_what_the_limit_withholds(p):
    """Within half a second, as the balance's."""
    target, found = 3.0, []
    p.start()
    for _ in range(50):
        p.step(0.0, 0.0, 0.0, target)
        found.append(p.state.sum * TURN[2])
    first = -TURN[0] * target - 1.5
    end = 0.5 * -TURN[2] * target - first
    expected = end * (1 - np.exp(-T / TRACKING_TIME * np.arange(1, 51)))
    assert found == pytest.approx(expected, rel=0.02)


STEERS = (
    a_smooth_turn_is_answered_by_the_gain_of_it,
    it_takes_its_share_of_what_balance_leaves,
    both_wheels_turn_so_fast_and_no_faster,
    a_turn_of_a_million_volts_is_none,
    its_sum_follows_what_the_limit_withholds,
    a_turn_of_12_rad_peaks_a_little_above_and_settles,
)


# A sampled regulator, without and with an observer

ROBOT = Robot.shipped("thesis")
MIP = Mip.printed()


def of_least_cost():
    """The law of a robot with so late volts, and a firmware that sees exactly."""
    found = optimal_law(MIP, ROBOT, np.eye(5), 20.0)
    firmware = Firmware(found.law, limit=LIMIT, blend=1.0, stall=10**4)
    return SimpleNamespace(firmware=firmware, K=found.K)


def is_the_gain_of_the_true_state(p, K):
    """V is K [theta, phi, rates, integral, V before] of a robot at its limit.

    The robot is linear, its volts come a tick late, and its start needs more volts
    than there are. An observer knows the rate of phi that the encoders don't tell.
    """
    plant, M = MIP.plant(), np.linalg.inv(MIP.plant().M)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-M @ plant.S, -M @ plant.D]])
    B = np.vstack([np.zeros((2, 1)), M @ plant.B])
    held = expm(T * np.block([[A, B], [np.zeros((1, 5))]]))
    x, before, total, told = np.array([0.3, 0.1, 0, 0]), 0.0, 0.0, 0
    p.start(x[0], x[1] - x[0])
    zero = x[1]
    for _ in range(150):
        seen = x - [0, zero, 0, 0]
        u = float(K[0] @ [*seen, total, before])
        V = np.clip(u, -LIMIT, LIMIT)
        assert p.step(x[2], x[1] - x[0], x[0]) == pytest.approx(V, abs=1e-6)
        told += V != u
        total += T * seen[1] + T / TRACKING_TIME * (V - u) / K[0, 4]
        x, before = held[:4, :4] @ x + held[:4, 4] * before, V
    assert told > 5 and p.fault == "running"


@pytest.mark.parametrize("kind", ["gain", "observer"])
def test_a_start_that_takes_all_volts_is_survived_thanks_to_the_anti_windup(kind):
    """With its sign turned the robot falls."""
    tilt, delay = (0.5, 0.0) if kind == "gain" else (0.45, T)
    law = FULL.law if kind == "gain" else of_least_cost().firmware.law

    def told(law):
        firmware = Firmware(law, limit=LIMIT, tip=1.2, stall=10**4)
        return simulate(MIP, firmware, tilt, 12.0, delay, sensors=Sensors(ideal=True))

    run = told(law)
    assert np.mean(abs(run.V) == LIMIT) > 0.01 and run.settled.all()
    assert abs(run.x[1, 0, -1]) < 0.02  # where it began
    assert told(replace(law, W=-law.W)).fell.all()


# Each number


def broken(statements, program):
    """The first statement that a program breaks; None where it keeps all."""
    for statement in statements:
        try:
            statement(program)
        except AssertionError:
            return statement.__name__
    return None


def unnoticed(statements, program):
    """The changes of a program's numbers that no statement notices."""
    for statement in statements:
        statement(program)  # it is true of the program as it is
    return [
        change for change in program.changes() if broken(statements, program) is None
    ]


def test_every_number_that_balances_is_noticed(gcc, tmp_path):
    assert unnoticed(BALANCE, Balance(gcc, tmp_path, FULL)) == []


def test_every_number_that_steers_is_noticed(gcc, tmp_path):
    assert unnoticed(STEERS, Steers(gcc, tmp_path, STEERING)) == []


def test_every_number_of_a_law_of_least_cost_is_noticed(gcc, tmp_path):
    about = of_least_cost()

    def regulates(p):
        is_the_gain_of_the_true_state(p, about.K)

    program = Balance(gcc, tmp_path, about.firmware)
    for label in set(program.numbers) - set("ABCDW") - {"START"}:
        del program.numbers[label]  # the firmware's own, as above
    assert unnoticed([regulates], program) == []
