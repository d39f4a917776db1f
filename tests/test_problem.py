"""`LMIProblem` against Lyapunov's equation, Riccati's and a second solver."""

import cvxpy
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov

from sosbook.exact.definite import exact
from sosbook.lmi import Unknown, block, eye, he
from sosbook.lmi.problem import LMIProblem
from sosbook.runtime.time_limit import OutOfTime, time_limit
from sosbook.solver.blocks import Blocks
from sosbook.solver.loop import Unbounded
from sosbook.solver.settings import Settings

A = np.array([[0.0, 1.0], [-2.0, -3.0]])
B = np.array([[0.0], [1.0]])
ROUND = np.array([[0.25, 0.0], [0.0, 0.5]])


def lyapunov(A, sigma=0.0, **more):
    """P > 0 and A P + P A' + 2 sigma P < 0."""

    def write(values, number):
        P, shifted = values["P"], number(A) + number(sigma * np.eye(len(A)))
        return {"P": P, "decay": -he(shifted @ P)}

    return LMIProblem(write, [Unknown("P", len(A), symmetric=True)], **more)


def driven(A, Q):
    """A P + P A' + Q < 0: P exceeds the solution of Lyapunov's equation."""

    def write(values, number):
        return {"decay": -he(number(A) @ values["P"]) - number(Q)}

    return LMIProblem(write, [Unknown("P", len(A), symmetric=True)])


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
    found = problem.minimize({"P": np.eye(2)})
    assert_allclose(found.values["P"], P, rtol=1e-4)
    inside = problem.minimize({"P": np.eye(2)}, start={"P": 2 * P})
    assert_allclose(inside.values["P"], P, rtol=1e-4)


def test_the_weights_pick_entries():
    """With weight W the least <W, P> is that of Lyapunov's solution, too."""
    P = solve_continuous_lyapunov(A, -np.eye(2))
    found = driven(A, np.eye(2)).minimize({"P": ROUND})
    assert_allclose((ROUND * found.values["P"]).sum(), (ROUND * P).sum(), rtol=1e-5)


def test_several_unknowns_give_riccatis_gain():
    """The LQR of section 2.5 as an LMI with P, Y and J."""

    def write(v, number):
        P, Y, J = v["P"], v["Y"], v["J"]
        flow = he(number(A) @ P + number(B) @ Y)
        return {
            "decay": -block([[flow, P, Y.T], [P, -eye(2), 0], [Y, 0, -eye(1)]]),
            "cost": block([[J, eye(2)], [eye(2), P]]),
        }

    problem = LMIProblem(
        write,
        [
            Unknown("P", 2, symmetric=True),
            Unknown("Y", 1, 2),
            Unknown("J", 2, symmetric=True),
        ],
    )
    found = problem.minimize({"J": np.eye(2)}, gap=1e-9)
    X = solve_continuous_are(A, B, np.eye(2), np.eye(1))
    assert_allclose(np.trace(found.values["J"]), np.trace(X), rtol=1e-5)
    K = np.linalg.solve(found.values["P"], found.values["Y"].T).T
    assert_allclose(K, -B.T @ X, rtol=1e-3)


def test_no_minimum_is_said():
    with pytest.raises(Unbounded):
        lyapunov(A).minimize({"P": -np.eye(2)})
    with pytest.raises(Unbounded):
        lyapunov(A).centre({"P": lyapunov(A).find().values["P"]})


def test_an_infeasible_problem_has_no_minimum():
    found = lyapunov(-A).minimize({"P": np.eye(2)})
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
    found = driven(A, np.eye(2)).minimize({"P": np.eye(2)}, gap=1e-4)
    assert found.bound <= np.trace(P) <= np.trace(found.values["P"])
    assert np.trace(found.values["P"]) - found.bound < 1e-3 * np.trace(P)


