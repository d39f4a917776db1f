"""Every entry point takes every law, with one answer, or refuses it with a cure.

The loops' truth is written by hand here: the plant's matrices and the controller's.
"""

import functools
import json
import re
from itertools import permutations

import control
import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_are

import sosbook as sos
from sosbook.controllers.code import read_gains
from sosbook.delay import largest
from sosbook.laws.taken import row_of
from tests.cases import crossed

M, D, S = 0.3, 0.2, 9.81  # one coordinate, input, disturbance: no width tells
PLANT = sos.SecondOrderSystem(M, D, S, 1, F=[[1.0]], coordinates=["arm"])
A_P = np.array([[0, 1], [-S / M, -D / M]])
B_P = np.array([[0], [1 / M]])
HEAVIER = 1.4


def with_mass(m):
    return sos.SecondOrderSystem(m, D, S, 1, F=[[1.0]], coordinates=["arm"])


FAMILY = sos.Uncertain(with_mass, m=(M, HEAVIER * M))
PID = sos.PIDLaw([[1]], filter=0.03, integrate=True)
OF_PID = dict(K_P=[[-1.0]], K_D=[[-2.0]], K_I=[[-4.0]])
DYNAMIC = sos.DynamicLaw(1, [[1]], [[1]], strictly_proper=False)
OF_DYNAMIC = dict(A_c=[[-30]], B_c=[[10, 2]], C_c=[[-1]], D_c=[[-2, -1]])
SYSTEM = control.ss(
    [[-9, 1], [0, -4]], [[1, 2], [0.5, -1]], [[-1, -3]], [[-1, 0.2]],
    inputs=["arm'", "arm"], outputs=["u"], dt=0,
)  # fmt: skip
STATES = [[-1.0, -2.0]]
ONCE = sos.Search(starts=1)


@functools.cache
def observer():
    return sos.design_observer(PLANT, STATES, Q_F=[[0], [1], [0], [0]], R_F=[[0.1]])


def of_observer():
    L = observer().L
    A = A_P + B_P @ STATES + L @ [[1, 0]]
    return A, np.hstack([-L, 0 * L]), np.array(STATES), np.zeros((1, 2))


LAWS = {  # law and gains as an entry takes them, A, B, C, D from [z; z'] to u
    "states": (
        sos.FullState(), lambda: STATES,
        lambda: (*(np.zeros(x) for x in ((0, 0), (0, 2), (1, 0))), np.array(STATES)),
    ),
    "PID": (
        PID, lambda: OF_PID,
        lambda: (
            np.diag([0, -1 / 0.03]), np.array([[1, 0], [1 / 0.03, 0]]),
            np.array([[-4.0, 2 / 0.03]]), np.array([[-1 - 2 / 0.03, 0]]),
        ),
    ),
    "dynamic": (
        DYNAMIC, lambda: OF_DYNAMIC,
        lambda: tuple(np.array(OF_DYNAMIC[k], float) for k in OF_DYNAMIC),
    ),
    "observer": (None, observer, of_observer),
    "labels": (
        None, lambda: SYSTEM,
        lambda: (SYSTEM.A, SYSTEM.B[:, ::-1], SYSTEM.C, SYSTEM.D[:, ::-1]),
    ),
}  # fmt: skip
every_law = pytest.mark.parametrize("name", LAWS)


def given(name):
    law, gains, _ = LAWS[name]
    return law, gains()


def loop(name, plant=PLANT):
    return sos.Loop(plant, *given(name))


def closed(name, m=M):
    """The loop's A from [x; memory], how w pushes it, and the row of u."""
    A, B, C, D_c = LAWS[name][2]()
    A_m = np.array([[0, 1], [-S / m, -D / m]])
    B_m = np.array([[0], [1 / m]])
    F = np.block([[A_m + B_m @ D_c, B_m @ C], [B, A]])
    return F, np.vstack([B_m, 0 * B[:, :1]]), np.hstack([D_c, C])


