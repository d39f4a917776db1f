"""`LMIProblem` against Lyapunov's equation, Riccati's and a second solver."""

import re

import cvxpy
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov

from sosbook.exact.definite import exact
from sosbook.lmi import LMIProblem, Unknown, block, eye, he, matrix, pairs, symmetric
from sosbook.runtime.time_limit import OutOfTime, time_limit
from sosbook.solver.blocks import Blocks
from sosbook.solver.loop import Unbounded
from sosbook.solver.settings import Settings
from tests.cases import campaign, seeds

A = np.array([[0.0, 1.0], [-2.0, -3.0]])
B = np.array([[0.0], [1.0]])
ROUND = np.array([[0.25, 0.0], [0.0, 0.5]])


P2, ONE = symmetric("P", 2), np.eye(1)
X1 = matrix("x", 1, 1)


def lyapunov(A, sigma=0.0, **more):
    """P > 0 and A P + P A' + 2 sigma P < 0."""
    P = symmetric("P", len(A))
    return LMIProblem({"P": P, "decay": -he(A @ P) - 2 * sigma * P}, **more)


def driven(A, Q):
    """A P + P A' + Q < 0: P exceeds the solution of Lyapunov's equation."""
    return LMIProblem({"decay": -he(A @ P2) - Q})


def test_a_stable_matrix_is_proven_stable():
    found = lyapunov(A).solve()
    assert found.status == "feasible" and min(found.margins.values()) > 0
    assert found.infeasibility is None
    proof = found.prove(("A is stable",))
    assert proof.proven and proof.statement == ("A is stable",)
    assert proof.claims == ("these blocks are positive definite: P, decay",)
    P = found.values["P"]
    assert np.linalg.eigvalsh(P)[0] > 0
    assert np.linalg.eigvalsh(A @ P + P @ A.T)[-1] < 0


@pytest.mark.parametrize("sigma, status", [(0.5, "feasible"), (3.0, "infeasible")])
def test_the_decay_rate_decides(sigma, status):
    """The poles are -1 and -2."""
    found = lyapunov(A, sigma).solve()
    assert found.status == status
    if status == "infeasible":
        assert found.infeasibility.proven and found.infeasibility.value <= 0
        assert set(found.infeasibility.multipliers) == {"P", "decay"}
        with pytest.raises(ValueError, match="there is no point"):
            found.prove()


def test_a_false_point_is_not_proven():
    proof = lyapunov(A).prove({"P": -np.eye(2)}, ("never",))
    assert not proof.proven and proof.claims == () and "P" in proof.failed


def test_the_smallest_trace_is_lyapunovs():
    problem = driven(A, np.eye(2))
    P = solve_continuous_lyapunov(A, -np.eye(2))
    found = problem.minimize(P2)
    assert_allclose(found.values["P"], P, rtol=1e-4)
    inside = problem.minimize(P2, start={"P": 2 * P})
    assert_allclose(inside.values["P"], P, rtol=1e-4)


def test_the_weights_pick_entries():
    """With weight W the least <W, P> is that of Lyapunov's solution, too."""
    P = solve_continuous_lyapunov(A, -np.eye(2))
    found = driven(A, np.eye(2)).minimize(ROUND @ P2)
    assert_allclose((ROUND * found.values["P"]).sum(), (ROUND * P).sum(), rtol=1e-5)


def test_several_unknowns_give_riccatis_gain():
    """The LQR of section 2.5 as an LMI with P, Y and J."""
    P, Y, J = P2, matrix("Y", 1, 2), symmetric("J", 2)
    flow = he(A @ P + B @ Y)
    problem = LMIProblem(
        {
            "decay": -block([[flow, P, Y.T], [P, -eye(2), 0], [Y, 0, -eye(1)]]),
            "cost": block([[J, eye(2)], [eye(2), P]]),
        }
    )
    found = problem.minimize(J, gap=1e-9)
    X = solve_continuous_are(A, B, np.eye(2), np.eye(1))
    assert_allclose(np.trace(found[J]), np.trace(X), rtol=1e-5)
    K = np.linalg.solve(found[P], found[Y].T).T
    assert_allclose(K, -B.T @ X, rtol=1e-3)


