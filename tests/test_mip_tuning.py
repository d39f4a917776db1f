"""The weight and the decay are found, and refusals say the true cause."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sosbook.pendulum import Mip, Robot, SampledLaw, polytope, tuning, vertices
from sosbook.pendulum.deployment import recommend
from sosbook.pendulum.facts import facts
from sosbook.pendulum.rest import Gears
from sosbook.pendulum.tuning import (
    WEIGHTS,
    design,
    fall_time,
    peak_of,
    prove,
    recoverable_tilt,
    timed,
)
from tests.cases import later
from tests.gains import named
from tests.six_robots import SIX, pendulum, spared, stand
from tests.test_mip_robot import GEARS as OTHER
from tests.test_mip_robot import THESIS, truth
from tests.test_mip_six_robots import described

Q, GEARS = np.eye(5), OTHER.but(law="gain")


@cache
def gain(mip, robot, R):
    """K of a design with the weight R."""
    return design(mip, robot, 0.04, Q, R, 2.0, Gears()).certify().K


def peak(mip, robot, R):
    law = SampledLaw.of_gain(named(gain(mip, robot, R)), robot.T)
    return peak_of((mip, *vertices(mip)), law, robot)


@pytest.mark.slow
@pytest.mark.parametrize(
    "mip, robot, R", [(truth(GEARS), GEARS, 5.0), *later((Mip.printed(), THESIS, 20.0))]
)
def test_the_smallest_weight_that_keeps_the_margin(mip, robot, R):
    found = design(mip, robot, 0.04, Q, None, 2.0, Gears())
    assert found.request.cost.R[0, 0] == R
    assert peak(mip, robot, R) <= 2
    assert peak(mip, robot, WEIGHTS[WEIGHTS.index(R) - 1]) > 2


@pytest.mark.slow
def test_a_clock_that_is_too_slow_is_named_with_one_that_would_do():
    robot, mip = THESIS.but(T=0.04, delay=0.04), Mip.printed()
    with pytest.raises(ValueError, match=r"T = 40 ms .*About \d+ Hz") as e:
        design(mip, robot, 0.04, Q, None, 2.0, Gears())
    hertz = float(str(e.value).split("About ")[1].split()[0])
    fast = robot.but(T=1.05 / hertz / 1.25, delay=0.04 * 25 / hertz / 1.3)
    found = design(mip, fast, 0.04, Q, None, 2.0, Gears())
    assert peak(mip, fast, found.request.cost.R[0, 0]) <= 2


@pytest.mark.slow
def test_the_decay_is_lowered_until_it_is_proven():
    """Gear motors: proven at 0.2/s; at 50/s a smaller one is found."""
    mip = truth(GEARS)
    K = gain(mip, GEARS, 5.0)
    found = prove(polytope(mip, 0.04), tuning.U, GEARS, K, 0.2)
    assert found.certify().proven
    assert found.request.delta == 0.2
    assert found.request.tau + found.request.mu == pytest.approx(0.0075)
    # more than the loop's own decay is never tried
    slow = prove(polytope(mip, 0.04), tuning.U, GEARS, K, 50.0)
    assert slow.request.delta < slow.slowest_decay()[0]


def test_an_unstable_loop_is_the_cause_that_is_named():
    late, K = THESIS.but(delay=0.2), gain(Mip.printed(), THESIS, 20.0)
    with pytest.raises(ValueError, match="unstable for a delay of .* ms"):
        prove(polytope(Mip.printed(), 0.04), tuning.U, late, K, 0.2)


def test_a_proof_that_lacks_means_says_so(monkeypatch):
    class Undecided:
        status = "undecided"

    monkeypatch.setattr(tuning, "solve_delay", lambda *a, **k: Undecided)
    K = gain(Mip.printed(), THESIS, 20.0)
    with pytest.raises(ValueError, match="0.64.* it is the proof that"):
        prove(polytope(Mip.printed(), 0.04), tuning.U, THESIS, K, 0.2)


def test_the_reach_is_where_the_unstable_mode_gets_away():
    """Full voltage at once, on the linear plant: to either side of it."""
    mip, limit = Mip.printed(), 7.4
    plant = mip.plant()
    M, D, S, B = plant.M, plant.D, plant.S, plant.B[:, 0]

    def mode(tilt):
        """Of |theta| after two seconds of 7.4 V: gets away, and where."""
        z, dz, h = np.array([tilt, 0.0]), np.zeros(2), 1e-4
        for _ in range(20000):
            dz = dz + h * np.linalg.solve(M, B * limit - D @ dz - S @ z)
            z = z + h * dz
            if abs(z[0]) > 20:
                break
        return np.sign(z[0])

    edge = recoverable_tilt(mip, limit)
    assert mode(1.005 * edge) == 1 and mode(0.995 * edge) == -1


def test_weak_motors_are_named():
    weak = replace(Mip.printed(), e=0.05 * Mip.printed().e)
    with pytest.raises(ValueError, match="motors are too weak.* It takes"):
        recommend(weak)


@pytest.mark.parametrize(
    "asked, words",
    [(dict(peak=1.0), "peak must be above 1"), (dict(decay=-1), "decay must")],
)
def test_bad_input(asked, words):
    with pytest.raises(ValueError, match=words):
        recommend(Mip.printed(), **asked)


@pytest.mark.slow
def test_a_thin_margin_is_not_written(tmp_path):
    found = spared(recommend(Mip.printed(), R=10.0), lacking=(), sampled={})
    with pytest.raises(ValueError, match="margin is thin.* peaks at 2"):
        found.write(tmp_path / "none")
    assert not (tmp_path / "none").exists()
    object.__setattr__(found, "peak", 3.0)
    assert found.write(tmp_path)


@pytest.mark.slow
def test_other_weights_are_said():
    found = recommend(Mip.printed(), Q=[2, 1, 1, 1, 0.5])
    spared(found, sampled={}, held=found.certificate)
    assert "Q = diag(2, 1, 1, 1, 0.5), R = 20" in (found.facts["specification"])
    assert timed(Robot.shipped("thesis"), found.mip).words == found.facts["robot"]


def test_the_waits_are_by_the_robots_own_fall():
    """A robot four times as tall falls half as fast, and is given twice the time."""
    short = Mip.printed()
    tall = replace(short, a=short.a, b=16 * short.b, c=256 * short.c, d=16 * short.d)
    rate = float(max(np.linalg.eigvals(_companion(tall)).real))
    for mip in (short, tall):
        robot = timed(THESIS, mip)
        assert robot.ticks["stall"] == np.ceil(robot.stall / robot.T - 1e-9)
        assert robot.stall == pytest.approx(4 * fall_time(mip), abs=6e-4)
    assert fall_time(tall) == pytest.approx(1 / rate)
    slow = timed(THESIS.but(T=0.05), short)
    assert slow.ticks["missing"] == 5 and slow.ticks["frozen"] == 12
    given = timed(THESIS.but(stall=0.7, deaf=0.0), short)
    assert given.stall == 0.7 and given.ticks["deaf"] == 0


def _companion(mip):
    """The matrix of [z, z'] of a pendulum without voltage, from its letters."""
    M = np.array([[mip.c, mip.b - mip.J], [mip.b - mip.J, mip.a]])
    D, S = mip.f * np.array([[1, -1], [-1, 1]]), np.diag([-mip.d, 0])
    rates = -np.linalg.solve(M, np.hstack([S, D]))
    return np.vstack([np.eye(2, 4, 2), rates])


@pytest.mark.slow
def test_the_reach_is_what_is_held_with_the_faults_on():
    """Seen by another simulator: it stands up a little below and not far above."""
    machine = next(m for m in SIX if m.name == "8 kg")
    found = recommend(pendulum(machine), R=5.0, robot=described(machine))
    spared(found, sampled={}, held=found.certificate, reach=found.reach)
    bound = recoverable_tilt(found.mip, machine.V_n)
    assert found.reach < bound < found.robot.tip
    words = found.facts["reach"]
    assert f"no law can from more than {np.degrees(bound):.0f} degrees" in words
    assert f"stands up from {np.degrees(found.reach):.0f} degrees" in words
    for share, upright in ((0.95, True), (bound / found.reach * 1.1, False)):
        program = found.firmware.controller()
        tilts, fault = stand(
            machine, program, machine.V_n, 6.0, share * found.reach, dropouts=0.0
        )
        assert (fault == 0 and abs(tilts[-100:]).max() < 0.06) == upright
    same = {x: getattr(found, x) for x in ("delayed", "certificate", "held")}
    short = replace(found, robot=found.robot.but(tip=0.2))
    spared(short, sampled={}, **same)
    assert "the motors go off beyond tip = 11 degrees" in facts(short)["reach"]
