"""The description of a robot, and where each of its keys arrives."""

import json
import re
from copy import copy
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest

from sosbook.pendulum import Mip, Robot
from sosbook.pendulum.command import _places, main
from sosbook.pendulum.compiled import Compiled
from sosbook.pendulum.deployment import deploy, described
from sosbook.pendulum.experiments import chirp, motion
from sosbook.pendulum.gate import widened
from sosbook.pendulum.identify import identify
from sosbook.pendulum.log import Log
from sosbook.pendulum.modelled import Model
from sosbook.pendulum.rig import COUNTS_PER_TURN, DATA
from sosbook.pendulum.robot import STEERING
from sosbook.pendulum.tuning import timed
from sosbook.proofs import load
from tests import six_robots
from tests.compiler import find, refuse
from tests.once import once
from tests.six_robots import by_its_sheet, pendulum, spared

THESIS, GEARS = Robot.shipped("thesis"), Robot.shipped("gearmotors")


def table(robot):
    return {key: value for key, value in vars(robot).items() if value is not None}


def text(robot):
    """As a TOML file."""
    return "".join(f"{k} = {json.dumps(v)}\n" for k, v in table(robot).items())


# The file


def test_the_thesiss_robot_is_the_one_that_the_functions_assume():
    known = {k: getattr(THESIS, k) for k in ("M_b", "l", "r", "M_w", "g")}
    assert THESIS.counts == COUNTS_PER_TURN
    assert Mip.from_ratios(30.52, 7.133, 110.6, 208.8, **known) == Mip.printed()


LAW, RC, PYCTRL = "balance_gains.h", "rc_balance.c", "pyctrl_balance.py"
PINS = "rc_robot.h"
#: Keys of a robot that steers: another value, and whose code it changes. Balance
#: is the same with each.
STEERED = {
    "track": (0.08, {LAW}),
    "steering": (0.3, {LAW}),
    "unequal": (0.05, set()),
    "turning": ((1e-4, 2e-4), {LAW}),
}
OPTIONAL = {"free_rpm", "ten_swings", "g", "jitter", "blend", "compensation",
            "backlash_deg", "edges", "law", "tip", "missing", "frozen", "stall", "deaf",
            "late", "board", *STEERED}  # fmt: skip


@pytest.mark.parametrize("robot", [THESIS, GEARS])
def test_a_description_survives_its_file(robot, tmp_path):
    (tmp_path / "robot.toml").write_text(text(robot), "utf-8")
    assert Robot.read(tmp_path / "robot.toml") == robot


@pytest.mark.parametrize(
    "change, words",
    [
        ({"count": 1.0}, "unknown key count; do you mean counts"),
        ({"wheels": {}}, "unknown key wheels"),
        ({"zzz": 1}, "the keys are name, M_b"),
        ({"M_b": -1}, "M_b .mass of the body.* above 0 .* kg, got -1"),
        ({"M_b": 272.0}, "M_b .*at most 100 kg"),  # in grams
        ({"M_w": 27.0}, "M_w .*at most 20 kg"),
        ({"l": 40.0}, "l .*at most 2 m"),  # in mm
        ({"gyro_range": 440}, "1000 deg/s are 17.45.*at most 100 rad/s"),
        ({"M_b": "1"}, "M_b"),
        ({"track": 0.1, "turning": [1, "1"]}, "turning must be two inertias"),
        ({"M_b": True}, "M_b"),
        ({"l": float("nan")}, "l .from the axle"),
        ({"T": 0}, "T .time between"),
        ({"delay": -0.1}, "delay .* 0 or more"),
        ({"blend": 2.0}, "blend .* at most 1"),
        ({"tip": 2.0}, "tip .* at most"),
        ({"rotors": 1}, "rotors must be true or false, got 1"),
        ({"stall": 50}, "stall .longest time at the limit. .* at most 10 s, got 50"),
        ({"board": "uno"}, "board must be one of"),
        ({"edges": 3}, r"edges .* must be one of .1, 2, 4., got 3"),
        ({"edges": 2}, "this board count all four edges .* counts = 4244.4"),
        ({"name": ""}, "name must"),
        ({"motor_channels": [3, 3]}, "motor_channels must be two different"),
        ({"encoder_polarities": [1, 2]}, "encoder_polarities must be 1 or -1"),
        ({"battery": [9.0]}, "battery must be two voltages"),
        ({"nominal": 12.0}, "nominal = 12 V must lie within battery"),
    ],
)
def test_a_wrong_key_is_named_with_what_it_must_be(change, words, tmp_path):
    with pytest.raises(ValueError, match=words):
        Robot.of(table(THESIS) | change)


