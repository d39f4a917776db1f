"""The law that holds a heading: proven, as C, and on unequal motors."""

import ctypes
import sys
from dataclasses import replace

import numpy as np
import pytest

import tests.test_mip_export as programs
from sosbook.pendulum import Firmware, Robot, SampledLaw, recommend, steering_design
from sosbook.pendulum.compiled import FLAGS, Compiled
from sosbook.pendulum.drive import Drive
from sosbook.pendulum.export import Program as Written
from sosbook.pendulum.spread import scaled, vertices
from sosbook.pendulum.steering import Steering
from sosbook.pendulum.steering_design import SteeringDesign
from sosbook.pendulum.steering_design import _both as both_laws
from sosbook.pendulum.ticks import TickLog
from sosbook.pendulum.tuning import DELAY_SHARES
from sosbook.pendulum.turning import inertia_bounds, turning_plants, unequal_plant
from sosbook.proofs import load
from sosbook.sampled import sampled_loop
from tests.cases import campaign, later
from tests.compiler import run
from tests.gains import named
from tests.geared_robots import ALL
from tests.six_robots import by_its_sheet, pendulum, spared, wired
from tests.test_mip_recording import cpp, sketch_program
from tests.test_mip_robot import told
from tests.test_mip_sketch import BOARD, live
from tests.turning import TURNER, advance, drive, ramp, steer_functions

assert cpp  # a fixture
fake_pyctrl = programs.fake_pyctrl
MACHINE = TURNER.machine
ROBOT = wired(MACHINE, delay=MACHINE.delay, track=TURNER.track)
MIP = pendulum(MACHINE)
FIRMWARE = Firmware(
    SampledLaw.of_gain(named(programs.PRINTED.pid[5]), 0.01), blend=0.02, limit=7.4
)
STEERING = Steering(FIRMWARE, [[-0.93, -0.29, -0.52]], 0.25, 0.07, 0.034)


@pytest.fixture(scope="module")
def found():
    """A deployment that steers; motors that differ have a test of their own."""
    found = spared(recommend(MIP, R=None, robot=ROBOT))
    spared(found.steering, unequal=())
    return found


def alike(design, **changes):
    """A design of steering with ``changes``, the same law and the same proofs of it."""
    same = "_chosen", "sampled", "certificate", "held"
    return spared(replace(design, **changes), **{x: getattr(design, x) for x in same})


# The plant and the law


def test_own_equations_keep_their_energy():
    free = replace(MACHINE, stall=1e-9)  # motors without torque or back-EMF
    turner = replace(TURNER, machine=free)
    x = np.array([0.3, 0.0, 0.0, 0.4, 3.0, 2.0])
    before = turner.energy(x)
    after = turner.energy(advance(turner.rate, x, np.zeros(2), 0.3, 3000))
    assert after == pytest.approx(before, rel=1e-7)


def test_the_plant_is_the_machines_about_upright():
    """Slopes of its own equations: a_d delta'' + f delta' = e W."""
    robot = ROBOT.but(turning=(TURNER.upright, TURNER.upright))
    inertia, same = inertia_bounds(MIP, robot)
    assert inertia == same
    per = ROBOT.track / ROBOT.r

    def ddelta(turn, W):
        x = np.array([0, 0, 0, 0, 0, turn / per])
        return TURNER.rate(x, [-W / 2, W / 2])[5] * per

    assert ddelta(0, 1.0) == pytest.approx(MIP.e / inertia, rel=1e-9)
    assert ddelta(1.0, 0) == pytest.approx(-MIP.f / inertia, rel=1e-9)
    low, high = inertia_bounds(MIP, ROBOT)
    assert low < inertia < high == pytest.approx(MIP.a)


