"""A crane and a drive with play, by equations of my own: moves as they are proven."""

import functools
import shutil

import numpy as np
import pytest

import sosbook as sos
from sosbook.controllers import Backlash, CompiledCode, predicted_cycles
from sosbook.controllers.facts import simulated
from sosbook.controllers.trial import steps_of
from tests.test_controllers_motions import late, within

G, TROLLEY, LOAD, ROLLS, AIR = 9.81, 400.0, 300.0, 60.0, 2.0  # m/s^2, kg, N s/m
ROPES = 1.5, 3.0
compiled = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


def crane(L):
    """All forces on trolley and load; and along the load's way, per kg of it."""
    return sos.SecondOrderSystem(
        [[TROLLEY + LOAD, LOAD * L], [1, L]], [[ROLLS, 0], [0, AIR * L / LOAD]],
        [[0, 0], [0, G]], [[1], [0]], coordinates=["trolley", "sway"],
    )  # fmt: skip


@functools.cache
def carried():
    """For every rope, with the least force from a metre; its encoders see both."""
    design = sos.design_pid(
        sos.Uncertain(crane, L=ROPES), [[1, 0]], region=sos.PoleRegion(0.3, rho=12),
        saturation=sos.Saturation(None, [1, 0, 0, 0, 0]), minimize="u_max",
    )  # fmt: skip
    return design.controller(["trolley", "sway"], T=0.02, delay=0.02)


def swung(c, r, ropes, dry=0.0):
    """(trolley, sway, u) of a program on cranes with these ropes, by RK4: a point mass
    on a rope, for any angle; the trolley has ``dry`` friction.
    """
    program, many = CompiledCode(c, runs=len(ropes)), len(ropes)
    x, force, seen = np.zeros((4, many)), np.zeros(many), []

    def rate(x):
        _, a, v, w = x
        # from x'' and th'': the rope's pull on the trolley is that of the load
        sin, cos = np.sin(a), np.cos(a)
        own = force - ROLLS * v - dry * np.tanh(v / 0.01)
        pushed = (
            own + LOAD * (ropes * w**2 * sin + G * sin * cos) + AIR * ropes * w * cos
        )
        acceleration = pushed / (TROLLEY + LOAD * sin**2)
        turn = -(acceleration * cos + G * sin) / ropes - AIR * w / LOAD
        return np.array([v, w, acceleration, turn])

    program.start(x[:2])
    for goal in r:
        u = program.step(x[:2], [goal])[0]
        seen.append((x[0], x[1], u))
        for _ in range(4):
            h = c.T / 4
            k1 = rate(x)
            k2 = rate(x + h / 2 * k1)
            k3 = rate(x + h / 2 * k2)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(x + h * k3))
        force = u
    assert not program.fault.any()
    return np.array(seen).transpose(1, 0, 2)


@pytest.mark.campaign  # in the gate a drive and a satellite keep what moves are proven
@compiled
def test_a_crane_goes_ten_metres_and_sways_three_degrees():
    """The proof is of small angles: of 3 degrees they are off by a thousandth."""
    c, most = carried(), np.radians(3)
    move = c.motions.move(10.0, u_max=1000.0, output="sway", error=most)
    ropes, r = np.linspace(*ROPES, 4), move.profile.points(10.0)
    limited = c.set_point(profile=move.profile).limit(1000.0).watch(stall=60.0)
    r = np.concatenate([r, np.full(round(25 / c.T), 10.0)])
    _, sway, u = swung(limited, r, ropes)
    error = move.error.proven
    assert error <= most and move.effort[0].proven <= 1000
    assert 0.98 * error < abs(sway).max() <= error
    assert 0.98 * move.effort[0].proven < abs(u).max() <= move.effort[0].proven
    trolley, sway, u = swung(limited, r, ropes, dry=15.0)
    assert abs(sway).max() < 1.1 * most and abs(u).max() <= 1000
    assert abs(trolley[-1] - 10).max() < 0.05 and abs(sway[-1]).max() < 1e-3


@pytest.mark.campaign  # in the gate motions ask no more than is proven of carts in oil
def test_no_motion_within_its_limits_sways_a_crane_further():
    """A set point that goes to and fro as a rope of mine swings, as fast as it may."""
    c, limits = carried(), (0.8, 0.4, 0.4)
    proven = c.motions.follow(*limits, output="sway").proven
    asked = []
    for L in (1.5, 2.2, 3.0):
        F, g, _ = late(c, crane(L))
        x, later = np.linalg.solve(np.eye(len(F)) - F, g), []
        for _ in range(3000):
            later.append(-x[1])
            x = F @ x
        for v in within(limits, c.T, np.array(later)[::-1, None] > [[0, 1e-4]]):
            asked.append(abs(np.convolve(v * c.T, later)[:3000]).max())
    assert 0.5 * proven < max(asked) <= proven


K_SHAFT, D_SHAFT, MOTOR = 20.0, 0.01, 0.0025


def drive(J2):
    d, k = D_SHAFT, K_SHAFT
    return sos.SecondOrderSystem(
        np.diag([MOTOR, J2]), [[d, -d], [-d, d]], [[k, -k], [-k, k]], [[1], [0]],
        coordinates=["motor", "load"],
    )  # fmt: skip


