"""Logs that no working robot writes are refused, each with its reason."""

import re
from dataclasses import replace
from pkgutil import resolve_name

import numpy as np
import pytest

from sosbook.pendulum import deployment
from sosbook.pendulum.command import main
from sosbook.pendulum.fit_checks import check_fits, lateness
from sosbook.pendulum.gate import Inspection, check_log, refused, widened
from sosbook.pendulum.identify import fit_body, identify
from sosbook.pendulum.log import Log
from sosbook.pendulum.recorded import check_recording
from sosbook.pendulum.report import page
from sosbook.pendulum.rig import COUNTS_PER_TURN, DATA, Rig, shipped
from tests.cases import campaign
from tests.corrupted import SPOILT
from tests.six_robots import SIX, balancing, by_its_sheet, spared
from tests.six_robots import logs as record_six
from tests.test_mip_robot import GEARS, THESIS, record

pytestmark = pytest.mark.slow  # each log is identified


def once(function):
    """A function of logs and fits that answers once; arrays follow from these."""
    known = {}

    def answer(*given, **more):
        key = *(x for x in given if not isinstance(x, np.ndarray)), *more.items()
        if key not in known:
            known[key] = function(*given, **more)
        return known[key]

    return answer


@pytest.fixture(scope="module", autouse=True)
def fitted_once():
    """A log is fitted and examined once, also where the other one is spoilt."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("identify.fit_body", "identify.fit_wheel",
                     "fit_checks.lateness", "fit_checks.wheel_lateness"):  # fmt: skip
            place = f"sosbook.pendulum.{name}"
            patch.setattr(place, once(resolve_name(place)))
        yield


@pytest.fixture(scope="module")
def robots(tmp_path_factory):
    """Description and logs of the thesis's robot and a second one."""
    folder = tmp_path_factory.mktemp("gears")
    record(GEARS, folder)
    names = "body", "wheels"
    return {
        "thesis": (THESIS, *(half(shipped(x)) for x in names)),
        "gears": (GEARS, *(half(Log.read(folder / f"{x}.csv")) for x in names)),
    }