def gain(F, G, row, w):
    """row (jw - F)^-1 G, by the modes of F, all of which differ."""
    poles, modes = np.linalg.eig(F)
    parts = (row @ modes)[0] * np.linalg.solve(modes, G + 0j)[:, 0]
    return (parts / (1j * w[:, None] - poles)).sum(axis=1)


GRID = np.r_[0, np.geomspace(1e-2, 1e3, 20_001)]


@functools.cache
def true_norm(name, m=M):
    F, G, _ = closed(name, m)
    return abs(gain(F, G, np.eye(1, len(F)), GRID)).max()


def delay_margin(name):
    """Where the loop's gain crosses one, and its phase is used up first."""
    A, B, C, D_c = LAWS[name][2]()
    x = np.linalg.solve(GRID[1:, None, None] * 1j * np.eye(2) - A_P, B_P + 0j)
    K = D_c + C @ np.linalg.solve(
        GRID[1:, None, None] * 1j * np.eye(len(A)) - A, B + 0j
    )
    L = -(K @ x)[:, 0, 0]
    at = np.flatnonzero((abs(L[1:]) - 1) * (abs(L[:-1]) - 1) < 0)
    turn = (np.angle(L[at]) + np.pi) % (2 * np.pi)
    return min(turn / GRID[1:][at], default=np.inf)


def refused(ask, *words):
    with pytest.raises(ValueError) as error:
        ask()
    for word in words:
        assert word in str(error.value), str(error.value)


def analyse(name):
    law, K = given(name)
    for size, status in ((1.02, "feasible"), (0.98, "infeasible")):
        asked = [sos.HInfinity(size * true_norm(name))]
        found = sos.analyse_pid(PLANT, K, law=law, requirements=asked)
        assert found.status == status
        if status == "feasible":
            assert found.certify().proven


def disk(name):
    F, G, row = closed(name)
    S_half = 1 + gain(F, G, row, GRID) - 0.5
    for margin in (loop(name).margins(), loop(name).design.disk_margin()):
        assert margin.radius == pytest.approx(1 / abs(S_half).max(), rel=1e-4)


def simulated(name):
    F = closed(name)[0]
    law, K = given(name)
    start = np.r_[0.2, -0.1, np.zeros(len(F) - 2)]
    if name == "PID":
        start[3] = start[0]  # a filter has long stood at what is measured
    t = np.linspace(0, 1.5, 31)
    x = [(expm(F * s) @ start)[0] for s in t]
    run = sos.analyse_pid(PLANT, K, law=law).simulate(t, x0=start)
    np.testing.assert_allclose(run.z[0], x, atol=1e-9)
    law_only = loop(name).simulate(t, x0=start)
    np.testing.assert_allclose(law_only.z[0], x, atol=1e-9)


def late(name):
    law, K = given(name)
    margin = min(delay_margin(name), 1.0)
    for entry in (
        sos.analyse_delay(PLANT, K, tau=0.4 * margin, law=law).certify(),
        loop(name).late(0.4 * margin).prove(),
    ):
        assert entry.proven, str(entry)
    far = sos.analyse_delay(PLANT, K, tau=1.05 * margin, law=law)
    assert far.status != "feasible" or margin == 1.0
    roots = loop(name).late(0.4 * margin).poles()[0]
    F, _, row = closed(name)
    A, B, C, D_c = LAWS[name][2]()
    whole = np.block([[A_P, np.zeros((2, len(A)))], [B, A]])
    for s in roots[:3]:  # det(s - A - B K e^(-s tau)) = 0
        pencil = s * np.eye(len(F)) - whole
        pencil[:2] -= np.exp(-0.4 * margin * s) * B_P @ row
        sizes = np.linalg.svd(pencil, compute_uv=False)
        assert sizes[-1] < 1e-6 * sizes[0]


def ticked(name, T):
    """The loop of u held over T, with the package's own memory at ticks."""
    c = loop(name).at(T).controller
    Phi = expm(np.block([[A_P, B_P], [np.zeros((1, 3))]]) * T)[:2]
    F, G = Phi[:, :2], Phi[:, 2:]
    seen = c.readings.rows
    return np.block([[F + G @ c.D @ seen, G @ c.C], [c.B @ seen, c.A]])


