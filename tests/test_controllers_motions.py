"""Motions within velocity, acceleration and jerk: my own loops stay inside."""

import shutil
import subprocess

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.controllers import Code, CompiledCode, Profile
from sosbook.controllers.facts import bounded
from tests.cases import by_turns, campaign
from tests.test_controllers_margins import drive, drives, held
from tests.test_controllers_trial import bearing

T = 0.001
INERTIAS = np.linspace(0.003, 0.006, 7)


def own(c, J2):
    """(F, G, H): the drive's loop with set point, [x; u before; memory], by hand."""
    A, now, _ = held(drive(J2), T, 0.0)
    rows, l = c.readings.rows, c.order
    F = np.zeros((5 + l, 5 + l))
    H = np.hstack([c.D @ rows, [[0]], c.C])
    F[:4, :4], F[:4, 4:5], F[4], F[5:, :4] = A, now, H, c.B @ rows
    F[5:, 5:] = c.A
    return F, np.vstack([np.zeros((4, 1)), c.D_r, c.B_r])[:, 0], H[0]


def run(c, J2, r):
    """(u, load) at the ticks while the set point is r, from rest at r[0] = 0."""
    F, G, H = own(c, J2)
    x, found = np.zeros(len(F)), []
    for k, goal in enumerate([*r, *[r[-1]] * 600]):
        found.append((H @ x + c.D_r[0, 0] * goal, x[1] - r[min(k, len(r) - 1)]))
        x = F @ x + G * goal
    return np.array(found).T


@pytest.fixture(scope="module")
def c():
    return drives()


@pytest.fixture(scope="module")
def least(c):
    """Of u and the load: what my own plants ask for a unit of A, and of J."""
    found = []
    for J2 in INERTIAS:
        F, G, H = own(c, J2)
        left, load = np.eye(len(F)) - F, np.eye(len(F))[1]
        x_r = np.linalg.solve(left, G)
        y = np.linalg.solve(left, -T * np.linalg.solve(left, -T * x_r))
        of_A, sums = [abs(H @ y), abs(load @ y)], np.zeros(2)
        for _ in range(1500):
            sums += abs(np.array([H @ y, load @ y]))
            y = F @ y
        found.append([of_A, T * sums])
    return np.max(found, axis=0)


def test_every_motion_asks_what_plants_do_and_little_more(c, least):
    for k, output in enumerate((0, "load")):
        found = c.motions._units(0, output, 60).cells.max(axis=0)[0]
        assert found[0] == 0 and found[1] < 1e-9  # nothing rubs, and no spring pulls
        assert (least[:, k] * 0.9999 <= found[2:]).all()
        assert (found[2:] <= 1.02 * least[:, k]).all()
    jumps = c.motions.follow(50, 3.0, output=0)  # of any jerk
    for jerk, share in ((5.0, 0.6), (1e4, 1.0)):
        smooth = c.motions.follow(50, 3.0, jerk, output=0).proven
        assert share * jumps.proven * 0.9 < smooth <= share * jumps.proven


def test_sixty_radians_take_little_more_than_the_motor_needs(c):
    move = c.motions.move(60.0, u_max=2.0, output="load")
    r = move.profile.points(60.0)
    assert r[0] == 0 and r[-1] == 60 and move.effort[0].proven <= 2
    found = np.array([abs(run(c, J2, r)).max(axis=1) for J2 in INERTIAS]).max(axis=0)
    proven = np.array([move.effort[0].proven, move.error.proven])
    assert (found <= proven).all() and (proven < 1.05 * found).all()
    least = 2 * np.sqrt(60 * 0.0085 / 2.0)  # of the heaviest drive, by bangs
    assert least < move.duration < 1.5
    safe = c.motions.limits_for(2.0, 60.0)
    sizes = safe.velocity, safe.acceleration, safe.jerk
    assert c.motions.follow(*sizes, output=0).proven <= 2
    assert move.duration < safe.duration(60.0) < 1.25 * move.duration
    assert "60 in 1." in str(move)


