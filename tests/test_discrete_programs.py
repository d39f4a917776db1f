"""Programs in C of plants of discrete time: loops in z, bits, files."""

import re
from functools import cache, partial
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import sosbook as sos
from sosbook.controllers import CompiledCode, code_fault, read_gains
from sosbook.controllers.report import report_texts
from sosbook.exact.checker import verdict as checker
from sosbook.exact.proof_file import load
from sosbook.proofs.subject import compare_code, proofs_beside
from tests.cases import later

DISK = sos.LMIRegion.disk


@cache
def identified():
    """An ARX model: two lightly damped pairs, an input that comes two ticks late."""
    poles = np.r_[0.98 * np.exp([0.6j, -0.6j]), 0.97 * np.exp([1.6j, -1.6j])]
    A = np.eye(4, k=1)
    A[:, 0] = -np.poly(poles).real.round(6)[1:]
    B = np.array([[0], [0.3], [0.25], [0.0]])
    names = ["wave", "b", "c", "d"]
    one = np.eye(4)
    p = sos.DescriptorSystem(one, A, B, one[:, :1], C=one[:1], dt=0.3, states=names)
    law = sos.DynamicLaw(2, position=one[:1], noise=[[0.1]])
    return p, sos.design_pid(p, law=law, region=DISK(0.95))


@cache
def rough():
    """Two inputs, unsymmetric, unstable, E no identity; units of .3 and 9.81."""
    E = [[0.3, 0.1, 0], [0, 9.81, 0], [0, 0, 1]]
    A = [[0.31, 0.9, 0], [-0.3, 9.9, 1], [0.05, 0, 0.6]]
    B, w = [[0.02, 0], [0.981, 0.3], [0, 1]], [[0.1], [0], [1]]
    p = sos.DescriptorSystem(E, A, B, w, C=np.eye(3), dt=9.81)
    return p, sos.design_pid(p, region=DISK(0.8))


@cache
def family():
    """A cart with an unknown push, by a PID that sums and filters at the ticks."""

    def cart(b):
        A, w = [[1, 0.05], [0, 0.98]], [[0], [0.05]]
        return sos.DescriptorSystem(np.eye(2), A, [[0], [b]], w, C=[[1, 0]], dt=0.05)

    law = sos.PIDLaw(position=[[1, 0]], integrate=True, filter=0.1)
    p = sos.Uncertain(cart, b=(0.03, 0.06))
    return p, sos.design_pid(p, law=law, region=DISK(0.99))


def controllers():
    sensors = ["x1", "x3"], ["x3", "x1", "x2"]
    return {
        "dynamic": identified()[1].controller(units={"wave": "m"}),
        "observer": rough()[1].controller(sensors[0]),
        "static": rough()[1].controller(sensors[1]),
        "sums": family()[1].controller(),
    }


KINDS = ("dynamic", "observer", "static", "sums")


def next_of(p):
    """A and B of x(k+1) of one plant, solved by numpy."""
    return np.linalg.solve(p.E, p.A), np.linalg.solve(p.E, p.B)


@pytest.mark.parametrize("kind", KINDS)
def test_the_program_as_it_is_is_proven_and_a_stranger_decides(kind):
    c = controllers()[kind]
    proof = c.certify()
    assert proof.proven and checker.check(proof.text) == list(proof.claims)
    assert (proof.K == np.hstack([c.D, c.C])).all() and c.T == c.plant.dt
    worst = 0.0
    several = c.plant.vertices if c.plant.family is None else c.plant.sample(20, 1)
    for one in [c.plant] if c.plant.family is None else several:
        A, B = next_of(one)
        R = c.readings.rows
        F = np.block([[A + B @ c.D @ R, B @ c.C], [c.B @ R, c.A]])
        worst = max(worst, abs(np.linalg.eigvals(F)).max())
    assert worst < 1
    assert abs(c.radius / worst - 1) < (1e-9 if c.plant.family is None else 0.05)
    rate = float(f"{0.3 + 0.7 * c.radius:.6g}")
    assert c.certify(rate=rate).proven
    assert not c.certify(rate=float(f"{0.99 * worst:.6g}")).proven


def test_an_observer_has_the_poles_of_the_gain_and_its_own():
    p, d = rough()
    c = controllers()["observer"]
    A, B = next_of(p)
    M, R = c.estimate.chosen.M, c.readings.rows
    wanted = np.r_[np.linalg.eigvals(A + B @ d.K), np.linalg.eigvals(A - A @ M @ R)]
    found = np.linalg.eigvals(c.loops[0].F)
    assert np.allclose(*map(np.sort_complex, (wanted, found)), atol=1e-6)


