"""Identification of machines: logs of our own simulators, with encoders' steps."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import sosbook as sos
from sosbook.analysis.doubts import line_of
from sosbook.analysis.fit import covariance, radius, standing
from sosbook.analysis.trial import Trial
from tests.cases import campaign

COUNT = 2 * np.pi / 4096
MOVING = 150  # samples of a log are left out before it: the machine moves


def sweep(t, first, last, amplitude, digits=3):
    """A sine whose frequency rises from the first to the last, in Hz."""
    turns = first * t + (last - first) * t**2 / (2 * t[-1])
    return np.round(amplitude * np.sin(2 * np.pi * turns), digits)


def encoder(z, steps, seed=0):
    """What counters say that begin anywhere between two counts."""
    rng, steps = np.random.default_rng(seed), np.broadcast_to(steps, z.shape[1:])
    z = z + steps * (rng.random(z.shape[1:]) + rng.normal(0, 0.25, z.shape))
    return np.floor(z / steps) * steps


def moved(M, D, S, t, u):
    """Displacements under a force on the first of them, by our own exponentials."""
    n, inverse = len(M), np.linalg.inv(M)
    joined = np.zeros((2 * n + 1, 2 * n + 1))
    joined[:n, n : 2 * n] = np.eye(n)
    joined[n : 2 * n] = np.hstack([-inverse @ S, -inverse @ D, inverse[:, :1]])
    flows = {h: expm(joined * h)[:-1] for h in np.unique(np.diff(t))}
    path, x = [], np.zeros(2 * n)
    for h, force in zip(np.append(np.diff(t), 0), u):
        path.append(x[:n])
        x = flows[h] @ [*x, force] if h else x
    return np.array(path)


def drive(J1, J2, d, c):
    """Motor and load on an elastic shaft; the bearings' damping is known."""
    D = [[d + 0.004, -d], [-d, d + 0.001]]
    return sos.SecondOrderSystem([[J1, 0], [0, J2]], D, [[c, -c], [-c, c]], [[1], [0]])


def swing(m, d, k):
    return sos.SecondOrderSystem(m, d, k, 9.81)


def crane(m, L, b):
    M = [[100 + m, m * L], [m * L, m * L**2]]
    return sos.SecondOrderSystem(M, [[b, 0], [0, 0.5]], np.diag([0, 9.81 * m * L]),
                                 [[1], [0]])  # fmt: skip


MOTOR = sos.Output(position=[[1, 0]])
TRUE = dict(J1=0.0025, J2=0.004, d=0.006, c=9.0)
GUESS = dict(J1=0.005, J2=0.003, d=0.02, c=5.0)
T = np.arange(500) * 0.002
BRIEF = T[:250]
U = sweep(T, 0.5, 40, 0.3)


def of(plant):
    return plant.M, plant.D, plant.S


DRIVE = of(drive(**TRUE))
Z = moved(*DRIVE, T, U)
JITTER = np.cumsum(np.random.default_rng(7).choice([1.4, 2, 2.6], 500)) * 1e-3
SWING, CRANE = dict(m=0.3, d=0.002, k=9.81), dict(m=50.0, L=2.0, b=30.0)
LONG = np.arange(1500) * 0.02
#: builder, truth, guess, t, u, displacements seen, steps of the encoders, outputs
MACHINES = {
    "drive": (drive, TRUE, GUESS, T, U, Z[:, :1], COUNT, MOTOR),
    "both ends": (drive, TRUE, GUESS, T, U, Z, [COUNT, 4 * COUNT], None),
    "coarse": (drive, TRUE, GUESS, T, U, Z[:, :1], 2 * np.pi / 200, MOTOR),
    "lightly damped, odd units": (
        *(swing, SWING, dict(m=0.5, d=0.01, k=5.0), LONG, sweep(LONG, 0.1, 3, 0.01, 5)),
        moved(*of(swing(**SWING)), LONG, 9.81 * sweep(LONG, 0.1, 3, 0.01, 5)),
        *(1e-3, None),
    ),
    "crane": (
        *(crane, CRANE, dict(m=90.0, L=1.4, b=80.0), LONG, sweep(LONG, 0.05, 1, 80)),
        moved(*of(crane(**CRANE)), LONG, sweep(LONG, 0.05, 1, 80)),
        *([1e-3, 2e-3], None),
    ),
    "ticks that jitter": (
        *(drive, TRUE, GUESS, JITTER, sweep(JITTER, 0.5, 40, 0.3)),
        moved(*DRIVE, JITTER, sweep(JITTER, 0.5, 40, 0.3))[:, :1],
        *(COUNT, MOTOR),
    ),
}  # fmt: skip