def test_a_move_keeps_its_output_near(c):
    """Without it a radian in a tenth of a second overshoots by half of one."""
    quick, gentle = (
        c.motions.move(1.0, 2.0, output="load", error=most) for most in (None, 0.05)
    )
    assert quick.duration < 0.1 < 0.4 < quick.error.proven
    r = gentle.profile.points(1.0)
    off = max(abs(run(c, J2, r)[1]).max() for J2 in INERTIAS[::3])
    assert 0.95 * gentle.error.proven < off <= gentle.error.proven <= 0.05
    safe = c.motions.limits_for(2.0, 1.0, output="load", error=0.05)
    sizes = safe.velocity, safe.acceleration, safe.jerk
    assert c.motions.follow(*sizes, output="load").proven <= 0.05
    with pytest.raises(ValueError, match="error must be positive"):
        c.motions.move(1.0, 2.0, error=0)


@pytest.mark.parametrize(
    "limits",
    by_turns([(2.0, 8.0, 64.0, 0.01), (0.3, 9.81, 9.81, 0.02),
              (94.8, 186.0, 1526.0, 0.001), (7.0, 7.0, 7.0, 0.05)], 1),
)  # fmt: skip
def test_a_profile_keeps_its_limits_and_ends_exactly(limits):
    profile, rng, T = Profile(*limits), np.random.default_rng(8), limits[3]
    for distance in [*rng.uniform(-3, 3, 6), 1e-9, 40.0]:
        start = rng.uniform(-1, 1)
        r = profile.points(distance, start)
        assert r[0] == start and r[-1] == start + distance
        assert kept(profile, np.concatenate([[start] * 3, r, [r[-1]] * 3]))
        goals = np.concatenate([rng.normal(size=400) * limits[0], [distance] * 6000])
        for several in (goals, np.repeat(goals, 30)[:12000]):
            followed = profile.follow(several, start)
            assert kept(profile, np.concatenate([[start] * 3, followed]))
        assert profile.follow(goals)[-1] == distance or abs(distance) > 3
        V, A, J = limits[:3]
        free = abs(distance) / V + V / A + A / J + max(0, A / J - V / A)
        assert (
            profile.duration(distance)
            <= max(free, 2 * (max(V / A, A / J) + A / J)) + 4 * T
        )


MAIN = """#include <math.h>
#include <stdio.h>
#include "arm_move.h"
int main(void) {
    const double goal[] = {%s};
    arm_move m;
    unsigned i;
    arm_move_start(&m, 0);
    for (i = 0; i < sizeof goal / sizeof *goal; i++) {
        if (!arm_move_to(&m, (ARM_MOVE_REAL)goal[i])) return 1;
        if (arm_move_to(&m, 9)) return 3;
        while (!arm_move_over(&m)) printf("%%.17g\\n", (double)arm_move_next(&m));
    }
    if (arm_move_to(&m, (ARM_MOVE_REAL)1e30)) return 2;
    if (arm_move_next(&m) != m.to) return 4;
    arm_follow f;
    const double asked[] = {%s};
    arm_follow_start(&f, (ARM_MOVE_REAL)0.3);
    for (i = 0; i < %d + 150; i++) {
        if (i == %d) arm_follow_stop(&f);
        printf("%%.17g\\n", (double)arm_follow_next(
            &f, (ARM_MOVE_REAL)(i < %d ? asked[i] : (double)NAN)));
    }
    return 0;
}
"""
STREAM = [1.7, np.nan, -2.5, 1e300, np.inf, 0.01, 3.0]


def kept(profile, r):
    """True if r moves within the limits of a profile, but for its own rounding."""
    limits = profile.velocity, profile.acceleration, profile.jerk
    noise = 1e-15 * abs(r).max()
    return all(
        abs(np.diff(r, k)).max() / profile.T**k
        <= most * (1 + 1e-9) + 2.0**k * noise / profile.T**k
        for k, most in enumerate(limits, 1)
    )


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("precision", ["double", "single"])
def test_the_program_is_the_profile_bit_by_bit(precision, tmp_path):
    profile = Profile(2.0, 8.0, 64.0, 0.01, "rad")
    goals = [1.0, -0.37, 0.0, 1e-7, 25.3]
    text = profile.to_c("arm", precision)
    assert "ARM_VELOCITY_RAD_S " in text and "ARM_JERK_RAD_S3 " in text
    (tmp_path / "arm_move.h").write_text(text, "utf-8")
    stream = np.repeat(STREAM, [120, 20, 60, 30, 10, 80, 90])
    several = [", ".join(map(repr, x)) for x in (goals, stream.tolist())]
    text = MAIN % (*several, *[len(stream)] * 3)
    text = text.replace("nan", "NAN").replace("inf,", "INFINITY,")
    (tmp_path / "main.c").write_text(text, "utf-8")
    words = "-std=c99 -Wall -Wextra -Wconversion -Wdouble-promotion -Werror -pedantic"
    build = ["cc", *words.split(), "main.c", "-o", "main"]
    subprocess.run(build, cwd=tmp_path, check=True)
    done = subprocess.run(["./main"], cwd=tmp_path, capture_output=True, check=True)
    found = np.array(done.stdout.split(), float)
    found, followed = np.split(found, [-len(stream) - 150])
    mine, here = [], 0.0
    for goal in np.array(goals, np.float32 if precision == "single" else float):
        mine += [*profile.points(float(goal) - here, here)[1:-1], float(goal)]
        here = float(goal)
    off = 1e-15 if precision == "double" else 1e-6
    assert len(found) == len(mine) and abs(found - mine).max() <= 30 * off
    again = profile.follow(stream, 0.3)
    here = followed[: len(stream)]
    assert abs(here - again).max() <= (0 if precision == "double" else 1e-6)
    assert len(set(followed[-40:])) == 1 and followed[-1] != again[-1]  # it has stopped
    assert precision == "single" or kept(profile, followed)
    ends = np.cumsum([profile.ticks(b - a) for a, b in zip([0, *goals], goals)]) - 1
    assert (found[ends] == np.array(mine)[ends]).all()