def test_no_minimum_is_said():
    with pytest.raises(Unbounded):
        driven(A, np.eye(2)).minimize(-P2)
    with pytest.raises(Unbounded):
        lyapunov(A).centre({"P": lyapunov(A).find().values["P"]})


def test_an_infeasible_problem_has_no_minimum():
    problem = LMIProblem({"P": P2, "decay": he(A @ P2)})
    found = problem.minimize(P2)
    assert found.status == "infeasible" and found.values is None


def test_the_same_blocks_in_cvxpy():
    constraints, variables = driven(A, np.eye(2)).to_cvxpy()
    problem = cvxpy.Problem(cvxpy.Minimize(cvxpy.trace(variables["P"])), constraints)
    problem.solve(solver="CLARABEL")
    assert_allclose(
        variables["P"].value, solve_continuous_lyapunov(A, -np.eye(2)), atol=1e-5
    )


def test_a_minimum_is_bracketed():
    P = solve_continuous_lyapunov(A, -np.eye(2))
    found = driven(A, np.eye(2)).minimize(P2, gap=1e-4)
    assert found.bound <= np.trace(P) <= np.trace(found.values["P"])
    assert np.trace(found.values["P"]) - found.bound < 1e-3 * np.trace(P)


def interval(low, high):
    """low < x < high, whose analytic centre lies in the middle."""
    return LMIProblem({"low": X1 - low, "high": high - X1})


def test_the_centre_of_an_interval():
    problem = interval(0.25, 1.0)
    assert_allclose(problem.solve().values["x"], 0.625)
    assert_allclose(problem.centre({"x": [[0.3]]}).values["x"], 0.625)
    with pytest.raises(ValueError, match="start isn't inside block 'high'"):
        problem.centre({"x": [[1.5]]})
    with pytest.raises(ValueError, match=r"start needs x of the shape \(1, 1\)"):
        problem.centre({"y": [[0.3]]})


def test_bounds_hold_where_they_are_asked_for():
    found = lyapunov(A).solve(within_bounds=True)
    assert found.status == "feasible"
    assert np.linalg.eigvalsh(found.values["P"])[-1] < 16


def test_an_empty_interval_is_refused():
    found = interval(1.0, 0.25).solve()
    assert found.status == "infeasible" and found.excluded == np.inf
    Z = found.infeasibility.multipliers
    assert Z["low"] == Z["high"] and Z["low"][0, 0] > 0
    assert found.infeasibility.value < 0 and found.reason == ""
    quick = interval(1.0, 0.25).solve(refuse=False)
    assert quick.status == "undecided" and quick.infeasibility is None
    assert quick.excluded == 0 and "neither a point nor" in quick.reason


def test_digits_of_a_proof():
    problem = interval(1.23456, 1.23458)
    found = problem.solve()
    proof = found.prove(("x is known to five digits",), digits=6)
    assert proof.proven and proof.digits == 6 and proof.values["x"] == 1.23457
    assert not found.prove(digits=3).proven
    assert found.prove().digits == 12
    narrow = interval(1.0, 1.0 + 1e-14)
    inside = {"x": np.array([[1.0 + 5e-15]])}
    assert narrow.prove(inside).digits == 17 and narrow.prove(inside).proven
    for digits in (0, -1, 2.5, "6"):
        with pytest.raises(ValueError, match="digits must be 1 or more"):
            found.prove(digits=digits)


def test_a_point_that_floats_cannot_judge_is_proven_or_undecided():
    """A margin of rounding errors is no answer by itself."""

    def thin(gap):
        return LMIProblem({"g": block([[ONE, X1], [X1, ONE]]), "edge": X1 - 1 + gap})

    found = thin(1e-12)._at(np.array([1 - 5e-13]))
    assert min(found.margins.values()) < 1e-9 and found.status == "feasible"
    lost = thin(0.0)._at(np.array([1.0]))
    assert lost.status == "undecided" and "'g' has the margin" in lost.reason


def test_irrational_multipliers_prove_as_much_as_rationals_can():
    """Of a saddle they are one irrational vector's, alone."""
    found = lyapunov(np.array([[0.0, 1.0], [2.0, 3.0]])).solve()
    assert found.status == "undecided" and found.infeasibility is None
    assert 1e3 < found.excluded < np.inf
    assert f"none is shorter than {found.excluded:.1e}" in found.reason
    assert lyapunov(np.diag([1.0, -1.0])).solve().infeasibility.verify()