def test_the_limits_of_a_drive_are_what_the_machines_motors_can():
    """By its own equations: 40 % of what the volts hold, reached with half of them."""
    limit, share = ROBOT.limit, ROBOT.steering
    robot = ROBOT.but(turning=(TURNER.upright, TURNER.upright))
    limits = Drive.of(MIP, limit).turning(MIP, robot)
    turner = replace(TURNER, machine=replace(MACHINE, friction=0.0))

    def turns(psi, volts):
        """psi'' of a robot whose right motor gets so much and the left as little."""
        return turner.rate(np.array([0, 0, 0, 0, 0, psi]), [-volts, volts])[5]

    rolls = np.array([0, 0, 0, 0, limits.speed / 0.4, 0])
    assert np.array(turner.torques([limit, limit], rolls)) == pytest.approx(0, abs=1e-9)
    assert limits.turn > 0 < limits.turn_acceleration
    assert turns(limits.turn / 0.4, share * limit) == pytest.approx(0, abs=1e-9)
    half = turns(0.0, share * limit / 2)
    assert limits.turn_acceleration == pytest.approx(half, rel=1e-9)
    # whatever the inertia is within its bounds, these volts reach it
    assert Drive.of(MIP, limit).turning(MIP, ROBOT).turn_acceleration <= half
    left, right = turner.wheels([0, 0, 0.3])
    assert STEERING.per_radian * 0.3 == pytest.approx(right - left)


def test_the_rectangle_and_its_triangles_hold_every_plant_that_is_meant():
    whole, *parts = turning_plants(MIP, ROBOT, 0.04)
    corners = [(p.M[0, 0], p.D[0, 0]) for p in whole.vertices]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    for e in (0.96, 1.04):
        for inertia in inertia_bounds(MIP, ROBOT):
            # 2 I_w and a move with e, or stay: both quotients lie within
            for moved in (e, 1.0):
                m = inertia * moved / (MIP.e * e)
                assert low[0] <= m * (1 + 1e-12) and m <= high[0] * (1 + 1e-12)
        assert low[1] <= MIP.f / (MIP.e * e) * (1 + 1e-12)
    assert [p.N for p in parts] == [3, 3]


@pytest.mark.slow
def test_it_is_designed_and_proven(found):
    design = found.steering
    assert found.proven and design.lacking == ()
    assert design.sensitivity <= 2 and design.coupled_radius < 1
    assert np.array_equal(design.law.K, design.certificate.K)
    assert design.delayed.request.tau + design.delayed.request.mu == pytest.approx(
        ROBOT.T + ROBOT.delay
    )


@pytest.mark.slow
@pytest.mark.parametrize("name, held", [("tele", 1), *later(("lego", 1), ("hub", 2))])
def test_it_is_damped_fast_and_never_feeds_the_rate_back_positively(
    name, held, monkeypatch
):
    """By the roots of its characteristic polynomial, for plants of the rectangle.

    Behind the hold and with delays that vary the rate ``held`` is proven.
    """
    machine = ALL[name]
    mip = pendulum(machine)
    robot = by_its_sheet(machine, track=4 * machine.r, friction=False)
    firmware = Firmware(replace(FIRMWARE.law, T=machine.T))
    design = SteeringDesign(robot, (mip, *vertices(mip)), 0.04, firmware, None, 2.0)
    ((k, k_rate, k_sum),) = design.law.K
    assert max(k, k_rate, k_sum) < 0
    assert "Re s < -2" in " ".join(design.certificate.claims)
    assert design.delayed.request.delta == held
    assert all(proof.proven for proof in design.proofs.values())
    corners = [(p.M[0, 0], p.D[0, 0]) for p in design.plants[0].vertices]
    for m, d in np.linspace(np.min(corners, axis=0), np.max(corners, axis=0), 7):
        poles = np.roots([m, d - k_rate, -k, -k_sum])
        assert poles.real.max() < -2 and (-poles.real > abs(poles.imag)).all()
    if name == "lego":  # the others' peaks would be too high, too
        monkeypatch.setattr(steering_design, "DECAYS", (0.5,))
        slow = replace(design, robot=robot.but(T=0.2, delay=0.2))
        with pytest.raises(ValueError, match="ing: no R keeps.* fed back positively"):
            slow.law


KEYS = "track", "steering", "unequal", "turning"


@pytest.mark.slow
def test_what_is_written(found, tmp_path):
    paths = {path.name: path for path in found.write(tmp_path / "with")}
    plain = told(found, replace(ROBOT, **dict.fromkeys(KEYS)))
    assert plain.steering is None
    # the same proofs aren't made twice
    spared(plain, sampled=found.sampled, held=found.held, certificate=found.certificate)
    others = {path.name: path for path in plain.write(tmp_path / "without")}
    more = set(paths) - set(others)
    assert {x for x in more if x.startswith("balance")} == {
        f"balance{x}_steer.{end}" for x in ("", "_single") for end in "ch"
    }
    for name in ("balance.c", "balance_single.c"):  # but for the header's words
        code = [p.read_text("utf-8").split("*/", 1)[1] for p in (paths[name],)]
        assert code == [others[name].read_text("utf-8").split("*/", 1)[1]]
    for name, proof in found.steering.proofs.items():
        assert load(paths[f"proof_balance_{name}.json"]) == proof
    header = " ".join(paths["balance_gains.h"].read_text("utf-8").split())
    assert "motors that differ" in header and "steering's proof" in header