def sampled(name):
    K = LAWS[name][1]() if name != "PID" and name != "dynamic" else loop(name).design
    for T in (0.01, 0.4):
        if T > 0.03 and name == "PID":
            refused(lambda: sos.certify_sampled(PLANT, K, T), "filter of 0.03 s")
            continue
        radius = abs(np.linalg.eigvals(ticked(name, T))).max()
        assert sos.certify_sampled(PLANT, K, T).proven is bool(radius < 1)
    assert loop(name).at(0.01).prove().proven
    run = loop(name).at(0.01).poles()
    np.testing.assert_allclose(
        sorted(abs(run[0])),
        sorted(abs(np.linalg.eigvals(ticked(name, 0.01)))),
        atol=1e-9,
    )
    if name != "states":
        refused(lambda: sos.certify_sampled(PLANT, K, (0.01, 0.02)), ".controller")
    c = loop(name).at(0.01).controller
    ranged = sos.certify_sampled(PLANT, c, (0.01, 0.012))
    assert ranged.proven


def furthest(name):
    c = loop(name).at(0.01).controller
    proof = sos.furthest_sampled(PLANT, c, T=(0.01, 0.02), tolerance=0.5)
    assert proof.proven and proof.T[0] == 0.01 < proof.T[1] <= 0.02
    assert loop(name).at(0.01).largest("T", 0.02, tolerance=0.5).text == proof.text


def at_ticks(name):
    run = loop(name).at(0.01)
    true = run.norm()
    for size, kept in ((1.05, True), (0.98, False)):
        asked = sos.HInfinity(size * true)
        assert run.controller.certify(norm=asked).proven is kept
        assert run.prove(asked).proven is kept


def program(name):
    """The numbers in C make the loop that was asked about, norm and all."""
    run = loop(name).at(0.01)
    numbers = read_gains(run.to_c("arm", time_limit=0.1).texts["arm_gains.h"])
    A, B, C, D_c, rows = (np.array(numbers[x], float) for x in (*"ABCD", "ROWS"))
    l = int(numbers["STATES"])
    A, B, C = A[:l, :l], B[:l], C[:, :l]
    held = expm(np.block([[A_P, B_P, B_P], [np.zeros((2, 4))]]) * 0.01)[:2]
    F = np.block(
        [[held[:, :2] + held[:, 2:3] @ D_c @ rows, held[:, 2:3] @ C], [B @ rows, A]]
    )
    G = np.vstack([held[:, 3:], np.zeros((l, 1))])
    z = np.exp(1j * np.r_[0, np.geomspace(1e-4, np.pi, 20_001)])
    x = np.linalg.solve(z[:, None, None] * np.eye(len(F)) - F, G + 0j)
    assert run.norm() == pytest.approx(abs(x[:, 0, 0]).max(), rel=1e-5)


ENTRIES = {
    "analyse_pid": analyse,
    "disk_margin": disk,
    "simulate": simulated,
    "analyse_delay": late,
    "certify_sampled": sampled,
    "furthest_sampled": furthest,
    "Controller.certify": at_ticks,
    "Controller.to_c": program,
}


@pytest.mark.filterwarnings("ignore:T = .* the loop is sampled")
@pytest.mark.parametrize("entry, name", crossed(ENTRIES, LAWS))
def test_an_entry_point_takes_every_law(entry, name):
    ENTRIES[entry](name)