@pytest.mark.parametrize(
    "key", [x.name for x in fields(Robot) if x.name not in OPTIONAL]
)
def test_a_missing_key_is_named(key):
    with pytest.raises(ValueError, match=key):
        Robot.of({k: v for k, v in table(THESIS).items() if k != key})


def test_a_key_that_no_program_would_read_is_refused():
    with pytest.raises(ValueError, match="mount: no program for board"):
        GEARS.but(mount=0.1)
    with pytest.raises(ValueError, match="isn't TOML"):
        Robot.read(DATA / "body.csv")


def test_another_clock_keeps_the_estimates_memory():
    assert GEARS.but(T=0.01).blend == pytest.approx(2 * GEARS.blend)
    assert GEARS.but(T=0.01, blend=0.1).blend == 0.1


# The robot behind the logs


def test_foreign_logs_need_a_description(tmp_path):
    body, wheels = (DATA / f"{x}.csv" for x in ("body", "wheels"))
    assert described(None, (body, wheels)) == THESIS
    assert described({"M_b": 0.3}, (body, wheels)) == THESIS.but(M_b=0.3)
    changed = tmp_path / "body.csv"
    changed.write_text(body.read_text("utf-8") + "60,0,0.01\n", "utf-8")
    for given in (None, {"M_b": 0.3}):
        with pytest.raises(ValueError, match="must be described.*robot.toml"):
            deploy(changed, wheels, given)
    assert described(GEARS, (changed, wheels)) == GEARS
    assert described(DATA / "thesis.toml", (changed, wheels)) == THESIS


def test_the_places_of_the_files():
    assert _places(["a.toml", "b", "w", "f"]) == ("a.toml", "b", "w", "f")
    assert _places(["b", "w"]) == (None, "b", "w", "deployment")
    assert _places([])[1:3] == (DATA / "body.csv", DATA / "wheels.csv")
    for bad in (["a.toml"], ["b"], ["a.toml", "b"], ["b", "w", "f", "g"]):
        with pytest.raises(ValueError, match="give robot.toml"):
            _places(bad)


# Every key arrives


def truth(robot):
    """A plausible pendulum of this description: two gear motors.

    Stall torque 0.3 N m a motor at 12 V, 10 rad/s per volt... in SI:
    e and f of both motors; the rotors' inertia through the gears.
    """
    e, f, J = 0.10, 0.045, 4e-4
    I_w = (J + robot.M_w * robot.r**2) / 2
    b, d = robot.M_b * robot.l * robot.r, robot.M_b * robot.g * robot.l
    a = robot.r**2 * (robot.M_b + 2 * robot.M_w) + 2 * I_w
    return Mip(a, b, 1.4 * robot.M_b * robot.l**2, d, e, f, I_w=I_w, J=J)


def record(robot, folder, amplitude=4.0):
    """The logs of the two experiments, with noise and counts."""
    mip, random = truth(robot), np.random.default_rng(12)
    rate = 1 / robot.T
    t, V = chirp(0.5, 12, 10, rate, amplitude)
    _, w = motion(-mip.e / mip.c, mip.f / mip.c, mip.d / mip.c, V, robot.T, steps=6)
    gyro = w + 0.01 + 0.002 * random.standard_normal(len(t))
    body = Log(t, V, gyro=np.round(gyro, 4))
    t, V = chirp(0.3, 20, 10, rate, amplitude)
    q, _ = motion(
        mip.e / (2 * mip.I_w), mip.f / (2 * mip.I_w), 0.0, V, robot.T, steps=6
    )
    counts = np.floor(q * robot.counts / (2 * np.pi) + random.random())
    logs = body, Log(t, V, encoder1=counts, encoder2=counts - 3)
    for log, name in zip(logs, ("body.csv", "wheels.csv")):
        log.write(folder / name)