def test_the_loops_as_one_are_the_machines(found):
    """With equal motors the coupled loop has both loops' eigenvalues."""
    design = alike(found.steering, robot=ROBOT.but(unequal=0.0))
    steered = max(
        abs(np.linalg.eigvals(matrix)).max()
        for plants in design.plants[1:]
        for share in DELAY_SHARES
        for matrix in sampled_loop(
            plants, design.law.system, ROBOT.T, share * ROBOT.delay
        )
    )
    # the corners' inertia is larger than any of a_d here
    assert design.coupled_radius <= max(found.radius, steered) * (1 + 1e-9)
    assert design.coupled_radius >= found.radius * (1 - 1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("first", [4, *campaign([0])])
def test_motors_that_differ_are_proven_at_each_robot(
    first, found, tmp_path, monkeypatch
):
    """The gate takes a corner and the largest delay alone; between robots and delays,
    where nothing is proven, no plant is found that is unstable."""
    shares = (1.0,) if first else steering_design.DELAY_SHARES
    monkeypatch.setattr(steering_design, "DELAY_SHARES", shares)
    design = alike(found.steering, robots=found.steering.robots[first:])
    again = told(found, ROBOT)
    known = {x: getattr(found, x) for x in ("sampled", "held", "certificate")}
    spared(again, steering=design, **known)
    assert design.unequal_proven
    assert len(design.unequal) == (5 - first) * 2 * len(shares)  # and two inertias
    said = again.facts["motors that differ"]
    assert "every e and f of the right motor up to 10 %" in said
    paths = [p for p in again.write(tmp_path) if p.parent.name == "unequal_motors"]
    assert len(paths) == len(design.unequal)
    proof = load(paths[-1])
    assert proof == design.unequal[-1] and proof.proven

    random, worst = np.random.default_rng(4), 0.0
    for _ in range(300):
        body, wheels = random.uniform(0.96, 1.04, 2)
        mip = scaled(MIP, body, wheels)
        low, high = inertia_bounds(mip, ROBOT)
        pair = random.uniform(-ROBOT.unequal, ROBOT.unequal, 2)
        plant = unequal_plant(mip, random.uniform(low, high), *pair)
        law, late = both_laws(design.balance, design.law.system), random.uniform(0, 1)
        (F,) = sampled_loop(plant, law, ROBOT.T, late * ROBOT.delay)
        worst = max(worst, abs(np.linalg.eigvals(F)).max())
    print(worst)
    assert worst < 1


@pytest.mark.slow
def test_motors_of_which_nothing_is_proven_are_said_to_be_so(found, monkeypatch):
    monkeypatch.setattr(steering_design, "UNEQUAL_CELLS", 1)
    assert not alike(found.steering, robot=ROBOT.but(unequal=0.5)).unequal_proven
    again = told(found, ROBOT.but(unequal=0.0))
    equal = alike(found.steering, robot=again.robot)
    assert equal.unequal == ()
    known = {x: getattr(found, x) for x in ("sampled", "held", "certificate")}
    spared(again, steering=equal, **known)
    said = again.facts["motors that differ"]
    assert "Of motors that differ nothing is proven" in said


def test_the_plant_of_unequal_motors_has_the_machines_slopes():
    turner, per = replace(TURNER, more=0.1, brake=-0.07), ROBOT.track / ROBOT.r
    inertia = inertia_bounds(MIP, ROBOT.but(turning=2 * (TURNER.upright,)))[0]
    plant = unequal_plant(MIP, inertia, 0.1, -0.07)
    scale = np.array([1, 1, per])

    def acceleration(z, u):
        x, (V, W) = np.divide(z, np.tile(scale, 2)), u
        return turner.rate(x, [V - W / 2, V + W / 2])[3:] * scale

    step = 1e-6
    for z in step * np.eye(6):
        force = plant.S @ z[:3] + plant.D @ z[3:]
        ours = -np.linalg.solve(plant.M, force) / step
        assert ours == pytest.approx(acceleration(z, (0, 0)) / step, rel=1e-5, abs=1e-3)
    for u in step * np.eye(2):
        ours = np.linalg.solve(plant.M, plant.B @ u) / step
        theirs = acceleration(np.zeros(6), u) / step
        assert ours == pytest.approx(theirs, rel=1e-6)


# The arithmetic


class Program:
    """The C of both laws in a library."""

    def __init__(self, gcc, folder, steering, precision):
        self.law = Compiled(steering.firmware, precision, folder)
        written = Written(steering.firmware, precision=precision, steering=steering)
        programs.write(folder, written)
        library = folder / "steer.so"
        flags = [*FLAGS, *programs.STRICT, "-shared", "-fPIC"]
        run(*gcc, *flags, folder / "balance_steer.c", "-o", library)
        real = {"double": ctypes.c_double, "single": ctypes.c_float}[precision]
        functions = steer_functions(ctypes.CDLL(str(library)), real)
        self.state, self.volts, self._start, self._step = functions

    def start(self, tilt, left, right, bias=0.0):
        self.law.start(tilt, (left + right) / 2, bias)
        self._start(self.state, left, right)

    def step(self, gyro, left, right, tilt, target, rate, heading, turn):
        self.law.step(gyro, (left + right) / 2, tilt, target, rate)
        state = ctypes.byref(self.law.states[0])
        self._step(self.state, state, left, right, heading, turn, self.volts)
        return tuple(self.volts)


@pytest.mark.parametrize("precision, kind", [("double", float), ("single", np.float32)])
def test_the_c_is_the_controller_to_the_last_bit(precision, kind, gcc, tmp_path):
    program = Program(gcc, tmp_path, STEERING, precision)
    ours, steered = FIRMWARE.controller(kind=kind), STEERING.controller(kind=kind)
    random = np.random.default_rng(5)
    rows = random.normal(0, 0.03, (400, 8)).astype(kind)
    rows[:, 1:3] = np.cumsum(random.normal(0, 0.05, (400, 2)), axis=0)
    rows[:, 6] *= 20  # headings that ask for more than there is
    rows[40, 2] += 7.0  # a jump
    rows[60:63, 1] = np.nan
    rows[90, 6], rows[95, 7] = np.nan, np.inf
    rows[397, 3] = rows[398, 0] = 90.0
    program.start(0.05, 0.3, 0.1)
    ours.start(kind(0.05), (kind(0.3) + kind(0.1)) / 2)
    steered.start(0.3, 0.1)
    used = []
    for row in rows:
        gyro, left, right, tilt, target, rate, heading, turn = map(kind, row)
        V = ours.step(gyro, (left + right) / 2, tilt, target, rate)
        volts = steered.step(V, ours.fault, left, right, heading, turn)
        theirs = program.step(*map(float, row))
        if kind is np.float32:  # the mean in single precision, as the sketch has it
            theirs = tuple(map(np.float32, theirs))
        assert theirs == (volts[0][0], volts[1][0])
        if not ours.fault[0] and np.isfinite(V[0]):
            assert np.mean(volts) == pytest.approx(float(V[0]), abs=1e-5)
            assert abs(np.array(volts)).max() <= kind(FIRMWARE.limit)
            used.append(abs(float(volts[1][0] - volts[0][0])) / 2)
    assert max(used) == pytest.approx(STEERING.volts, rel=1e-6) and min(used) == 0.0


@pytest.mark.parametrize("kind", [float, np.float32])
def test_robots_side_by_side_steer_as_each_does_alone(kind):
    random = np.random.default_rng(6)
    rows = random.normal(0, [[3.0], [0.1], [0.1], [5.0], [1.0]], (200, 5, 4))
    rows[random.random(rows.shape) < 0.02] = np.nan
    faults = np.where(random.random((200, 4)) < 0.05, 2, 0)
    fleet, *single = (STEERING.controller(runs, kind) for runs in (4, 1, 1, 1, 1))
    for each in (fleet, *single):
        each.start(0.1, 0.2)
    for row, fault in zip(rows, faults):
        together = np.array(fleet.step(row[0], fault, *row[1:]))
        for k, one in enumerate(single):
            alone = one.step(row[0, k], fault[k], *map(float, row[1:, k]))
            assert np.array_equal(together[:, k], np.ravel(alone), equal_nan=True)
            assert alone[0].dtype == kind
    assert fleet.sum.any() and fleet.sum.tolist() == [one.sum[0] for one in single]


@pytest.mark.parametrize("start", [(np.nan, 0.1), (0.3, np.nan), (np.inf, -np.inf)])
def test_a_start_without_a_reading_begins_with_the_first_one(start, gcc, tmp_path):
    """It isn't a robot that never steers: C and Python alike."""
    program = Program(gcc, tmp_path, STEERING, "double")
    ours, steered = FIRMWARE.controller(), STEERING.controller()
    program.law.start(0.0, 0.0)
    ours.start(0.0, 0.0)
    program._start(program.state, *start)
    steered.start(*start)
    rows = [(np.nan, 0.0), (0.0, np.nan), (5.0, 5.5), (5.0, 5.6), (5.0, 5.6)]
    pushed = []
    for k, (left, right) in enumerate(rows):
        V = ours.step(0.0, 0.0, 0.0)
        found = steered.step(V, ours.fault, left, right, target=0.2)
        theirs = program.step(0.0, left, right, 0.0, 0, 0, 0.2, 0.0)
        assert tuple(np.ravel(found)) == theirs
        pushed.append(theirs[1] - theirs[0])
        assert steered.lost == (k + 1 if k < 2 else 0)
    assert pushed[:2] == [0.0, 0.0]  # nothing is known yet
    K, T = STEERING.K[0], 0.01
    assert pushed[2] == pytest.approx(-0.2 * K[0])  # the first reading is zero
    room = 2 * STEERING.volts
    later = -0.1 * K[0] + 0.1 / T * K[1] - 0.2 * T * K[2]
    assert pushed[3] == pytest.approx(np.clip(later, -room, room))


# On a robot whose motors differ


@pytest.mark.slow
@pytest.mark.parametrize("more", [0.1, *campaign([-0.1])])
def test_unequal_motors_turn_a_robot_that_does_not_steer(more, found, gcc, tmp_path):
    turner = replace(TURNER, more=more, brake=-more)
    program = Program(gcc, tmp_path, found.steering.law, "double")

    def steered(*seen):
        per = found.steering.law.per_radian
        return program.step(*seen[:6], per * seen[6], per * seen[7])

    def plain(*seen):
        program.step(*seen[:6], 0, 0)
        return 2 * [float(program.law.states[0].volts)]

    ends, worst = {}, {}
    for name, law in (("steered", steered), ("plain", plain)):
        program.start(0.05, 0.0, 0.0)
        path, volts = drive(turner, law, speed=8.0)
        assert len(path) == 1200 and program.law.fault[0] == 0
        assert abs(path[:, 0]).max() < 0.35
        assert abs(volts).max() <= ROBOT.limit
        assert path[-1, 4] == pytest.approx(8.0, abs=1.5)
        ends[name], worst[name] = path[-1, 2], abs(path[:, 2]).max()
    print(more, ends, worst)
    assert abs(ends["plain"]) > 1.0  # rad: it drives in a circle
    assert worst["steered"] < 0.3 and abs(ends["steered"]) < 0.03


@pytest.mark.slow
def test_a_turn_is_followed_while_it_rolls(found, gcc, tmp_path):
    program = Program(gcc, tmp_path, found.steering.law, "single")
    per = found.steering.law.per_radian

    def steered(*seen):
        return program.step(*seen[:6], per * seen[6], per * seen[7])

    program.start(0.05, 0.0, 0.0)
    turn = 0.8 * found.drive.turn
    path, _ = drive(UNEQUAL, steered, speed=4.0, turn=turn)
    assert program.law.fault[0] == 0 and abs(path[:, 0]).max() < 0.35
    assert path[-1, 5] == pytest.approx(turn, rel=0.05)
    assert path[-1, 2] == pytest.approx(path[-1, 8], abs=0.1)


# The programs


def heard(rows):
    """What rc_balance's wheels read, left and right."""
    one = 6.283185307179586 / programs.COUNTS_PER_TURN
    return [(row[3] * one, -row[4] * one) for row in rows]


LINES = "#define _POSIX_C_SOURCE 200809L\n" + programs.STUB.replace(
    '#include "robotcontrol.h"',
    '#include <unistd.h>\n#include "robotcontrol.h"\nstatic int way[2];\n'
    "static FILE *ticks;",
)
for _old, _new in (
    ("    if (scanf(", '    if (!ticks) {\n        ticks = fdopen(dup(0), "r");\n'
     "        if (pipe(way) || dup2(way[0], 0))\n            return;\n    }\n"
     "    if (fscanf(ticks, "),
    ("    if (word == 's')", "    if (word == 'v' || word == 'p') {\n"
     "        char line[64];\n        const int n = "
     'sprintf(line, "%c %.3f %.3f\\n", word, pitch, rate);\n'
     "        if (write(way[1], line, (size_t)n) != n)\n            state = EXITING;\n"
     "        return;\n    }\n    if (word == 's')"),
):  # fmt: skip
    assert LINES.count(_old) == 1
    LINES = LINES.replace(_old, _new)
LIMITS = Drive(3.0, 5.0, 2.0, 8.0)


def command(word, speed, turn):
    return (word, speed, turn, 0, 0, 0.0)


def rc_log(robot, folder, rows, source):
    ticks, output = robot.live([*programs.REST, *rows], str(folder / "log.csv"), source)
    return TickLog.read(folder / "log.csv"), ticks, output


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
@pytest.mark.parametrize("source, word", [("-", "v"), ("dsm", "d")])
def test_librobotcontrols_program_steers_and_obeys_at_run_time(
    source, word, gcc, tmp_path
):
    robot = programs.Robot(
        gcc, tmp_path, FIRMWARE, stub=LINES, drive=LIMITS, steering=STEERING
    )
    moves = programs.moves(300)
    full = (3.0, 2.0) if word == "v" else (1.0, 1.0)
    more = (9.0, 9.0) if word == "v" else (3.0, 3.0)  # more than it may
    rows = []
    for k, row in enumerate(moves):
        if k < 100 and k % 5 == 0:
            rows.append(command(word, *(full if k < 50 else more)))
        rows.append(row)
    log, ticks, _ = rc_log(robot, tmp_path, rows, source)
    assert abs(log.rate).max() == 3.0 and log.rate[-1] == 0.0  # nobody says more
    assert log.rate[96:195].min() == 3.0 > log.rate[197]  # a second without a word
    steps = abs(np.diff(log.rate[1:]))
    assert steps.max() == pytest.approx(LIMITS.acceleration * 0.01)

    motors = np.column_stack([log.V_left, log.V_right])
    assert abs(motors).max() > 0.5
    assert abs(log.replayed_motors(STEERING) - motors)[log.running].max() < 1e-9
    assert np.allclose(log.left[1:], [a for a, _ in heard(moves)])
    assert np.array_equal(log.replayed(FIRMWARE)[1:], log.V[1:])
    turns = np.diff(log.heading, prepend=0.0) / 0.01
    assert turns.max() == pytest.approx(2.0) and turns[-1] == pytest.approx(0.0)
    sane, (left, right) = log.battery[1:], motors[1:].T
    mean = np.clip((left + right) / 2, -sane, sane)
    half = np.clip((right - left) / 2, abs(mean) - sane, sane - abs(mean))
    duties = np.column_stack([mean - half, -mean - half]) / sane[:, None]
    assert duties == pytest.approx(np.array(ticks[101:])[:, :2], abs=1e-6)


def arrives(log, way, turn):
    """Whether set points reach a place gently, stay, and never pass it."""
    for points, goal, speed, most in (
        (log.target, way, LIMITS.speed, LIMITS.acceleration),
        (log.heading, turn, LIMITS.turn, LIMITS.turn_acceleration),
    ):
        rates = np.diff(points[1:]) / 0.01
        assert points[-1] == pytest.approx(goal, abs=1e-3) and rates[-1] == 0
        assert (np.sign(goal) * np.diff(points[1:]) > -0.3 * most * 0.01**2).all()
        assert abs(rates).max() <= speed + 1e-9
        assert abs(np.diff(rates)).max() <= 0.3 * most * 0.01 + 1e-9


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
def test_librobotcontrols_program_goes_to_a_place(gcc, tmp_path):
    """One command will do; another speed ends it."""
    robot = programs.Robot(
        gcc, tmp_path, FIRMWARE, stub=LINES, drive=LIMITS, steering=STEERING
    )
    still = 500 * [programs.REST[-1]]
    rows = [command("p", 2.0, -0.7), *still]
    log, *_ = rc_log(robot, tmp_path, rows, "-")
    arrives(log, 2.0, -0.7)
    rows = [command("p", 2.0, 0.0), *still[:60], command("v", 0, 0), *still[:200]]
    log, *_ = rc_log(robot, tmp_path, rows, "-")
    assert 0 < log.target[-1] < 1 and log.rate[-1] == 0


def test_a_file_that_goes_away_stops_the_wheels(gcc, tmp_path):
    robot = programs.Robot(gcc, tmp_path, FIRMWARE, drive=LIMITS)
    (tmp_path / "speed.txt").write_text("2 1\n", "utf-8")
    source = str(tmp_path / "speed.txt")
    log, *_ = rc_log(robot, tmp_path, programs.moves(90), source)
    assert log.rate[-1] == 2.0  # a file that stays is a command that stays
    log, *_ = rc_log(robot, tmp_path, programs.moves(90), str(tmp_path / "none"))
    assert set(log.rate) == {0.0}


@pytest.mark.usefixtures("fake_pyctrl")
def test_the_script_steers_and_obeys(gcc, tmp_path):
    about = dict(drive=LIMITS, steering=STEERING)
    _, block = programs.script(gcc, tmp_path, FIRMWARE, **about)
    random = np.random.default_rng(8)
    block.logging = True
    for _ in range(101):
        block.write(-0.065, 0.001, 0.2, 0.3)
    (tmp_path / "speed.txt").write_text("2 -1.5", "utf-8")
    block.obey(tmp_path / "speed.txt")
    assert (block.run.speed, block.run.turn) == (2.0, -1.5)
    for row in random.normal(0, 0.003, (60, 4)) + [-0.065, 0.001, 0.2, 0.3]:
        block.write(*row)
        left, right = block.run.motor
        assert block.read() == pytest.approx((100 * left / 7.4, 100 * right / 7.4))
    assert right < left  # it turns right
    for _ in range(99):
        block.obey(tmp_path / "none.txt")
        block.write(*row)
    assert block.run.speed == block.run.turn == 0.0
    block.save(tmp_path / "log.csv")
    names = (tmp_path / "log.csv").read_text("utf-8").splitlines()[0]
    assert names.endswith("fault,late,left,right,V_left,V_right,heading")
    log = TickLog.read(tmp_path / "log.csv")
    assert len(log.t) > 61 and log.steers
    motors = np.column_stack([log.V_left, log.V_right])
    assert abs(log.replayed_motors(STEERING) - motors).max() < 1e-9
    assert np.array_equal(log.replayed(FIRMWARE), log.V)
    points = ramp(LIMITS, 2.0, 0.01, 60)
    found = np.column_stack([log.target, log.rate])[1:61]
    assert found == pytest.approx(np.array(points))

    block.reset()
    block.rows = []
    (tmp_path / "speed.txt").write_text("p 2 -0.7", "utf-8")
    for k in range(700):
        block.obey(tmp_path / ("none.txt" if k > 300 else "speed.txt"))
        block.write(-0.065, 0.001, 0.2, 0.3)
    block.save(tmp_path / "place.csv")
    arrives(TickLog.read(tmp_path / "place.csv"), 2.0, -0.7)
    (tmp_path / "speed.txt").write_text("p up", "utf-8")
    block.obey(tmp_path / "speed.txt")
    assert (block.run.place, block.run.bearing, block.run.going) == (2.0, -0.7, 2)


TURNS = BOARD
for _old, _new in (
    ("k >= 20000 && k < 40000 && k % 5000 == 0", "k == 20000"),
    ('letters = "v 3\\n";', 'letters = "v 3 1.5\\n";'),
):
    assert TURNS.count(_old) == 1, _old
    TURNS = TURNS.replace(_old, _new)
UNEQUAL = replace(TURNER, more=0.1, brake=-0.1)


@pytest.mark.slow
def test_the_sketch_steers_and_stops_without_commands(gcc, cpp, found, tmp_path):
    law = found.steering.law
    limits = Drive(3.0, 6.0, 1.5, 6.0)
    about = Written(found.firmware, robot=ROBOT, drive=limits, steering=law)
    program = sketch_program(gcc, cpp, tmp_path, about.sketch, TURNS)
    path, said = live(program, "x\n", UNEQUAL)
    serial = program.parent / "serial.txt"
    assert "motors off" not in said and abs(path[:, 0]).max() < 0.3
    log = TickLog.read(serial)
    motors = np.column_stack([log.V_left, log.V_right])
    replayed = log.replayed_motors(law)
    assert abs(motors).max() > 0.5 and log.heading.max() > 1.0
    assert abs(replayed - motors)[log.running].max() < 2e-3  # single precision
    # v 3 1.5 is said once, at 1.94 s, and a second later it is forgotten
    assert log.rate.max() == 3.0 and log.rate[-1] == 0.0
    names = next(x for x in said.splitlines() if x.startswith("t,")).split(",")
    rows = [x.split(",") for x in said.splitlines()[1:] if x[:1].isdigit()]
    heading = np.array([float(r[names.index("heading")]) for r in rows])
    # a second at 1.5 rad/s, up and down in a quarter of a second each
    assert heading[-1] == pytest.approx(1.5, rel=0.05)
    assert path[-1, 2] == pytest.approx(heading[-1], abs=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("metres, turn", [(1.0, 0.0), (0.0, np.pi / 2)])
def test_the_sketch_goes_a_metre_and_turns_a_quarter(
    metres, turn, gcc, cpp, found, tmp_path
):
    """Within 2 cm and 2 degrees, passed by less than 5 %, with motors that differ."""
    law = found.steering.law
    about = Written(found.firmware, robot=ROBOT, drive=found.drive, steering=law)
    board = TURNS.replace("k == 20000", "k < 0").replace("k < 62000", "k < 200000")
    program = sketch_program(gcc, cpp, tmp_path, about.sketch, board)
    path, said = live(program, f"p {metres / MACHINE.r:.4f} {turn:.4f}\n", UNEQUAL)
    assert "motors off" not in said and abs(path[:, 0]).max() < 0.35
    way = path[:, 1] * MACHINE.r
    assert abs(way[-300:] - metres).max() < 0.02
    assert abs(path[-300:, 2] - turn).max() < np.radians(2)
    asked = way if metres else path[:, 2]
    assert asked[:380].max() < 0.1 and asked.max() < 1.05 * max(metres, turn)


# The description


def test_the_description_of_steering():
    robot = Robot.shipped("thesis")
    assert robot.track is robot.steering is robot.unequal is None
    assert "track" not in robot.words
    steered = robot.but(track=0.07)
    assert (steered.steering, steered.unequal, steered.turning) == (0.25, 0.1, None)
    assert "track = 0.07 m, steering = 0.25, unequal = 0.1" in steered.words
    given = robot.but(track=0.07, steering=0.3, turning=[1e-4, 2e-4])
    assert given.steering == 0.3 and given.turning == (1e-4, 2e-4)
    for changes, words in (
        (dict(steering=0.2), "steering: without track"),
        (dict(track=0.0), "track .between the wheels' middles. must be a number above"),
        (dict(track=0.07, steering=0.6), "steering .share of the limit that steers."),
        (dict(track=0.07, turning=[2e-4, 1e-4]), "turning must be two inertias"),
        (dict(track=0.07, unequal=-0.1), "unequal"),
    ):
        with pytest.raises(ValueError, match=words):
            robot.but(**changes)


def test_bad_input_is_named():
    with pytest.raises(ValueError, match="share must be below 1"):
        replace(STEERING, share=1.0)
    with pytest.raises(ValueError, match="K's last entry"):
        replace(STEERING, K=[[-1, -0.1, 0]])
    with pytest.raises(ValueError, match="firmware must be"):
        replace(STEERING, firmware=None)
    with pytest.raises(ValueError, match="no track"):
        turning_plants(MIP, Robot.shipped("thesis"))
    with pytest.raises(ValueError, match="no I_w"):
        turning_plants(replace(MIP, I_w=None), ROBOT)
    with pytest.raises(ValueError, match="steering must be a Steering"):
        Written(FIRMWARE, steering="yes")