@every_law
def test_what_designs_takes_a_law_or_says_who_does(name):
    law, K = given(name)
    law = K if law is None else law
    region = dict(region=sos.PoleRegion(0.05))
    region |= {} if name == "states" else dict(search=ONCE)
    known = isinstance(law, (sos.FullState, sos.PIDLaw, sos.DynamicLaw))
    designs = {
        "design_pid": lambda: sos.design_pid(PLANT, law=law, **region),
        "design_lqr": lambda: sos.design_lqr(PLANT, np.eye(2), [[1.0]], law=law),
        "design_sampled": lambda: sos.design_sampled(PLANT, law, T=0.02, sigma=0.05),
        "design_delay_pid": lambda: sos.design_delay_pid(PLANT, tau=0.05, law=law),
        "design_observer": lambda: sos.design_observer(
            PLANT, loop(name).design, Q_F=np.eye(4, 2), R_F=[[1.0]]
        ),
    }
    if not known:
        for ask in designs.values():
            refused(ask, "law")
        return
    found = designs["design_pid"]()
    assert found.status == "feasible" and found.certify().proven
    assert max(sos.Loop(PLANT, found).poles()[0].real) < -0.05
    if name == "states":
        X = solve_continuous_are(A_P, B_P, np.eye(2), [[1.0]])
        np.testing.assert_allclose(designs["design_lqr"]().K, -B_P.T @ X, rtol=1e-5)
        assert designs["design_delay_pid"]().certify().proven
        assert designs["design_observer"]().status == "feasible"
        refused(designs["design_sampled"], "law", "PIDLaw")
        return
    # behind a delay both laws are designed in tests/test_delay_laws
    refused(designs["design_observer"], "law")
    size = 2 + len(LAWS[name][2]()[0])
    lqr = sos.design_lqr(PLANT, np.eye(size), [[1.0]], law=law, search=ONCE)
    assert lqr.status in ("feasible", "undecided") and lqr.request.law is law
    c = designs["design_sampled"]()
    assert c.status == "feasible" and max(abs(c.poles())) < np.exp(-0.05 * 0.02)


@every_law
@pytest.mark.parametrize("plant", [PLANT, FAMILY], ids=["one", "family"])
def test_a_loop_answers_as_its_matrices_do(plant, name):
    """Norm, poles and rest in continuous time, and poles where it was opened at u."""
    one = loop(name, plant)
    masses = [M] if plant is PLANT else [M, HEAVIER * M]
    worst = max(true_norm(name, m) for m in masses)
    assert one.norm() == pytest.approx(worst, rel=1e-5)
    for vertices in (one.poles(), np.array([p for p in opened_poles(one)])):
        for m, poles in zip(masses, vertices):
            true = np.linalg.eigvals(closed(name, m)[0])
            np.testing.assert_allclose(np.sort(poles), np.sort(true), rtol=1e-6)
    wide, K = one.opened
    assert (wide.family is None) is (plant is PLANT) and wide.m == len(K) == 1
    x, u = one.static(w=[1.0])
    F, G, row = closed(name)
    rest = -np.linalg.solve(F, G)
    np.testing.assert_allclose(x[0], rest[:2, 0], atol=1e-12)
    np.testing.assert_allclose(u[0], row @ rest[:, 0], atol=1e-9)


SENSORS = sos.Output(position=[[1]]) & sos.Output(acceleration=[[1]])
LATE = sos.PIDLaw(sensors=SENSORS, lag=0.05, noise=[[0, 0.7], [0, 0]])


@pytest.mark.parametrize("m", [M, HEAVIER * M])
def test_a_late_sensors_loop_is_one_in_continuous_time_and_at_fine_ticks(m):
    """[z, z', y], .05 y' = z'' - y and u = -(z + .7 w2) - .3 y, written by hand."""
    plant = sos.SecondOrderSystem(m, D, S, 1, F=[[1, 0]])
    one = sos.Loop(plant, LATE, dict(K_P=[[-1, -0.3]]))
    speeds = np.array([-S - 1, -D, -0.3]) / m, np.array([1, -0.7]) / m
    F = np.array([[0, 1, 0], speeds[0], (speeds[0] - np.eye(3)[2]) / 0.05])
    G = np.array([[0, 0], speeds[1], speeds[1] / 0.05])
    np.testing.assert_allclose(np.sort(one.poles()[0]), np.sort(np.linalg.eigvals(F)))
    for w in (0, 1):
        for output, row, now in (
            (dict(position=1), [1, 0, 0], 0),
            (dict(input=1), [-1, 0, -0.3], -0.7 * w),
        ):
            true = abs(gain(F, G[:, [w]], np.array([row]), GRID) + now).max()
            asked = sos.Output(**output), [w]
            assert one.norm(*asked) == pytest.approx(true, rel=1e-5)
            far, near = (abs(one.at(T).norm(*asked) - true) for T in (2e-3, 1e-3))
            assert near < 0.02 * true and near < 0.7 * far
        e = np.eye(2)[w]
        for still, ticked in zip(one.static(w=e), one.at(0.01).static(w=e)):
            np.testing.assert_allclose(still, ticked, atol=1e-9)
        rest = -np.linalg.solve(F, G @ e)
        np.testing.assert_allclose(one.static(w=e)[0][0], rest, atol=1e-12)
    refused(lambda: sos.Loop(plant, one.to_ss()), "z1''", "law of its sensors")


