"""Lemma 2.1, proven and refused; modes at infinity, counted."""

from dataclasses import replace

import cvxpy
import numpy as np
import pytest
from flint import fmpz_mat, fmpz_poly
from hypothesis import event, given, settings
from hypothesis import strategies as st
from scipy.linalg import null_space

import sosbook as sos
from sosbook.analysis.infinite_modes import InfiniteModes, infinite_modes
from sosbook.book import thesis
from sosbook.exact.checker import verdict
from sosbook.synthesis.regularization import prove_regular, regularize
from tests.cases import examples
from tests.random_plants import ODD

few = settings(max_examples=examples(12, 25), derandomize=True, deadline=None)
seeds = st.integers(0, 10**6)
I2 = np.eye(2)


def plant(M, B, D=None, S=None):
    n = len(M)
    D, S = (np.eye(n) if x is None else x for x in (D, S))
    return sos.SecondOrderSystem(M, D, S, B)


def segment(first, second):
    return sos.Polytope([plant(*first), plant(*second)])


def smallest(v, K_A):
    mass = v.M - v.B @ K_A
    return np.linalg.eigvalsh((mass + mass.T) / 2)[0]


def random_case(seed):
    """Singular masses of n 1-4, one to three vertices; a beta."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))
    rank = int(rng.integers(0, n))
    m = int(rng.integers(n - rank, n + 2))
    B = rng.standard_normal((n, m)).round(2)
    vertices = []
    for _ in range(int(rng.integers(1, 4))):
        root = rng.standard_normal((n, rank))
        skew = rng.standard_normal((n, n)) * rng.choice([0, 0.3])
        M = root @ root.T + skew - skew.T
        push = B * rng.choice([0.5, 1, 2, 4, -1], m)
        try:
            vertices.append(plant(M, push))
        except ValueError:  # [M B] lacks full row rank
            continue
    if not vertices:
        return random_case(seed + 10**6)
    single = len(vertices) == 1
    return (vertices[0] if single else sos.Polytope(vertices), 10 ** rng.uniform(-2, 0))


# ------------------------------------------------------------ the theorem
@pytest.mark.slow
@few
@given(seeds, st.sampled_from(["centre", "least norm"]))
def test_the_lemma_keeps_its_promise(seed, choose):
    """At the vertices and, (2.12) being affine, between them."""
    case, beta = random_case(seed)
    found = regularize(case, beta, choose=choose)
    event(found.status)
    if found.status != "feasible":
        assert found.K_A is None
        return
    assert found.certify(15).proven
    assert found.bound > beta**2
    assert found.bound == pytest.approx(
        min(smallest(v, found.K_A) for v in case.vertices)
    )
    if isinstance(case, sos.Polytope):
        for v in case.sample(20, seed=1):
            assert smallest(v, found.K_A) > beta**2
            assert smallest(v, found.K_A) > found.bound * (1 - 1e-9)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")
@few
@given(seeds)
def test_the_verdict_is_clarabels_and_refusals_are_proofs(seed):
    case, beta = random_case(seed)
    found = regularize(case, beta)
    K = cvxpy.Variable((case.m, case.n))
    t = cvxpy.Variable()
    limits = [t <= 1, cvxpy.norm(K, "fro") <= 1e3]
    for v in case.vertices:
        mass = v.M - v.B @ K
        limits.append((mass + mass.T) / 2 >> (t + beta**2) * np.eye(case.n))
    margin = cvxpy.Problem(cvxpy.Maximize(t), limits)
    try:
        margin.solve(solver="CLARABEL")
    except cvxpy.SolverError:
        pass
    event(f"Clarabel: {margin.status}")
    if margin.status == "optimal" and abs(t.value) > 1e-4:
        assert (t.value > 0) == (found.status == "feasible")
    if found.status == "infeasible" and found.infeasibility.proven:
        event("proven infeasible")
        proof = found.infeasibility
        assert verdict.check(proof.text) == list(proof.claims)


# ---------------------------------------------------------- which K_A
def test_least_norm_of_one_mass():
    """M - B K > beta^2, raised by 1 %: K = (M - 1.01 beta^2) / B."""
    for M, B, beta in ((0.0, 2.0, 0.1), (-3.0, -0.5, 2.0), (1.0, 4.0, 3.0)):
        found = regularize(plant([[M]], [[B]]), beta, choose="least norm")
        wanted = (M - 1.01 * beta**2) / B
        assert found.K_A == pytest.approx(wanted, rel=1e-4)


@pytest.mark.slow
@few
@given(seeds)
def test_least_norm_is_cvxpys(seed):
    case, beta = random_case(seed)
    found = regularize(case, beta, choose="least norm")
    if found.status != "feasible":
        return
    K = cvxpy.Variable((case.m, case.n))
    limits = []
    for v in case.vertices:
        mass = v.M - v.B @ K
        limits.append((mass + mass.T) / 2 >> 1.01 * beta**2 * np.eye(case.n))
    best = cvxpy.Problem(cvxpy.Minimize(cvxpy.sum_squares(K)), limits)
    best.solve(solver="CLARABEL")
    if best.status == "optimal" and best.value > 1e-6:
        event("compared")
        norm = np.linalg.norm(found.K_A)
        assert norm == pytest.approx(np.sqrt(best.value), rel=2e-3)


def test_least_norm_is_zero_where_no_gain_is_needed():
    heavy = plant(np.diag([3.0, 2.0]), [[0], [1]])
    assert not regularize(heavy, 0.1, choose="least norm").K_A.any()


def test_vertices_that_differ_in_stiffness_only_count_once():
    M, B = np.diag([2.0, 0]), [[0], [1]]
    one = plant(M, B)
    two = sos.Polytope([one, plant(M, B, S=3 * I2)])
    assert np.array_equal(regularize(one).K_A, regularize(two).K_A)


def test_redundant_inputs():
    """Two actuators on one coordinate share the work; units too."""
    M = np.diag([2.0, 0])
    one = regularize(plant(M, [[0], [1]]))
    for unit in (1.0, 1e3):
        two = regularize(plant(M, [[0, 0], [1, unit]]))
        assert np.allclose(
            [[0, 0], [1, unit]] @ two.K_A, [[0], [1]] @ one.K_A, atol=1e-6
        )
        assert two.K_A[0, 1] == pytest.approx(unit * two.K_A[1, 1])
    idle = regularize(plant(I2, np.zeros((2, 1))))
    assert idle.status == "feasible"
    assert not idle.K_A.any()


def test_centre_of_one_mass_by_hand():
    """max log(s - b) + log(4 b^2 - s^2), b = beta^2, s = -K."""
    b = 0.01
    s = b * (1 + np.sqrt(13)) / 3
    found = regularize(plant([[0]], [[1]]), 0.1)
    assert found.K_A == pytest.approx(-s, rel=1e-4)


@pytest.mark.parametrize("beta", [1e-3, 0.1, 30.0])
def test_centre_of_no_mass_at_all_is_sized_by_beta(beta):
    """The docstring of `regularize`: nothing else has the unit of a mass."""
    B = np.array([[1.0, 0.3], [-0.4, 2.0]])
    found = regularize(plant(np.zeros((2, 2)), B), beta)
    assert found.status == "feasible"
    mass = -B @ found.K_A
    symmetric = np.linalg.eigvalsh((mass + mass.T) / 2)
    assert symmetric[0] > beta**2 and np.linalg.norm(mass, 2) < 2.001 * beta**2
    unit = regularize(plant(np.zeros((2, 2)), B), 1.0)
    assert np.allclose(found.K_A, beta**2 * unit.K_A, rtol=1e-3)


# ------------------------------------------------------------ Example 3
def test_example_3():
    ex = thesis.example_3()
    assert prove_regular(ex.plant, ex.K_A, 0.1).proven
    assert prove_regular(ex.plant, ex.K_A, 0.999).proven
    assert not prove_regular(ex.plant, ex.K_A, 1).proven
    for choose, status in (("centre", "feasible"), ("least norm", "infeasible")):
        proof = regularize(ex.plant, 0.1, choose=choose).certify()
        assert proof.proven
        asked = ex.requirements | {"K_A": proof.K}
        assert sos.design_pid(ex.plant, **asked).status == status
    assert regularize(ex.plant, 1).infeasibility.proven
    assert "below 1:" in regularize(ex.plant, 1.2).advice


def test_a_tiny_mass_is_brought_back():
    ex = thesis.example_3()
    v = ex.plant
    near = sos.SecondOrderSystem(np.diag([3, 2, 1, 1e-6]), v.D, v.S, v.B)
    assert near.poles().real.min() < -1.9e7
    found = regularize(near)
    assert found.regular.poles().real.min() > -100
    assert found.certify().proven


# ----------------------------------------------- what the lemma refuses
@pytest.mark.parametrize("M", [[[0, 1], [1, 0]], [[-1, 0], [0, 0]]])
@pytest.mark.parametrize("beta", [1e-6, 1.0, 1e6])
def test_only_sufficient(M, beta):
    """K_A exists, (2.12) has no solution for any beta."""
    v = plant(M, [[0], [1]])
    assert np.linalg.det(v.M - v.B @ [[0, -1]]) != 0
    found = regularize(v, beta)
    assert found.status == "infeasible"
    assert found.infeasibility.proven
    assert verdict.check(found.infeasibility.text)
    assert found.advice.startswith("No beta helps")


@few
@given(seeds)
def test_the_exact_condition_and_the_row_transformation(seed):
    """Feasible iff N'(M - b^2)N > 0; after T = (M - B K0)' always."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 5))
    rank = int(rng.integers(1, n))
    M = rng.standard_normal((n, rank)) @ rng.standard_normal((rank, n))
    B = rng.standard_normal((n, n - rank))
    v = plant(M, B)
    N = null_space(B.T)
    limit = np.linalg.eigvalsh(N.T @ (M + M.T) @ N / 2)[0]
    beta = 0.1
    found = regularize(v, beta)
    if abs(limit - beta**2) > 1e-3:
        assert (found.status == "feasible") == (limit > beta**2)
        assert found.status == "feasible" or found.infeasibility.proven
    left, right = null_space(M.T, rcond=1e-9), null_space(M, rcond=1e-9)
    K0 = -np.linalg.pinv(left.T @ B) @ right.T
    T = (M - B @ K0).T
    least = np.linalg.svd(T, compute_uv=False)[-1]
    assert least > 1e-9
    moved = regularize(plant(T @ M, T @ B), 0.5 * least)
    assert moved.status == "feasible"
    assert np.linalg.matrix_rank(M - B @ moved.K_A) == n


