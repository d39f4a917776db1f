"""Tick logs of running programs, and what they say of the robot."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import fsolve

from sosbook.book import thesis
from sosbook.pendulum import Firmware, Robot, SampledLaw
from sosbook.pendulum.command import main
from sosbook.pendulum.comparison import compare
from sosbook.pendulum.drive import Drive
from sosbook.pendulum.modelled import Model
from sosbook.pendulum.ticks import FORMATS, START, TickLog
from tests import test_mip_export as programs
from tests.cases import campaign
from tests.gains import named
from tests.six_robots import SIX, advance, pendulum
from tests.turning import ramp

MACHINE = SIX[0]


MODEL = Model(
    pendulum(MACHINE),
    Robot.shipped("thesis").but(counts=MACHINE.counts, delay=0.005, jitter=0.0005),
    0.04,
    SampledLaw.of_gain(named(thesis.mip().pid[5]), MACHINE.T),
)


def run(machine=MACHINE, late=0.003, seconds=24.0, drive=6.0, seed=1):
    """What the program logs on a machine; it rolls to and fro."""
    random = np.random.default_rng(seed)
    controller, T = MODEL.firmware.controller(), machine.T
    x, V, now, bias = np.array([0.05, 0, 0, 0]), 0.0, 0.0, 0.008
    turn, half = 2 * np.pi / machine.counts, 2.0
    controller.start(0.05, 0.0, bias)
    rows, points = [[-T, bias, 0, 0.05, 0, 0, 0, 0.05, 7.8, START]], [(0.0, 0.0)]
    limits = Drive(drive, 6.0)
    for k in range(round(seconds / T)):
        at = k * T + 0.0003 * random.random()
        x = advance(machine.rate, x, V, max(at - now, 1e-9), 3)
        gyro = x[2] + bias + 0.002 * random.standard_normal()
        wheels = turn * np.floor((x[1] - x[0]) / turn)
        tilt = x[0] + 0.01 * random.standard_normal()
        wanted = drive if (k * T) % (2 * half) > half else -drive
        points = ramp(limits, wanted, T, 1, points[-1])
        u = float(controller.step(gyro, wheels, tilt, *points[-1])[0])
        fault = int(controller.fault[0])
        theta = float(controller.theta[0])
        rows.append([at, gyro, wheels, tilt, *points[-1], u, theta, 7.8, fault])
        now = at + late
        x, V = advance(machine.rate, x, V, late, 2), u
    return TickLog(*np.array(rows).T)


def first(log, ticks=400):
    """The beginning of a log, too short for a fit."""
    columns = {name: value for name, value in vars(log).items() if value is not None}
    return TickLog(**{name: value[:ticks] for name, value in columns.items()})


@pytest.fixture(scope="module")
def same():
    return compare(run(seconds=16.0), MODEL)


@pytest.mark.slow
def test_the_same_robot_isnt_said_to_be_another(same):
    assert same.within is True
    for name in ("body", "wheels", "back-EMF"):
        assert same.tracking.values[name] == pytest.approx(1, abs=0.02)
    assert same.tracking.values["delay"] == pytest.approx(0.003, abs=4e-4)
    assert same.tracking.values["friction"] < 0.03
    assert [str(f) for f in same.findings] == []


@pytest.mark.slow
def test_friction_is_found():
    found = compare(run(replace(MACHINE, friction=0.4), seconds=14.0), MODEL)
    assert found.tracking.values["friction"] == pytest.approx(0.4, rel=0.1)
    assert "friction, which no proof has" in found.report


@pytest.mark.slow
def test_a_voltage_that_acts_later_than_proven_is_named():
    found = compare(run(late=0.008, seconds=14.0), MODEL)
    assert found.tracking.values["delay"] == pytest.approx(0.008, abs=5e-4)
    assert "after the sample, but delay + jitter = 5.5 ms" in found.report


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.8, *campaign([1.2])])
def test_another_motor_is_outside_of_what_was_proven(share):
    """e and f of both motors: what a change of gears or magnets does."""
    other = replace(MACHINE, stall=share * MACHINE.stall)
    found = compare(run(other, seconds=14.0), MODEL)
    assert found.within is False, found.report
    for name in ("body", "wheels", "back-EMF"):
        assert found.tracking.values[name] == pytest.approx(share, rel=0.03)
    assert "outside of what was proven" in found.report


@pytest.mark.slow
def test_a_robot_that_hardly_moves_leaves_it_open():
    found = compare(run(drive=0.0), MODEL)
    assert found.within is None
    assert "drive it back and forth" in found.report


@pytest.mark.slow
def test_another_program_another_clock_and_an_empty_battery_are_named(same):
    log = first(same.log)
    volts = log.V + 0.1 * (np.arange(len(log.t)) == 300)
    assert "another program ran" in compare(replace(log, V=volts), MODEL).report
    assert "another clock" in compare(replace(log, t=1.1 * log.t), MODEL).report
    late = log.t + 0.002 * (np.arange(len(log.t)) % 9 == 4)
    assert "late by more than jitter" in compare(replace(log, t=late), MODEL).report
    empty = compare(replace(log, battery=0 * log.t + 6.5), MODEL)
    assert "battery sinks to 6.5 V" in empty.report


def test_a_model_survives_its_file(tmp_path):
    (tmp_path / "model_balance.json").write_text(MODEL.text, "utf-8")
    again = Model.read(tmp_path)
    assert again.mip == MODEL.mip and again.robot == MODEL.robot
    assert again.text == MODEL.text
    for bad, words in (("[]", "isn't a model"), ("{", "is no JSON file")):
        (tmp_path / "model_balance.json").write_text(bad, "utf-8")
        with pytest.raises(ValueError, match=words):
            Model.read(tmp_path)
    with pytest.raises(ValueError, match="0 files"):
        Model.read(tmp_path / "..")


@pytest.mark.slow
def test_the_command_writes_a_page(same, tmp_path, capsys):
    same.log.write(tmp_path / "log.csv")
    (tmp_path / "model_balance.json").write_text(MODEL.text, "utf-8")
    found = main(["compare", str(tmp_path / "log.csv"), str(tmp_path)])
    assert found.findings == ()
    for name in FORMATS:
        columns = getattr(found.log, name), getattr(same.log, name)
        assert columns[0] == pytest.approx(columns[1], rel=1e-8, abs=1e-6), name
    # a search ends where its cost changes by 1e-8, far less than a deviation away
    for name, sd in same.tracking.sd.items():
        values = found.tracking.values[name], same.tracking.values[name]
        assert values[0] == pytest.approx(values[1], rel=0, abs=sd / 20), name
    page = (tmp_path / "comparison.html").read_text("utf-8")
    assert page.count("<svg") == 5 and found.verdict in page
    with pytest.raises(SystemExit):
        main(["compare", str(tmp_path / "none.csv"), str(tmp_path)])


def test_the_longest_run_is_read_and_a_torn_last_line_forgiven(tmp_path):
    rows = ["0,0.01,0,0.1,0,0,0,0.1,7,-1", "0.01,0,0,0.1,0,0,1,0.1,7,0"]
    rows += [f"{0.01 * k},0,0,0.1,0,0,1,0.1,nan,0" for k in range(2, 5)]
    other = ["1,0.02,0,0.2,0,0,0,0.2,7,-1", "1.01,0,0,0.1,0,0,1,0.1,7,0"]
    path = tmp_path / "log.csv"
    path.write_text("\n".join([",".join(FORMATS), *rows, *other, "1.02,0"]), "utf-8")
    log = TickLog.read(path)
    assert len(log.t) == 5 and log.gyro[0] == 0.01 and log.running.sum() == 4
    for text, words in (
        ("t,V\n0,1\n", "lacks the column.* wheels, .*battery, fault: .* fault = -1"),
        (",".join(FORMATS) + "\n" + rows[1] + "\n", "no start .*: .* at rest"),
        (",".join(FORMATS) + "\n0,x\n" + rows[1], "line 2"),
    ):
        path.write_text(text, "utf-8")
        with pytest.raises(ValueError, match=words):
            TickLog.read(path)


# The programs that log, and obey


@pytest.mark.slow
def test_librobotcontrols_program_logs_what_it_did(gcc, tmp_path):
    firmware = Firmware(programs.LAWS["PID"], blend=0.02)
    robot = programs.Robot(gcc, tmp_path, firmware, drive=Drive(3.0, 5.0))
    (tmp_path / "speed.txt").write_text("-1.5\n", "utf-8")
    words = str(tmp_path / "log.csv"), str(tmp_path / "speed.txt")
    ticks, _ = robot.live([*programs.REST, *programs.moves(80)], *words)
    log = TickLog.read(tmp_path / "log.csv")
    assert len(log.t) == 81 and np.allclose(np.diff(log.t), 0.01)
    assert np.array_equal(log.replayed(firmware), log.V)
    points = ramp(Drive(3.0, 5.0), -1.5, 0.01, 80)
    assert np.allclose(np.column_stack([log.target, log.rate])[1:], points)
    duties = [left for left, *_ in ticks[101:]]
    drawn = np.clip(log.V[1:] / log.battery[1:], -1, 1)
    assert np.allclose(duties, drawn, rtol=2e-3)
    (tmp_path / "speed.txt").write_text("99\n", "utf-8")  # more than it may
    robot.live([*programs.REST, *programs.moves(80)], *words)
    assert abs(TickLog.read(tmp_path / "log.csv").rate).max() == 3.0


@pytest.mark.parametrize("machine", SIX, ids=lambda machine: machine.name)
def test_a_ramp_leans_the_body_as_far_as_it_is_said(machine):
    """By the machine's own equations, whose rotors turn with the body.

    There is one lean with which its speed grows by the ramp and the body doesn't tip.
    """
    mip = pendulum(machine)
    drive = Drive.of(mip, machine.V_n)
    smooth = replace(machine, friction=0.0)

    def missing(unknown):
        lean, V = unknown
        *_, tips, rolls = smooth.rate([lean, 0.0, 0.0, 0.0], V)
        return tips, rolls - drive.acceleration

    lean, V = fsolve(missing, [0.0, 0.0])
    # the cosine of the lean is .9988, and with J turned it would be off by this:
    assert 2 * mip.J > 0.005 * (mip.a + mip.b - mip.J)
    assert lean == pytest.approx(0.05, rel=2e-3) and V > 0


@pytest.mark.parametrize("bad", [dict(speed=-1.0), dict(acceleration=float("nan"))])
def test_a_drive_that_isnt_one_is_refused(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        Drive(**bad)
