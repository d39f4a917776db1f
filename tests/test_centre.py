"""The interior point method against closed forms and cvxpy."""

import cvxpy
import numpy as np
import pytest

import sosbook as sos
from benchmarks.catalogue import case
from benchmarks.robustness import SYSTEMS, in_units
from sosbook.book import thesis
from sosbook.lmi import Unknown, block, eye
from sosbook.solver.barrier import Barrier
from sosbook.solver.blocks import Blocks
from sosbook.solver.loop import (
    STEPS_BEFORE_DIRECTIONS,
    Unbounded,
    centre,
    minimize,
    phase_one,
)
from sosbook.solver.newton import Newton
from sosbook.solver.primal_dual import interior_steps
from sosbook.synthesis.feasibility import search
from sosbook.synthesis.request import Request
from tests.random_plants import random_case


def test_centre_of_a_disk():
    x = Unknown("x", 2, 1)
    shift = np.array([[3.0], [4.0]])
    ball = block([[np.eye(2), x - shift], [(x - shift).T, eye(1)]])
    found = centre(Blocks([ball], [x]), np.array([2.9, 4.5]))
    assert np.allclose(found, [3, 4], atol=1e-9)


def test_centre_of_an_unbounded_set_is_refused():
    x = Unknown("x", 1)
    with pytest.raises(Unbounded, match="no analytic centre"):
        centre(Blocks([x - eye(1)], [x]), np.full(1, 2.0))


@pytest.mark.parametrize(
    "ask",
    [
        lambda barrier, x: barrier.step(x, 0 * x),
        lambda barrier, x: barrier.recedes(x, [x]),
        lambda barrier, x: barrier.multipliers(x),
    ],
)
def test_a_point_outside_by_rounding_is_an_error_that_callers_know(ask):
    """Eigenvalues may say that it is inside, and Cholesky's factors that it isn't."""
    P = Unknown("P", 1, symmetric=True)
    blocks = Blocks([block([[P]]), block([[eye(1) - P]])], [P])
    with pytest.raises(np.linalg.LinAlgError, match="isn't inside"):
        ask(Barrier(blocks.newton), np.array([2.0]))


def test_a_plant_at_its_edge_gets_an_answer_in_small_units():
    """The point that was found had no factors there: seed 13184 of the campaign."""
    edge = random_case(13184)
    plant, asked = in_units(edge, *SYSTEMS["uN, mm, ms"])
    assert sos.design_pid(plant, **asked).status in ("feasible", "undecided")


def settled_modes(sigma, n=4):
    """A plant some of whose modes are settled without input, and an input bound."""
    rng = np.random.default_rng(8)
    Q = np.linalg.qr(rng.standard_normal((n, n)))[0]
    rates = np.linspace(1, 5, n)
    plant = sos.SecondOrderSystem(
        np.eye(n),
        Q * (0.02 * rates) @ Q.T,
        Q * rates**2 @ Q.T,
        rng.standard_normal((n, 2)),
    )
    x0 = rng.standard_normal(2 * n)
    limit = sos.Saturation(30.0, x0 / np.linalg.norm(x0))
    return plant, dict(region=sos.PoleRegion(sigma, rho=12), saturation=limit)


def test_a_set_without_end_is_seen_before_rounding_hides_it(monkeypatch):
    """Far away the mode that is settled seemed to leave: 15 steps, then 100 of both."""
    rng = np.random.default_rng(0)
    Q = np.linalg.qr(rng.standard_normal((4, 4)))[0]
    rates, force = rng.uniform(1, 5, 4), rng.standard_normal((4, 1))
    plant = sos.SecondOrderSystem(
        np.eye(4), Q * (0.02 * rates) @ Q.T, Q * rates**2 @ Q.T, force
    )
    x0 = np.append(rng.standard_normal(4) / 5, np.zeros(4))
    taken, step = [], Barrier.step
    monkeypatch.setattr(
        Barrier, "step", lambda self, *x: taken.append(1) or step(self, *x)
    )
    monkeypatch.setattr("sosbook.solver.loop.near_centre", lambda *_: pytest.fail())
    monkeypatch.setattr("sosbook.synthesis.centre.LARGE_BOUNDS", ())
    design = sos.design_pid(
        plant, region=sos.PoleRegion(0.04, rho=30), saturation=sos.Saturation(30.0, x0)
    )
    assert design.status == "feasible" and design.certify().proven
    assert len(taken) <= 8