def test_what_a_move_leaves_of_the_limit_is_left_for_a_step(c):
    """In mid-move the set point jumps: with the limit, every drive still arrives."""
    limited = c.limit(2.0)
    reach = limited.bounds.reach(seconds=60, asked=1.5)
    whole = limited.bounds.reach(seconds=60)
    assert 0 < reach.step <= 0.26 * whole.step
    move = c.motions.move(20.0, u_max=1.5)
    r = move.profile.points(20.0)
    for at in (len(r) // 4,):  # where it accelerates most
        moved = r + reach.step * (np.arange(len(r)) >= at)
        run = limited.simulate(
            len(r) * T + 0.7, r=lambda t, x=moved: [x[min(round(t / T), len(x) - 1)]]
        )
        assert abs(run.u).max() <= 2 and not run.fault.any()
        assert abs(run.x[:, -1, 1] - moved[-1]).max() < 1e-2
    with pytest.raises(ValueError, match="leaves nothing"):
        limited.bounds.reach(asked=2.0)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_a_program_with_moves_runs_as_bounded(c, tmp_path):
    """From what was asked to compiled C, with another weight of the set point."""
    move = c.motions.move(20.0, u_max=2.0)
    moved = c.set_point(profile=move.profile)
    code = Code(moved, "arm")
    assert code.texts["arm_sketch/arm_move.h"] == code.texts["arm_move.h"]
    code.write(tmp_path)
    assert (tmp_path / "arm_move.h").read_text("utf-8") == move.profile.to_c("arm")
    limits = move.profile.velocity, move.profile.acceleration, move.profile.jerk
    for words in (c.motions.follow(*limits, output=0), c.motions.follow(*limits)):
        assert str(words) in " ".join(bounded(moved, ()))
    r = move.profile.points(20.0)
    weighted, runs = moved.limit(2.0).set_point(b=0.427), []
    for more in ({}, {"program": CompiledCode(weighted, runs=2)}):
        goal = dict(r=lambda t: [r[min(round(t / T), len(r) - 1)]])
        runs.append(weighted.simulate(1.1, **goal, **more))
    assert (runs[0].u == runs[1].u).all() and not runs[1].fault.any()
    assert abs(runs[1].x[:, -1, 1] - 20).max() < 0.1
    with pytest.raises(ValueError, match="profile has T"):
        c.set_point(profile=Profile(1.0, 1.0, 1.0, 0.5))


RUBBING = {  # M, D and S of a first and a second end; gains; filter and T; way, u_max
    "turntable": (
        lambda q: ([[0.01, 0], [0, 0.01 + 0.02 * q]], [[0.03, -0.01], [-0.01, 0.01]],
                   [[10, -10], [-10, 10]]),
        (-4, -0.5, -10), (0.01, 0.002), 10.0, 1.88,
    ),
    "cart in oil": (
        lambda q: ([[2.943 * (1 + q)]], [[98.1]], [[0]]),
        (-981, -98.1, -98.1), (0.03, 0.01), 0.3, 30.0,
    ),
}  # fmt: skip


def rubbing(name):
    """The controller, its plant by q, and the way and limit of one of RUBBING."""
    made, gains, (lag, T), *asked = RUBBING[name]

    def plant(q):
        M, D, S = made(q)
        return sos.SecondOrderSystem(M, D, S, np.eye(len(M))[:, :1])

    n = plant(0).n
    law = sos.PIDLaw(position=np.eye(n)[:1], integrate=True, filter=lag)
    names = dict(zip(("K_P", "K_D", "K_I"), ([[x]] for x in gains)))
    design = sos.analyse_pid(sos.Uncertain(plant, q=(0, 1)), names, law=law)
    return design.controller(T=T, delay=T), plant, *asked


def late(c, plant):
    """(F, G, H) of a loop that acts a tick late, [x; u before; memory], by hand."""
    A, before, _ = held(plant, c.T, 0.0)
    rows, (N, m), l = c.readings.rows, before.shape, c.order
    H = np.hstack([c.D @ rows, np.zeros((m, m)), c.C])
    own = np.hstack([c.B @ rows, np.zeros((l, m)), c.A])
    F = np.vstack([np.hstack([A, before, np.zeros((N, l))]), H, own])
    return F, np.concatenate([np.zeros(N), c.D_r[:, 0], c.B_r[:, 0]]), H[0]


def within(limits, T, wanted):
    """Two v that want to be positive where ``wanted`` says so, but for v, a and j."""
    V, A, J = limits
    now, found = np.zeros(2), []
    for up in wanted:
        way = np.where(up, A * T, -A * T)
        now = np.clip(now + way, -V, V)
        found.append(now)
    many = int(np.ceil(2 * A / (J * T)))
    several = np.pad(found, ((many - 1, 0), (0, 0)))
    return np.lib.stride_tricks.sliding_window_view(several, many, 0).mean(axis=2).T


@pytest.mark.parametrize("name", by_turns(RUBBING, 1))
def test_motions_ask_no_more_than_is_proven_where_speed_costs_something(name):
    """Where an integral is slow a bound by jerk alone was twice what motions ask."""
    c, plant, way, u_max = rubbing(name)
    move, profile = c.motions.move(way, u_max), c.motions.limits_for(u_max, way)
    limits = profile.velocity, profile.acceleration, profile.jerk
    proven, T = c.motions.follow(*limits, output=0).proven, c.T
    assert 0.97 * u_max < proven <= u_max
    ticks = 2 * move.profile.ticks(way)
    drawn = np.random.default_rng(6).normal(size=(ticks, 1)) > 0
    moved, asked = [], []
    for q in (0.0, 1.0):
        F, G, H = late(c, plant(q))
        left = np.eye(len(F)) - F
        x = np.linalg.solve(left, G)
        y, later = np.linalg.solve(left, x), []
        for _ in range(ticks):  # what a speed and an acceleration ask later
            later.append((-H @ x, H @ y))
            x, y = F @ x, F @ y
        speeds = np.diff(move.profile.points(way))
        moved.append(abs(np.convolve(speeds, np.array(later)[:, 0])[:ticks]).max())
        for wanted in (np.array(later[::-1]) > 0, drawn):
            for v in within(limits, T, wanted):
                sums = np.convolve(v * T, np.array(later)[:, 0])[:ticks]
                asked.append(abs(sums).max())
    assert max(moved) <= move.effort[0].proven <= 1.1 * max(moved)
    assert 0.8 * proven < max(asked) <= proven


MACHINES = {  # heaviest, lightest; K_P, K_D, K_I; filter, T, u_max, way, friction
    "satellite": ((70, 130), (-12, -60, -0.6), (0.5, 0.1), 0.2, np.pi / 6, 0.004),
    "slide": ((0.3, 0.5), (-98.1, -9.81, -98.1), (0.01, 0.002), 9.81, 3.0, 0.3),
}


# in the gate a satellite whose panel rings moves and steps so, compiled and with
# friction, in tests/test_controllers_modes; and the test above has motions that follow
@pytest.mark.campaign
@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("name", ["slide", "satellite"])
def test_compiled_machines_move_step_and_follow_as_proven(name):
    """Plants of my own, a tick late: with friction they keep near, without within."""
    ends, gains, (lag, T), u_max, way, rubs = MACHINES[name]
    masses = np.linspace(*ends, 3)
    family = sos.Uncertain(lambda m: sos.SecondOrderSystem(m, 0, 0, 1), m=ends)
    law = sos.PIDLaw(position=[[1]], integrate=True, filter=lag)
    names = dict(zip(("K_P", "K_D", "K_I"), ([[x]] for x in gains)))
    design = sos.analyse_pid(family, names, law=law, region=sos.PoleRegion(0.03))
    c = design.controller(T=T, delay=T).limit(u_max).watch(stall=1e3 * T)

    def ran(c, r, friction=0.0):
        program = CompiledCode(c, runs=3)
        z, v, now, seen = np.zeros(3), np.zeros(3), np.zeros(3), []
        program.start(z[None])
        for goal in r:
            u = program.step(z[None], [goal])[0]
            seen.append((z - goal, u, z))
            sticks = (v == 0) & (abs(now) <= friction)
            force = np.where(sticks, 0, now - friction * np.sign(np.where(v, v, now)))
            after = v + T * force / masses
            after = np.where(after * v < 0, 0, after)  # it sticks, and may break loose
            z, v, now = z + T * (v + after) / 2, after, u
        assert not program.fault.any()
        return np.array(seen).transpose(1, 0, 2)

    move = c.motions.move(way, u_max)
    rest = [way] * round(160 * lag / T)
    off, u, _ = ran(c, [*move.profile.points(way), *rest])
    assert abs(off).max() <= move.error.proven and abs(u).max() <= move.effort[0].proven
    assert move.duration < 1.3 * 2 * np.sqrt(way * ends[1] / u_max)  # by bangs
    off, u, _ = ran(c, [*move.profile.points(way), *rest], rubs)
    assert abs(u).max() <= u_max and abs(off[-1]).max() < 0.03 * way
    soft = c.bounds.weights(0.05, u_max, size=way / 30)
    *_, z = ran(soft, [way / 30] * len(rest))
    assert 0.99 < z[-1].min() * 30 / way and z.max() <= 1.05 * way / 30
    profile = c.motions.limits_for(u_max, way)
    goals = np.repeat(np.random.default_rng(7).uniform(-way, way, 6), len(rest) // 9)
    assert abs(ran(c, profile.follow(goals))[1]).max() <= u_max * 0.999


def floated(c, r, ks, metre=1.0, ampere=1.0, program=None):
    """(u, gap - r) of a bearing of my own at rest at r[0], at all ticks."""
    A = np.array([[0, 1, 0], [ks / 2, 0, 100 * metre / ampere], [0, 0, 0]])
    flow, found = expm(A * c.T)[:2], []
    x = np.array([r[0], 0.0])
    rest = -ks / 200 / metre * ampere * r[0]  # what holds it there
    memory = np.linalg.lstsq(c.C, rest - c.D @ x - c.D_r[:, 0] * r[0], rcond=None)[0]
    for goal in r:
        u = c.C @ memory + c.D @ x + c.D_r[:, 0] * goal
        found.append((u[0], x[0] - goal))
        memory = c.A @ memory + c.B @ x + c.B_r[:, 0] * goal
        x = flow @ [*x, u[0]]
    return abs(np.array(found)).max(axis=0)


@pytest.mark.parametrize("units", [(1, 1), (9.81, 0.3)])
def test_a_magnet_that_holds_a_rotor_moves_it_as_proven(units):
    """It pulls the rotor away: at rest u isn't zero, and each plant has its own."""
    metre, ampere = units
    c, limit = bearing(*units)[1], 5.0 * ampere
    for start, way in ((0.0, 3e-4), (-2e-4, 3e-4)):
        start, way = start * metre, way * metre
        move = c.motions.move(way, start=start)
        r = [*move.profile.points(way, start), *[start + way] * 200]
        each = [floated(c, r, ks, *units) for ks in np.linspace(1e5, 3e5, 5)]
        true = np.max(each, axis=0)
        proven = np.array([move.effort[0].proven, move.error.proven])
        assert (true <= proven).all() and (proven < 1.01 * true).all()
        assert 0.9 * limit < move.effort[0].proven <= limit
    safe = c.motions.limits_for(None, way, start=start)
    far = max(abs(start), abs(start + way))
    assert safe.range == far and way / c.T > safe.velocity
    sizes = safe.velocity, safe.acceleration, safe.jerk
    proven = c.motions.follow(*sizes, output=0, range=far).proven
    goals = np.repeat(np.random.default_rng(3).choice([-far, far], 12), 60)
    r = safe.follow(goals, far)
    worst = max(floated(c, r, ks, *units)[0] for ks in (1e5, 2e5, 3e5))
    assert 0.4 * proven < worst <= proven <= limit
    with pytest.raises(ValueError, match="range is missing"):
        c.motions.follow(*sizes, output=0)
    with pytest.raises(ValueError, match="springs may ask 1.8 times"):
        c.motions.move(6e-3 * metre)
    text = " ".join(bounded(c.set_point(profile=safe), ()))
    assert f"within {far:.6g} of zero, and" in text and "without its limit" not in text


def test_a_weight_of_a_magnet_that_holds_a_rotor():
    """Half of its step is overshoot without one; what is in vain two plants prove."""
    c = bearing()[1]
    assert c.bounds.step_response(1e-4).overshoot.proven > 0.49
    soft = c.bounds.weights(0.1, 5.0, size=1e-4)
    found = soft.bounds.step_response(1e-4)
    for ks in (1e5, 1.7e5, 3e5):
        asked, _ = floated(soft, [0.0, *[1e-4] * 300], ks)
        assert asked <= found.effort[0].proven <= 5.0
    assert found.overshoot.proven <= 0.1 and 0 < soft.R[0, 0] < 1
    for over, most in ((0.05, 5.0), (0.5, 0.5)):
        with pytest.raises(ValueError, match="no b keeps to it.*proven by one program"):
            c.bounds.weights(over, most, size=1e-4)


def spring(k, m=1.3):
    return sos.SecondOrderSystem(m, 0.05, k, 1, coordinates=["place"])


@pytest.mark.parametrize("several", [False, *campaign([True])])
def test_springs_leave_each_plant_its_own_rest_and_a_step_is_bounded(several):
    law = sos.PIDLaw(position=[[1]], integrate=True, filter=0.01)
    ranges = dict(k=(2, 9.81), **({"m": (1, 1.6)} if several else {}))
    gains = {"K_P": [[-30.0]], "K_D": [[-9.0]], "K_I": [[-40.0]]}
    design = sos.analyse_pid(sos.Uncertain(spring, **ranges), gains, law=law)
    c = design.controller(T=0.01, delay=0.006)
    found = c.bounds.step_response(size=0.3)
    t, low, high = found.curves
    rows, rng, seen = c.readings.rows, np.random.default_rng(1), np.zeros(3)
    for _ in range(6):
        some = {x: rng.uniform(*ends) for x, ends in ranges.items()}
        A, now, before = held(spring(**some), 0.01, 0.006)
        x, old, xi, places, force = np.zeros(2), 0.0, np.zeros(c.order), [], []
        for _ in t:
            u = (c.D @ rows @ x + c.C @ xi + c.D_r[:, 0] * 0.3)[0]
            places.append(x[0])
            force.append(u)
            xi = c.A @ xi + c.B @ rows @ x + c.B_r[:, 0] * 0.3
            x, old = A @ x + now[:, 0] * u + before[:, 0] * old, u
        places, force = np.array(places), np.array(force)
        assert (low <= places).all() and (places <= high).all()
        out = np.flatnonzero(abs(places - 0.3) > 0.02 * 0.3)
        measures = places.max() / 0.3 - 1, t[out[-1] + 1], abs(force).max()
        seen = np.maximum(seen, measures)
    proven = found.overshoot, found.settling_time, found.effort[0]
    for one, bound in zip(seen, proven):
        assert one <= bound.proven <= bound.seen * 1.02 and bound.seen < 1.2 * one
    # at rest the stiffest spring asks k z: a bound of what moves alone would miss it
    assert c.bounds.step_response(output="place'").effort[0].proven >= 9.81
    with pytest.raises(ValueError, match="StepBounds.effort"):
        c.bounds.step_response(output=0)


def test_what_cannot_be_asked_is_said(c):
    with pytest.raises(ValueError, match="u_max is missing"):
        c.motions.move(1.0)
    with pytest.raises(ValueError, match="acceleration"):
        c.motions.follow(1.0, -1.0)
    with pytest.raises(ValueError, match=r"distance = 1e\+09 .* take a shorter one"):
        c.motions.move(1e9, 2.0)
    for ask in (c.bounds.weights, sos.controllers.StepLimits):
        with pytest.raises(ValueError, match="0.05 for 5 %; got 5"):
            ask(overshoot=5)
    with pytest.raises(ValueError, match="larger jerk or a longer T"):
        Profile(1e9, 1.0, 1e-3, 1e-6)
    with pytest.raises(ValueError, match="jerk"):
        Profile(1.0, 1.0, 0.0, 0.01)
