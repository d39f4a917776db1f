"""The Riccati equation against scipy's pencil and against closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov

import sosbook as sos
from sosbook.analysis.riccati import balanced_units, lyapunov, riccati
from sosbook.plants.descriptor import descriptors
from tests.cases import by_hand, random_plant, seeds
from tests.closed import analyse_loop


def system(seed):
    """A random plant in units far apart, with random weights."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 6)), int(rng.integers(1, 4))
    plant = random_plant(rng, n, m)
    A, B = by_hand(plant)
    unit = 10.0 ** rng.uniform(-1, 1, 2 * n)
    roots = rng.standard_normal((2 * n, n)), rng.standard_normal((m, m))
    Q, R = (x @ x.T for x in roots)
    return unit[:, None] * A / unit, unit[:, None] * B, Q, R + 0.1 * np.eye(m)


@pytest.mark.filterwarnings("ignore:M isn't symmetric")
@pytest.mark.parametrize("seed", seeds(40))
def test_it_is_the_stabilising_solution(seed):
    A, B, Q, R = system(seed)
    X = riccati(A, B, Q, R)
    assert np.array_equal(X, X.T)
    wanted = solve_continuous_are(A, B, Q, R)
    assert_allclose(X, wanted, atol=1e-7 * abs(wanted).max())
    loop = A - B @ np.linalg.solve(R, B.T @ X)
    assert np.linalg.eigvals(loop).real.max() < 0


def test_two_integrators_have_a_closed_form():
    """x'' = u with Q = diag(1, 0): K = -[1, sqrt 2]."""
    A, B = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]])
    X = riccati(A, B, np.diag([1.0, 0.0]), np.eye(1))
    assert_allclose(X, [[np.sqrt(2), 1], [1, np.sqrt(2)]], rtol=1e-12)


def test_what_no_input_settles_has_no_solution():
    A = np.diag([1.0, -1.0])
    with pytest.raises(np.linalg.LinAlgError):
        riccati(A, np.array([[0.0], [1.0]]), np.eye(2), np.eye(1))


@pytest.mark.parametrize("factor, pole, lost", [(1, -2, 0), (2, -2, 1), (1, -0.1, 1)])
def test_scipy_has_the_word_where_the_schur_vectors_are_lost(
    factor, pole, lost, monkeypatch
):
    """Where X leaves a residual, or its loop has other eigenvalues than were sorted."""
    A, B, Q, R = np.array([[-1.0]]), np.eye(1), 3 * np.eye(1), np.eye(1)
    found = factor * np.eye(1), np.array([pole])
    asked = []

    def scipys(*given):
        asked.append(given)
        return solve_continuous_are(*given)

    monkeypatch.setattr("sosbook.analysis.riccati._by_schur_vectors", lambda H: found)
    monkeypatch.setattr("sosbook.analysis.riccati.solve_continuous_are", scipys)
    assert_allclose(riccati(A, B, Q, R), np.eye(1), rtol=1e-12)
    assert len(asked) == lost


@pytest.mark.parametrize("seed", seeds(60))
def test_it_is_the_same_in_any_units(seed):
    """Of states, of time and of cost, each from 1e-9 to 1e9."""
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(2, 9)), int(rng.integers(1, 3))
    A, B = rng.standard_normal((n, n)), rng.standard_normal((n, m))
    root = rng.standard_normal((n, n))
    Q, R = root @ root.T + 0.1 * np.eye(n), np.eye(m)
    wanted = solve_continuous_are(A, B, Q, R)
    apart, together = 10.0 ** rng.uniform(-9, 9, n), 10.0 ** rng.uniform(-9, 9)
    for unit in (apart, np.full(n, together)):
        time, cost = 10.0 ** rng.uniform(-9, 9, 2)
        there = riccati(
            unit[:, None] * A / unit * time,
            unit[:, None] * B * time,
            Q / np.outer(unit, unit) * time * cost,
            R * time * cost,
        )
        back = there * np.outer(unit, unit) / cost
        assert_allclose(back, wanted, atol=1e-7 * abs(wanted).max())


def test_what_overflows_has_no_solution():
    """B R^-1 B' isn't a float; nor is the frame of such a request."""
    one = np.eye(1)
    for equation in (riccati, balanced_units):
        with (
            pytest.raises(np.linalg.LinAlgError, match="finite"),
            np.errstate(all="ignore"),
        ):
            equation(one, 1e200 * one, one, one)
    far = sos.SecondOrderSystem(1e-60, 0, 0, 1e100)
    with np.errstate(all="ignore"):
        design = sos.design_lqr(far, np.eye(2), one)
    assert design.status != "infeasible"


FREE = sos.SecondOrderSystem(
    [[10.79, 2.6], [2.6, 3.82]], np.zeros((2, 2)), np.zeros((2, 2)), [[-2.06], [0.16]]
)


def test_a_pencil_that_cannot_be_sorted_has_no_solution(monkeypatch):
    """Two free masses and one force: what rounding makes of them is no solution."""

    def unsorted(*given):
        raise ValueError("Reordering of (A, B) failed")  # by processor

    monkeypatch.setattr("sosbook.analysis.riccati.solve_continuous_are", unsorted)
    A, B, _ = descriptors(FREE)[0].state_space()
    cost = sos.QuadraticCost(np.eye(4), np.eye(1), bound=59.0)
    with pytest.raises(np.linalg.LinAlgError, match="Reordering"):
        riccati(A, B, *cost.riccati())
    assert sos.design_pid(FREE, requirements=[cost]).status == "infeasible"


def test_nor_has_a_sampled_one(monkeypatch):
    def unsorted(*given, **more):
        raise ValueError("Reordering of (A, B) failed")

    monkeypatch.setattr("sosbook.sampled.lqr.solve_discrete_are", unsorted)
    cart = sos.SecondOrderSystem(1, 0, 0, 1)
    with pytest.raises(ValueError, match="no stabilising solution"):
        sos.design_sampled_lqr(cart, np.eye(2), [[1]], 0.1)


@pytest.mark.parametrize("seed", seeds(10))
def test_the_lyapunov_equation_is_scipys(seed):
    A, _, Q, _ = system(seed)
    wanted = solve_continuous_lyapunov(A, Q)
    assert_allclose(lyapunov(A, Q), wanted, rtol=0, atol=1e-10 * abs(wanted).max())


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("A", [[[0, 1], [-1, 0]], [[1, 0], [0, -1]], [[0, 1], [0, 0]]])
def test_poles_that_sum_to_zero_are_judged_in_silence(A):
    """Scipy warns of such an equation."""
    with pytest.raises(RuntimeWarning, match="eigenvalue pair"):
        solve_continuous_lyapunov(A, np.eye(2))
    assert analyse_loop(np.eye(2), A).status == "infeasible"