#: Another value of each key, and which files' code it changes, all comments and notes
#: left out.
CHANGES = dict(M_b=0.28, l=0.041, r=0.033, M_w=0.03, g=9.81, gyro_range=17.5, limit=6.5)
CHANGES |= dict(rotors=True, friction=True, delay=0.008, jitter=0.001, blend=0.006)
CHANGES |= dict(tip=0.8, compensation=0.25, law="observer", missing=0.04, frozen=0.14)
CHANGES |= dict(stall=0.7, deaf=0.14, late=0.2)
CHANGES = {key: (value, {LAW}) for key, value in CHANGES.items()} | {
    "name": ("other", set()),
    "counts": (2100.0, {RC, PYCTRL}),
    "free_rpm": (300.0, set()),
    "ten_swings": (6.0, set()),
    "T": (0.005, {LAW, PINS, PYCTRL}),
    "backlash_deg": (1.5, set()),
    "mount": (0.5, {RC, PYCTRL}),
    "nominal": (7.3, {PINS, PYCTRL}),
    "battery": ((5.5, 8.9), {PINS}),
    "motor_channels": ((1, 4), {PINS}),
    "motor_polarities": ((-1, 1), {PINS, PYCTRL}),
    "encoder_channels": ((1, 4), {PINS}),
    "encoder_polarities": ((-1, 1), {PINS, PYCTRL}),
}


def code(path):
    """Without comments, docstrings, decimals beside numbers."""
    found = path.read_text("utf-8")
    if path.suffix == ".py":
        found = re.sub(r'""".*?"""', "", found, flags=re.S)
        return re.sub(r"#.*", "", found)
    return re.sub(r"/\*.*?\*/", "", found, flags=re.S)


def exact_data(name):
    """Whether a file is a proof or its checker, which no robot's words are in.

    A proof holds the exact numbers of its LMIs, any digits among them, the
    model has numbers that are read back, and the checker is the same file for
    all robots.
    """
    return name.startswith(("proof_", "model_", "program_")) or name == "check_proof.py"


def wordless(name):
    """Whether a file has no robot's words: exact data, or the C of all robots."""
    same = r"balance(_single|_stand)?(_steer|_tick|_run)?\.[ch]"
    return exact_data(name) or bool(re.fullmatch(same, name))


@cache
def deployed():
    """The deployment of the thesis's robot, which several files of tests look at."""
    logs = DATA / "body.csv", DATA / "wheels.csv"
    return once("the thesis's robot", lambda: deploy(*logs))


@pytest.fixture(scope="module")
def base():
    return deployed()


@pytest.fixture(scope="module")
def theirs(base, tmp_path_factory):
    """The files of the thesis's robot."""
    return written(base, tmp_path_factory.mktemp("thesis"))


def told(base, robot):
    """The same design of a robot that is described otherwise.

    What simulations say stands in comments, which `code` leaves out.
    """
    found = replace(base, robot=robot)
    return spared(found, design=base.design, delayed=base.delayed)


def bare(found):
    """A deployment without sampled proofs, which take seconds: nothing is lacking."""
    if found.steering:
        spared(found.steering, sampled={}, unequal=())
    return spared(found, lacking=(), sampled={})


def written(found, folder):
    """What `write` writes, whatever is proven."""
    found = bare(copy(found))
    return {path.name: path for path in found.write(folder)}


def test_the_list_of_keys_is_whole():
    keys = {x.name for x in fields(Robot)} - {"edges"}  # see test_mip_counts
    assert keys - set(STEERED) == set(CHANGES) | {"board"}
    assert keys > set(STEERED) == {"track", *STEERING}


@pytest.fixture(scope="module")
def steered(base, tmp_path_factory):
    """The thesis's robot that steers, and its files."""
    robot = THESIS.but(track=0.07)
    found = told(base, robot)
    files = written(found, tmp_path_factory.mktemp("steered"))
    law = {x: getattr(found.steering, x) for x in ("_chosen", "certificate", "held")}
    return robot, files, law


