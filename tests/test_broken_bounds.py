"""A plant that breaks an H2 norm, a cost or a peak of a known gain is named."""

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_lyapunov

import sosbook as sos
from sosbook.exact.checker import verdict


def chain():
    T = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    M, some = np.diag([1, 1.5, 2]), np.eye(3, 1)
    return sos.SecondOrderSystem(M, 0.3 * T, 9.81 * T, some, some)


def unsymmetric():
    M, D = [[1, 0.2], [0.1, 1.3]], [[0.3, 0.4], [-0.4, 0.3]]
    return sos.SecondOrderSystem(M, D, [[3, 1], [-0.5, 4]], np.eye(2), [[0.3], [1]])


def light():
    M, S = np.diag([0.3, 2.2046]), [[50, -9.81], [-9.81, 300]]
    return sos.SecondOrderSystem(M, 0.003 * np.eye(2), S, [[1], [0]], [[0], [1]])


def stiffer(p):
    return sos.SecondOrderSystem(p.M, p.D, p.S + 0.02 * np.diag(np.diag(p.S)), p.B, p.F)


def loop(p, K):
    solved, n = np.linalg.solve(p.M, np.hstack([-p.S, -p.D, p.B, p.F])), p.n
    below = np.vstack([np.zeros((n, p.m + p.p)), solved[:, 2 * n :]])
    A = np.vstack([np.eye(2 * n)[n:], solved[:, : 2 * n]]) + below[:, : p.m] @ K
    return A, below[:, p.m :]


def h2(p, K, x0):
    A, F = loop(p, K)
    return np.sqrt(np.trace(solve_continuous_lyapunov(A, -F @ F.T)[: p.n, : p.n]))


def cost(p, K, x0, noisy=True):
    A, F = loop(p, K)
    X = solve_continuous_lyapunov(A.T, -(np.eye(len(A)) + K.T @ K))
    return np.trace(F.T @ X @ F) if noisy else np.trace(X)


def peak(p, K, x0):
    A, _ = loop(p, K)
    step, x, sizes = expm(0.002 * A), x0, []
    for _ in range(20_000):
        sizes.append(np.linalg.norm(K @ x))
        x = step @ x
    return max(sizes)


def weights(p, noise, bound):
    return sos.QuadraticCost(np.eye(2 * p.n), np.eye(p.m), noise=noise, bound=bound)


ASKED = {
    "h2": (h2, lambda p, x0, bound: sos.H2(bound)),
    "cost": (cost, lambda p, x0, bound: weights(p, "F", bound)),
    "cost of states": (
        lambda p, K, x0: cost(p, K, x0, noisy=False),
        lambda p, x0, bound: weights(p, "states", bound),
    ),
    "peak": (peak, lambda p, x0, bound: sos.Saturation(bound, x0)),
}


TURNS = [
    pytest.param(plant, what, marks=[pytest.mark.campaign] * ((j + k) % 3 != 1))
    for j, plant in enumerate((chain, unsymmetric, light))
    for k, what in enumerate(ASKED)
]


@pytest.mark.parametrize("plant, what", TURNS)
def test_both_sides_of_what_a_known_gain_reaches(plant, what):
    p, (true, requirement) = plant(), ASKED[what]
    plants, n = (p, stiffer(p)), 2 * p.n
    K = -0.1 * np.random.default_rng(4).random((p.m, n))
    x0 = np.array([1.0, *np.zeros(n - 1)])
    values = [true(p, K, x0) for p in plants]
    worst = int(np.argmax(values)) + 1
    family = sos.Polytope(list(plants))
    for share in (0.1, 0.95, 1.05):
        asked = requirement(p, x0, float(f"{share * max(values):.5g}"))
        found = sos.analyse_pid(family, K, requirements=[asked])
        if share > 1:  # a peak's inequality may lose more than that
            assert found.status == "feasible" or what == "peak" != found.status
            continue
        proof = found.infeasibility
        assert found.status == "infeasible" and proof.proven
        assert verdict.check(proof.text) == list(proof.claims)
        assert f"The vertex {worst} " in found.reason or share < 0.95
        assert asked.claim() in found.reason


def test_a_plant_inside_the_ranges_is_named():
    plants = sos.Uncertain(lambda m: sos.SecondOrderSystem(m, 0.3, 1, 1, 1), m=(1, 1.2))
    found = sos.analyse_pid(plants, [[0, 0]], requirements=[sos.H2(0.018)])
    assert found.status == "infeasible" and "The plant with m = 1" in found.reason


def test_an_input_is_too_large_at_once():
    plants = sos.Polytope([sos.SecondOrderSystem(m, 0.3, 1, 1) for m in (1, 1.2)])
    limit = sos.Saturation(0.01, [10, 0])
    found = sos.analyse_pid(plants, [[-0.5, 0]], saturation=limit)
    assert found.status == "infeasible" and "|K x(0)| = 5" in found.reason
