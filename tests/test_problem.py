"""`LMIProblem` against Lyapunov's equation, Riccati's and a second solver."""

import cvxpy
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov

from sosbook.lmi import Unknown, block, eye, he
from sosbook.lmi.centre import Unbounded
from sosbook.lmi.problem import LMIProblem

A = np.array([[0.0, 1.0], [-2.0, -3.0]])
B = np.array([[0.0], [1.0]])
ROUND = np.array([[0.25, 0.0], [0.0, 0.5]])


def lyapunov(A, sigma=0.0):
    """P > 0 and A P + P A' + 2 sigma P < 0."""
    def write(values, number):
        P, shifted = values["P"], number(A) + number(sigma * np.eye(len(A)))
        return {"P": P, "decay": -he(shifted @ P)}
    return LMIProblem(write, [Unknown("P", len(A), symmetric=True)])


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
    assert proof.proven and proof.claims == ("A is stable",)
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
    problem = LMIProblem(write, [
        Unknown("P", 2, symmetric=True), Unknown("Y", 1, 2),
        Unknown("J", 2, symmetric=True)])
    found = problem.minimize({"J": np.eye(2)}, gap=1e-9)
    X = solve_continuous_are(A, B, np.eye(2), np.eye(1))
    assert_allclose(np.trace(found.values["J"]), np.trace(X), rtol=1e-5)
    K = np.linalg.solve(found.values["P"], found.values["Y"].T).T
    assert_allclose(K, -B.T @ X, rtol=1e-3)


def test_no_minimum_is_said():
    with pytest.raises(Unbounded):
        lyapunov(A).minimize({"P": -np.eye(2)})


def test_an_infeasible_problem_has_no_minimum():
    found = lyapunov(-A).minimize({"P": np.eye(2)})
    assert found.status == "infeasible" and found.values is None


def test_the_same_blocks_in_cvxpy():
    constraints, variables = driven(A, np.eye(2)).to_cvxpy()
    problem = cvxpy.Problem(
        cvxpy.Minimize(cvxpy.trace(variables["P"])), constraints)
    problem.solve(solver="CLARABEL")
    assert_allclose(
        variables["P"].value, solve_continuous_lyapunov(A, -np.eye(2)), atol=1e-5)