@pytest.mark.parametrize("key", STEERED)
def test_each_key_of_steering_arrives_where_it_belongs(key, base, steered, tmp_path):
    change, arrives = STEERED[key]
    first, files, known = steered
    robot = first.but(**{key: change})
    new = told(base, robot)
    if key in ("steering", "unequal"):  # which its law isn't chosen by
        spared(new.steering, **known)
    files = files, written(new, tmp_path)
    before, after = ({name: code(path) for name, path in x.items()} for x in files)
    assert set(before) == set(after)
    whole = {LAW, RC, PYCTRL}
    balance = [x[LAW].partition("#define BALANCE_SHARE")[0] for x in (before, after)]
    assert balance[0] == balance[1]
    assert {name for name in whole if before[name] != after[name]} == arrives
    said = f"{key} = " + robot.words.split(f"{key} = ")[1].split(",")[0]
    for name in whole:
        text = re.sub(r"^ \*", "", files[1][name].read_text("utf-8"), flags=re.M)
        assert said in " ".join(text.split()), name


#: The fits take these, the proofs the next ones: both take their time.
FITTED = tuple(THESIS.identification)
CHAINED = "T", "law"


@pytest.mark.parametrize("key", FITTED)
def test_each_key_of_the_fit_changes_the_robot(key):
    """Of three seconds of the logs: a fit with friction takes half a minute of all."""
    whole = [Log.read(DATA / f"{name}.csv") for name in ("body", "wheels")]
    logs = [log.part(slice(300)) for log in whole]
    robots = THESIS, THESIS.but(**{key: CHANGES[key][0]})
    one, other = (identify(*logs, **robot.identification).mip for robot in robots)
    assert one != other


@pytest.mark.parametrize(
    "key",
    [
        pytest.param(key, marks=pytest.mark.slow) if key in CHAINED else key
        for key in CHANGES
        if key == "counts" or key not in FITTED
    ],
)
def test_each_key_arrives_where_it_belongs(key, base, theirs, tmp_path):
    robot = THESIS.but(**{key: CHANGES[key][0]})
    found = told(base, robot)
    if key in CHAINED:
        found = replace(base, robot=robot)
    spared(found)
    ours = written(found, tmp_path / "new")
    changed = {
        name
        for name in theirs
        if name in ours and code(ours[name]) != code(theirs[name])
    }
    assert {LAW, RC, PINS, PYCTRL} & changed == (CHANGES[key][1] & set(ours))
    assert Model.read(ours["model_balance.json"]).robot == timed(robot, found.mip)
    said = f"{key} = " + robot.words.split(f"{key} = ")[1].split(",")[0]
    for name, path in ours.items():  # and every file of words says it
        if wordless(name):
            continue
        # a comment's margin and line breaks are no part of what it says
        plain = " ".join(
            re.sub(r"^ \*", "", path.read_text("utf-8"), flags=re.M).split()
        )
        if path.suffix == ".json":
            plain = plain.encode().decode("unicode_escape")
        assert said in plain, path.name


SECOND = six_robots.ALL["Balboa-like"]


@pytest.fixture(scope="module")
def second(tmp_path_factory):
    """A robot whose logs are by somebody else's equations, end to end, by the command;
    it has rotors on its body."""
    folder = tmp_path_factory.mktemp("second")
    board = dict(board="beaglebone", mount=0.1, nominal=5.7, battery=(4.8, 6.6))
    board |= dict(motor_channels=(3, 2), motor_polarities=(-1, 1))
    board |= dict(encoder_channels=(3, 2), encoder_polarities=(1, -1))
    wired = by_its_sheet(SECOND, friction=False, **board)
    (folder / "robot.toml").write_text(text(wired), "utf-8")
    body, wheels = six_robots.logs(SECOND, seconds=6.0)
    six_robots.write(folder / "body.csv", "t,V,gyro", body)
    six_robots.write(folder / "wheels.csv", "t,V,encoder1,encoder2", wheels)
    names = "robot.toml", "body.csv", "wheels.csv", "out"
    with pytest.MonkeyPatch.context() as patch:  # a minute's rest: tests/test_mip_rest
        patch.setattr("sosbook.pendulum.proven.REST_SECONDS", 6.0)
        patch.setattr("sosbook.pendulum.tuning.QUIET_SECONDS", 6.0)
        return wired, folder, main([str(folder / name) for name in names])


