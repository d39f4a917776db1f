"""A robot at rest is quiet, and a program stands whatever happens to its robot."""

from dataclasses import replace
from functools import cache
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from sosbook.pendulum import Firmware, recommend
from sosbook.pendulum.compiled import Compiled
from sosbook.pendulum.deployment import Deployment
from sosbook.pendulum.fit import Fit
from sosbook.pendulum.optimal import optimal_law
from sosbook.pendulum.rest import Gears, volts_at_rest
from tests.cases import examples, later
from tests.compiler import find, refuse
from tests.geared_robots import ALL, KINDS, stand
from tests.six_robots import by_its_sheet, pendulum, spared

REST = examples(10.0, 20.0)  # s


@pytest.fixture(autouse=True)
def briefly(monkeypatch):
    """A sixth or a third of a minute's rest is as loud."""
    monkeypatch.setattr("sosbook.pendulum.proven.REST_SECONDS", REST)
    monkeypatch.setattr("sosbook.pendulum.tuning.QUIET_SECONDS", REST)


def asked(geared, law=None):
    """The description of a machine with play, and its pendulum."""
    more = dict(law=law, backlash_deg=geared.play, friction=False)
    return pendulum(geared), by_its_sheet(geared, **more)


@cache
def quiet(name):
    """A machine's deployment, its R chosen with its play."""
    mip, robot = asked(ALL[name])
    return recommend(mip, R=None, robot=robot)


