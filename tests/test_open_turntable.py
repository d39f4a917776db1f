"""The open cells of part VII agree with the package's calls, on other tables too."""

import re
from math import comb
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import block_diag, eigh, expm, null_space

import sosbook as sos
from sosbook.book import plots, turntable
from sosbook.plants import condense, descriptors
from tests.energy_to_peak import EnergyToPeak
from tests.test_open_cells import cells, code, names

TABLES = sos.Uncertain(turntable.drive, J=(0.01, 0.03))


def after(chapter, *words, **given):
    """What is at hand after the cells with these words have run."""
    space = names(drive=turntable.drive, table=turntable.table, **given)
    for each in words:
        exec(next(source for source in code(chapter) if each in source), space)
    return space


def test_the_vertices_of_the_table_have_the_call_s_bound():
    """Bernstein's weights give the table back; the call stays a hundredth away."""
    space = after("31", "def bernstein", comb=comb)
    for t in (0, 0.3, 1):
        mean = np.dot([(1 - t) ** 2, 2 * t * (1 - t), t**2], space["loaded"])
        assert_allclose(mean, turntable.table(2, 0.05 + 0.05 * t).M[1, 1])
    exec(cells("31")[0], space)
    design = sos.design_pid(
        TABLES,
        region=sos.PoleRegion(sigma=5, rho=200),
        saturation=sos.Saturation(None, [0.1, 0.1, 0, 0]),
        minimize="u_max",
    )
    least = np.sqrt(space["least"].values["u2"].item())
    assert 1.009 <= design.request.saturation.u_max / least < 1.015


def test_free_multipliers_prove_what_the_call_proves():
    """The truth is eigenvalues': a hundredth below is proven, above is not."""
    space = after("32", "def free(loops")
    K = np.array([[-3.0, 1.1, -0.3, -0.05]])  # another gain than the chapter's
    loops = [(d.E, d.A + d.Bu @ K) for d in descriptors(TABLES.polytope())]
    true = min(-np.linalg.eigvals(np.linalg.solve(*x)).real.max() for x in loops)
    for share, status in ((0.99, "feasible"), (1.01, "infeasible")):
        region = sos.PoleRegion(sigma=share * true)
        assert sos.analyse_pid(TABLES, K, region=region).status == status
        point = space["free"](loops, share * true).solve(refuse=False)
        assert (point.status == "feasible") is (share < 1)
        assert share > 1 or point.prove().proven


def test_the_joined_loop_and_its_cells_are_the_call_s():
    """Poles of the law's loop by hand; cells where one Q keeps the decay."""
    law = sos.PIDLaw(position=[[1, 0]], filter=0.01)
    gains = {"K_P": np.array([[-2.0]]), "K_D": np.array([[-0.3]])}
    motor = SimpleNamespace(gains=gains)
    space = after("34", "def loop", "def kept", motor=motor, block_diag=block_diag)
    for J in (0.01, 0.023):
        E, A = space["loop"](J)
        poles = sos.analyse_pid(turntable.drive(J), gains, law=law).poles()
        mine = np.linalg.eigvals(np.linalg.solve(E, A))
        assert_allclose(np.sort_complex(mine), np.sort_complex(np.ravel(poles)))
    region = sos.PoleRegion(sigma=3)
    call = sos.analyse_pid(TABLES, gains, law=law, region=region)
    assert call.status == "feasible"
    assert call.parts[0].cells <= space["cells"](0.01, 0.03, 3) < 20


@pytest.mark.campaign  # chapter 33 prints both figures
def test_the_upright_table_s_least_push_is_the_closed_form(capsys):
    space = after("33", "def tipped", null_space=null_space)
    capsys.readouterr()
    exec(cells("33")[0], space)
    for line in capsys.readouterr().out.splitlines():
        ours, by_hand = line.split(", by hand ")
        assert_allclose(float(ours), float(by_hand), rtol=5e-3)


def test_the_least_norm_of_any_controller_is_clarabel_s():
    """By cvxpy in units in which it is right, with other noises than the chapter's."""
    space = after("36", "def sensor", "def unseen", "def least", null_space=null_space)
    exec(next(x for x in code("36") if "def by_clarabel" in x), space)
    T = np.diag([1, 1, 30, 30])
    A, B, B_w, C_z = (space[x] for x in ("A", "B", "B_w", "C_z"))
    plant = *(np.linalg.solve(T, x) for x in (A @ T, B, B_w)), C_z @ T
    for name, noise in (("motor", (0.02, 0.01)), ("both", (0.005, 0.03))):
        C, D = space["sensor"](name, noise)
        theirs = space["by_clarabel"](C @ T, D, *plant).solve(solver="CLARABEL")
        assert_allclose(space["least"](C, D), theirs, 1e-3)