def interval(low, high):
    """low < x < high, whose analytic centre lies in the middle."""

    def write(values, number):
        x = values["x"]
        return {"low": x - number([[low]]), "high": number([[high]]) - x}

    return LMIProblem(write, [Unknown("x", 1)])


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
        def write(values, number):
            x, one = values["x"], number([[1.0]])
            return {"g": block([[one, x], [x, one]]), "edge": x - one + number([[gap]])}

        return LMIProblem(write, [Unknown("x", 1)])

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

    def write(values, number):
        x, y = values["x"], values["y"]
        return {"x": -x, "y": x - number([[1.0]]) - number(1e-3) * y}

    problem = LMIProblem(write, [Unknown("x", 1), Unknown("y", 1)])
    one = np.eye(1)
    assert problem.refuse([one, one]) is None
    assert_allclose(problem.excluded_radius([one, one]), 1e3)
    assert problem.margins({"x": -1e-9 * one, "y": -1001 * one})["y"] > 0
    assert problem.excluded_radius([one, -one]) == 0


@pytest.mark.parametrize("seed", range(8))
def test_verdicts_agree_with_clarabel(seed):
    """A common Lyapunov function of two random matrices."""
    rng = np.random.default_rng(seed)
    pair = rng.normal(size=(2, 3, 3)) - rng.uniform(0, 4) * np.eye(3)

    def write(values, number):
        P = values["P"]
        return {"P": P} | {f"{k}": -he(number(M) @ P) for k, M in enumerate(pair)}

    problem = LMIProblem(write, [Unknown("P", 3, symmetric=True)])
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
    stopped = late.minimize({"P": np.eye(2)}, start=inside)
    assert stopped.note.startswith("stopped") and stopped.bound is None
    monkeypatch.setattr(Blocks, "settings", Settings(most_dense_variables=1))
    full = lyapunov(A).solve()
    assert full.status == "undecided" and "too many for a dense matrix" in full.reason


def test_an_outer_time_limit_is_not_swallowed():
    with time_limit(1e-9), pytest.raises(OutOfTime):
        lyapunov(A).solve()
    assert lyapunov(A).solve().status == "feasible"


P2 = [Unknown("P", 2, symmetric=True)]


@pytest.mark.parametrize(
    "write, unknowns, words",
    [
        (None, P2, "write must be a function"),
        (lambda v, n: v["P"], P2, "write must return a dict"),
        (lambda v, n: {}, P2, "write must return a dict"),
        (lambda v, n: {"g": 1.0}, P2, "block 'g' must be a square matrix"),
        (lambda v, n: {"g": v["P"][:1]}, [], "unknowns is empty"),
        (lambda v, n: {"g": n(A) @ v["P"]}, P2, "block 'g' isn't symmetric"),
        (lambda v, n: {"g": v["P"] @ B}, P2, r"square matrix, got \(2, 1\)"),
        (lambda v, n: {"g": v["P"] * np.nan}, P2, "block 'g' has NaN"),
        (lambda v, n: {"g": v["P"] * 1j}, P2, "block 'g' must hold real numbers"),
        (lambda v, n: v, 2 * P2, "two unknowns have one name"),
        (lambda v, n: v, ["P"], "unknowns must hold Unknown"),
    ],
)
def test_bad_blocks_are_named(write, unknowns, words):
    with pytest.raises(ValueError, match=words):
        LMIProblem(write, unknowns).solve()


def test_bad_arguments_are_named():
    problem = driven(A, np.eye(2))
    for weights, words in (
        ({}, "weights must name some of"),
        ({"Q": np.eye(2)}, "weights must name some of"),
        ({"P": 1.0}, "the weight of P has the shape"),
    ):
        with pytest.raises(ValueError, match=words):
            problem.minimize(weights)
    with pytest.raises(ValueError, match="values has no P"):
        problem.margins({})


@pytest.mark.parametrize(
    "write",
    [
        lambda v, n: {"P": v["P"], "decay": -he(A @ v["P"])},
        lambda v, n: {"P": v["P"], "shift": v["P"] - 0.5 * np.eye(2)},
        lambda v, n: {"P": v["P"], "wide": block([[v["P"], n(B)], [B.T, n([[9]])]])},
    ],
)
def test_floats_do_not_slip_into_a_proof(write):
    found = LMIProblem(write, P2).solve()
    assert found.status == "feasible"
    with pytest.raises(ValueError, match="pass all data but integers"):
        found.prove()