def test_the_program_of_a_law_is_the_law_itself():
    """The sums and the filter by their own recursion, under a limit."""
    d = family()[1]
    P, D, sums = (d.gains[x].item() for x in ("K_P", "K_D", "K_I"))
    c = d.controller().limit(0.4, anti_windup=False)
    for b, corner in ((0.03, 0), (0.06, 1)):
        x, f, i, seen = np.array([1.0, 0.0]), 1.0, 0.0, []
        for _ in range(300):
            y = x[0]
            u = np.clip(P * y + D * (y - f) / 0.1 + sums * i, -0.4, 0.4)
            f, i = f + 0.5 * (y - f), i + 0.05 * y
            seen.append(x)
            x = np.array([x[0] + 0.05 * x[1], 0.98 * x[1] + b * u])
        run = c.watch(stall=1e3).simulate(15.0, x0=[1, 0])
        assert not run.fault.any() and abs(run.u).max() == 0.4
        assert np.allclose(run.x[corner], seen, atol=1e-9)


@pytest.mark.parametrize(
    "precision, kind",
    [
        *(("double", kind) for kind in [*KINDS][::2]),
        *(("single", kind) for kind in [*KINDS][1::2]),
        *later(*(("double", kind) for kind in [*KINDS][1::2])),
        *later(*(("single", kind) for kind in [*KINDS][::2])),
    ],
)
def test_the_c_program_has_the_bits_of_python_under_its_limits(precision, kind):
    c = controllers()[kind].limit(0.3).watch(stall=1e3 * controllers()[kind].T)
    p = c.plant if c.plant.family is None else c.plant.sample(1, 3)[0]
    A, B = next_of(p)
    run = CompiledCode(c, precision=precision)
    x, xs, us = np.linspace(0.5, -0.3, len(A)), [], []
    run.start(c.readings.rows @ x)
    for _ in range(120):
        u = run.step(c.readings.rows @ x, np.zeros(len(c.set_points)))[:, 0]
        xs.append(x), us.append(u)
        x = A @ x + B @ u.astype(float)
    mine = c.simulate(120 * c.T, x0=xs[0], plants=None if p is c.plant else p.vertices)
    size = 1e-9 if precision == "double" else 2e-3
    assert np.allclose(mine.u[0], us, atol=size) and not mine.fault.any()
    assert np.allclose(mine.x[0], xs, atol=size * (1 + abs(np.array(xs)).max()))
    assert np.max(np.abs(us)) == np.float64(run.kind.type(0.3))  # it is limited


def test_verify_takes_the_program_and_refuses_exchanged_names(tmp_path):
    c = controllers()["observer"].limit(5.0)
    c.to_c("axis").write(tmp_path)
    code, file = tmp_path / "axis.c", tmp_path / "axis_gains.h"
    (mine,) = proofs_beside(code)
    proof = load(mine)
    assert proof.verify() and f"tick of {c.T:g} s" in proof.claims[0]
    assert compare_code(proof, code)[0] == ""
    file.write_text(_names(file.read_text("utf-8")), "utf-8")
    with pytest.raises(ValueError, match="ROWS has another row for x3"):
        proofs_beside(code)


@pytest.mark.parametrize("kind", KINDS)
def test_a_proof_binds_each_number_of_the_loop(kind):
    c = controllers()[kind]
    text, proof = c.to_c("axis").gains, c.certify()
    assert code_fault(proof.data, text) == ""
    if len(c.readings.signals) > 1:  # a sensor in the place of another
        for change in (_rows, _names, lambda x: _names(_rows(x))):
            assert code_fault(proof.data, change(text))
            assert code_fault(c.certificate.data, change(text))
    us = f"{round(1e6 * c.T)}UL"
    for old, new, words in (
        (us, "77UL", "TICK"),
        ("DELAY_TICKS 0", "DELAY_TICKS 1", "later"),
    ):
        assert old in text
        assert words in code_fault(proof.data, text.replace(old, new, 1))
        assert code_fault(c.certificate.data, text.replace(old, new, 1))
    for label in ("A", "B", "C", "D", "ROWS"):
        block = re.search(rf"AXIS_{label} \{{ \\\n(.*\n)+?\}}", text)[0]
        number = next(iter(re.findall(r"-?0x1[.0-9a-f]*p[+-]\d+", block)), None)
        if number is not None:
            other = float(np.nextafter(float.fromhex(number), 1e9)).hex()
            wrong = text.replace(block, block.replace(number, other, 1))
            assert code_fault(proof.data, wrong).startswith(f"its {label} ")


def _rows(text):
    """The text with the first two rows of ROWS exchanged."""
    block = re.search(r"_ROWS \{ \\\n(.*\n)(.*\n)", text)
    return text.replace(block[1] + block[2], block[2] + block[1])


