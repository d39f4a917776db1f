"""The cells that write a theorem out agree with the package's call below them."""

import json
import warnings
from pathlib import Path

import cvxpy
import numpy as np
import pytest
from numpy.linalg import inv, norm
from numpy.testing import assert_allclose
from scipy.linalg import solve_continuous_are

import sosbook as sos
from sosbook import theorems
from sosbook.book import counterexamples, tables, thesis
from sosbook.pendulum import Mip, polytope, vertices
from sosbook.plants import descriptors, mean_descriptor

BOOK = Path(__file__).parent.parent / "book"


def code(chapter):
    """The code cells of a chapter."""
    (path,) = BOOK.glob(f"{chapter}_*.ipynb")
    every = json.loads(path.read_text("utf8"))["cells"]
    return ["".join(c["source"]) for c in every if c["cell_type"] == "code"]


def cells(chapter):
    """The code cells of a chapter that write blocks in the open."""
    return [x for x in code(chapter) if "symmetric(" in x or "LMIProblem(" in x]


def plain(chapter, space, last):
    """``space`` after a chapter's cells in cvxpy have run, to that with ``last``."""
    for source in code(chapter):
        if "cp." in source or last in source:
            exec(source, space)
        if last in source:
            return space


def names(**given):
    """What a cell finds in its chapter: the words, the libraries and ``given``."""
    words = {}
    exec(
        "from numpy.linalg import eigvals, eigvalsh, inv, solve\n"
        "from sosbook.lmi import *\nfrom sosbook.plants import descriptors",
        words,
    )
    return words | {"np": np, "sos": sos, "cp": cvxpy} | given


def run(chapter, count, **given):
    """The names after the first ``count`` open cells of a chapter have run."""
    space = names(**given)
    for source in cells(chapter)[:count]:
        exec(source, space)
    return space


def test_procedure_2_1_gives_the_package_s_gains():
    example = thesis.example_1()
    design = sos.design_pid(example.plant, **example.requirements)
    open_ = run("07", 2, plant=example.plant, U=np.eye(2))
    assert_allclose(open_["K"], design.K, atol=1e-9)
    assert open_["point"].prove().proven


@pytest.mark.campaign  # chapter 7 shows the gains and the room of each
def test_an_objective_chooses_the_point_of_clarabel():
    """The centre has the open cells' gains, the least trace lies on the edge."""
    space = run("07", 2, plant=thesis.example_1().plant, U=np.eye(2))
    K, given = space["K"], {"warnings": warnings, "tables": tables, "thesis": thesis}
    space = plain("07", space | given, "rows = [[")
    gains, room = space["gains"], space["room"]
    assert_allclose(gains["largest sum of log det"], K, atol=1e-3)
    assert abs(gains["none"] - K).max() > 1 and room["none"] > 0.01
    assert abs(gains["least trace of P"] - K).max() > 10
    assert abs(room["least trace of P"]) < 1e-6
    assert [row[1] for row in space["rows"]] == [
        f"{x[0, 0]:.1f}" for x in gains.values()
    ]


@pytest.mark.parametrize("name, moved", [("sector", 0), ("half-plane", 1), ("norm", 2)])
def test_a_block_that_is_left_out_is_missed(name, moved):
    """Against the loop's own eigenvalues: what the block asked isn't kept any more."""
    plant = thesis.example_1().plant
    space = run("07", 3, plant=plant, U=np.eye(2))
    all_in, less = space["left_out"]("none"), space["left_out"](name)
    assert all_in[0] < 45 and all_in[1] < -0.7
    assert (less[0] > 45, less[1] > -0.7, less[2] < all_in[2] / 4)[moved]


def test_the_region_s_blocks_give_a_gain_that_keeps_it():
    """Another gain than the call's: the solutions are a cone. Both are proven."""
    example = thesis.example_1()
    space = run("04", 1, example=example)
    K, d = space["K_open"], space["d"]
    loop = np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ K))
    assert example.region.contains(loop) and space["point"].prove().proven
    asked = {"U": example.U, "region": example.region}
    assert sos.analyse_pid(example.plant, K.round(6), **asked).certify().proven
    assert abs(sos.design_pid(example.plant, **asked).K / K - 1).max() > 0.1