def test_lists_and_numbers_are_data():
    def write(v, number):
        return {
            "P": v["P"] - number(0.5) * eye(2),
            "top": number([[3, 0], [0, 3]]) - v["P"],
        }

    found = LMIProblem(write, P2).solve()
    assert_allclose(found.values["P"], 1.75 * np.eye(2), atol=1e-7)
    proof = found.prove()
    assert proof.proven and "P, top" in proof.claims[0]


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e4, 1e6])
def test_a_minimum_is_found_in_any_unit_of_the_noise(unit):
    """The cost of an oscillator under noise of so many units, against Lyapunov's."""
    A, w, c = np.array([[0, 1], [-9.81, -0.3]]), np.eye(2)[:, 1:], np.eye(2)[:1]

    def write(values, number):
        Q, J, noise = values["Q"], values["J"], number(unit * w)
        decay = block([[he(Q @ number(A)), number(c.T)], [number(c), -eye(1)]])
        return {"decay": -decay, "cost": J - noise.T @ Q @ noise}

    unknowns = [Unknown("Q", 2, symmetric=True), Unknown("J", 1, symmetric=True)]
    least = LMIProblem(write, unknowns).minimize({"J": 1.0})
    X = solve_continuous_lyapunov(A.T, -c.T @ c)
    true = unit**2 * (w.T @ X @ w).item()
    assert least.values["J"].item() == pytest.approx(true, rel=1e-5)
    assert least.bound <= true * (1 + 1e-9) and least.prove().proven


def test_a_minimum_that_is_not_attained_names_the_largest_unknown():
    def write(values, number):
        x, y = values["x"], values["y"]
        return {"hyperbola": block([[x, number([[1.0]])], [number([[1.0]]), y]])}

    problem = LMIProblem(write, [Unknown(n, 1, symmetric=True) for n in "xy"])
    with pytest.raises(Unbounded, match="where y has entries"):
        problem.minimize({"x": 1.0})


SADDLES = {
    "a mode of its own": ([[1, 0], [0, -1]], [[0], [1]]),
    "in odd units": ([[0.3, 0, 0], [9.81, -1, 0.2], [1, 2, -3]], [[0], [1], [0.3]]),
    "two modes": ([[0, 1, 0], [4, 0, 0], [0.7, 0.2, 1]], [[0], [0], [1]]),
}


@pytest.mark.parametrize("name", SADDLES)
def test_a_refusal_whose_multipliers_are_singular_is_proven(name):
    """A mode with Re s > 0 that B doesn't reach: its multiplier has its rank."""
    A, B = (np.array(x, float) for x in SADDLES[name])

    def write(values, number):
        P, Y = values["P"], values["Y"]
        return {"P": P, "decay": -he(number(A) @ P + number(B) @ Y)}

    n = len(A)
    unknowns = [Unknown("P", n, symmetric=True), Unknown("Y", 1, n)]
    answer = LMIProblem(write, unknowns).solve()
    assert answer.status == "infeasible" and answer.infeasibility.verify()


def test_a_singular_multiplier_of_few_digits_is_taken_as_it_is():
    """A mass that no K_A makes regular enough: z = (v, -1.2 v) with B'v = 0."""
    M, B = np.diag([1.0, 0.3, 0]), np.eye(3)[:, :1]

    def write(values, number):
        mass, one = number(M) - number(B) @ values["K_A"], np.eye(3)
        off = number(2.4 * one)
        return {"mass": block([[he(mass), off], [off, number(2 * one)]])}

    problem = LMIProblem(write, [Unknown("K_A", 1, 3)])
    v = np.eye(3)[2]
    z = np.concatenate([v, -1.2 * v])
    refusal = problem.refuse([np.outer(z, z)])
    assert refusal.verify() and float(refusal.value) < 0
    assert problem.solve().status == "infeasible"