def test_singular_inside_though_the_vertices_are_regular():
    M1, M2 = np.diag([1.0, 1]), np.diag([1.0, -1])
    both = segment((M1, [[1], [0]]), (M2, [[1], [0]]))
    with pytest.raises(ValueError, match="lacks full row rank"):
        both.at([0.5, 0.5])
    found = regularize(both)
    assert found.status == "infeasible"
    assert verdict.check(found.infeasibility.text)
    # with an input there K_A = 0 is regular at the ends, not between
    full = segment((M1, I2), (M2, I2))
    assert np.linalg.det(full.mean.M) == 0
    found = regularize(full)
    assert found.certify().proven
    for v in full.sample(50, seed=2):
        assert smallest(v, found.K_A) > 0.01


@pytest.mark.parametrize(
    "B1, B2",
    [
        ([[0], [1]], [[0], [-1]]),  # the multipliers can be definite
        (I2, np.diag([1, -1])),  # they can't: one input helps, one doesn't
    ],
)
def test_an_input_that_changes_sign(B1, B2):
    M = np.diag([1.0, 0])
    both = segment((M, B1), (M, B2))
    for v in both.vertices:
        assert regularize(v).status == "feasible"
    found = regularize(both)
    assert found.status == "infeasible"
    assert found.infeasibility.proven
    assert verdict.check(found.infeasibility.text)
    assert "full row rank" in found.advice