def test_the_least_gamma_of_one_loop_is_its_norm():
    example = thesis.example_1()
    norm = sos.analyse_pid(example.plant, example.K, example.U).hinf()
    (d,) = descriptors(example.plant, example.U)
    space = run("05", 1, d=d, K=example.K, norm=norm)
    assert_allclose(np.sqrt(space["least"].values["g2"]), norm, rtol=1e-5)
    assert np.sqrt(space["least"].bound) <= norm * (1 + 1e-9)


def test_the_least_limit_of_the_input_is_clarabel_s_and_the_call_s():
    cart = sos.SecondOrderSystem([[1]], [[0.2]], [[1]], B=[[1]])
    least = run("06", 1, cart=cart)["least"]
    constraints, variables = least.problem.to_cvxpy()
    best = cvxpy.Problem(cvxpy.Minimize(variables["u2"][0, 0]), constraints)
    limit = np.sqrt(best.solve(solver="CLARABEL"))
    assert_allclose(np.sqrt(least.values["u2"]), limit, rtol=1e-4)
    start = sos.Saturation(None, [1, 0.5])
    design = sos.design_pid(
        cart, region=sos.PoleRegion(sigma=0.8), saturation=start, minimize="u_max"
    )
    assert 1.01 <= design.request.saturation.u_max / limit < 1.015


def test_the_lemma_of_masses_lends_what_it_says():
    chain = thesis.example_3().plant
    space = run("08", 1, chain=chain, regular_mass=theorems.regular_mass)
    K_A = space["point"].values["K_A"]
    mass = chain.M - chain.B @ K_A
    assert np.linalg.eigvalsh(mass + mass.T)[0] / 2 > 0.01
    assert_allclose(space["mass"], (mass + mass.T) / 2, atol=1e-12)


def test_the_pairs_refuse_what_the_vertices_accept(capsys):
    """As `polytopes.compare` says of the same plants and the same disk."""
    run("09", 1, driven=counterexamples.actuated())
    ends, both = capsys.readouterr().out.splitlines()
    assert ends.endswith(" feasible") and both.endswith(" infeasible")
    for coupling, said in (("vertices", ends), ("pairs", both)):
        design = sos.design_pid(
            counterexamples.actuated(), region=sos.PoleRegion(rho=10), coupling=coupling
        )
        assert said.endswith(f" {design.status}")


def test_an_open_cell_is_short():
    for path in BOOK.glob("[0-9]*.ipynb"):
        chapter = path.name[:2]
        field = [x for x in code(chapter) if "cp.bmat" in x]
        for source in cells(chapter) + field:
            lines = [line for line in source.splitlines() if line.strip()]
            assert len(lines) <= 15 and max(map(len, lines)) <= 72, source


def test_an_uncertain_mass_has_the_package_s_gains():
    """Example 2: in the open the blocks of the vertices, as the call asks them."""
    seat = thesis.example_2()
    x0 = seat.saturation.x0
    space = run("12", 2, plant=seat.plant, x0=x0, descriptors=descriptors)
    design = sos.design_pid(seat.plant, **seat.requirements)
    assert_allclose(space["open_K"], design.K, rtol=1e-8)
    assert space["point"].prove().proven


def test_the_least_cost_is_riccati_s():
    """`design` is the call's; the truth is scipy's Riccati equation."""
    carts = sos.SecondOrderSystem(
        np.eye(2), np.eye(2), [[3, -1], [-1, 2]], np.eye(2), np.eye(2)
    )
    design = sos.design_lqr(carts, 100 * np.eye(4), np.eye(2), noise="F")
    space = run("18", 1, carts=carts, R=np.eye(2), design=design)
    (d,) = descriptors(carts)
    A, B, G = d.state_space()
    X = solve_continuous_are(A, B, 100 * np.eye(4), np.eye(2))
    assert_allclose(np.trace(space["least"].values["J"]), np.trace(G.T @ X @ G), 1e-6)
    assert_allclose(space["open_K"], -B.T @ X, atol=2e-4)
    field = plain("18", space, "plain_K =")
    assert_allclose(field["plain"].value, np.trace(G.T @ X @ G), 1e-6)
    assert_allclose(field["plain_K"], -B.T @ X, atol=1e-4)


@pytest.mark.campaign  # chapter 22 prints whether they have
def test_the_pendulum_s_pairs_have_the_call_s_gains(capsys):
    """Between the dearest vertex, by scipy's Riccati equation, and the call's bound."""
    plants = polytope(Mip.printed())
    four = {("PD", R): sos.design_lqr(plants, np.eye(4), [[R]]) for R in (1, 2, 5)}
    space = run("22", 1, plants=plants, four=four)
    assert capsys.readouterr().out.count("True") == len(four)
    loops = [d.state_space()[:2] for d in descriptors(plants)]
    alone = [np.trace(solve_continuous_are(*x, np.eye(4), [[5]])) for x in loops]
    least, bound = (
        np.trace(space["least"].values["J"]),
        four["PD", 5].request.cost.bound,
    )
    assert max(alone) < least < bound < 1.001 * least


