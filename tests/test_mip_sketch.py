"""The sketch that balances: compiled, and on a simulated robot by a pipe."""

import re
from dataclasses import replace

import numpy as np
import pytest

from sosbook.book import thesis
from sosbook.pendulum import FAULTS, Firmware, Robot, SampledLaw
from sosbook.pendulum.drive import Drive
from sosbook.pendulum.export import Program
from sosbook.pendulum.ticks import TickLog
from tests.gains import named
from tests.test_mip_recording import PIPE, cpp, live_sketch, sketch_program
from tests.turning import TURNER, advance

assert cpp  # a fixture
MACHINE = TURNER.machine
ROBOT = Robot.shipped("gearmotors").but(
    counts=MACHINE.counts, limit=7.4, T=MACHINE.T, delay=0.003
)
LAW = SampledLaw.of_gain(named(thesis.mip().pid[5]), MACHINE.T)
FIRMWARE = Firmware(LAW, blend=0.005, gyro_range=17.4)
DRIVE = Drive(4.0, 6.0)

#: The pipe of the recorder's test, with a second wheel, a tilt and lines of commands.
LATER = """now += 97;
        if (k >= 20000 && k < 40000 && k % 5000 == 0)
            letters = "v 3\\n"; /* again and again, or it stops */
        if (k == 40000)
            letters = argv[1];"""
BOARD = PIPE
for _old, _new in (
    ("static double rate,", "static double rate, tilt,"),
    ("io_tilt(void) { return 0; }", "io_tilt(void) { return (float)tilt; }"),
    ("static long count;", "static long count, other;"),
    ("return side ? count : count;", "return side ? other : count;"),
    ('"%lf %ld", &rate, &count) == 2',
     '"%lf %ld %ld %lf", &rate, &count, &other, &tilt) == 4'),
    ("static int letter;", "static const char *letters;"),
    ("if (baud < 9600) letter = 0;", "if (baud < 9600) letters = 0;"),
    ("return letter != 0;", "return letters && *letters;"),
    ("int c = letter; letter = 0; return c;", "return *letters++;"),
    ("letter = argv[1][0];", 'letters = "l\\n";'),
    ("k < 1400000", "k < 62000"),
    ("now += 97;", LATER),
):  # fmt: skip
    assert BOARD.count(_old) == 1, _old
    BOARD = BOARD.replace(_old, _new)


@pytest.fixture
def program(gcc, cpp, tmp_path):
    """The sketch, its law and the pipe as one program."""
    texts = Program(FIRMWARE, robot=ROBOT, drive=DRIVE).sketch
    return sketch_program(gcc, cpp, tmp_path, texts, BOARD)


def live(program, word, turner=TURNER, dead=None):
    """The path of a robot that is held for a second and then let go, with the left
    motor's volts; and what the sketch says. Its gyro may be ``dead`` from a tick on.
    """
    per_count = 2 * np.pi / MACHINE.counts
    random, path, times = np.random.default_rng(2), [], []
    x = np.array([0.03, 0, 0, 0, 0, 0])

    def answer(volts, now):
        nonlocal x
        if len(path) > 101:
            x = advance(turner.rate, x, volts, now - times[-1], 3)
        times.append(now)
        path.append((*x, volts[0]))
        counts = np.floor(turner.wheels(x[:3]) / per_count).astype(int)
        gyro = x[3] + 0.01 + 0.002 * random.standard_normal()
        if dead is not None and len(path) > dead:
            gyro = 99.0
        tilt = x[0] + 0.01 * random.standard_normal()
        return f"{float(gyro)!r} {counts[0]} {counts[1]} {float(tilt)!r}"

    said = live_sketch(program, word, answer)
    return np.array(path), said


@pytest.mark.slow
def test_the_sketch_balances_logs_and_obeys(program, tmp_path):
    path, said = live(program, "s\n")
    stood = path[102:400]
    assert abs(stood[:, 0]).max() < 0.2 and abs(stood[:, -1]).max() > 0.1
    assert set(path[402:, -1]) == {0.0}  # stopped
    (tmp_path / "log.csv").write_text(said, "utf-8")
    log = TickLog.read(tmp_path / "log.csv")
    assert len(log.t) > 280 and log.battery[0] == pytest.approx(7.4)
    replayed = log.replayed(FIRMWARE)
    assert abs(replayed - log.V).max() < 1e-3  # single precision, seven digits
    assert log.rate[-1] == pytest.approx(3.0, rel=1e-5)
    ramp = np.diff(log.rate)
    assert ramp.max() == pytest.approx(DRIVE.acceleration * MACHINE.T, rel=1e-3)


@pytest.mark.slow
def test_a_dead_sensor_stops_the_motors_and_says_why(program):
    path, said = live(program, "v 9\n", dead=220)
    assert "# motors off: sensor" in said
    assert set(path[240:, -1]) == {0.0}


def test_every_number_is_the_descriptions():
    texts = Program(FIRMWARE, robot=ROBOT, drive=DRIVE).sketch
    code = texts["balance_sketch/balance_sketch.ino"]
    code += texts["balance_sketch/balance_single_gains.h"]
    for words in (
        "TICK_US 10000UL",
        "HERTZ 0x1.9p+6f",
        "6.2831853f / 2134.0f",
        "SPEED 0x1p+2f",
        "ACCELERATION 0x1.8p+2f",
    ):
        assert words in code
    board = texts["balance_sketch/robot_io.cpp"]
    assert "SUPPLY = 7.4f" in board and "GYRO_RANGE = 0x10" in board  # 1000 deg/s
    step = float(re.search(r"GYRO_STEP = ([\d.e-]+)f", board)[1])
    assert step == pytest.approx(np.deg2rad(1000) / 2**15)


#: The same board; from 300 ticks on the sketch's loop comes every 3.3 ms.
SLOW = BOARD.replace("now += 97;", "now += k > 30000 ? 3300 : 97;", 1)


@pytest.mark.slow
def test_a_late_tick_is_counted_and_no_short_one_follows(gcc, cpp, tmp_path):
    firmware = replace(FIRMWARE, late=6)
    texts = Program(firmware, robot=ROBOT, drive=DRIVE).sketch
    _, said = live(sketch_program(gcc, cpp, tmp_path, texts, SLOW), "v 1\n")
    (tmp_path / "log.csv").write_text(said, "utf-8")
    log = TickLog.read(tmp_path / "log.csv")
    steps = np.diff(log.t[1:])
    assert steps.min() >= MACHINE.T - 1e-6 and steps.max() > 1.2 * MACHINE.T
    assert "# motors off: late" in said and log.fault[-1] == FAULTS.index("late")
    assert log.late[-1] == (steps > MACHINE.T + 0.0005).sum() > 0