def test_advice_is_worth_following():
    v = plant([[1.0, 5], [5, 0]], [[0], [1]])
    assert regularize(v, 2).advice.startswith("Ask for a beta below 1:")
    assert regularize(v, 0.9).status == "feasible"
    assert regularize(v, 0.9).advice == ""


# ------------------------------------------------- certificates, errors
def test_tampering_is_noticed():
    ex = thesis.example_3()
    found = regularize(ex.plant, 0.1, choose="least norm")
    spoilt = replace(found, K_A=0.98 * found.K_A)
    proof = spoilt.certify()
    assert not proof.proven
    assert proof.failed == ("mass",)
    assert proof.claims == ()
    assert not replace(found, beta=0.102).certify().proven
    assert not found.certify(digits=1).proven  # 0.0101 rounds to 0.01


def test_bad_input():
    v = plant(np.diag([1, 0]), [[0], [1]])
    for beta in (0, -1, np.nan, np.inf, "a", None):
        with pytest.raises(ValueError, match="beta"):
            regularize(v, beta)
    with pytest.raises(ValueError, match='"centre" or "least norm"'):
        regularize(v, choose="best")
    for function in (regularize, infinite_modes):
        with pytest.raises(ValueError, match="plant must be"):
            function(np.eye(2))
    refused = regularize(plant([[-1, 0], [0, 0]], [[0], [1]]))
    assert repr(refused) == "<Regularization: infeasible>"
    assert not refused.certify().proven
    for ask in (lambda: refused.bound, lambda: refused.regular):
        with pytest.raises(ValueError, match="see its advice"):
            ask()


