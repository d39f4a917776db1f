"""Exact proofs: what they accept, and what they must refuse."""

from dataclasses import replace
from decimal import Decimal
from unittest.mock import patch

import numpy as np
import pytest
from flint import fmpq, fmpq_mat
from hypothesis import given, settings
from hypothesis import strategies as st

import sosbook as sos
from sosbook.book import counterexamples, thesis
from sosbook.exact import definite as certificate
from sosbook.exact.definite import (
    Rational,
    definite,
    exact,
    inverse,
    pivots,
    round_digits,
)
from sosbook.exact.repair import repair_multipliers
from sosbook.lmi import Unknown, eye
from tests.cases import campaign


@pytest.fixture(scope="module")
def robot():
    ex = thesis.example_1()
    return ex, sos.design_pid(ex.plant, **ex.requirements)


TAMPERED = {  # more of them as files in test_tampering
    "sign of K": lambda d: replace(d, K=-d.K),
    "P scaled up": lambda d: replace(d, P=10 * d.P),
    "lower gamma": lambda d: replace(d, request=replace(d.request, gamma=0.3)),
}


@pytest.mark.parametrize("name", TAMPERED)
def test_tampered_designs_are_refused(robot, name):
    proof = TAMPERED[name](robot[1]).certify()
    assert not proof.proven
    assert proof.failed
    assert proof.claims == ()
    assert str(proof).startswith("not proven")


@pytest.mark.parametrize(
    "change, name",
    [
        (lambda d: replace(d, K=d.K * np.nan), "K"),
        (lambda d: replace(d, P=d.P * np.inf), "P"),
        (lambda d: replace(d, K=d.K[:, :4]), "K"),
        (lambda d: replace(d, P=d.P[:4, :4]), "P"),
    ],
)
def test_broken_designs_are_refused(robot, change, name):
    with pytest.raises(ValueError, match=f"^{name} has"):
        change(robot[1]).certify()


def test_printed_gains_of_example_1(robot):
    ex, _ = robot
    proof = sos.analyse_pid(ex.plant, ex.K, **ex.requirements).certify(7)
    assert proof.proven
    assert np.array_equal(proof.K, ex.K)
    assert len(proof.claims) == 6


def test_the_proof_is_repeated_with_determinants(robot):
    """Sylvester's criterion, with flint's determinants."""
    ex, d = robot
    proof = d.certify()
    K, P = exact(proof.K), exact(proof.P)
    blocks = d.request.blocks(P, K @ P, exact)
    assert set(blocks) == set(proof.blocks)
    assert all(positive_definite(g) for g in blocks.values())


def positive_definite(matrix):
    """All leading minors are positive."""
    q = len(matrix)
    entries = [[fmpq(e) for e in row] for row in matrix]
    return all(
        fmpq_mat([row[:k] for row in entries[:k]]).det() > 0 for k in range(1, q + 1)
    )


def test_vertices_prove_nothing_between_them():
    plants, region = counterexamples.actuated(), sos.PoleRegion(rho=10)
    d = sos.design_pid(plants, coupling="vertices", region=region)
    proof = d.certify()
    assert proof.proven
    assert "not the plants between" in proof.claims[0]


def test_vertices_that_suffice_prove_what_lies_between_them():
    """The mass of the seat's rider stands in one row."""
    seat = thesis.example_2()
    for coupling in ("vertices", "pairs"):
        design = sos.design_pid(seat.plant, coupling=coupling, **seat.requirements)
        proof = design.certify()
        assert proof.proven
        assert proof.claims[0].startswith("every constant or changing plant of")


