"""Programs as they are compiled, on robots as they are: what happens to them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from sosbook.mip import Firmware, recommend
from sosbook.mip.compiled import Compiled

from tests.compiler import find, refuse
from tests.geared_robots import ALL, described, stand
from tests.test_mip_compare import pendulum

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
def program(name):
    """The law of a robot of the tests, by its own numbers."""
    robot = described(ALL[name]).but(friction=False, backlash_deg=ALL[name].play)
    found = recommend(pendulum(ALL[name]), R=None, robot=robot)
    return Firmware.of(found.law, found.robot)


@pytest.mark.slow
@pytest.mark.parametrize("story", STORIES)
@pytest.mark.parametrize("name", ["n20", "hub", "lego"])
def test_a_program_stands_or_turns_its_motors_off(name, story):
    events, flaws = STORIES[story]
    machine = replace(ALL[name], **flaws)
    if find() is None:
        refuse()
    tilts, volts, turns, fault = stand(machine, Compiled(program(name)), **events)
    if story == "a hand":
        assert fault and volts[-1] == 0
        return
    late = tilts[2 * len(tilts) // 3 :]
    assert fault == 0 and abs(volts).max() <= machine.V_n * (1 + 1e-6)
    assert abs(late - late.mean()).max() < UPRIGHT
    assert abs(turns[-1] - turns[len(turns) // 2]) < 2 * np.pi