def loud(geared, law, robot):
    """The share of the limit that another simulator sees at rest."""
    program = Firmware.of(law, robot).controller()
    tilts, volts, _, fault = stand(geared, program, seconds=1.2 * REST, seed=1)
    tilts, volts = (x[len(x) // 3 :] for x in (tilts, volts))
    assert fault == 0 and abs(tilts - tilts.mean()).max() < np.radians(3)
    return float(np.sqrt(np.mean(volts**2))) / robot.limit


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_robots_of_all_kinds_are_quiet(name):
    """By equations, teeth, a driver and sensors that aren't the package's."""
    robot, found = asked(ALL[name])[1], quiet(name)
    assert found.robot.law == "observer" and found.proven
    assert found.sensitivity <= 2 and found.rest <= 0.1 * robot.limit
    spared(found, rest=found.rest)
    assert loud(ALL[name], found.law, found.robot) < 0.1
    assert "warning, at rest" not in found.facts and "law" not in found.facts
    assert f"{robot.backlash_deg:g} degrees of play" in found.facts["at rest"]


#: That of least room for the gate; the others once a week.
TIGHT = [("gear motors 200 Hz", 0.5)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, share",
    [
        pytest.param(*x, marks=[pytest.mark.campaign] * (x not in TIGHT))
        for x in product(ALL, (0.5, 1.0, 2.0))
    ],
)
def test_no_robot_is_louder_than_what_is_said(name, share):
    """By dry gears that stick and a bridge with a dead zone: 2.4 times as loud."""
    machine = replace(ALL[name], friction=share * ALL[name].friction)
    law, robot = quiet(name).law, quiet(name).robot
    rub = 0.9 * machine.friction, 1.1 * machine.friction
    gears = replace(Gears.of(None, robot), frictions=rub)
    said = volts_at_rest(asked(machine)[0], law, robot, REST, gears) / robot.limit
    heard = loud(machine, law, robot)
    assert heard <= said < 2 * heard


def test_friction_and_play_are_those_of_the_fits():
    """Of both logs, 1.96 deviations either way; a play may be described, too."""
    robot = asked(ALL["tele"])[1]
    known = {("e_c", "friction"): (9, 0.1), ("e_a", "play"): (9, 1)}
    fits = [
        Fit(names, np.array(values), np.eye(2) * 0.01, np.zeros(3))
        for names, values in known.items()
    ]
    found = SimpleNamespace(body=fits[0], wheels=(fits[1], fits[0]))
    gears = Gears.of(found, robot)
    assert gears.frictions == pytest.approx((0, 0.296), abs=1e-3)
    assert gears.play == pytest.approx(1.196, abs=1e-3)
    robot = robot.but(compensation=0.3, backlash_deg=2.0)
    assert Gears.of(None, robot) == Gears((0.3, 0.3), np.radians(2.0))


@pytest.mark.slow
def test_play_asks_for_a_larger_weight_than_the_peak_does():
    """The smallest weight that keeps the peak hammers the gears, as both see."""
    mip, robot = asked(ALL["gear motors 200 Hz"])
    stiff = robot.but(backlash_deg=0.0, law="observer")
    sharp = recommend(mip, R=None, robot=stiff)
    mild = quiet("gear motors 200 Hz")
    assert mild.design.R > sharp.design.R
    assert loud(ALL["gear motors 200 Hz"], sharp.law, sharp.robot) > 0.2
    hammered = replace(mild, R=sharp.design.R)
    spared(hammered, sampled={}, rest=hammered.rest)
    assert "chatter" in hammered.facts["warning, at rest"]


@pytest.mark.campaign  # in the gate test_mip_six_robots has a gain that shakes motors
def test_a_gain_is_loud_where_an_observer_is_quiet():
    mip, robot = asked(ALL["8 kg"], law="gain")
    gain = recommend(mip, R=0.2, robot=robot)
    assert loud(ALL["8 kg"], gain.law, gain.robot) > 0.3
    vars(gain).update(sampled={}, delayed=None)
    assert gain.rest > 0.1 * robot.limit


def test_what_falls_is_as_loud_as_can_be():
    mip, robot = asked(ALL["tele"])
    law = optimal_law(mip, robot, np.eye(5), 1.0).law
    far = replace(mip, d=30 * mip.d)
    assert volts_at_rest(far, law, robot, 3.0, Gears()) == robot.limit


@pytest.mark.slow
def test_the_gain_stands_in_for_an_observer_that_is_not_proven(monkeypatch):
    """The header says so; where the description asks for a law it is that law."""
    mip, robot = asked(ALL["gear motors 200 Hz"])
    why, shy = "sampled, 0 ms late: undecided", ["observer"]

    def lacking(self):
        return [why] if self.robot.law in shy else []

    monkeypatch.setattr(Deployment, "lacking_sampled", property(lacking))
    found = recommend(mip, R=20.0, robot=robot)
    assert found.robot.law == "gain" and found.proven
    words = f"gain, since of the observer it is said: {why}"
    spared(found, sampled={}, held=found.certificate)
    assert found.facts["law"] == words
    seeing = recommend(mip, R=20.0, robot=robot.but(law="observer"))
    assert seeing.robot.law == "observer" and seeing.lacking == (why,)
    shy.append("gain")  # no gain is proven either
    assert recommend(mip, R=20.0, robot=robot).robot.law == "observer"


# Programs as they are compiled, on robots as they are

UPRIGHT = np.radians(5)  # about where the robot rests, in the run's last third
#: What happens, and what else is wrong with the robot; one that is picked up is off.
STORIES = {
    "a slope": (dict(slope=np.radians(4)), {}),
    "a push": (dict(shove=(0.15, 6.0, 6.15)), {}),
    "an empty battery": (dict(tilt=0.1), dict(battery=0.75, sag=0.08)),
    "a board that is askew": (dict(tilt=0.1), dict(askew=0.08, gyro=0.97)),
    "a bus that loses samples": (dict(tilt=0.1, dropouts=0.04), {}),
    "a bridge that sleeps": (dict(tilt=0.1), dict(dead=0.05, bits=100)),
    "a hand": (dict(lift=(5.0, 12.0)), {}),
}


@cache
def standing(name):
    """The law of a robot of the tests, by its own numbers."""
    return Firmware.of(quiet(name).law, quiet(name).robot)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, story",
    [  # with the slowest clock and the coarsest counts; the others once a week
        *product(["lego"], STORIES),
        *later(*product(["n20", "hub"], STORIES)),
    ],
)
def test_a_program_stands_or_turns_its_motors_off(name, story):
    events, flaws = STORIES[story]
    machine = replace(ALL[name], **flaws)
    if find() is None:
        refuse()
    tilts, volts, turns, fault = stand(machine, Compiled(standing(name)), **events)
    if story == "a hand":
        assert fault and volts[-1] == 0
        return
    late = tilts[2 * len(tilts) // 3 :]
    assert fault == 0 and abs(volts).max() <= machine.V_n * (1 + 1e-6)
    assert abs(late - late.mean()).max() < UPRIGHT
    assert abs(turns[-1] - turns[len(turns) // 2]) < 2 * np.pi