def opened_poles(one):
    wide, K = one.opened
    for d in wide.vertices:
        yield np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ K))


@pytest.mark.parametrize("name, plant", crossed(LAWS, [PLANT, FAMILY]))
def test_a_loop_comes_back_from_all_that_it_is_written_as(plant, name):
    one = loop(name, plant)
    again = sos.Loop.read(json.loads(json.dumps(one.at(0.02, delay=0.01).data())))
    assert again.clock == sos.Clock(0.02, 0.01) and again.signals[0].name == "arm"
    same = sos.Loop(again.plant, again.law, again.gains)
    assert same.norm() == pytest.approx(one.norm(), rel=1e-12)
    assert again.norm() == pytest.approx(one.at(0.02, 0.01).norm(), rel=1e-12)
    assert sos.Loop(plant, one.to_ss()).norm() == pytest.approx(one.norm(), rel=1e-9)
    c = one.at(0.02).controller
    by_state = sos.certify_sampled(plant, c, 0.02)
    assert sos.Loop(plant, c).norm() == one.at(0.02).norm() and by_state.proven


def test_a_law_with_noise_comes_back_too():
    law = sos.PIDLaw([[1]], filter=0.03, noise=[[0.7]])
    one = sos.Loop(PLANT, law, dict(K_P=[[-1]], K_D=[[-2]]))
    read = sos.Loop.read(json.loads(json.dumps(one.data())))
    u = sos.Output(input=1)
    assert read.norm(u) == one.norm(u) != sos.Loop(PLANT, one.to_ss()).norm(u)
    noisy = sos.DynamicLaw(1, [[1]], noise=[[0.7]], strictly_proper=False)
    (back,) = (sos.Loop(PLANT, noisy, one.to_ss()),)
    assert back.norm(u) == pytest.approx(one.norm(u), rel=1e-9)


PAIR = sos.SecondOrderSystem(
    [[0.3, 0], [0.1, 2]], 9.81 * np.eye(2), [[3, -0.5], [0.3, 1]], np.eye(2),
    F=[[1], [0]], coordinates=["arm", "tip"],
)  # fmt: skip