def half(log):
    """The sweep of a log, without the way back."""
    return log.part(slice(len(log.t) // 2))


@pytest.mark.parametrize("which", ["thesis", "gears"])
def test_good_logs_pass_without_a_word(which, robots):
    robot, body, wheels = robots[which]
    seen = Inspection.of(body, wheels, robot)
    assert seen.findings == ()
    assert "Nothing speaks against" in page(seen)
    assert page(seen).count("<svg") == 6


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    "name, which",
    [  # by turns; the other halves once a week
        pytest.param(name, which, marks=[pytest.mark.campaign] * ((k + n) % 2))
        for k, name in enumerate(SPOILT)
        for n, which in enumerate(("thesis", "gears"))
    ],
)
def test_spoilt_logs_are_refused_with_the_reason(
    name, which, robots, monkeypatch, pytestconfig
):
    """Fits with friction beside them are in the campaign: they are a hint alone."""
    if not pytestconfig.getoption("--campaign"):
        monkeypatch.setattr("sosbook.pendulum.gate._rubbing", lambda *_: ())
    robot, body, wheels = robots[which]
    spoil, words = SPOILT[name]
    seen = Inspection.of(*spoil(body, wheels), robot)
    assert refused(seen.findings), seen.findings
    assert re.search(words, seen.refusal), seen.refusal
    assert 'class="refused"' in page(seen)


def test_friction_is_tried_where_gears_rub(robots):
    """Both are told, and those with friction are the robot's."""
    robot = robots["thesis"][0]
    rig = Rig(friction=0.3, seconds=4.0)
    logs = rig.body(), rig.wheels()
    seen = Inspection.of(*logs, robot)
    (told,) = [x.text for x in seen.findings if "with friction = true" in x.text]
    found = dict(re.findall(r"(\w/\w) = (\S+) instead", told))
    for name, value in rig.ratios.items():
        mine = float(found[name.replace("_", "/")])
        assert mine == pytest.approx(value, rel=0.02)
        assert name[0] != "f" or abs(seen.identified.ratios[name] / value - 1) > 0.05
    again = Inspection.of(*logs, robot.but(friction=True))
    assert not any("friction = true" in str(x) for x in again.findings)


@pytest.mark.parametrize("drive", [0.0, 1.5])
@pytest.mark.parametrize("k", [0, 2, 5, *campaign([1, 3, 4, 6])])
def test_a_log_of_a_robot_that_balances_is_called_that(k, drive):
    """Upright and in a loop, driving or not, its gyro in another unit or reversed; a
    fit of its wheels looks good, and is of another inertia.
    """
    t, V, gyro, counts = balancing(SIX[k], drive, seed=k)
    robot = by_its_sheet(SIX[k], friction=False)
    for unit in (1.0, -1.0, np.degrees(1)):
        body = Log(t, V, gyro=unit * gyro)
        words = [str(x) for x in refused(check_log("body", body, robot))]
        assert "does the robot balance?" in words[0]
        fast = abs(body.gyro).max() > 1.01 * robot.gyro_range
        assert fast == any("rad/s. Is it in deg/s?" in x for x in words)
    log = Log(t, V, encoder1=counts)
    assert "does the robot balance?" in str(refused(check_log("wheels", log, robot))[0])


def test_a_log_that_balances_says_no_more_than_that(tmp_path):
    t, V, gyro, _ = balancing(SIX[3])
    Log(t, V, gyro=gyro).write(tmp_path / "body.csv")
    (told,) = refused(check_recording(tmp_path / "body.csv").findings)
    assert "does the robot balance?" in told.text


@pytest.mark.parametrize("hold", [5, 40])
def test_steps_are_no_controllers(hold, robots):
    """Random ones that no sensor makes are as good as a sweep, and so is one that a
    voltmeter measures.
    """
    rng = np.random.default_rng(hold)
    V = np.repeat(rng.uniform(-3, 3, 2000 // hold), hold)
    t = 0.01 * np.arange(len(V))
    assert refused(check_log("body", Log(t, V, gyro=np.sin(t)))) == []
    robot, body, wheels = robots["thesis"]
    for name, log in (("body", body), ("wheels", wheels)):
        V = log.V + 0.01 * log.V.std() * rng.standard_normal(len(log.V))
        assert refused(check_log(name, replace(log, V=V), robot)) == []


def test_a_gyro_in_degrees_is_asked_about(robots):
    """Also where the gears or the motors are blamed."""
    body = robots["thesis"][1].part(slice(1500))
    with pytest.raises(ValueError, match="does the robot balance, or a cont") as error:
        fit_body(replace(body, gyro=-np.degrees(body.gyro)))
    assert re.search(r"gyro reads \S+ rad/s: is it in deg/s\?", str(error.value))


def test_a_slow_log_in_degrees_a_second_is_recognised(robots):
    """No rate in it is too fast for a robot; that of the wheels tells."""
    robot, body, wheels = robots["thesis"]
    slow = replace(body, V=0.05 * body.V, gyro=np.degrees(0.05 * body.gyro))
    assert abs(slow.gyro).max() < 60
    both = identify(slow, wheels, robot.counts), slow, wheels, robot
    told = [str(x) for x in refused(check_fits(*both))]
    assert any("is the gyro in deg/s?" in x for x in told)


@pytest.mark.parametrize("factor, severity", [(1.1, "warning"), (0.5, "refused")])
def test_wrong_counts_are_told_and_refused_where_they_are_far_off(
    factor, severity, robots
):
    robot, body, wheels = robots["thesis"]
    seen = Inspection.of(body, wheels, robot.but(counts=factor * COUNTS_PER_TURN))
    told = [f.severity for f in seen.findings if "wrong counts per turn" in str(f)]
    assert told == [severity]
    assert bool(refused(seen.findings)) == (severity == "refused")


@pytest.mark.parametrize("which", ["thesis", "gears"])
@pytest.mark.parametrize(
    "change", [{"M_b": 1e-3}, {"M_b": 1e-2}, {"M_w": 1e2}], ids=str
)
def test_wheels_that_no_material_makes_are_refused(change, which, robots):
    """Masses a thousand times too small or large tell of another robot."""
    robot, body, wheels = robots[which]
    (name, factor), *_ = change.items()
    wrong = robot.but(**{name: factor * getattr(robot, name)})
    seen = Inspection.of(body, wheels, wrong)
    assert refused(seen.findings), seen.findings
    assert "check M_b, M_w and r" in seen.refusal
    assert "np.float64" not in seen.refusal


def test_force_goes_on_and_every_file_says_so(tmp_path, capsys, monkeypatch):
    """The gyro's range is half of what the log shows."""
    made = deployment.recommend

    def forced(*given, **asked):
        return spared(made(*given, **asked), sampled={}, lacking=())

    for name in ("body", "wheels"):
        shipped(name).part(slice(1500)).write(tmp_path / f"{name}.csv")
    paths = DATA / "thesis.toml", *(tmp_path / x for x in ("body.csv", "wheels.csv"))
    asked = [*map(str, paths), str(tmp_path / "out"), "--gyro_range", "5"]
    with pytest.raises(SystemExit):
        main(asked)
    assert "gyro_range = 5 rad/s" in capsys.readouterr().err
    (page,) = (tmp_path / "out").iterdir()
    assert page.name == "identification.html"  # the reason, and no program
    monkeypatch.setattr(deployment, "recommend", forced)
    monkeypatch.setattr("sosbook.pendulum.gate._rubbing", lambda *_: ())
    found = main([*asked, "--force", "--R", "50"])
    assert "FORCED" in found.facts["warning 1"]
    for name in ("balance_gains.h", "rc_balance.c", "pyctrl_balance.py"):
        assert "FORCED" in (tmp_path / "out" / name).read_text("utf-8")


def test_the_intervals_hold_what_the_two_wheels_disagree_by(robots):
    robot, body, wheels = robots["thesis"]
    found = identify(body, wheels, **robot.identification)
    sd = dict(zip(found.ratios, widened(found)))
    for name in ("e_a", "f_a"):
        for fit in found.wheels:
            assert abs(fit[name] - found.ratios[name]) <= 1.001 * sd[name]
    middle = found.mip.e / found.mip.c
    assert abs(middle - found.ratios["e_c"]) <= 1.01 * sd["e_c"]


# Time stamps


def uneven(log, share, seed=1):
    """Every sample at its own time: of what happened, recorded so."""
    random = np.random.default_rng(seed)
    return log.t + share * log.T * random.uniform(-1, 1, len(log.t))


def test_uneven_time_stamps_are_used_as_they_are():
    """A rig whose clock jitters by 30 %, and the same logs pretending
    that it doesn't: worse by far."""
    from sosbook.pendulum.experiments import motion

    rig = Rig(seconds=12.0)
    x, random = rig.ratios, np.random.default_rng(4)
    logs, flat = [], []
    for log, e, d in ((rig.body(), -x["e_c"], x["d_c"]), (rig.wheels(), x["e_a"], 0.0)):
        t = uneven(log, 0.3)
        f = x["f_c"] if d else x["f_a"]
        q, w = motion(e, f, d, log.V, np.append(np.diff(t), log.T), steps=8)
        columns = {"encoder1": np.floor(q * COUNTS_PER_TURN / (2 * np.pi))}
        if d:
            columns = {"gyro": w + 0.002 * random.standard_normal(len(t))}
        logs.append(Log(t, log.V, **columns))
        flat.append(Log(log.t, log.V, **columns))
    assert not logs[0].even and flat[0].even
    found, wrong = identify(*logs), identify(*flat)
    for name, value in x.items():
        assert found.ratios[name] == pytest.approx(value, rel=2e-3), name
    assert wrong.body.rms > 10 * found.body.rms
    seen = Inspection.of(*logs, THESIS)
    assert not seen.findings


def test_a_linear_fit_of_uneven_samples_is_refused():
    from sosbook.pendulum.identify import fit_body, fit_wheel

    body, wheels = shipped("body"), shipped("wheels")
    body = replace(body, t=uneven(body, 0.2))
    wheels = replace(wheels, t=uneven(wheels, 0.2))
    with pytest.raises(ValueError, match="needs model='pendulum'"):
        fit_body(body, "linear")
    with pytest.raises(ValueError, match="differencing='modelled'"):
        fit_wheel(wheels, 1, "plain")


@pytest.mark.parametrize("name, k", [("tall and thin", 1), ("gear motors 100 Hz", 0)])
def test_gears_that_rub_are_not_taken_for_a_late_gyro(name, k):
    """Nor does a large swing hide or feign a sample."""
    (machine,) = (m for m in SIX if m.name == name)
    rubs = replace(machine, friction=0.04 * machine.V_n)
    (t, V, gyro), _ = record_six(rubs, seconds=5.0)
    gyro = np.concatenate([np.full(k, gyro[0]), gyro[: len(gyro) - k]])
    log = Log(t, V, gyro=gyro)
    assert lateness(fit_body(log, friction=True), log) == k