def test_the_excluded_radius_is_right():
    """x < 0 and x > 1 + c y: points begin where c y reaches -1."""
    y = matrix("y", 1, 1)
    problem = LMIProblem({"x": -X1, "y": X1 - 1 - 1e-3 * y})
    one = np.eye(1)
    assert problem.refuse([one, one]) is None
    assert_allclose(problem.excluded_radius([one, one]), 1e3)
    assert problem.text.margins({"x": -1e-9 * one, "y": -1001 * one})["y"] > 0
    assert problem.excluded_radius([one, -one]) == 0


@pytest.mark.parametrize("seed", seeds(8))
def test_verdicts_agree_with_clarabel(seed):
    """A common Lyapunov function of two random matrices."""
    rng = np.random.default_rng(seed)
    pair = rng.normal(size=(2, 3, 3)) - rng.uniform(0, 4) * np.eye(3)
    P3 = symmetric("P", 3)
    problem = LMIProblem({"P": P3} | {f"{k}": -he(M @ P3) for k, M in enumerate(pair)})
    found = problem.solve()
    constraints, variables = problem.to_cvxpy()
    t, P = cvxpy.Variable(), variables["P"]
    best = cvxpy.Problem(
        cvxpy.Maximize(t),
        [cvxpy.trace(P) == 3, *(c.args[0] - t * np.eye(3) >> 0 for c in constraints)],
    )
    best.solve(solver="CLARABEL")
    if abs(t.value) > 1e-5:
        assert (found.status == "feasible") == (t.value > 0)
    if found.status == "feasible":
        assert found.prove().proven
    elif found.status == "infeasible":
        Z = found.infeasibility.multipliers
        total = Z["P"] - sum(
            exact(M).T @ Z[str(k)] + Z[str(k)] @ exact(M) for k, M in enumerate(pair)
        )
        assert not total.any()
    else:
        assert found.excluded > 1e3


def test_time_and_memory_end(monkeypatch):
    big = np.kron(np.eye(12), A) + np.diag(np.ones(23) / 4, 1)
    found = lyapunov(big, time_limit=1e-4).solve()
    assert found.status == "undecided" and found.reason == "stopped after 0.0001 s"
    assert found.values is None
    assert lyapunov(big, time_limit=60).solve().status == "feasible"
    late = driven(A, np.eye(2))
    late.time_limit = 1e-9
    inside = {"P": 2 * solve_continuous_lyapunov(A, -np.eye(2))}
    stopped = late.minimize(P2, start=inside)
    assert stopped.note.startswith("stopped") and stopped.bound is None
    monkeypatch.setattr(Blocks, "settings", Settings(most_dense_variables=1))
    full = lyapunov(A).solve()
    assert full.status == "undecided" and "too many for a dense matrix" in full.reason


def test_an_outer_time_limit_is_not_swallowed():
    with time_limit(1e-9), pytest.raises(OutOfTime):
        lyapunov(A).solve()
    assert lyapunov(A).solve().status == "feasible"


@pytest.mark.parametrize(
    "blocks, words",
    [
        (P2, "blocks must be a dict"),
        ({}, "blocks must be a dict"),
        ({"g": 1.0}, "block 'g' must be a square matrix"),
        ({"g": np.eye(2)}, "no block has an unknown"),
        ({"g": A @ P2}, "block 'g' isn't symmetric"),
        ({"g": P2 @ B}, r"square matrix, got \(2, 1\)"),
        ({"g": P2, "h": [[np.nan]]}, "block 'h': nan is no finite number"),
        ({"g": P2, "h": [[1j]]}, "block 'h': data must be real numbers"),
        ({"g": P2, "h": symmetric("P", 2)}, "two unknowns have one name"),
        ({"a\nb": P2}, "must be one line"),
    ],
)
def test_bad_blocks_are_named(blocks, words):
    with pytest.raises(ValueError, match=words):
        LMIProblem(blocks)