def test_rows_on_the_rate_prove_the_call_s_bound():
    """The truth is the worst gain over a grid of frequencies, at another gain."""
    K = np.array([[-200.0, 190.0, -2.0, -1.0]])
    space = after("37", "K, C_a = ", tables=TABLES, still=SimpleNamespace(K=K))
    true = 0
    for d in descriptors(TABLES.polytope()):
        for s in 1j * np.geomspace(1, 1e4, 1000):
            x = np.linalg.solve(s * d.E - d.A - d.Bu @ K, d.Bw)
            true = max(true, abs(s * x[3, 0]))
    assert space["rate"](1.02 * true).solve().prove().proven
    assert space["rate"](0.98 * true).solve(refuse=False).status != "feasible"


def test_a_reduced_shaft_s_gain_is_the_call_s_and_shifts_a_mode_as_the_formula_says():
    """Other flanges and another table; the truth is eigenvalues of the whole shaft."""
    space = after(
        "38", "NODES, FLANGES", "def design", condense=condense, inv=np.linalg.inv
    )
    whole = condense(*space["matrices"](0.013, flange=3e-4, friction=2e-5))
    part = whole.reduce(rows=[0, 6])
    (source,) = cells("38")
    exec(source, space | {"part": part}, space)
    K, proven = space["gain"](part, 15)
    assert proven
    assert_allclose(K, space["design"](part, 15).K, rtol=1e-9)
    (d,), small = descriptors(whole), 0.01 * np.array([[0, 0, -1, -7]])
    A = d.A + d.Bu @ part.reduction.lift(small)
    poles = np.linalg.eigvals(np.linalg.solve(d.E, A))
    squares, V = eigh(whole.S, whole.M)
    for w, mode in zip(np.sqrt(squares[2:]), V.T[2:], strict=True):
        rates = small[0, 2:] @ mode[[0, 6]] * mode[0] - mode @ whole.D @ mode
        true = poles[abs(poles - 1j * w).argmin()].real
        assert_allclose(rates / 2, true, rtol=2e-2)


def test_the_least_peak_in_the_open_is_the_call_s():
    """The truth is the root of the impulse response's energy, integrated by steps."""
    space = after("41", "def twisting", "tables = sos.Un", plots=plots)
    space["limit"] = sos.Saturation(0.7, [0.1, 0.1, 0, 0])  # not the chapter's
    exec(next(x for x in cells("41") if "least peak" in x), space)
    point, tables = space["least"], space["tables"]
    least = np.sqrt(point[space["size"]].item())
    call = sos.design_pid(
        tables, minimize="peak", requirements=[EnergyToPeak(), space["limit"]],
        **space["asked"],
    )  # fmt: skip
    assert 1.009 <= call.request.owner("peak").bound / least < 1.02
    K = point[space["Y"]] @ np.linalg.inv(point[space["P"]])
    for J in (0.01, 0.017, 0.03):
        (d,) = space["twisting"](J).vertices
        (motor,) = descriptors(turntable.drive(J))
        for name in ("E", "A", "Bu", "Bw"):
            assert_allclose(getattr(d, name), getattr(motor, name))
        step = expm(1e-4 * np.linalg.solve(d.E, d.A + d.Bu @ K))
        x, energy = np.linalg.solve(d.E, d.Bw), 0
        for _ in range(40_000):
            energy, x = energy + 1e-4 * (d.C @ x).item() ** 2, step @ x
        assert 0.3 * least < np.sqrt(energy) < least


def test_a_motion_s_three_numbers_hold_a_motion_of_my_own():
    """Whose acceleration goes to and fro as fast as it may; and a guess of a step."""
    space = after("42", "tables = ", "loop = axis", "def tube", "left = ")
    axis, F, h, n = (space[x] for x in ("axis", "F", "h", "n"))
    guess, doubt, true = space["tube"](6, 300)
    bound = axis.bounds.step_response(output="load").overshoot.proven
    assert true.max() < (guess + doubt).max() < 1.002 * bound
    x, r, v, a, worst = np.zeros(n), 0.0, 0.0, 0.0, 0.0
    for k in range(1500):
        worst = max(worst, abs(h @ (x - space["x_r"] * r)))
        x = F @ x + space["loop"].set_point[:, 0] * r
        r, v = r + 0.002 * v, v + 0.002 * a
        a += 0.002 * (50 if (k + 200) % 800 < 400 else -50)
        assert abs(v) <= 10 and abs(a) <= 20.001
    sizes = abs(h @ space["y_v"]), abs(h @ space["y_a"]), space["total"]
    three = np.dot(sizes, (10, 20, 50))
    assert 0.5 * three < worst < three
    assert three < axis.motions.follow(10, 20, 50, output=0).proven < 1.02 * three


def test_the_picture_of_a_move_asks_no_more_than_its_sentence_says():
    """The program that is drawn has an encoder, whose steps ask something, too."""
    book = Path(__file__).resolve().parent.parent / "book"
    text = (book / "42_step_ramp_move.ipynb").read_text("utf-8")
    said = r"asks more than ([\d.]+) N m\. Proven\.\W+Here it asks ([\d.]+) N m"
    pairs = [[*map(float, pair)] for pair in re.findall(said, text)]
    assert len(pairs) == 3
    assert all(drawn <= most <= 2 for most, drawn in pairs), pairs