def test_the_observer_is_the_printed_one(capsys):
    """Table 4.3, to the digits that it prints, and the call's bound."""
    space = names(thesis=thesis, design_observer=sos.design_observer)
    space |= {"Mip": Mip, "vertices": vertices, "mean_descriptor": mean_descriptor}
    every = code("19")
    begin = next(k for k, x in enumerate(every) if x.startswith("C = np.array"))
    end = next(k for k, x in enumerate(every) if "open_L =" in x)
    exec(next(x for x in every if x.startswith("def error_and_state")), space)
    for source in every[begin : end + 1]:
        exec(source, space)
    printed = thesis.mip().lqe[1][1]
    assert_allclose(space["open_L"][1:], printed[1:], atol=0.3)
    assert_allclose(space["open_L"], space["designs"][1].L, rtol=1e-3)
    least, bound = space["least"].values["J"].item(), space["designs"][1].bound
    assert bound * 0.999 < least < bound
    J, L = plain("19", space, "def plain")["plain"](1e-4, inv(space["mean"].E))
    assert_allclose(1e8 * J, least, rtol=1e-5)
    assert_allclose(L, space["open_L"], rtol=2e-4)
    capsys.readouterr()
    plain("19", space, "cp.SolverError")
    assert "unit 1: Solver 'CLARABEL' failed" in capsys.readouterr().out


def test_a_lent_mass_keeps_the_procedure():
    """Example 3: with the printed K_A the blocks are those of chapter 7."""
    chain = thesis.example_3()
    wanted = chain.requirements | {"K_A": None}
    (loop,) = descriptors(chain.plant, chain.U, chain.K_A)
    designed = []

    def ask(K_A):
        designed.append(sos.design_pid(chain.plant, **wanted | {"K_A": K_A}))
        return designed[-1]

    space = run("13", 2, wanted=wanted, loop=loop, ask=ask, K_A=chain.K_A)
    assert_allclose(space["open_K"], designed[0].K, rtol=1e-6)


def test_the_arm_s_region_is_kept_at_both_vertices():
    """Another gain than the call's: a cone. The truth is numpy's eigenvalues."""
    arm = thesis.example_4()
    K = run("14", 1, plants=arm.plant, U=arm.U)["open_K"]
    for d in descriptors(arm.plant, arm.U):
        loop = np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ K))
        assert arm.region.contains(loop)
    own = sos.design_pid(arm.plant, arm.U, region=arm.region)
    assert 1e-4 < abs(own.K / K - 1).max() < 0.1


def test_the_delay_theorem_in_the_open_is_the_package_s():
    """The same block at the same point; the gain is certified by the call."""
    ex = thesis.delay_example_2()
    given = {"plant": ex.plant, "asked": ex.requirements, "U": ex.U}
    space = run("16", 2, tau=ex.tau, mu=ex.mu, delta=ex.delta, **given)
    point, e1, e2 = space["point"], space["e1"], space["e2"]
    parts = (point.values[x] for x in ["P", "Q", "S", "R1", "R2", "R3", "Z"])
    times = theorems.Times(ex.tau, ex.mu, ex.delta, e1, e2)
    F, X, v = point.values["F"], point.values["X"], theorems.Functional(*parts)
    theirs = theorems.delay_stabilization(space["d"], v, F, X, times, space["a"])
    ours = point.problem.text.blocks(point.values)["decay"]
    assert_allclose(theirs, ours, atol=1e-12 * abs(ours).max())
    assert space["again"].certify().proven
    field = plain("16", space, "plain_K =")
    assert field["given"].certify().proven
    assert norm(field["plain_K"] - ex.K) < 0.05 * norm(ex.K)


def test_the_printed_gains_decay_by_theorem_a_3():
    """In the open and by the call."""
    ex = thesis.delay_example_2()
    point = run("17", 2, masses=ex)["point"]
    assert point.status == "feasible" and point.prove().proven
    given = sos.analyse_delay(ex.plant, ex.K, ex.U, ex.tau, ex.mu, ex.delta)
    assert given.certify().proven