def test_bad_arguments_are_named():
    problem, Q = driven(A, np.eye(2)), symmetric("Q", 2)
    for expression, words in (
        ({"P": 1.0}, r"as minimize\(J\)"),
        (P2 @ B, "takes a square expression"),
        (Q, "no block has the unknown Q of this expression; they have P"),
    ):
        with pytest.raises(ValueError, match=words):
            problem.minimize(expression)
    found = problem.solve()
    for expression, words in (("P", r"as solution\[P\]"), (P2 + Q, "unknown Q")):
        with pytest.raises(ValueError, match=words):
            found[expression]
    with pytest.raises(ValueError, match="values has no P"):
        problem.text.margins({})
    with pytest.raises(ValueError, match="there is no point"):
        lyapunov(-A).solve()[P2]
    with pytest.raises(ValueError, match=r"written 0.3 \* eye\(1\)"):
        block([[P2, B], [B.T, 0.3]])
    with pytest.raises(ValueError, match="nan is no finite number"):
        P2 * np.nan


def test_floats_are_read_as_the_decimals_that_were_written():
    """0.3 P is three tenths of P: exactly, wherever the number meets the unknowns."""
    x, plain = X1, Unknown("Q", 1)
    problem = LMIProblem(
        {"a": (x + x) * 0.3 - 0.1, "b": 9.81 - x / 0.7, "c": [[0.1]] @ x + x / 3}
    )
    exactly = problem.text.exactly
    assert str(exactly["a"].constant[0, 0]) == "-1/10"
    terms = (t for g in exactly.values() for t in g.terms)
    factors = [str(t.left[0, 0] * t.right[0, 0]) for t in terms]
    assert factors == ["3/10", "3/10", "-10/7", "1/10", "1/3"]
    assert problem.solve().prove().proven
    for mixed in (plain + 0.3 * x, 0.3 * x + plain, block([[plain, 0.3 * x]])):
        assert mixed.decimals and {t.unknown.name for t in mixed.terms} == {"Q", "x"}


def test_an_expression_has_its_value_and_its_minimum():
    """The least of 2 x + 0.5 y + 3 over x y > 1, x and y > 0: 2 sqrt(1) + 3."""
    y = matrix("y", 1, 1)
    least = LMIProblem({"hyperbola": block([[X1, ONE], [ONE, y]])}).minimize(
        2 * X1 + 0.5 * y + 3
    )
    assert_allclose(least[2 * X1 + 0.5 * y + 3], 5, rtol=1e-6)
    assert least.bound <= 5 and least.bound == pytest.approx(5, rel=1e-5)
    assert_allclose([least[X1], least[y]], [[[0.5]], [[2]]], rtol=1e-2)
    assert_allclose(least[X1 @ [[1, 2]]], least.values["x"] @ [[1, 2]])


def test_lists_and_numbers_are_data():
    found = LMIProblem({"P": P2 - 0.5 * eye(2), "top": [[3, 0], [0, 3]] - P2}).solve()
    assert_allclose(found.values["P"], 1.75 * np.eye(2), atol=1e-7)
    proof = found.prove()
    assert proof.proven and "P, top" in proof.claims[0]


def test_pairs_of_vertices_are_what_a_mean_needs():
    """i P j' at the mean of vertices is the mean of all pairs' blocks."""
    P, rng = symmetric("P", 2), np.random.default_rng(3)
    some = rng.normal(size=(3, 2, 2))
    found = pairs("rate", lambda i, j: i @ P @ j.T, some)
    names = ["rate 1", "rate 1, 2", "rate 1, 3", "rate 2", "rate 2, 3", "rate 3"]
    assert list(found) == names
    at, mean = LMIProblem({"P": P}).solve(), some.mean(axis=0)
    assert_allclose(at[sum(found.values())] / 9, mean @ at[P] @ mean.T)


@pytest.mark.parametrize("unit", [1e-3, 1e6, *campaign([1.0, 1e4])])
def test_a_minimum_is_found_in_any_unit_of_the_noise(unit):
    """The cost of an oscillator under noise of so many units, against Lyapunov's."""
    A, w, c = np.array([[0, 1], [-9.81, -0.3]]), np.eye(2)[:, 1:], np.eye(2)[:1]
    Q, J, noise = symmetric("Q", 2), symmetric("J", 1), unit * w
    decay = block([[he(Q @ A), c.T], [c, -eye(1)]])
    least = LMIProblem({"decay": -decay, "cost": J - noise.T @ Q @ noise}).minimize(J)
    X = solve_continuous_lyapunov(A.T, -c.T @ c)
    true = unit**2 * (w.T @ X @ w).item()
    assert least.values["J"].item() == pytest.approx(true, rel=1e-5)
    assert least.bound <= true * (1 + 1e-9) and least.prove().proven