def asked(name, seed=0, before=0):
    """What `identify` says of a machine, and the truth; so many samples are lost."""
    builder, truth, guess, t, u, z, steps, outputs = MACHINES[name]
    record = sos.Record(t[before:], u[before:], encoder(z[before:], steps, seed))
    return sos.identify(builder, record, guess, outputs, rest=not before), truth


def ends(family):
    """The range of each parameter, in floats."""
    box = family.box
    return {x: (float(a), float(b)) for x, a, b in zip(box.names, box.low, box.high)}


@pytest.mark.parametrize(
    "name", [*[x for x in MACHINES if x != "crane"], *campaign(["crane"])]
)
def test_the_truth_lies_within_what_the_log_allows(name):
    found, truth = asked(name)
    assert not found.doubts
    for x, (low, high) in ends(found.family()).items():
        assert low < truth[x] < high
        assert (high - low) / abs(truth[x]) < (0.5 if name == "coarse" else 0.06)


@pytest.mark.parametrize("last", [1.0, 40, *campaign([1.5])])
def test_an_interval_is_of_the_log_and_not_of_roundings(last):
    """A slow sweep hardly shows d; a plant whose entries shake by 1e-11 has its sd."""
    rng, true = np.random.default_rng(1), dict(J1=0.01, J2=0.02, d=0.01, c=10.0)

    def shaken(**values):
        plant = drive(**values)
        M, D, S = (x * (1 + 1e-11 * rng.uniform(-1, 1, x.shape)) for x in of(plant))
        return sos.SecondOrderSystem(M, D, S, plant.B)

    t = np.arange(600) * 0.002
    u = sweep(t, 0.1, last, 1.0)
    record = sos.Record(t, u, encoder(moved(*of(drive(**true)), t, u)[:, :1], COUNT))
    still, noisy = (sos.identify(x, record, true, MOTOR) for x in (drive, shaken))
    assert np.allclose(noisy.sd, still.sd, rtol=0.02)


def rubbed(M, D, S, t, u, F):
    """Displacements with Coulomb friction F on the first of them, which is pushed: it
    slides or is held, and when this changes is found by halving."""
    n, pull = len(M), np.linalg.inv(M)[:, 0]
    slides = np.zeros((2 * n + 1, 2 * n + 1))  # by u - F sign(v)
    slides[:n, n : 2 * n] = np.eye(n)
    slides[n : 2 * n] = np.hstack([*np.linalg.solve(M, [-S, -D]), pull[:, None]])
    holds = slides - np.outer(slides[:, -1], slides[n]) / pull[0]
    x, way, path = np.zeros(2 * n), 0, []

    def after(s):
        return (expm((slides if way else holds) * s) @ [*x, f - F * way])[:-1]

    def ends(s):
        later = after(s)
        return later[n] * way < -1e-15 if way else abs(needed(later)) > F

    def needed(x):
        return slides[n] @ [*x, f] / pull[0]

    for h, force in zip(np.append(np.diff(t), 0), u):
        path.append(x[:n])
        f = force
        while h > 0:
            way = np.sign(x[n]) or (abs(needed(x)) > F) * np.sign(needed(x))
            ended = [s for s in h * np.arange(0.25, 1.1, 0.25) if ends(s)]
            low, high = (0, ended[0]) if ended else (h, h)
            while high - low > 1e-13:
                mean = (low + high) / 2
                low, high = (low, mean) if ends(mean) else (mean, high)
            x, h = after(high), h - high
            x[n] *= abs(x[n]) > 1e-11
    return np.array(path)