def test_claims_never_say_more_than_was_asked():
    """All digits of what was asked stand in the claims."""
    sigma, rho, gamma = 0.1234567891234, 50.00000001, 1.0000000123
    one = [[1.0]]
    d = sos.design_pid(
        sos.SecondOrderSystem(one, one, one, one, one),
        gamma=gamma,
        region=sos.PoleRegion(sigma, rho=rho) & sos.LMIRegion.sector(1.0, apex=0.25),
    )
    claims = str(d.certify())
    for words in (
        f"Re s < {-sigma}",
        str(rho),
        str(gamma),
        "half-angle 57.3 degrees with apex 0.25",
    ):
        assert words in claims
    assert np.degrees(1.0) < 57.3


def test_the_mass_that_is_proven_has_no_rounding_error():
    """M - B K_A is formed in exact arithmetic: 0.3 - 0.1 is 0.2."""
    one = [[1.0]]
    d = sos.design_pid(sos.SecondOrderSystem([[0.3]], one, one, one), K_A=[[0.1]])
    (v,) = d.request.vertices
    assert v.E[1, 1] != 0.2
    P = exact(np.eye(2))
    found = d.request.blocks(P, exact(d.K) @ P, exact)["stability"]
    by_hand = exact(np.array([[0, 1.0], [-1, -1]]))
    by_hand = by_hand + exact(np.array([[0.0], [1]])) @ exact(d.K)
    by_hand = by_hand @ np.diag([fmpq(1), fmpq(1, 5)])
    assert (found == -(by_hand + by_hand.T)).all()


@pytest.mark.parametrize("x", [0.1, -2.5e-300, 123456.789, 1 / 3, 0.0])
def test_exact_reads_the_decimal(x):
    assert float(exact(x)) == x
    assert exact(x) == fmpq(*Decimal(repr(x)).as_integer_ratio())


def test_round_digits_keeps_short_numbers():
    K = np.array([[-101.9639, 9.7931, 0.0]])
    assert np.array_equal(round_digits(K, 7), K)
    assert np.array_equal(round_digits(K, 2), [[-100, 9.8, 0]])


def test_multipliers_that_exclude_nothing_are_refused():
    """x > 0 and 1 - x > 0 have a solution: no repair may succeed."""
    x, one = Unknown("x", 1), exact(np.ones((1, 1)))
    for z in (1.0, 0.5, 1e-3):
        Z = [np.full((1, 1), z)] * 2
        assert repair_multipliers([one @ x, one - x], [x], Z) is None


def test_multipliers_are_repaired():
    """X - 1 > 0 excludes -X - 0.1 A X A' > 0; an unused y is no harm."""
    X, y = Unknown("X", 2, symmetric=True), Unknown("y", 1)
    A, one = exact(np.array([[0.1, 0.7], [0.3, -0.2]])), exact(np.eye(2))
    blocks = [one @ X - one, -one @ X - A @ X @ A.T / 10]
    second = np.array([[3.0, 0.4], [0.4, 2]])
    a = A.astype(float)
    first = second + a.T @ second @ a / 10
    noise = np.array([[1e-9, 2e-9], [2e-9, -1e-9]])
    Z, value = repair_multipliers(blocks, [X, y], [first + noise, second])
    assert all(positive_definite(z) for z in Z)
    assert (Z[0] == Z[1] + A.T @ Z[1] @ A / 10).all()
    assert value == -Z[0][0, 0] - Z[0][1, 1]


def as_large(x):
    """`definite` in the way in which it treats large matrices."""
    with patch.object(certificate, "ELIMINATION_UP_TO_ROWS", 0):
        return definite(x)


def chain(q):
    """2 on the diagonal, -1 beside it: its pivots are (k + 1) / k."""
    x = 2 * np.eye(q) - np.eye(q, k=1) - np.eye(q, k=-1)
    return exact(x), fmpq(q + 1, q)


