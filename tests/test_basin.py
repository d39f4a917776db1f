"""The certified basin of the nonlinear arm, against its motions."""

import cvxpy as cp
import numpy as np
import pytest

import sosbook as sos
from sosbook.analysis.linear import loop_matrix
from sosbook.analysis.nonlinear import arm_gravity, simulate_nonlinear
from sosbook.book import thesis
from sosbook.book.reproduction.region_of_attraction import region_of_attraction
from sosbook.exact.definite import exact, pivots
from sosbook.plants.descriptor import descriptors
from sosbook.synthesis.scaling import Frame, in_unknowns_of
from tests.cases import campaign
from tests.random_plants import Units

EX = thesis.example_4()
RELEASE = np.array([1.0, 1, 0, 0, 0])
ASKED = dict(row=[1, 0, 0, 0, 0], bound=np.pi / 2, start=RELEASE)


def reach_by_cvxpy(sigma, T):
    """The largest a with (a v)' P^-1 (a v) <= 1, written out."""
    loops = [loop_matrix(d, EX.K) for d in descriptors(EX.plant, EX.U)]
    X, t = cp.Variable((5, 5), symmetric=True), cp.Variable((1, 1))
    v = np.linalg.solve(T, RELEASE)[:, None]
    lmis = [T[:1] @ X @ T[:1].T <= (np.pi / 2) ** 2, cp.bmat([[X, v], [v.T, t]]) >> 0]
    for loop in loops:
        N = np.linalg.solve(T, loop @ T)
        lmis.append(2 * sigma * X + N @ X + X @ N.T << 0)
    cp.Problem(cp.Minimize(t[0, 0]), lmis).solve(solver="CLARABEL")
    return 1 / np.sqrt(t.value[0, 0])


@pytest.mark.parametrize("sigma", [0.0, 2.0])
def test_reach_against_cvxpy(sigma):
    found = region_of_attraction(EX.plant, EX.K, EX.U, sigma, **ASKED)
    best = reach_by_cvxpy(sigma, np.linalg.cholesky(found.P))
    assert found.proven
    assert 0.985 * best < found.reach < best


def test_the_proof_is_about_the_three_claims():
    found = region_of_attraction(EX.plant, EX.K, EX.U, 3.0, **ASKED)
    P = exact(found.P)
    assert float(P[0, 0]) < (np.pi / 2) ** 2
    assert found.level(found.reach * RELEASE) < 1
    for d in descriptors(EX.plant, EX.U):
        E, A = exact(d.E), exact(d.A) + exact(d.Bu) @ exact(EX.K)
        theta = A @ P @ E.T
        assert pivots(-(theta + theta.T + E @ P @ E.T * 6))[-1] > 0


def test_motions_from_the_boundary_stay_and_decay():
    sigma = 3.0
    found = region_of_attraction(EX.plant, EX.K, EX.U, sigma, **ASKED)
    t = np.linspace(0, 1.5, 151)
    starts = found.boundary(8)
    assert np.allclose(found.level(starts.T), 1)
    for x0 in starts:
        motion = simulate_nonlinear(thesis.arm(0.0), arm_gravity, EX.K, t, EX.U, x0=x0)
        assert np.abs(motion.z[0]).max() < np.pi / 2
        V = found.level(motion.x)
        assert (V <= np.exp(-2 * sigma * t) + 1e-6).all()


def test_more_decay_costs_reach():
    reaches = [
        region_of_attraction(EX.plant, EX.K, EX.U, sigma, **ASKED).reach
        for sigma in (0, 2, 4)
    ]
    assert reaches[0] > reaches[1] > reaches[2] > 0


def test_the_range_of_the_output_scales_the_ellipsoid():
    near = region_of_attraction(EX.plant, EX.K, EX.U, **ASKED | {"bound": 0.1})
    far = region_of_attraction(EX.plant, EX.K, EX.U, **ASKED | {"bound": 1.0})
    assert np.isclose(far.reach, 10 * near.reach, rtol=1e-3)


def test_no_common_p_means_no_basin():
    found = region_of_attraction(EX.plant, EX.K, EX.U, 7.0, **ASKED)
    assert (found.status, found.reach, found.proven) == ("infeasible", 0.0, False)


def stiff_and_free(seed):
    """Three rates that are far apart, some hardly damped; a range and a start."""
    rng = np.random.default_rng([seed, 31])
    omega, zeta = 10 ** rng.uniform(-2, 2, 3), 10 ** rng.uniform(-3, 0.5, 3)
    Q = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    plant = sos.SecondOrderSystem(
        np.eye(3), Q * (2 * zeta * omega) @ Q.T, Q * omega**2 @ Q.T, np.eye(3)[:, :1]
    )
    row, start = rng.standard_normal((2, 3))
    return plant, np.append(row, np.zeros(3)), np.append(start, np.zeros(3))


@pytest.mark.parametrize("seed", [1, *campaign([0, 2, 3])])
def test_rates_far_apart_in_any_units(seed):
    """Coordinates so skew that six digits of their inverse are none."""
    plant, row, start = stiff_and_free(seed)
    reaches = []
    for time, length, force in [(1, 1, 1), (1e-9, 1, 1e9), (1e9, 1e-9, 1), (1, 1e9, 1)]:
        unit = Units(time, length * np.eye(3), force * np.eye(3), np.eye(1), np.eye(0))
        found = region_of_attraction(
            unit.plant(plant),
            np.zeros((1, 6)),
            row=np.linalg.solve(unit.state.T, row),
            bound=1.0,
            start=unit.state @ start,
        )
        assert found.proven, found.proof
        reaches.append(found.reach)
    assert reaches == pytest.approx(4 * reaches[:1], rel=1e-4)


def test_a_solution_comes_back_into_skew_coordinates():
    """`Frame.back` is an inverse up to six digits, times the condition of T."""
    plant, row, start = stiff_and_free(2)
    d = sos.analyse_pid(plant, np.zeros((1, 6)))
    T = Frame.of(d.request).T
    inside = in_unknowns_of(d.request, Frame.at(d.request, T, 1.0), d)["P"]
    assert T @ inside @ T.T == pytest.approx(d.P, rel=1e-9, abs=0)


@pytest.mark.parametrize(
    "bad, words",
    [
        (dict(row=[1, 0]), "row has 2 columns"),
        (dict(start=[1, 0]), "start has 2 columns"),
        (dict(bound=0.0), "bound must be positive"),
        (dict(start=np.zeros(5)), "row or start is zero"),
        (dict(row=np.zeros(5)), "row or start is zero"),
    ],
)
def test_bad_input_is_named(bad, words):
    with pytest.raises(ValueError, match=words):
        region_of_attraction(EX.plant, EX.K, EX.U, **ASKED | bad)