RIG = np.arange(300) * 0.01, sweep(np.arange(300) * 0.01, 0.3, 3, 30, 2)
ROCK = np.arange(600) * 0.01, sweep(np.arange(600) * 0.01, 0.2, 3, 1)


def slide(m, d):
    return sos.SecondOrderSystem(m, d, 0, 1)


def rock(m, d, k):
    return sos.SecondOrderSystem(m, d, k, 1)


#: builder, truth, guess, friction and its guess, t, u, steps, outputs
RUBBED = {
    "slide": (slide, dict(m=12.0, d=20.0), dict(m=20, d=50), 6, 3, *RIG, 1e-4, None),
    "rock": (rock, dict(m=0.3, d=0.1, k=9.81), dict(m=0.5, d=0.2, k=6), 0.2, 0.1,
             *ROCK, 1e-4, None),
    "drive that rubs": (drive, TRUE, GUESS, 0.05, 0.02, T, U, COUNT, MOTOR),
}  # fmt: skip


def rubbing(name):
    """One of the above as it is: its displacements that are seen, and friction=."""
    builder, truth, _, F, _, t, u, _, outputs = RUBBED[name]
    z = rubbed(*of(builder(**truth)), t, u, F)
    row = np.eye(z.shape[1])[:1]
    return z if outputs is None else z @ outputs.position.T, {"F": row}


def misses(name, seeds):
    """Errors of the values over their deviations, (seeds, p), and how often all lay in
    the box of 95 %: of a machine above, or "moving", of which a piece of a log is left
    out before it, or one that rubs. Of sixty one may be doubted in vain: the steps of
    an encoder that turns slowly have lines."""
    z, boxes, doubted = [], 0, 0
    for seed in range(seeds):
        if name in RUBBED:
            builder, truth, guess, F, first, t, u, steps, outputs = RUBBED[name]
            seen, rubs = rubbing(name)
            truth, guess = truth | {"F": F}, guess | {"F": first}
            record, how = sos.Record(t, u, encoder(seen, steps, seed)), rubs
            found = sos.identify(builder, record, guess, outputs, friction=how)
        elif name.startswith("moving "):
            found, truth = asked(name.removeprefix("moving "), seed, MOVING)
        else:
            found, truth = asked(name, seed)
        doubted += bool(found.doubts) and name not in RUBBED
        z.append([(found[x] - truth[x]) / s for x, s in zip(truth, found.sd)])
        box = ends(found.family(0.95))
        boxes += all(low < truth[x] < high for x, (low, high) in box.items())
    assert doubted <= seeds // 60
    return np.array(z), boxes / seeds


@pytest.mark.campaign
@pytest.mark.parametrize("name", MACHINES)
def test_intervals_hold_the_truth_as_often_as_they_say(name):
    """95 % each; the box of 95 % all at once."""
    z, boxes = misses(name, 60)
    assert (np.mean(np.abs(z) < radius(0.95), axis=0) > 0.85).all()
    assert np.sqrt(np.mean(np.square(z))) < 1.35
    assert boxes > 0.88