@pytest.mark.parametrize("sigma, settled", [(0.02, True), (0.1, False)])
def test_a_mode_in_its_place_is_seen_as_a_set_without_end(sigma, settled):
    """Its part of P may grow forever; a walk of many steps found that, too."""
    plant, asked = settled_modes(sigma)
    problem = search(Request(plant, **asked)).problem
    blocks, x = problem.compiled, problem.text.packed(problem.find().values)
    steps = []
    if settled:
        with pytest.raises(Unbounded):
            centre(blocks, x, steps.append, directions=problem.free_directions)
        assert len(steps) < STEPS_BEFORE_DIRECTIONS  # long ones
        with pytest.raises(Unbounded):  # without a hint
            centre(blocks, x)
    else:  # no ray
        found = centre(blocks, x, directions=problem.free_directions)
        assert (found == centre(blocks, x)).all()
    design = sos.design_pid(plant, **asked)
    assert design.status == "feasible" and design.certify().proven


def test_a_ray_that_leaves_the_set_is_not_believed():
    x = Unknown("x", 2, 1)
    shift = np.array([[3.0], [4.0]])
    ball = block([[np.eye(2), (x - shift) / 1e9], [(x - shift).T / 1e9, eye(1)]])
    far = np.array([0.999e9, 0.0])
    found = centre(Blocks([ball], [x]), far, directions=lambda: np.eye(2))
    assert np.allclose(found, [3, 4], atol=1)


def test_example_1_is_the_centre_that_cvxpy_finds():
    """The sum of log det where P is the identity: in SI units Clarabel stops early."""
    ex = thesis.example_1()
    d = sos.design_pid(ex.plant, **ex.requirements)
    P = cvxpy.Variable((6, 6), symmetric=True)
    Y = cvxpy.Variable((2, 6))
    T = np.linalg.cholesky(d.P)
    blocks = d.request.blocks(T @ P @ T.T, 100 * Y @ T.T)
    volume = sum(cvxpy.log_det((g + g.T) / 2) for g in blocks.values())
    sharp = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), 1e-10)
    cvxpy.Problem(cvxpy.Maximize(volume)).solve(solver="CLARABEL", **sharp)
    K = 100 * np.linalg.solve(P.value, Y.value.T).T @ np.linalg.inv(T)
    assert np.abs(K - d.K).max() < 2e-4


def test_a_minimum_takes_few_steps_from_a_point_near_the_edge(monkeypatch):
    """An observer's: the first method gets there, though Z is hardly feasible."""
    steps, whole = [], Barrier.step
    monkeypatch.setattr(
        Barrier, "step", lambda *given: steps.append(1) or whole(*given)
    )
    question = case("observed beam", 8)
    assert question.judge(question.design())["excess"] < 1e-9
    assert len(steps) < 25  # near the path before the minimum, and to the centre


def test_an_infimum_that_is_not_attained_is_refused():
    x = Unknown("x", 2, symmetric=True)
    blocks = Blocks([x - np.array([[0, 1], [1, 0]])], [x])
    with pytest.raises(Unbounded, match="attained"):
        minimize(blocks, np.array([1.0, 0, 0]), np.array([2.0, 0, 2]))


def test_a_far_solution_is_found():
    """x = 1e6 in units where everything else is one."""
    x, far = Unknown("x", 1), 1e6
    blocks = Blocks([x - (far - 1) * eye(1), (far + 1) * eye(1) - x], [x])
    found = phase_one(blocks)
    assert found.verdict == "feasible"
    assert abs(found.x[0] - far) < 1


def test_an_idle_variable_does_no_harm():
    x, idle = Unknown("x", 1), Unknown("idle", 1)
    blocks = Blocks([x + eye(1), eye(1) - x], [x, idle])
    assert abs(centre(blocks, np.array([0.5, 0.0]))[0]) < 1e-9


def test_phase_one_starts_inside_its_ball():
    """However large the entries beside the diagonal are."""
    x, constant = Unknown("x", 1), np.array([[1.0, 1e6], [1e6, 1.0]])
    g = constant + x * np.array([[0.0, 1.0], [1.0, 0.0]])
    phase = phase_one(Blocks([g], [x]))
    assert phase.verdict != "infeasible"  # x = -1e6 is feasible
    blocks = Blocks([g, np.eye(1) + 1e-3 * x], [x])
    assert phase_one(blocks).x is None  # x > -1e3 excludes it


def test_nothing_goes_along_a_direction_that_overflows(monkeypatch):
    def solver(newton, *where):
        return lambda right, tolerance: np.full(len(right), -np.inf)

    monkeypatch.setattr(Newton, "solver", solver)
    x = Unknown("x", 1)
    newton = Newton(Blocks([eye(1) + x, eye(1) - x], [x]))
    assert not list(interior_steps(newton, np.zeros(1), np.ones(1), 1.0, 3))