def test_the_order_of_names_is_nothing_and_other_names_are_refused():
    names = ["arm", "tip'", "arm' - 0_5 tip"]
    parts = [[-3.0]], [[1, 2, -1]], [[1.0], [0.5]], [[-1, 0, 0.2], [0, -2, 0]]
    outputs = ["u1", "u2"]

    def of(order, rows=(0, 1), names=names, outputs=outputs):
        A, B, C, D_c = map(np.array, parts)
        order, rows = list(order), list(rows)
        return control.ss(
            A, B[:, order], C[rows], D_c[rows][:, order],
            inputs=[names[k] for k in order], outputs=[outputs[k] for k in rows], dt=0,
        )  # fmt: skip

    known = sos.Loop(PAIR, of((0, 1, 2)))
    asked = [sos.HInfinity(1.05 * known.norm())]
    proof = sos.analyse_pid(PAIR, known, requirements=asked).certify()

    def said(proof):  # the order of y is that of the file's K
        first, y, rest = re.split(r"y = \[(.*?)\]", proof.claims[0])
        return first, sorted(y.split(", ")), rest, proof.claims[1:]

    text = said(proof)
    for order in permutations(range(3)):
        for rows in ((0, 1), (1, 0)):
            K = of(order, rows)
            assert sos.Loop(PAIR, K).norm() == pytest.approx(known.norm(), rel=1e-12)
            proof = sos.analyse_pid(PAIR, K, requirements=asked).certify()
            assert proof.proven and said(proof) == text
    for other, words in (
        (
            dict(names=["arm", "speed", "tip"]),
            "'speed' is none of arm, tip, arm', tip'",
        ),
        (dict(outputs=["u1", "torque"]), "closed by the names u1, u2"),
        (dict(names=["u[0]", "u[1]", "u[2]"]), "name what each input measures"),
    ):
        refused(lambda x=other: sos.Loop(PAIR, of((0, 1, 2), **x)), words)
    sampled = control.ss(*parts, 0.1, inputs=names, outputs=outputs)
    refused(lambda: sos.analyse_pid(PAIR, sampled), "dt = 0.1", "certify_sampled")
    assert row_of("-2e-05 tip + 3 tip'", ("arm", "tip", "tip'")).tolist() == [
        0,
        -2e-5,
        3,
    ]


def test_a_static_system_is_a_gain_of_all_states():
    K = control.ss([], [], [], [[-2.0, -1.0]], inputs=["arm'", "arm"], outputs=["u"])
    np.testing.assert_array_equal(sos.analyse_pid(PLANT, K).K, [[-1.0, -2.0]])
    assert sos.Loop(PLANT, K).norm() == loop("states").norm()


def test_a_design_and_a_controller_have_their_loop():
    design = sos.design_pid(PLANT, law=PID, region=sos.PoleRegion(0.05))
    own = design.loop
    np.testing.assert_allclose(np.sort(own.poles()[0]), np.sort(design.poles()))
    design = sos.design_pid(PLANT, [[1]], region=sos.PoleRegion(0.05))
    np.testing.assert_allclose(np.sort(design.loop.poles()[0]), np.sort(design.poles()))
    roles = {s.role: s.name for s in design.loop.at(0.01).signals}
    assert roles["memory"] == "integral of arm" and roles["input"] == "u"
    assert roles["set point"] == "set point of arm"
    c = design.controller(T=0.01)
    ran = sos.Loop(PLANT, c)
    assert ran.clock == sos.Clock(0.01, 0.0) and ran.prove().text == c.certify().text
    refused(ran.data, "Controller", "design.loop")
    refused(lambda: sos.Loop(PLANT, PID), "gains are missing")
    refused(lambda: loop("PID").to_c(), "no clock", "loop.at(T=...)")
    refused(lambda: loop("PID").late(0.1).prove(sos.HInfinity(1.0)), "delta=")
    refused(lambda: sos.Loop(PLANT, PID, OF_PID, clock=0.1), "Clock or Late")


def test_the_longest_delay_of_a_law_is_near_its_margin():
    found = largest("tau", loop("PID"), tau=0.05, refuse=False)
    assert 0.5 * delay_margin("PID") < found.value < delay_margin("PID")
    assert loop("PID").late(0.05).largest("tau", refuse=False).value == found.value


def test_a_controllers_loop_keeps_the_clock_that_it_was_made_for():
    c = loop("PID").design.controller(T=0.01, delay=(0.001, 0.004), jitter=0.002)
    again = sos.Loop(PLANT, c)
    assert again.clock == sos.Clock(0.01, (0.001, 0.004), 0.002)
    proof = again.largest("delay", 0.006, tolerance=0.5)
    assert proof.proven and proof.T == (0.008, 0.012) and proof.delay[0] == 0.001
    proof = again.largest("T", 0.02, tolerance=0.5)
    assert proof.proven and proof.T[0] == 0.008 and proof.delay == (0.001, 0.004)