def _names(text):
    """The text with the names of the first two sensors exchanged, all over."""
    labels = re.findall(r"#define AXIS_IN_(\w+) [01]", text)
    words = re.findall(r"/\* (\S*)(?: \(\w+\))?: [^:]* \*/ \\", text.split("_ROWS")[1])
    for a, b in ([f"IN_{x} " for x in labels], [f"/* {x}: " for x in words[:2]]):
        text = text.replace(a, "\0").replace(b, a).replace("\0", b)
    return text


def test_bounds_and_margins_hold_for_every_plant():
    """Tubes and disks of the change: steps and gains of plants between the corners."""
    c = controllers()["sums"]
    step, steps = c.bounds.step_response(), []
    for one in c.plant.sample(12, 5):
        run = c.simulate(60 * 0.3, r=1.0, plants=one.vertices)
        steps.append(run.x[0, :, 0].max() - 1)
    assert max(steps) <= step.overshoot.proven < 1.2 * max(steps) + 0.05
    margins = c.margins(sharp=False)
    (low, high), R = margins.gain, c.readings.rows
    for one in c.plant.sample(12, 6):
        A, B = next_of(one)
        for share in (low.proven, high.proven):
            D, C = share * c.D, share * c.C
            F = np.block([[A + B @ D @ R, B @ C], [c.B @ R, c.A]])
            assert abs(np.linalg.eigvals(F)).max() < 1
    assert margins.delay is None


def test_what_has_no_meaning_at_the_plants_own_ticks_is_refused():
    p, d = rough()
    c = d.controller()
    for name, value in (("T", 0.3), ("delay", 9.81), ("delay", (0, 1)), ("jitter", 1)):
        with pytest.raises(ValueError, match=f"^{name} = .*ticks of 9.81 s"):
            d.controller(**{name: value})
    assert d.controller(T=9.81, delay=0.0).clock == c.clock == d.loop.controller.clock
    mine, yours = (read_gains(x.to_c().gains) for x in (d.loop, c))
    assert all(np.allclose(mine[x], yours[x], rtol=1e-4) for x in mine)
    for asked in (dict(T=0.3), dict(delay=1.0), dict(cells=3)):
        with pytest.raises(ValueError, match="discrete time"):
            c.certify(**asked)
    with pytest.raises(ValueError, match="furthest"):
        c.furthest()
    with pytest.raises(ValueError, match="T is missing"):
        sos.design_pid(sos.SecondOrderSystem(1, 1, 1, 1)).controller()
    blind = sos.DescriptorSystem(np.eye(2), np.diag([0.5, 1.2]), [[1], [1]], dt=0.3)
    with pytest.raises(ValueError, match=r"mode at z = 1\.2"):
        sos.design_pid(blind).controller(["x1"])


def test_a_report_says_that_all_is_of_the_plants_own_ticks():
    d = identified()[1]
    page = report_texts(d, d.controller())["index.html"]
    assert "Asked, proven and true, at the plant's ticks" in page
    assert "(next x - x)/(0.3 s) = A x + B u" in page and "x&#x27; = A x" not in page
    assert "poles z" in page and "poles, rad/s" not in page


def test_inputs_with_delays_of_their_own_are_states_of_a_plant_of_ticks():
    """What a late loop's refusal says: the manual's lines, against arrivals."""
    D, S = 0.1 * np.eye(2), np.array([[2, -1], [-1, 2.0]])
    plant = sos.SecondOrderSystem(np.eye(2), D, S, np.eye(2))
    K = np.array([[-0.3, 0, -0.5, 0], [0, -0.3, 0, -0.5]])
    for tau in ([0.1, 0.2], (0.1, 0.2), np.array([0.1, 0.2])):
        for ask in (sos.Loop(plant, None, K).late, partial(analyse, plant, K)):
            with pytest.raises(ValueError, match=r"one delay.*DescriptorSystem"):
                ask(tau)
    page = (Path(__file__).parents[1] / "book/api/loops.md").read_text("utf8")
    lines = next(
        x for x in re.findall(r"```python\n(.*?)```", page, re.S) if "c2d" in x
    )
    known = {"sos": sos}
    exec(lines, known)
    late, T = known["late"], known["T"]
    d = sos.analyse_pid(late, known["K"])
    assert d.certify().proven
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-S, -D]])
    x, u = np.array([1.0, -0.5, 0.3, 0]), {}
    state = np.concatenate([x, np.zeros(6)])
    for k in range(60):
        assert np.allclose(state[:4], x, atol=1e-9)
        u[k] = K @ x
        held = np.array([u[k - n][i] if k >= n else 0 for i, n in enumerate((2, 4))])
        M = np.zeros((5, 5))
        M[:4, :4], M[2:4, 4] = A, held
        x = (expm(M * T) @ np.append(x, 1.0))[:4]
        state = late.A @ state + late.B @ (known["K"] @ state)


def analyse(plant, K, tau):
    return sos.analyse_delay(plant, K, tau=tau)