@pytest.mark.slow
@pytest.mark.parametrize("q", [1, 2, 3, 7, 24, 25, 40, *campaign([60])])
def test_definite_around_the_border(q):
    """Less than the last pivot off the last entry, all of it, and more."""
    tiny = fmpq(1, 10**40)
    for decide in (definite, as_large):
        x, smallest = chain(q)
        proven, measure = decide(x)
        assert proven
        assert (1 - fmpq(1, 10**6)) * smallest <= measure <= smallest
        x[-1, -1] -= smallest - tiny
        proven, measure = decide(x)
        assert proven
        assert 0 < measure <= tiny
        x[-1, -1] -= tiny
        assert decide(x) == (False, 0)
        x[-1, -1] -= tiny
        proven, measure = decide(x)
        assert not proven
        assert measure <= 0


@settings(max_examples=150)
@given(st.integers(1, 7), st.integers(0, 10**9), st.booleans())
def test_no_integer_matrix_is_judged_wrongly(q, seed, gram):
    """Small integers: many are singular, or have a zero on the way."""
    g = np.random.default_rng(seed).integers(-2, 3, (q, q))
    x = exact((g @ g.T if gram else g + g.T + 2 * eye(q)).astype(float))
    found = pivots(x)
    proven, measure = as_large(x)
    assert proven == (found[-1] > 0) == (measure > 0)
    assert proven == positive_definite(x)


@pytest.mark.parametrize("q", [10, 30])
def test_units_of_the_rows_do_not_decide(q):
    """Rows in units from 1e-15 to 1e15, condition 1e12 besides."""
    rng = np.random.default_rng(3)
    Q = np.linalg.qr(rng.standard_normal((q, q)))[0]
    x = (Q * np.logspace(0, -12, q)) @ Q.T
    x = exact((x + x.T) / 2)
    units = np.diag(exact(10.0 ** rng.integers(-15, 16, q)))
    scaled = units @ x @ units
    assert np.linalg.cond(scaled.astype(float)) > 1e20
    assert as_large(scaled)[0] is True
    x[0, 0] -= fmpq(1, 10**6)
    assert as_large(units @ x @ units)[0] is False


def test_far_from_definite():
    """Entries that no scaling brings near those of the diagonal."""
    x = exact(np.eye(30))
    x[4, 2] = x[2, 4] = fmpq(10) ** 400
    assert definite(x)[0] is False
    x[0, 0] = fmpq(-1, 10**400)
    assert definite(x) == (False, fmpq(-1, 10**400))


def test_what_definite_refuses_to_judge():
    with pytest.raises(ValueError, match="isn't symmetric"):
        definite(exact(np.eye(30) + 1e-300 * np.eye(30, k=1)))
    with pytest.raises(ValueError, match="isn't symmetric"):
        pivots(exact(np.array([[1.0, 1e-300], [0, 1]])))
    with pytest.raises(TypeError):
        definite(np.array([[0.5]]))  # a float is no rational


def test_rationals_are_multiplied_as_numpy_does():
    rng = np.random.default_rng(0)
    A, B = exact(rng.random((3, 4))), exact(rng.random((4, 2)))
    plain = [np.array(x, object) for x in (A, B)]
    assert isinstance(A @ B, Rational)
    assert (A @ B == np.dot(*plain)).all()
    assert (plain[0] @ B == A @ plain[1]).all()
    assert (A @ eye(4) == A).all()
    assert (eye(3) @ A == A).all()
    assert (A @ B[:, 0] == (A @ B)[:, 0]).all()
    assert (A[:, :0] @ B[:0] == 0).all()
    assert (inverse(A[:, :3]) @ A[:, :3] == eye(3)).all()
    assert (A.astype(float) @ B.astype(float)).dtype == float
    with pytest.raises(ValueError):
        A @ A


def test_rationals_multiply_unknowns():
    X = Unknown("X", 2)
    L, x = exact(np.array([[0.1, 2]])), exact(np.array([[3, 0.7], [1, 9]]))
    assert ((L @ X @ L.T).value({X: x}) == L @ x @ L.T).all()


def test_a_sum_of_rationals_is_a_number():
    total = exact(np.array([[0.5, 0.25], [0.125, 1.0]])).sum()
    assert type(total) is type(exact(1.0))
    assert {total} == {exact(1.875)}
