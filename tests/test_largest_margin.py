"""The point of the largest margin, against problems written anew in cvxpy."""

from functools import cache

import cvxpy
import numpy as np
import pytest

import sosbook as sos
from sosbook.book import thesis
from sosbook.book.largest_margin import delay_margin, largest_margin, region_margin
from sosbook.lmi import Unknown, he


@cache
def of_masses(**changes):
    """The gain with the largest margin, of the two masses."""
    return delay_margin(thesis.delay_example_2(), **changes)


def distance(K, printed):
    return np.linalg.norm(K - printed) / np.linalg.norm(printed)


def stated(blocks, entries, radius):
    """The direction of the best x as the problem is stated: maximise t."""
    t = cvxpy.Variable()
    held = [(g + g.T) / 2 >> t * np.eye(g.shape[0]) for g in blocks]
    problem = cvxpy.Problem(cvxpy.Maximize(t), [*held, cvxpy.norm(entries) <= radius])
    problem.solve(solver="CLARABEL")
    return t.value


def test_the_shortest_point_is_the_one_of_the_largest_margin():
    A = np.array([[0.0, 1.0], [-2.0, -0.7]])
    unknown = Unknown("P", 2, symmetric=True)
    found = largest_margin([unknown @ np.eye(2), -he(A @ unknown)], [unknown])
    P = cvxpy.Variable((2, 2), symmetric=True)
    t = stated([P, -(A @ P + P @ A.T)], cvxpy.hstack([P[0, 0], P[1, 0], P[1, 1]]), 10.0)
    assert t == pytest.approx(10 / found.length, rel=1e-5)
    ours = found.values["P"] / np.linalg.norm(found.values["P"])
    assert ours == pytest.approx(P.value / np.linalg.norm(P.value), abs=1e-4)
    assert found.margin == pytest.approx(1)


def masses_anew(example):
    """(2.22) to (2.25) for E = I, typed once more, as the problem is stated."""
    M, D, S, B = (np.array(getattr(example.plant, k)) for k in "MDSB")
    assert (np.eye(2) == M).all()
    A = np.block(
        [
            [np.zeros((2, 2)), np.eye(2), np.zeros((2, 1))],
            [-S, -D, np.zeros((2, 1))],
            [example.U, np.zeros((1, 3))],
        ]
    )
    B = np.r_[np.zeros((2, 1)), B, [[0]]]
    tau, mu, delta, alpha = example.tau, example.mu, example.delta, example.alpha
    e1 = np.exp(-2 * delta * tau) / tau
    e2 = np.exp(-2 * delta * (tau + mu))
    P, S, R1, R3, Z = (cvxpy.Variable((5, 5), symmetric=True) for _ in range(5))
    Q, R2, F = (cvxpy.Variable((5, 5)) for _ in range(3))
    X, O = cvxpy.Variable((1, 5)), np.zeros((5, 5))
    AF, BX = A @ F.T, B @ X
    first = 2 * delta * P + Q + Q.T + tau * R1 - e1 * R3 + S + e2 * (AF + AF.T)
    second = tau * R3 + 2 * mu * Z - e2 * alpha * (F + F.T)
    lower = [
        [first],
        [P + tau * R2 + e2 * (alpha * AF - F), second],
        [e1 * R3 - Q.T + e2 * BX.T, e2 * alpha * BX.T, -e1 * (R3 + tau * S)],
        [2 * delta * Q.T - e1 * R2.T, Q.T, e1 * R2.T, -e1 * R1],
        [mu * BX.T, mu * alpha * BX.T, O, O, -mu * Z / e2],
    ]
    whole = cvxpy.bmat(
        [[lower[i][j] if j <= i else lower[j][i].T for j in range(5)] for i in range(5)]
    )
    blocks = [
        cvxpy.bmat([[P, Q], [Q.T, e1 * S]]),
        cvxpy.bmat([[R1, R2.T], [R2, R3]]),
        -whole,
    ]
    low = np.tril_indices(5)
    entries = cvxpy.hstack(
        [
            *(G[low] for G in (P, S, R1, R3, Z)),
            *(cvxpy.vec(G, order="F") for G in (Q, R2, F, X)),
        ]
    )
    t = stated(blocks, entries, 1000.0)
    return t, np.linalg.solve(F.value, X.value.T).T


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")
@pytest.mark.slow
def test_the_two_masses_are_those_of_the_thesis_typed_anew():
    example = thesis.delay_example_2()
    t, K = masses_anew(example)
    found = of_masses()
    assert found.K == pytest.approx(K, abs=2e-4)
    assert 1000 / found.length == pytest.approx(t, rel=1e-4)


@pytest.mark.campaign  # chapter 17 prints them
@pytest.mark.slow
def test_the_printed_gains_of_the_masses_are_near_in_seconds_only():
    example = thesis.delay_example_2()
    centre = sos.design_delay_pid(example.plant, **example.requirements)
    near = distance(of_masses().K, example.K)
    assert near < 0.05 < 0.3 < distance(centre.K, example.K)
    assert distance(of_masses(second=10).K, example.K) > 0.3


@pytest.mark.campaign  # chapter 17 prints how far
@pytest.mark.slow
def test_the_printed_sign_leads_far_away():
    example = thesis.delay_example_2()
    wrong = delay_margin(example, misprints=("sign",))
    assert distance(wrong.K, example.K) > 40


def test_the_arm_is_near_too():
    example = thesis.example_4()
    centre = sos.design_pid(example.plant, **example.requirements)
    found = region_margin(example)
    assert distance(found.K, example.K) < 0.025 < distance(centre.K, example.K)
    assert found.K[0, 4] == pytest.approx(example.K[0, 4], rel=0.01)


@pytest.mark.slow
def test_its_gain_is_certified_like_any_other():
    example = thesis.delay_example_2()
    K = of_masses().K
    asked = {k: v for k, v in example.requirements.items() if k != "alpha"}
    assert sos.analyse_delay(example.plant, K, **asked).certify().proven


def test_what_has_no_such_point_is_refused():
    with pytest.raises(ValueError, match="gamma"):
        region_margin(thesis.example_1())
    with pytest.raises(ValueError, match="no point is inside"):
        delay_margin(thesis.delay_example_2(), mu=0.4)
    with pytest.raises(ValueError, match="second must be positive"):
        delay_margin(thesis.delay_example_2(), second=0)
    with pytest.raises(ValueError, match="mu"):
        delay_margin(thesis.delay_example_2(), mu=[1, 2])
    P = Unknown("P", 1, symmetric=True)
    with pytest.raises(ValueError, match="homogeneous"):
        largest_margin([P - np.eye(1)], [P])