def test_a_minimum_that_is_not_attained_names_the_largest_unknown():
    y = matrix("y", 1, 1)
    problem = LMIProblem({"hyperbola": block([[X1, ONE], [ONE, y]])})
    with pytest.raises(Unbounded, match="where y has entries"):
        problem.minimize(X1)


SADDLES = {
    "a mode of its own": ([[1, 0], [0, -1]], [[0], [1]]),
    "in odd units": ([[0.3, 0, 0], [9.81, -1, 0.2], [1, 2, -3]], [[0], [1], [0.3]]),
    "two modes": ([[0, 1, 0], [4, 0, 0], [0.7, 0.2, 1]], [[0], [0], [1]]),
}


@pytest.mark.parametrize("name", SADDLES)
def test_a_refusal_whose_multipliers_are_singular_is_proven(name):
    """A mode with Re s > 0 that B doesn't reach: its multiplier has its rank."""
    A, B = (np.array(x, float) for x in SADDLES[name])
    P, Y = symmetric("P", len(A)), matrix("Y", 1, len(A))
    answer = LMIProblem({"P": P, "decay": -he(A @ P + B @ Y)}).solve()
    assert answer.status == "infeasible" and answer.infeasibility.verify()


def test_a_singular_multiplier_of_few_digits_is_taken_as_it_is():
    """A mass that no K_A makes regular enough: z = (v, -1.2 v) with B'v = 0."""
    M, B = np.diag([1.0, 0.3, 0]), np.eye(3)[:, :1]
    mass, off = M - B @ matrix("K_A", 1, 3), 2.4 * np.eye(3)
    problem = LMIProblem({"mass": block([[he(mass), off], [off, 2 * eye(3)]])})
    v = np.eye(3)[2]
    z = np.concatenate([v, -1.2 * v])
    refusal = problem.refuse([np.outer(z, z)])
    assert refusal.verify() and float(refusal.value) < 0
    assert problem.solve().status == "infeasible"


#: Words that name the cure, and what is written wrong, of P, 2 x 2, and Y, 1 x 2.
WRONG = {
    'matrix("Y", 2, 6)': "matrix('Y', (2, 6)); matrix('Y', 2); matrix('Y', 2, '6');"
    "matrix('Y', 2, 6.0); matrix('Y', 0, 2); matrix('Y', -1, 2)",
    'symmetric("P", 6)': "symmetric('P', (2, 2)); symmetric('P', 2.5);"
    "symmetric('P', True); symmetric('P', 0)",
    "must be one line of": "matrix(3, 2, 2); matrix('', 2, 2); symmetric('g^2', 2);"
    "symmetric(P, 2)",
    "eye(2)": "eye('2'); eye((2, 2)); eye(2.5); eye(-1)",
    "square array or expression": "he(3); he('P'); he(Y); he([[1, 2], [3, 4]]);"
    "he(np.zeros((2, 3)))",
    "block takes rows": "block(3); block(P); block([P, P]); block([[]])",
    "rows of a block have": "block([]); block([[P, 0], [Y]])",
    "a row has zeros alone": "block([[P, 0], [0, 0]])",
    "doesn't fit": "np.zeros((2, 3)) @ P; Y @ [[1, 2, 3]]",
    "as a row or a column": "P @ [1, 2]; np.array([1, 2]) @ P",
    "divided by zero": "P / 0; P / [[0]]",
    "isn't affine": "P / P; P @ P; P @ Y; P * Y",
    'LMIProblem({"a name": P - Q})': "P > 0; P <= eye(2)",
}


@pytest.mark.parametrize("words", WRONG)
def test_what_is_written_wrong_is_said_in_our_words(words):
    names = globals() | {"P": symmetric("P", 2), "Y": matrix("Y", 1, 2)}
    for written in WRONG[words].split(";"):
        with pytest.raises((ValueError, TypeError), match=re.escape(words)):
            eval(written.strip(), names)