# ------------------------------------------------------ infinite modes
def exact_degree(v):
    """Degree of det(s^2 M + s D + S), for integer matrices."""
    from flint import fmpz

    n = v.n
    points, values = range(2 * n + 1), []
    for s in points:
        entries = s * s * v.M + s * v.D + v.S
        values.append(fmpz_mat(n, n, [fmpz(int(e)) for e in entries.flat]).det())
    total = fmpz_poly([0]) * 1
    scale = 1
    for i in points:  # Lagrange, times a common factor
        for j in points:
            if i != j:
                scale *= i - j
    for i in points:
        basis, weight = fmpz_poly([1]), scale
        for j in points:
            if i != j:
                basis *= fmpz_poly([-j, 1])
                weight //= i - j
        total += basis * (values[i] * weight)
    return total.degree()


@few
@given(seeds)
def test_modes_are_counted_as_in_exact_arithmetic(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))
    rank = int(rng.integers(0, n + 1))
    low = int(rng.integers(0, n + 1))

    def part(rank):
        return rng.integers(-3, 4, (n, rank)) @ rng.integers(-3, 4, (rank, n))

    M, D, S = part(rank), part(low), part(n)
    v = sos.SecondOrderSystem(M, D, S, np.eye(n))
    degree = exact_degree(v)
    if degree < 0:
        with pytest.raises(ValueError, match="singular pencil"):
            infinite_modes(v)
        return
    found = infinite_modes(v)
    event(f"index {found.index}")
    assert found.finite == degree
    assert found.infinite == 2 * n - degree
    L, R = null_space(v.M.T), null_space(v.M)
    assert found.infinite - found.impulses == L.shape[1]
    A22 = L.T @ v.D @ R
    free = np.linalg.matrix_rank(A22, tol=1e-9) == L.shape[1]
    assert found.impulsive == (not free)
    assert (found.index <= 1) == free
    assert (found.index == 0) == (L.shape[1] == 0)


@pytest.mark.parametrize("scale", [1e-7, 1.0, 1e7, *ODD])
def test_higher_index_and_scales(scale):
    """z1 = u, then z2 follows from z1'': index four."""
    M, S = np.diag([1.0, 0]), np.array([[0.0, 1], [1, 0]])
    v = sos.SecondOrderSystem(scale * M, np.zeros((2, 2)), S, [[0], [1]])
    assert infinite_modes(v) == InfiniteModes(0, 4, 3, 4)


def test_example_3_has_no_impulsive_mode():
    """One infinite eigenvalue, and it is an algebraic equation."""
    v = thesis.example_3().plant
    assert infinite_modes(v) == InfiniteModes(7, 1, 0, 1)
    assert not infinite_modes(v).impulsive
    D = v.D.copy()
    D[2:, 2:] -= 20 * np.array([[1, -1], [-1, 1]])
    undamped = sos.SecondOrderSystem(v.M, D, v.S, v.B, v.F)
    assert infinite_modes(undamped) == InfiniteModes(6, 2, 1, 2)
    both = sos.Polytope([v, undamped])
    assert [x.index for x in infinite_modes(both)] == [1, 2]


def test_a_singular_pencil_is_refused():
    M = np.diag([1.0, 0])
    v = sos.SecondOrderSystem(M, M, M, I2)
    with pytest.raises(ValueError, match="singular pencil"):
        infinite_modes(v)
    assert regularize(v).certify().proven
