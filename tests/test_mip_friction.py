"""Friction, its compensation and play: programs, simulator, limit cycles."""

import numpy as np
import pytest

from sosbook.pendulum import (
    Drivetrain,
    Firmware,
    Mip,
    Robot,
    SampledLaw,
    Sensors,
    recommend,
    simulate,
)
from sosbook.pendulum.describing import coulomb, limit_cycle, soft_sign
from sosbook.pendulum.fleet import Fleet
from sosbook.pendulum.margins import SampledLoop
from sosbook.pendulum.play import Geared
from sosbook.pendulum.rig import gear_motors
from sosbook.pendulum.spread import vertices
from sosbook.pendulum.tuning import design
from tests.gains import named
from tests.six_robots import spared

MIP, THESIS = Mip.printed(), Robot.shipped("thesis")
#: One kilogram, two 12 V gear motors, 200 Hz.
GEARS = Mip(0.00238, 0.00244, 0.00880, 0.736, 0.0833, 0.0476, I_w=0.00061, J=9.2e-4)
LAW = SampledLaw.of_gain(named([[18.9, 0.5, 1.9, 0.8, 0.1]]), 0.01)
PHASE = 2 * np.pi * (np.arange(200000) + 0.5) / 200000


def harmonic(output, amplitude):
    """The first harmonic of an output over that of amplitude * sin."""
    return 2j * np.mean(output * np.exp(-1j * PHASE)) / amplitude


@pytest.mark.parametrize("amplitude", [0.3, 1.0, 4.0])
def test_describing_functions_are_first_harmonics(amplitude):
    sine = amplitude * np.sin(PHASE)
    measured = harmonic(0.4 * np.sign(sine), amplitude)
    assert measured == pytest.approx(coulomb(amplitude, 0.4), rel=1e-4)
    soft = 0.4 * np.clip(sine / 0.8, -1, 1)
    expected = soft_sign(amplitude, 0.4, 0.8)
    assert harmonic(soft, amplitude) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("mip", [MIP, gear_motors()], ids=["no J", "rotors"])
def test_in_the_gap_the_motors_turn_themselves_and_at_its_ends_the_wheels(mip):
    """Angular momentum of motors that spin up in a gap, and of one without a gap."""
    fleet, x = Geared([mip], 0.2, 0.0, 1), np.zeros((4, 1))
    x = fleet.advance(x, 0.3, (0, 0), 0.003, 4)
    turned = fleet.rotors[0, 0]
    assert 0 < turned < 0.1 and abs(x[1, 0]) < 0.2 * turned
    twists = []
    for _ in range(40):
        x = fleet.advance(x, 1.0, (0, 0), 0.005, 4)
        twists.append(abs(fleet.rotors[0, 0] - x[1, 0]))
    assert 0.1 < max(twists) < 0.13  # the teeth push, and give way a little
    if mip.J:  # teeth without a gap: the pendulum that has none
        stiff, same = Geared([mip], 1e-9, 0.0, 1), np.array([[0.05], [0], [0], [0]])
        ends = stiff.advance(same, 0.5, (0, 0), 0.1, 9)
        none = Fleet([mip]).advance(same, 0.5, (0, 0), 0.1, 99)
        assert ends == pytest.approx(none, rel=0.03, abs=2e-3)


@pytest.mark.parametrize("volts", [-0.1, 7.4, np.nan])
def test_a_compensation_out_of_range_is_refused(volts):
    with pytest.raises(ValueError, match="compensation"):
        Firmware(LAW, compensation=volts)
    with pytest.raises(ValueError, match="friction"):
        Drivetrain(friction=-1.0)
    with pytest.raises(ValueError, match="compensation"):
        limit_cycle(SampledLoop(MIP, LAW), 0.3, -0.1)


@pytest.mark.slow
def test_what_the_header_says_of_a_gain_that_varies_is_true():
    """Any gain from one to one and a half, by chance or at its worst."""
    found = spared(recommend(MIP, robot=THESIS.but(compensation=0.2)), sampled={})
    assert found.firmware.compensation == 0.2
    assert found.bench_firmware.compensation == 0
    said = found.facts["compensation"]
    assert "proofs are about the law without it" in said and "circle" in said
    random, peak = np.random.default_rng(1), found.sensitivity
    assert peak < 3
    for row in found.loops.values():
        for loop in row:
            L = loop.loop_gain
            z = np.exp(1j * np.linspace(1e-3, np.pi, 500))
            S = 1 / (1 - L.at(z)[:, 0, 0])
            assert (0.5 * S.real < 1.5).all()  # the circle
            x, ends = np.eye(len(L.A)), [L.A + gain * L.B @ L.C for gain in (1, 1.5)]
            for k in random.integers(0, 2, 4000):
                x = ends[k] @ x
            assert np.linalg.norm(x) < 1e-3 * np.linalg.cond(L.A + L.B @ L.C)


def swings(mip, law, delay, limit, friction, compensation):
    """Frequency and tilt of a cycle in the simulator; predicted, then seen."""
    loop = SampledLoop(mip, law, delay, "firmware", 0.005)
    predicted = limit_cycle(loop, friction, compensation)
    firmware = Firmware(law, limit=limit, blend=0.005, compensation=compensation)
    how = dict(substeps=8, drivetrain=Drivetrain(friction))
    run = simulate(mip, firmware, 0.03, 36.0, delay, Sensors(ideal=True), **how)
    assert not run.fell.any()
    theta = run.x[0, 0, len(run.t) // 3 :]
    swing = theta - theta.mean()
    ups = np.flatnonzero((swing[:-1] < 0) & (swing[1:] >= 0))
    seen = (len(ups) - 1) / ((ups[-1] - ups[0]) * law.T)
    return (predicted.frequency, predicted.tilt), (seen, np.ptp(theta) / 2)


@pytest.mark.campaign  # in the gate chapter 24 predicts such cycles and simulates them
@pytest.mark.parametrize("which", ["thesis", "gears"])
def test_friction_makes_the_cycle_that_its_harmonic_predicts(which):
    """Within a factor of two, and its compensation's effect within a fifth.

    The wheels stick for a while in every cycle, so the motion is no sine.
    """
    case = {
        "thesis": (MIP, 0.01, 0.005, 7.4, 0.3, 20.0),
        "gears": (GEARS, 0.005, 0.002, 12.0, 0.5, 10.0),
    }[which]
    mip, T, delay, limit, friction, R = case
    K = design(mip, THESIS, 0.04, np.eye(5), R, 2.0, None).certify().K
    law = SampledLaw.of_gain(named(K), T)
    tilts = []
    for compensation in (0.0, friction):
        predicted, seen = swings(mip, law, delay, limit, friction, compensation)
        for guess, truth in zip(predicted, seen):
            assert 0.5 < guess / truth < 2
        tilts.append((predicted[1], seen[1]))
    (guess, truth), (less_guess, less_truth) = tilts
    assert less_truth < 0.7 * truth
    assert less_guess / guess == pytest.approx(less_truth / truth, rel=0.2)


@pytest.mark.slow
def test_a_play_of_a_degree_leaves_every_robot_standing():
    found = recommend(MIP, robot=THESIS)
    firmware, robots = Firmware.of(found.law, found.robot), list(vertices(MIP))
    play = Drivetrain(backlash=np.radians(1.0))
    run = simulate(robots, firmware, 0.1, 4.0, 0.01, drivetrain=play)
    assert run.settled.all()
    sharp = simulate(robots, firmware, 0.1, 4.0, 0.01)
    assert not np.array_equal(run.V, sharp.V)
