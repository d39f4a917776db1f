"""Every number in every written file comes from a place that is known."""

import re
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

import sosbook.pendulum
from sosbook.pendulum import Robot
from sosbook.pendulum.boards import PYCTRL_COUNTS_PER_TURN
from sosbook.pendulum.firmware import PUSHING_SHARE, SOFTNESS, TRUSTED_VOLTS
from sosbook.pendulum.recording import GYRO_RANGES
from sosbook.pendulum.spread import vertices
from sosbook.pendulum.steering import MOST_COUNTED
from tests.six_robots import spared
from tests.test_mip_robot import bare, deployed, exact_data, told, written

FLT_DIGITS, DBL_DIGITS = 24, 53  # of their mantissas
TEMPLATES = Path(sosbook.pendulum.__file__).parent / "templates"
DIGEST = re.compile(r"\b[0-9a-f]{16}(?:[0-9a-f]{48})?\b")
NUMBER = re.compile(
    r"0x1(?:\.[0-9a-f]+)?p[+-]\d+"
    r"|(?<![\w.])\d+(?:\.\d*)?(?:[eE][+-]?\d+)?"
    r"|(?<![\w.])\.\d+"
)
TURN = 6.2831853  # rad, in single precision
#: What a template has for an example's robot, which another's must not have: all
#: definitions but those of pins, of rest, of sticks and the like.
FIXED = r"TURN = 6\.283185307|SILENCE|REST_(?!TICKS)|DSM_|LOG_|LONGEST|MOST_COUNTED"
FIXED += r"|GENTLE|IMU\b|ENCODER_[AB]|FORWARD|BACKWARD|PWM_PIN"
EXAMPLES = re.compile(
    rf"^(?:#define (?!{FIXED})\w+ .*"
    rf"|(?:static .*?\b)?(?!{FIXED})[A-Z]\w*[\[\]\w]* = [^;]*?(?:;|$(?=\n\S|\n\n)).*)$"
    r"|every\n \* +[\d.]+ s|beyond [\d.]+ rad|heading is [\d.]+",
    re.M,
)
#: No digit of them is the thesis's robot's.
STRANGE = dict(M_b=0.2713, l=0.0397, r=0.03217, M_w=0.02731, g=9.7913, counts=2119.3)
STRANGE |= dict(gyro_range=33.77, limit=7.313, delay=0.00913, blend=0.00537, tip=0.8371)
STRANGE |= dict(missing=0.17, frozen=0.23, stall=0.61, deaf=0.29, late=0.19)
STRANGE |= dict(compensation=0.1373)
BOARDS = {
    "beaglebone": dict(mount=0.4719, nominal=7.279, battery=(5.193, 8.917)),
    "other": {},
}
STEERS = dict(track=0.0717, steering=0.2319, unequal=0.0917)
KINDS = [("beaglebone", STEERS), ("other", {})]


def values(text):
    """The numbers of a text, as it spells them, and their values."""
    for spelled in NUMBER.findall(DIGEST.sub("", text)):
        value = float.fromhex(spelled) if "p" in spelled else float(spelled)
        yield spelled, value


def flat(*things):
    """All numbers in numbers, arrays and tuples of them."""
    for thing in things:
        yield from np.ravel(np.asarray(thing, float)).tolist()


def known(found):
    """Where the numbers of a deployment's files may come from."""
    robot, law, bench = found.robot, found.law, found.bench_firmware
    T, drive = robot.T, found.drive
    sizes = [getattr(law, x) for x in ("A", "B", "C", "D", "W", "start")]
    plants = [found.mip, *vertices(found.mip, found.spread)]
    described = [
        v
        for v in vars(robot).values()
        if isinstance(v, (int, float, tuple)) and not isinstance(v, bool)
    ]
    setting = next(x for x in GYRO_RANGES if radians(x) > 0.99 * robot.gyro_range)
    derived = [T / 2, 1 / T, 1e6 * T, TURN, PYCTRL_COUNTS_PER_TURN, TRUSTED_VOLTS]
    derived += [2 * pi / robot.counts, radians(setting) / 2**15]
    derived += [PUSHING_SHARE * found.firmware.limit, PUSHING_SHARE * bench.limit]
    derived += [*robot.ticks.values(), T / 20, 1e6 * T / 20]
    derived += [bench.limit, found.firmware.fastest * T, found.spread]
    derived += [SOFTNESS * robot.compensation, 1 / SOFTNESS]
    derived += [drive.speed, drive.acceleration, FLT_DIGITS, DBL_DIGITS]
    linear = [getattr(m.plant(), x) for m in plants[:1] for x in "MDSB"]
    letters = [v for v in vars(found.mip).values() if v is not None]
    facts = [v for x in found.facts.values() for _, v in values(x)]
    given = [
        v
        for p in TEMPLATES.iterdir()
        for _, v in values(EXAMPLES.sub("", p.read_text("utf-8")))
    ]
    if found.steering:
        ours = found.steering.law
        derived += [ours.per_radian, ours.volts]
        derived += [ours.numbers[x] for x in ("STEER_REACH", "UNWIND")]
        derived += [*ours.K[0], MOST_COUNTED, drive.turn, drive.turn_acceleration]
    every = [*described, *sizes, *derived, *linear, *letters, *facts, *given]
    return np.sort([abs(v) for v in flat(*every, *bench.law.D)])


def strangers(text, places, digits):
    """Numbers that stand in none of the sorted places; small counts are free."""
    foreign = []
    for spelled, value in values(text):
        if value == int(value) and value < 10:
            continue
        at = np.searchsorted(places, value)
        if not (abs(places[max(at - 1, 0) : at + 1] - value) <= digits * value).any():
            foreign.append(spelled)
    return foreign


@pytest.fixture(
    scope="module",
    params=KINDS,
    ids=lambda kind: kind[0] + " that steers" * bool(kind[1]),
)
def strange(request, tmp_path_factory):
    """A deployment with strange numbers, and its files."""
    board, more = request.param
    robot = Robot.shipped("thesis").but(**STRANGE, **BOARDS["beaglebone"], **more)
    if board == "other":
        about = dict(name="strange", T=0.01, rotors=False, friction=False, law="gain")
        robot = Robot(**STRANGE, **about, **more)
    found = bare(spared(told(deployed(), robot)))
    paths = written(found, tmp_path_factory.mktemp("strange")).values()
    return found, [p for p in paths if not p.name.startswith(("proof_", "check_"))]


@pytest.mark.slow
def test_every_number_in_every_file_has_a_source(strange):
    found, paths = strange
    places, seen, foreign = known(found), 0, {}
    assert len(paths) > 8
    for path in paths:
        text = path.read_text("utf-8")
        # single precision keeps seven digits, the comments nine; a program's record
        # holds the numbers of its C as they stand there
        exact = exact_data(path.name) and not path.name.startswith("program_")
        digits = 1e-12 if exact else 1e-7
        if path.suffix != ".json":
            text = re.sub(r"sosbook [\w.]+", "", text)
        found_here = strangers(text, places, digits)
        if found_here:
            foreign[path.name] = found_here
        seen += len(list(values(text)))
    assert not foreign
    assert seen > 1000


@pytest.mark.slow
@pytest.mark.parametrize("stranger", ["2122.2", "0x1.8f5c28f5c28f6p-2", "0.272"])
def test_a_number_of_another_robot_is_found(stranger, strange):
    found, _ = strange
    assert strangers(f"#define X {stranger}\n", known(found), 1e-7) == [stranger]
