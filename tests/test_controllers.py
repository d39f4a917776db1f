"""Controllers: the loop of all that runs, against what was written by somebody else."""

import control
import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.controllers import FAULTS, Backlash, Replay, predicted_cycles
from tests.axis import UNITS, T, axis, design, drive, rubbed, stepless
from tests.cases import by_hand, later, seeds

NAN = float("nan")


def held(plant, T):
    """The plant's step by one exponential."""
    (A, B), n, m = by_hand(plant), plant.n, plant.m
    both = expm(np.block([[A, B], [np.zeros((m, 2 * n + m))]]) * T)
    return both[: 2 * n, : 2 * n], both[: 2 * n, 2 * n :]


def joined(c, plant, rows, ticks):
    """The loop's matrix, joined by python-control from the controller's own parts."""
    A, B = held(plant, c.T)
    N, m = B.shape
    late = control.ss([], [], [], np.eye(m), c.T)
    for _ in range(ticks):
        late = control.series(
            control.ss(np.zeros((m, m)), np.eye(m), np.eye(m), np.zeros((m, m)), c.T),
            late,
        )
    machine = control.series(
        late, control.ss(A, B, rows, np.zeros((len(rows), m)), c.T)
    )
    law = c.to_ss()
    law = control.ss(law.A, law.B[:, : len(rows)], law.C, law.D[:, : len(rows)], c.T)
    return control.feedback(machine, law, sign=1)


@pytest.fixture(scope="module")
def drives():
    return [drive(J2) for J2 in (0.003, 0.006)]


def test_the_loop_is_that_of_python_control(drives):
    c = axis()
    for loop, plant in zip(c.loops, drives):
        theirs = joined(c, plant, np.array([[1.0, 0, 0, 0]]), 1).poles()
        assert max(abs(theirs)) == pytest.approx(loop.radius, abs=1e-9)
    assert c.radius < 1 and c.order == 6
    assert c.set_point(r=[[1], [1]]).radius == c.radius  # a set point closes no loop


def test_the_sampled_loop_of_every_load_is_proven():
    proof = axis().certify(time_limit=60)
    assert proof.proven
    assert "every constant plant with J2 in [0.003, 0.006]" in proof.claims[0]


@pytest.mark.parametrize("seed", seeds(6))
@pytest.mark.parametrize("memory", ["observer", "filter", None])
def test_loops_of_random_plants_in_odd_units(seed, memory):
    """Unsymmetric, scaled by .3 and 9.81, several inputs: the same law, joined anew."""
    rng = np.random.default_rng(seed)
    n, m = 1 + seed % 3, 1 + seed % 2
    m = min(m, n)
    some = rng.normal(0, 0.3, (3, n, n)) + np.eye(n)
    mass = some[0] @ some[0].T + np.eye(n)
    plant = sos.SecondOrderSystem(
        0.3 * mass, 0.3 * some[1], 9.81 * some[2], 9.81 * rng.normal(size=(n, m))
    )
    sampled = sos.design_lqr(plant, np.eye(2 * n), np.eye(m))
    fast = 0.02 / max(1.0, abs(sampled.poles()).max())
    measured = None if memory is None else [f"z{k + 1}" for k in range(n)]
    about = dict(T=fast, delay=fast * (seed % 2), peak=3.0)
    if memory == "filter":
        about |= dict(filter_time=2 * fast)
    else:
        about |= dict(memory=memory)
    c = sampled.controller(measured, **about)
    rows = np.eye(2 * n) if measured is None else np.eye(2 * n)[:n]
    theirs = abs(joined(c, plant, rows, seed % 2).poles()).max()
    assert theirs == pytest.approx(c.radius, abs=1e-7) and theirs < 1