@functools.cache
def geared():
    """The load's encoder is followed, the motor's rate damps: for every load."""
    law = sos.PIDLaw(position=[[0, 1]], velocity=[[1, 0]], integrate=True)
    gains = {"K_P": [[-1.2]], "K_D": [[-0.2]], "K_I": [[-3.4]]}
    loads = sos.Uncertain(drive, J2=(0.003, 0.006))
    return sos.analyse_pid(loads, gains, law=law).controller(T=1e-3, delay=1e-3)


def rattled(c, gaps, J2, seconds=5.0):
    """(motor, load, u) of a program on drives whose shafts have ``gaps``: within one
    its spring does nothing.
    """
    gap, many = np.array(gaps), len(gaps)
    program, x, u, seen = CompiledCode(c, runs=many), np.zeros((4, many)), 0.0, []

    def rate(x):
        twist = x[0] - x[1]
        pull = K_SHAFT * (twist - np.clip(twist, -gap / 2, gap / 2))
        pull += D_SHAFT * (x[2] - x[3])
        return np.array([x[2], x[3], (u - pull) / MOTOR, pull / J2])

    program.start(x[1:3])
    for _ in range(round(seconds / c.T)):
        new = program.step(x[1:3], [1.0])[0].copy()
        seen.append((x[0], x[1], new))
        for _ in range(3):
            h = c.T / 3
            k1 = rate(x)
            k2 = rate(x + h / 2 * k1)
            k3 = rate(x + h / 2 * k2)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(x + h * k3))
        u = new
    return np.array(seen).transpose(1, 2, 0)


@pytest.mark.campaign  # in the gate chapter 40 has a drive whose gap keeps it swinging
@compiled
def test_play_keeps_a_proven_drive_swinging_and_the_header_says_so():
    """Within its gap nothing holds the load that is followed: the integral hunts."""
    c, gap = geared(), 0.02
    assert c.certify().proven
    tight, loose = rattled(c, (0.0, gap), 0.006)[1][:, -2000:]
    assert abs(tight[-1000:] - 1).max() < 1e-3
    assert np.ptp(loose) > gap and abs(loose - 1).max() < 2 * gap
    play = Backlash(0, 1, gap)
    run = c.simulate(5.0, r=[1.0], backlash=play, plants=c.vertices[1:])
    assert np.ptp(run.x[0, -2000:, 1]) == pytest.approx(np.ptp(loose), rel=0.3)
    assert any(cycle.corner == 1 for cycle in predicted_cycles(c, backlash=play))
    text = " ".join(simulated(c, steps_of(c)))
    assert "friction and play (backlash) can keep a proven loop" in text


def shaft(J2):
    """Hardly damped, with numbers of its own: 120 N m/rad, 12 N m are there."""
    return sos.SecondOrderSystem(
        np.diag([0.012, J2]), [[0.03, -0.03], [-0.03, 0.03]],
        [[120, -120], [-120, 120]], [[1], [0]], coordinates=["motor", "load"],
    )  # fmt: skip


@functools.cache
def observed():
    design = sos.design_pid(
        sos.Uncertain(shaft, J2=(0.02, 0.05)), [[1, 0]],
        region=sos.PoleRegion(settling_time=0.5, rho=400),
        saturation=sos.Saturation(None, [1, 1, 0, 0, 0]), minimize="u_max",
    )  # fmt: skip
    return design.controller(["motor"], T=0.002, delay=0.002)


@pytest.mark.campaign  # in the gate tests/test_controllers_modes has arrivals, too
@pytest.mark.parametrize("whole", [True, False])
def test_a_move_says_when_its_output_arrives(whole):
    """Sixty radians: the set point is there long before the load may be."""
    c = observed().set_point(r=[[1], [1]]) if whole else observed()
    move = c.motions.move(60, u_max=11.5, output="load")
    r, late_by = move.profile.points(60), []
    for J2 in (0.02, 0.03, 0.05):
        F, g, _ = late(c, shaft(J2))
        x, away = np.zeros(len(F)), []
        for goal in [*r, *[60.0] * 600]:
            away.append(abs(x[1] - 60))
            x = F @ x + g * goal
        late_by.append(c.T * (np.flatnonzero(np.array(away) > 0.02 * 60)[-1] + 1))
    assert move.duration < max(late_by) <= move.arrival.proven
    assert move.arrival.proven <= max(late_by) + 4 * c.T
    assert "within 2 % of its way after at most 1." in str(move)
    assert (move.error.proven < 2) == whole
    assert c.motions.move(1, u_max=11.5, output="load'").arrival is None


def test_a_weight_that_changes_nothing_is_said():
    """It was asked for b = inf: the load hardly overshoots whatever b is."""
    c = observed()
    calm = c.bounds.weights(overshoot=0.05, effort=11.0, output="load")
    assert calm.bounds.step_response(output="load").overshoot.proven < 0.05
    with pytest.raises(ValueError, match="b changes nothing here"):
        c.bounds.weights(overshoot=0.05, effort=1.0, output="load")