@pytest.mark.slow
def test_a_second_robot_end_to_end(second):
    robot, folder, found = second
    assert found.proven
    assert found.sensitivity <= 2
    ratios, real = found.identified.ratios, pendulum(SECOND)
    for (name, value), sd in zip(ratios.items(), widened(found.identified)):
        true = SECOND.truth[name]
        assert abs(value - true) < 3.5 * sd + 5e-4 * true, name
    for letter in (*"abcdef", "J"):
        value = getattr(real, letter)
        assert getattr(found.mip, letter) == pytest.approx(value, rel=0.02), letter
    out = {path.name: path.read_text("utf-8") for path in (folder / "out").iterdir()}
    model = Model.read(folder / "out")
    robot = timed(robot, found.mip)
    assert (model.mip, model.robot, model.spread) == (found.mip, robot, found.spread)
    assert "#define COUNTS 1212.0" in out["rc_balance.c"]
    assert "BOARD_MOUNT_ANGLE 0.1 " in out["rc_balance.c"]
    assert "MOTOR_POLARITY[2] = {-1, 1};" in out[PINS]
    assert "#define RATE_HZ 200" in out[PINS]
    assert "COUNTS = 1212.0" in out["pyctrl_balance.py"]
    assert "MOTOR_POLARITY = (-1, -1)" in out["pyctrl_balance.py"]
    assert f"BALANCE_LIMIT {(6.0).hex().replace('.8000000000000', '.8')}" in out[LAW]
    for name, words in out.items():  # nothing of the thesis's robot
        if exact_data(name):
            continue
        assert not re.search(r"2122|2134|35\.577|0\.49\b|7\.4 V|0\.272", words), name
        plain = " ".join(re.sub(r"^ \*", "", words, flags=re.M).split())
        assert "counts = 1212 a turn" in plain or wordless(name), name


@pytest.mark.slow
def test_an_observer_is_written_with_the_proofs_of_its_clocks(second):
    """Without being asked for; and the compiled program stands by its robot's own
    equations."""
    _, folder, found = second
    said, out = found.facts["proof of the sampled loop"], folder / "out"
    assert "constant delays 0, 1, 2 ms; and each of 5 robots" in said
    assert "sequence of delays from 0 to 2 ms and of ticks from 4.5 to 5.5 ms" in said
    assert "That isn't proven of robots between these: patience" in said
    clocks = "every sequence of sampling intervals in [0.0045, 0.0055] s and delays in"
    assert len(found.varying_robots) == 5
    for k, proof in enumerate(found.varying_robots, 1):
        assert proof.proven and clocks in proof.claims[0]
        assert load(out / f"proof_balance_varying_{k}.json") == proof
    assert len([*out.glob("proof_balance_sampled*")]) == 6
    assert not (out / "proof_balance.json").exists()
    assert not (out / "proof_balance_hold.json").exists()
    text = (out / LAW).read_text("utf-8")
    assert "law = observer" in " ".join(text.replace(" * ", "").split())
    if find() is None:
        refuse()
    program = Compiled(found.firmware)
    tilts, fault = six_robots.stand(SECOND, program, SECOND.V_n, seconds=10.0)
    assert fault == 0 and abs(tilts).max() < 0.5
    assert abs(tilts[len(tilts) // 2 :]).max() < np.deg2rad(3)
    stand = found.bench_firmware.law.D[0]
    assert stand[0] > 0 < stand[2] and not stand[[1, 3]].any()


def test_a_board_of_ones_own_gets_the_law_alone(base, tmp_path):
    robot = GEARS.but(T=0.01, delay=0.01, blend=0.005, jitter=0.0, law="gain")
    names = written(told(base, robot), tmp_path)
    assert not any(name.startswith(("rc_", "pyctrl")) for name in names)