@pytest.mark.last_digits
def test_a_program_without_limits_is_the_linear_loop():
    c = axis().set_point(r=[[1], [1]])
    c = stepless(c)
    run = c.simulate(0.4, r=[0.7])
    for k, loop in enumerate(c.loops):
        x, push = np.zeros(len(loop.F)), loop.set_point[:, 0] * 0.7
        for tick in range(400):
            u = loop.H @ x + loop.direct_r[:, 0] * 0.7
            assert u == pytest.approx(run.u[k, tick], abs=1e-9)
            assert x[:4] == pytest.approx(run.x[k, tick], abs=1e-9)
            x = loop.F @ x + push


@pytest.mark.slow
def test_the_quiet_set_point_asks_nothing_of_the_springs():
    c = axis()
    assert abs(c.gains[0][:, :2] @ c.R).max() < 1e-12 * abs(c.gains[0]).max()
    assert c.R[0] == 1 and not c.D_r.any()
    quiet, naive = (x.simulate(2, r=[0.5]) for x in (c, c.set_point(r=[[1], [1]])))
    peaks = [abs(run.u).max() for run in (quiet, naive)]
    over = [run.x[:, :, 1].max() / 0.5 - 1 for run in (quiet, naive)]
    assert peaks[0] < peaks[1] / 2 and over[0] < 0.2 < over[1]
    with pytest.raises(ValueError, match="r must have U r = I"):
        c.set_point(r=[[2], [1]])


def test_what_a_load_leaves_is_its_twist():
    x, u = axis().static(r=[0.4], w=[0.3])
    assert x[:, 0] == pytest.approx([0.4, 0.4]) and u[:, 0] == pytest.approx([-0.3] * 2)
    assert x[:, 1] - 0.4 == pytest.approx([0.3 / 1.9] * 2)
    with pytest.raises(ValueError, match="below the static need: u .N m. must be 0.3"):
        axis().limit(0.25, load=[0.3])


@pytest.mark.slow
@pytest.mark.parametrize(
    "J2, r", [(0.006, 20), *later((0.006, 60), (0.003, 0.5), (0.0045, 6))]
)
def test_steps_do_not_run_away(J2, r):
    c = axis().set_point(ramp=6).limit(2.0, slew=200).watch(stall=20)
    angle, torque = rubbed(Replay(c), J2, r, 4 + r / 6, lose=97)
    assert abs(angle[-1] - r) < 0.05 and angle.max() < 1.2 * r
    assert abs(torque).max() < 2 and abs(np.diff(torque)).max() <= 0.2 * (1 + 1e-12)


@pytest.mark.campaign  # in the gate chapter 39 shows it, and what holds the sum back
def test_the_naive_program_runs_away():
    """All errors fed back at once, and a sum that knows no limit."""
    c = axis().set_point(r=[[1], [1]]).watch(stall=20)
    wild, _ = rubbed(Replay(c.limit(2.0, anti_windup=False)), 0.006, 60.0, 4)
    tame, _ = rubbed(Replay(c.limit(2.0)), 0.006, 60.0, 4)
    assert abs(wild[-1] - 60) > 200 and abs(tame[-1] - 60) < 0.1


def test_faults_are_of_time_and_last():
    c = axis().limit(2.0).watch(lost=0.004, late=0.003, stall=0.01, silence=0.02)
    assert c.faults.ticks(c.T) == {"lost": 4, "late": 3, "stall": 10, "silence": 20}

    def ends(steps):
        program = Replay(c)
        program.start([0.0])
        for k, (y, r, elapsed) in enumerate(steps):
            u = program.step([y], [r], elapsed)
            if program.fault[0]:
                assert u == 0
                return FAULTS[program.fault[0]], k + 1
        return "running", len(steps)

    assert ends([(NAN, 0, T)] * 9) == ("sensor", 5)
    assert ends([(0, 0, 2 * T)] * 9) == ("clock", 4)
    assert ends([(0, NAN, T)] * 30) == ("silent", 21)
    assert ends([(30.0, 0, T)] * 30) == ("stall", 11)
    assert ends([(NAN, 0, T), (0, 0, 2 * T)] * 9) == ("running", 18)
    fast = axis().watch(fastest=100.0)
    program = Replay(fast)
    program.start([0.0])
    for y in (0.05, 0.4, 0.2):  # .1 rad a tick, and so much more for each that is lost
        program.step([y], [0.0])
    assert program._now.lost == [0] and program._now.y == [0.2]