def pushes(hold, last):
    """Pushes of .3 N m whose signs are drawn, so many samples each; none at the end."""
    signs = np.random.default_rng(3).choice([-0.3, 0.3], len(T) // hold + 1)
    return np.where(T < last * T[-1], np.repeat(signs, hold)[: len(T)], 0)


@pytest.mark.campaign
@pytest.mark.parametrize("u", [pushes(15, 1), pushes(500, 0.4)], ids=["many", "one"])
def test_intervals_of_a_log_that_sweeps_nothing(u):
    """Of 240 intervals 227 and 225 hold the truth; neither twice too wide."""
    z, seen = [], moved(*DRIVE, T, u)[:, :1]
    for seed in range(60):
        record = sos.Record(T, u, encoder(seen, COUNT, seed))
        found = sos.identify(drive, record, GUESS, MOTOR)
        z.append([(found[x] - TRUE[x]) / s for x, s in zip(TRUE, found.sd)])
    assert np.mean(np.abs(z) < radius(0.95)) > 0.9
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.2


@pytest.mark.campaign
@pytest.mark.parametrize("name", [*(f"moving {x}" for x in MACHINES), *RUBBED])
def test_intervals_with_friction_or_motion_before_the_log(name):
    """At least 92 of 100 hold the truth, not twice too wide."""
    z, boxes = misses(name, 60)
    assert np.mean(np.abs(z) < radius(0.95)) > 0.92 and boxes > 0.88
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.2


def push(name, seconds, shaking, seed):
    """A fit to a log of one push of a machine that rubs, which stands afterwards; its
    encoder rounds, and is shaken by so many steps before.
    """
    builder, truth, guess, F, first, t, u, step, _ = RUBBED[name]
    t = np.arange(round(seconds / (t[1] - t[0]))) * (t[1] - t[0])
    u = np.where(t < 1.2, abs(u).max(), 0)
    z, rng = rubbed(*of(builder(**truth)), t, u, F), np.random.default_rng(seed)
    z = z + step * (rng.random() + rng.normal(0, shaking, z.shape))
    record = sos.Record(t, u, np.floor(z / step) * step)
    found = sos.identify(builder, record, guess | {"F": first}, friction={"F": [1]})
    return found, truth | {"F": F}


def test_a_machine_that_stands_on_a_step_of_its_encoder_says_no_more():
    """The whole rest is rounded by one number: the log of 30 s was 1.8 times surer."""

    def sd(seconds):
        t = np.arange(round(seconds / 0.02)) * 0.02
        u = np.where(t < 1.2, 30, 0)
        z = moved(*of(slide(12, 20)), t, u)
        record = sos.Record(t, u, np.floor(z / 1e-3 + 0.3) * 1e-3)
        return sos.identify(slide, record, dict(m=20, d=50)).sd

    assert (sd(30) > 0.9 * sd(7)).all()


@pytest.mark.campaign
@pytest.mark.parametrize("name, shaking", [("slide", 0.0), ("rock", 0.25)])
def test_intervals_of_a_machine_that_stands(name, shaking):
    """Without what rests have in common 33 of 48 intervals held the rock's d and F."""
    z = []
    for seed in range(24):
        found, truth = push(name, 4.0, shaking, seed)
        z.append([(found[x] - truth[x]) / found.sd[k] for k, x in enumerate(truth)])
    assert np.mean(np.abs(z) < radius(0.95)) > 0.88
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.3


@pytest.mark.parametrize("shaking", [0, 0.1, 0.2, 0.3])
def test_what_a_rest_is_wrong_by_is_what_rounding_leaves(shaking):
    """Rests at places drawn between the steps, of encoders in units of 0.3."""
    rng = np.random.default_rng(4)
    places = 0.3 * (rng.uniform(5, 50, 2000) + 50 * (np.arange(2000) % 2))
    shaken = places[:, None] + 0.3 * shaking * rng.normal(size=(2000, 400))
    read = 0.3 * np.floor(shaken / 0.3 + 0.5)
    true = np.var(read.mean(axis=1) - places)
    runs, said = standing(read.ravel(), np.repeat(places, 400), 30)
    assert len(runs) == 2000
    assert said + read.var(axis=1).mean() / 400 == pytest.approx(true, rel=0.1)


def test_a_simulation_of_an_ode_solver_agrees():
    """The two-mass drive, tick by tick, by an ODE solver and the typed equations."""

    def rates(t, x, u):
        twist = TRUE["c"] * (x[0] - x[1]) + TRUE["d"] * (x[2] - x[3])
        first, second = u - twist - 0.004 * x[2], twist - 0.001 * x[3]
        return [x[2], x[3], first / TRUE["J1"], second / TRUE["J2"]]

    x = np.zeros(4)
    for k in range(60):
        assert Z[k] == pytest.approx(x[:2], abs=1e-8)
        how = dict(rtol=1e-9, atol=1e-12, args=(U[k],))
        x = solve_ivp(rates, (T[k], T[k + 1]), x, **how).y[:, -1]


@pytest.mark.parametrize("name", RUBBED)
def test_friction_is_simulated_to_a_hundredth_of_a_step(name):
    builder, truth, _, F, _, t, u, steps, outputs = RUBBED[name]
    z, rubs = rubbing(name)
    record = sos.Record(t, u, z)
    trial = Trial(builder, record, truth | {"F": F}, outputs, rubs, True)
    trial.keep = np.ones(z.shape)
    assert abs(trial.left(np.zeros((1, len(trial.names))))).max() < 0.01 * steps


def test_friction_is_found_and_ignored_friction_is_named():
    (t, u), start = RIG, dict(m=20, d=50)
    record = sos.Record(t, u, encoder(rubbing("slide")[0], 1e-4))
    found = sos.identify(slide, record, start | {"F": 3}, friction={"F": [1]})
    for name, truth in dict(m=12, d=20, F=6).items():
        assert found[name] == pytest.approx(truth, abs=4 * found.sd[-1] * truth / 6)
        low, high = found.interval(name, 0.999)
        assert low < truth < high and high - low < 0.05 * truth
    assert not found.doubts and list(found.family().degree) == ["m", "d"]
    ignored = sos.identify(slide, record, start)
    assert "friction=" in ignored.doubts[0] and "hold none of it" in ignored.doubts[0]
    with pytest.raises(ValueError, match="friction F needs one row of a speed"):
        sos.identify(slide, record, start, friction={"F": [1]})


Y = encoder(Z[:, :1], COUNT)
SELDOM = T[::2]
SLOW = moved(*DRIVE, SELDOM, sweep(SELDOM, 0.1, 0.4, 0.3))[:, :1]


@pytest.mark.parametrize(
    "t, u, y, start, said",
    [
        (SELDOM, sweep(SELDOM, 0.1, 0.4, 0.3), encoder(SLOW, COUNT), TRUE,
         "the log doesn't tell d"),
        (T * 1e3, U, Y, GUESS, "t must be in seconds"),
        (T * 1e-3, U, Y, GUESS, "t must be in seconds"),
        (BRIEF, U[:250], np.minimum(Y, 0.9 * Y[:250].max())[:250], GUESS,
         "y1 stays at .* at its end"),
        (BRIEF, U[:250], -Y[:250], GUESS, "the fit leaves .* a sign"),
        (T, 0 * U, Y, GUESS, "u1 never changes"),
        (T, U, 0 * Y, GUESS, "y1 never changes"),
        (T, np.array([U, U]).T, Y, GUESS, "the plant has 1 inputs, the record 2"),
        (T, U, np.hstack([Y, Y]), GUESS, "a row for each sensor"),
        (T, U, Y, GUESS | {"d": 0}, "start of d must not be zero"),
    ],
)  # fmt: skip
def test_logs_that_say_too_little_are_refused(t, u, y, start, said):
    with pytest.raises(ValueError, match=said):
        sos.identify(drive, sos.Record(t, u, y), start, MOTOR)


def test_doubts_name_a_late_sensor_and_a_closed_loop():
    late = sos.Record(T[1:], U[1:], Y[:-1])
    found = sos.identify(drive, late, GUESS, MOTOR)
    assert any("1 samples late" in doubt for doubt in found.doubts)
    x, u, y = np.zeros(4), [], []
    flow = expm(0.002 * np.vstack([
        np.hstack([np.zeros((2, 2)), np.eye(2), np.zeros((2, 1))]),
        np.hstack([*(-np.linalg.solve(DRIVE[0], X) for X in DRIVE[:0:-1]),
                   [[400.0], [0.0]]]),
        np.zeros((1, 5))]))[:-1]  # fmt: skip
    for k, noise in enumerate(np.random.default_rng(3).normal(0, COUNT / 4, len(T))):
        y.append(np.floor((x[0] + noise) / COUNT) * COUNT)
        u.append(U[k] - 0.5 * y[-1])
        x = flow @ [*x, u[-1]]
    found = sos.identify(drive, sos.Record(T, u, y), GUESS, MOTOR)
    assert any("one of a closed loop" in doubt for doubt in found.doubts)
    far = sos.identify(drive, sos.Record(T, U, Y), TRUE | {"d": 0.3}, MOTOR)
    assert any("d is 0.02 times its guess" in doubt for doubt in far.doubts)


def test_a_machine_that_moves_when_the_log_begins():
    record = sos.Record(T[:-150], U[150:], Y[150:])
    with pytest.raises(ValueError, match=r"when the log begins \(rest=False\)"):
        sos.identify(drive, record, GUESS, MOTOR)
    z, boxes = misses("moving drive", 1)
    assert boxes == 1 and np.sqrt(np.mean(np.square(z))) < 1.6


def test_a_design_for_all_plants_that_the_log_allows():
    """What is proven holds of the true machine."""
    found, truth = asked("drive")
    design = sos.design_pid(found.family(), region=sos.PoleRegion(sigma=3))
    assert design.certify().proven
    loop = design.K @ np.eye(4)
    M, D, S = DRIVE
    A = np.block([[np.zeros((2, 2)), np.eye(2)],
                  [np.linalg.solve(M, [[1], [0]] @ loop[:, :2] - S),
                   np.linalg.solve(M, [[1], [0]] @ loop[:, 2:] - D)]])  # fmt: skip
    assert np.linalg.eigvals(A).real.max() < -3


def test_a_record_is_read_by_the_names_of_its_columns(tmp_path):
    path = tmp_path / "log.csv"
    rows = (f"{1e3 * t:g},{y / COUNT:g},7,{u}" for t, y, u in zip(T, Y[:, 0], U))
    path.write_text("\n".join(["ms,motor,more,torque", *rows]), "utf-8")
    units = dict(ms=1e-3, motor=COUNT)
    record = sos.Record.read(path, ["torque"], ["motor"], time="ms", **units)
    assert record.inputs == ("torque",) and record.outputs == ("motor",)
    assert np.allclose(record.t, T) and np.allclose(record.y, Y)
    for names in ["load"], ["more", "more"]:
        with pytest.raises(ValueError, match="log.csv"):
            sos.Record.read(path, ["torque"], names, time="ms")
    for t, y, said in (
        ([0, 1, 1], [0, 0, 0], "t must increase"),
        ([0, 1, 2, 4, 5], [0] * 5, "1 sample missing"),
        ([0, 1, 2], [0, np.nan, 0], "y1 isn't finite at row 2"),
        ([0, 1, 2], [0, 0], "y must have a row for each of the 3 times"),
    ):
        with pytest.raises(ValueError, match=said):
            sos.Record(t, np.zeros(len(t)), y)


def test_coloured_residuals_of_two_sensors():
    """Two sensors with one noise are one sensor."""
    rng = np.random.default_rng(0)
    J, r = rng.standard_normal((400, 2)), rng.standard_normal(400)
    one = covariance(J, r)
    two = covariance(np.repeat(J, 2, axis=0), np.repeat(r, 2).reshape(400, 2))
    assert np.allclose(one, two)


def test_a_line_in_what_a_fit_leaves_is_told_from_noise():
    """Of a hundred residuals of noise none has a line; a vibration has its own."""
    rng, t = np.random.default_rng(7), 0.003 * np.arange(1000)
    record = sos.Record(t, np.sin(9.81 * t), np.cos(t))
    noise = rng.standard_normal((100, len(t)))
    assert [line_of(r, record) for r in noise] == [None] * 100
    omega = line_of(noise[0] + 0.5 * np.sin(30 * t), record)
    assert omega == pytest.approx(30, abs=2 * np.pi / t[-1])
