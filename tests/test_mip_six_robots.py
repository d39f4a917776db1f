"""Robots of many kinds end to end, against a simulator of their own."""

from functools import cache

import numpy as np
import pytest

from sosbook.pendulum import recommend
from sosbook.pendulum.compiled import Compiled
from sosbook.pendulum.deployment import deploy
from sosbook.pendulum.fit_spread import FitSpread
from sosbook.pendulum.gate import widened
from tests.cases import later
from tests.compiler import find, refuse
from tests.six_robots import (
    OTHERS,
    SIX,
    by_its_sheet,
    logs,
    pendulum,
    spared,
    stand,
    write,
)


def described(machine):
    return by_its_sheet(machine, friction=machine.friction > 0, law=machine.law)


#: Each robot takes a minute, and all run once a week: the second of them goes from logs
#: to programs in test_mip_robot, which is in the gate.
MACHINES = [pytest.param(m, id=m.name) for m in SIX + OTHERS]


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """What comes of a machine's logs and its description."""
    folder = tmp_path_factory.mktemp("logs")

    @cache
    def deployment(machine):
        body, wheels = logs(machine)
        write(folder / "body.csv", "t,V,gyro", body)
        write(folder / "wheels.csv", "t,V,encoder1,encoder2", wheels)
        paths = folder / "body.csv", folder / "wheels.csv"
        return deploy(*paths, described(machine))

    return deployment


@pytest.mark.campaign  # in the gate test_mip_robot, test_a_second_robot_end_to_end
@pytest.mark.parametrize("machine", MACHINES)
def test_from_its_logs_to_a_minute_upright(machine, identified, tmp_path):
    found = identified(machine)
    ratios = found.identified.ratios
    for (name, value), sd in zip(ratios.items(), widened(found.identified)):
        truth = machine.truth[name]
        assert abs(value - truth) < 3.5 * sd + 5e-4 * truth, name
    assert found.mip.J == pytest.approx(machine.J, rel=0.1)

    assert found.sensitivity <= 2 and found.proven, found.lacking
    spared(found).write(tmp_path / "out")
    if find() is None:
        refuse()
    program = Compiled(found.firmware)
    tilts, fault = stand(machine, program, machine.V_n, 60.0)
    assert fault == 0 and len(tilts) == round(60.0 / machine.T)
    assert abs(tilts).max() < 0.5
    assert abs(tilts[len(tilts) // 2 :]).max() < np.deg2rad(3)
    print(f"{machine.name}: {found.facts['specification']}, {found.sensitivity:.2f}")


@pytest.mark.slow
@pytest.mark.parametrize(
    "name, warned", [("LEGO-like", True), *later(("gear motors 200 Hz", False))]
)
def test_counts_that_shake_the_motors_are_warned_of(name, warned):
    """Of 360 counts a turn at 200 Hz each takes the whole voltage of a gain, and not
    of an observer.
    """
    (machine,) = (m for m in SIX if m.name == name)
    R = 10.0 if warned else 5.0  # the peak's choice: at rest the motors chatter
    found = recommend(pendulum(machine), R=R, robot=described(machine))
    spared(found, sampled={}, held=found.certificate)  # proofs aren't the matter
    assert ("warning, counts" in found.facts) == warned
    program = Compiled(found.firmware) if find() else refuse()
    volts = []

    class Heard:
        """The program, and what it said."""

        start = program.start
        fault = property(lambda self: program.fault)

        def step(self, *readings):
            volts.append(program.step(*readings))
            return volts[-1]

    _, fault = stand(machine, Heard(), machine.V_n, seconds=8.0)
    assert fault == 0
    last = abs(np.ravel(volts))[len(volts) // 2 :]
    assert (last.max() > 0.5 * machine.V_n) == warned
    if warned:
        seeing = found.robot.but(law="observer")
        again = recommend(pendulum(machine), R=1.0, robot=seeing)
        assert "warning, counts" not in spared(again, sampled={}).facts


@pytest.mark.campaign  # test_mip_fit_spread proves one in the gate
@pytest.mark.timeout(900)  # one takes 40 s of a processor, the others six
@pytest.mark.parametrize("machine", MACHINES)
def test_it_is_proven_for_all_that_its_fit_allows(machine, identified):
    """All five ratios are uncertain, and the machine is one of the pendulums."""
    fit = identified(machine).identified
    spread = FitSpread.of(fit, widened(fit), 0.99)
    asked = dict(spread=spread, robot=described(machine), identified=fit)
    found = recommend(fit.mip, R=None, **asked)
    assert found.sensitivity <= 2 and found.proven, found.lacking
    truth, mip = pendulum(machine), found.mip
    moved = [getattr(truth, x) / getattr(mip, x) - 1 for x in ("c", "e", "f", "I_w")]
    assert (abs(found.spread.places(moved)) <= 1).all(), moved