def test_a_start_anywhere_is_bumpless():
    c = axis().limit(2.0)
    run = c.simulate(1, r=[6.0], x0=[6, 6, 0, 0])
    assert abs(run.u).max() < 0.02 and not run.fault.any()


def test_an_observer_is_chosen_for_all_loads():
    quick = design().controller(["motor"], T=T, delay=T, counts=4096, peak=1.6)
    slow = axis()
    assert slow.estimate.chosen.noise < quick.estimate.chosen.noise
    assert slow.sensitivity_peak() <= 2 and quick.sensitivity_peak() <= 1.7


def test_several_machines_side_by_side_are_each_alone():
    c = axis().limit(0.3, slew=30).watch(fastest=200)
    rng = np.random.default_rng(1)
    many, single = Replay(c, 3), [Replay(c) for _ in range(3)]
    y = rng.normal(size=3)
    many.start([y])
    for k, one in enumerate(single):
        one.start([y[k]])
    for _ in range(60):
        y = y + rng.normal(size=3) * 0.05
        y[rng.random(3) < 0.1] = NAN
        together = many.step([y], [[0.0, 1.0, NAN]])
        alone = [one.step([y[k]], [(0.0, 1.0, NAN)[k]]) for k, one in enumerate(single)]
        assert together.tobytes() == np.hstack(alone).tobytes()
        y = np.nan_to_num(y)
    assert many.fault.tolist() == [one.fault[0] for one in single]


@pytest.mark.slow
def test_friction_and_backlash_are_felt():
    c = axis().limit(2.0)
    smooth, rough = (c.simulate(0.8, r=[0.5], friction=f) for f in (None, [0.03, 0.02]))
    assert np.ptp(smooth.x[:, -1, 1] - 0.5) < np.ptp(rough.x[:, :, 1]) < 1
    gap = Backlash(0, 1, 0.02)
    loose = c.simulate(0.8, r=[0.5], backlash=gap)
    assert 1e-3 < abs(loose.x - smooth.x)[:, :, :2].max() < 0.05
    wide = c.simulate(0.3, x0=[0.0, 0.009, 0, 0], backlash=Backlash(0, 1, 1.0))
    assert wide.x[:, :, 1] == pytest.approx(0.009, abs=1e-3)  # nothing pulls the load


BAD = [
    (lambda: axis().watch(lost=-1), "lost must be 0 or more, in s"),
    (
        lambda: axis().watch(lost=100.0).order and Replay(axis().watch(lost=100.0)),
        "int",
    ),
    (lambda: axis().limit({"torque": 2}), "u_max names 'torque'"),
    (lambda: axis().limit(2, tracking_time=1e-4), "is below T"),
    (lambda: design().controller(["speed"], T=T), "measured names 'speed'"),
    (
        lambda: design().controller(sos.Output(position=[[1, 0]]), T=T),
        "measured must name signals, each once",
    ),
    (lambda: design().controller(["load"], T=T), "motor is integrated but isn't meas"),
    (lambda: design().controller(["motor"], T=T, units={"x": "m"}), "units names 'x'"),
    (lambda: design().controller(["motor"], T=0.2), "this gain is unstable even if"),
    (lambda: design().controller(["motor"], T=-1), "T must be positive"),
    (lambda: design().controller(["motor"], T=T, delay=-1), "delay must be 0 or more"),
    (lambda: design().controller(["motor"], T=T, filter_time=0.1), "not every coord"),
    (lambda: design().controller(["motor"], T=T, memory="past"), "memory must be one"),
    (lambda: axis().to_c("Axis"), "name must begin a C identifier"),
    (lambda: axis().to_c("while"), "no word of C"),
    (lambda: axis().to_c("axis", "half"), "precision must be"),
    (lambda: axis().static(w=[1, 2]), "w must hold 1 finite"),
    (lambda: Replay(axis()).step([0], [0]), "isn't started"),
]


