"""Example 4: what its rows say, by another way."""

import numpy as np
import pytest
from scipy.optimize import brentq

import sosbook as sos
from sosbook.book import thesis

EX = thesis.example_4()
TRACKED = "the reference is tracked as expected, far from rest"
M = np.diag([0.05, 0.1])


def loop(factor, U=(0.0, 1.0), k=50.0):
    """The printed loop, written out with numpy alone."""
    S = np.array([[k + factor, -k], [-k, k]])
    A = np.zeros((5, 5))
    A[:2, 2:4], A[4, :2] = np.eye(2), U
    A[2:4, :2] = -np.linalg.solve(M, S)
    A[3] += EX.K[0] / M[1, 1]
    return A


def far(printed, found):
    """Largest distance from a printed pole to the nearest found one."""
    return max(np.abs(found - p).min() for p in printed)


def test_table_3_3():
    for factor, printed in zip((1, 2 / np.pi), EX.closed_loop_poles):
        assert far(printed, np.linalg.eigvals(loop(factor))) < 1e-3
    for factor, printed in zip((1, 2 / np.pi), EX.open_loop_poles):
        S = [[50 + factor, -50], [-50, 50]]
        squares = np.linalg.eigvals(np.linalg.solve(M, S))
        found = 1j * np.sqrt(np.r_[squares, squares])
        assert far(printed[printed.imag > 0], found) < 1e-4


def test_other_readings_miss_table_3_3():
    first, second = EX.closed_loop_poles
    assert far(first, np.linalg.eigvals(loop(1, (1.0, 0.0)))) > 1
    assert far(second, np.linalg.eigvals(loop(0.64))) > 0.02


def test_the_mean_of_the_cosine():
    """(sin a - sin b) / (a - b) lies between cos phi_max and 1."""
    rng = np.random.default_rng(0)
    for top in (0.3, np.pi / 2, 3.0):
        a, b = rng.uniform(-top, top, (2, 1000))
        mean = (np.sin(a) - np.sin(b)) / (a - b)
        assert (mean >= np.cos(top)).all() and (mean <= 1).all()
    around = brentq(lambda p: p * np.cos(p) - np.sin(p), 4, 4.6)
    assert -0.2173 < np.sin(around) / around < -0.2172


@pytest.mark.parametrize(
    "low, sigma", [(2 / np.pi, 5.0), (0.0, 3.9), (-0.2173, 3.5), (-1.0, 2.2)]
)
def test_one_p_serves_a_moving_factor(low, sigma):
    """The claims of the chapter, from the returned P with numpy."""
    arms = sos.Polytope([thesis.arm(1.0), thesis.arm(low)])
    region = sos.PoleRegion(sigma=sigma)
    found = sos.analyse_pid(arms, EX.K, EX.U, region=region, coupling="pairs")
    assert found.certify(8).proven
    T = np.linalg.cholesky(found.P)
    for factor in np.linspace(low, 1, 9):
        N = np.linalg.solve(T, loop(factor) @ T)
        assert np.linalg.eigvalsh(N + N.T)[-1] < -2 * sigma


def test_the_remaining_error_is_the_twist_of_the_shaft(rows):
    """The row names it; test_nonlinear has the arm at rest."""
    phi1 = brentq(lambda p: np.sin(p) + 50 * (p - np.pi / 2), 0, 2)
    assert abs(phi1 - np.pi / 2 + np.sin(phi1) / 50) < 1e-12
    (row,) = (row for row in rows if row.item == TRACKED)
    assert "(m g l / k) sin(phi1)" in row.why