@pytest.mark.filterwarnings("ignore:T = .* the loop is sampled")
@pytest.mark.parametrize("call, words", BAD)
def test_bad_input_is_named(call, words):
    with pytest.raises(ValueError, match=words):
        call()


def test_a_clock_with_which_no_controller_can_do_it():
    """An unstable pole and the time to act bound the complementary sensitivity."""
    tip = sos.SecondOrderSystem([[1]], [[0]], [[-25]], [[1]])
    found = sos.design_pid(tip, region=sos.PoleRegion(1, rho=30))
    with pytest.raises(
        ValueError, match=r"no controller can do it at T = 0.5 s.*5 rad"
    ):
        found.controller(T=0.5)


def test_a_mode_that_nobody_sees_is_named():
    two = sos.SecondOrderSystem(np.eye(2), np.zeros((2, 2)), np.eye(2), np.eye(2))
    found = sos.design_pid(two, region=sos.PoleRegion(0.5, rho=9))
    with pytest.raises(ValueError, match="doesn't see the mode"):
        found.controller(["z1"], T=0.01)


def test_names_that_c_cannot_have():
    plant = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]], coordinates=["Größe"])
    c = sos.design_pid(plant, region=sos.PoleRegion(1)).controller(T=0.01)
    with pytest.raises(ValueError, match="can't be a name of C"):
        c.to_c("one")


def test_units_follow_the_coordinates():
    c = axis()
    assert [str(s) for s in (*c.readings.signals, *c.set_points, *c.outputs)] == [
        "motor (rad)",
        "set point of motor (rad)",
        "u (N m)",
    ]
    assert c.to_ss().input_labels == ["motor", "set point of motor"]
    assert c.units == UNITS


def test_a_cycle_of_friction_is_where_energy_balances():
    """Positive damping c against friction F: 4 F / pi a = c, an unstable cycle."""
    plant = sos.SecondOrderSystem([[1]], [[0]], [[0]], [[1]], coordinates=["q"])
    K = [[-100.0, 0.5]]
    c = sos.analyse_pid(plant, K, region=sos.PoleRegion(0)).controller(T=1e-3)
    (cycle,) = predicted_cycles(c, friction=[0.2])
    held = 0.5 + 100 * 1e-3 / 2  # half a tick of age is a damping of its own
    assert cycle.frequency == pytest.approx(10 / 2 / np.pi, rel=1e-2)
    assert cycle.amplitude == pytest.approx(4 * 0.2 / np.pi / held, rel=1e-2)
    assert "a cycle at 1.59 Hz" in str(cycle)
    around = [
        c.simulate(1.5, x0=[0, share * cycle.amplitude], friction=[0.2]).x[0, :, 0]
        for share in (0.8, 1.2)
    ]
    first, last = np.array(
        [[abs(x[:500]).max(), abs(x[-500:]).max()] for x in around]
    ).T
    assert last[0] < 0.97 * first[0] and last[1] > 1.03 * first[1]


def test_no_cycle_is_predicted_of_the_drive():
    assert predicted_cycles(axis(), [0.03, 0.02], Backlash(0, 1, 0.02)) == []
    with pytest.raises(ValueError, match="backlash must be a Backlash"):
        predicted_cycles(axis(), backlash=0.02)


@pytest.mark.parametrize(
    "unit, turn",
    [("deg", 360.0), ("mm", 1.0), *later(("rad", 2 * np.pi), ("", 2 * np.pi))],
)
def test_counts_are_of_a_turn_or_of_a_unit(unit, turn):
    """In degrees an encoder's step is 57 times the number that it is in radians."""
    units = {"motor": unit} if unit else {}
    c = design().controller(["motor"], T=T, delay=T, units=units, counts=4096)
    assert c.readings.steps == pytest.approx([turn / 4096], rel=1e-15)
