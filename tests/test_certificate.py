"""Exact proofs: what they accept, and what they must refuse."""

from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest
from flint import fmpq, fmpq_mat

import sosbook as sos
from sosbook.lmi.centre import Blocks
from sosbook.lmi.certificate import (
    exact,
    pivots,
    repair_multipliers,
    round_digits,
)


@pytest.fixture(scope="module")
def robot():
    ex = sos.thesis.example_1()
    return ex, sos.design_pid(ex.plant, **ex.requirements)


def asked(d, **changes):
    """The same K and P, held against another request."""
    return replace(d, request=replace(d.request, **changes))


def plant(d, **changes):
    return asked(d, plant=replace(d.request.plant, **changes))


def flip_one(K):
    K = K.copy()
    K[0, 0] *= -1
    return K


def negative(P):
    """P with its smallest eigenvalue's sign turned."""
    values, vectors = np.linalg.eigh(P)
    values[0] *= -1
    found = vectors @ np.diag(values) @ vectors.T
    return (found + found.T) / 2


def skewed(P):
    P = P.copy()
    P[0, 1] += 1e-9 * P[0, 0]
    return P


region, start = sos.PoleRegion, sos.Saturation
TAMPERED = {
    "sign of K": lambda d: replace(d, K=-d.K),
    "sign of one gain": lambda d: replace(d, K=flip_one(d.K)),
    "K is zero": lambda d: replace(d, K=0 * d.K),
    "no integral gain": lambda d: replace(
        d, K=np.hstack([d.K[:, :4], 0 * d.K[:, 4:]])),
    "K_P and K_D exchanged": lambda d: replace(
        d, K=d.K[:, [2, 3, 0, 1, 4, 5]]),
    "exchanged inputs": lambda d: replace(d, K=d.K[::-1]),
    "K doubled": lambda d: replace(d, K=2 * d.K),
    "P isn't symmetric": lambda d: replace(d, P=skewed(d.P)),
    "P is negative": lambda d: replace(d, P=-d.P),
    "one negative eigenvalue": lambda d: replace(d, P=negative(d.P)),
    "P scaled up": lambda d: replace(d, P=10 * d.P),
    "P scaled down": lambda d: replace(d, P=d.P / 10),
    "P is the identity": lambda d: replace(d, P=np.eye(6)),
    "another mass": lambda d: plant(d, M=np.diag([10, 30])),
    "exchanged masses and springs": lambda d: plant(
        d, S=-d.request.plant.S, M=d.request.plant.M / 3),
    "stronger disturbance": lambda d: plant(d, F=400 * np.eye(2)),
    "wrong U": lambda d: asked(d, U=-np.eye(2)),
    "exchanged rows of U": lambda d: asked(d, U=[[0, 1], [1, 0]]),
    "lower gamma": lambda d: asked(d, gamma=0.3),
    "faster decay": lambda d: asked(d, region=region(0.95, np.pi / 4, 5)),
    "narrower sector": lambda d: asked(d, region=region(0.7, 0.5, 5)),
    "smaller disk": lambda d: asked(d, region=region(0.7, np.pi / 4, 2.5)),
    "lower u_max": lambda d: asked(
        d, saturation=start(80, d.request.saturation.x0)),
    "larger x0": lambda d: asked(
        d, saturation=start(150, 2 * d.request.saturation.x0)),
}


@pytest.mark.parametrize("name", TAMPERED)
def test_tampered_designs_are_refused(robot, name):
    proof = TAMPERED[name](robot[1]).certify()
    assert not proof.proven
    assert proof.failed
    assert proof.claims == ()
    assert str(proof).startswith("not proven")


def test_too_few_digits_are_refused():
    """Margins decide how many digits of K a proof can spare."""
    plants = sos.SecondOrderSystem([[1]], [[1]], [[1]], [[1]])
    d = sos.design_pid(plants, region=sos.LMIRegion.disk(0.5, -30))
    assert d.certify(digits=6).proven
    assert not d.certify(digits=1).proven


@pytest.mark.parametrize("change, name", [
    (lambda d: replace(d, K=d.K * np.nan), "K"),
    (lambda d: replace(d, P=d.P * np.inf), "P"),
    (lambda d: replace(d, K=d.K[:, :4]), "K"),
    (lambda d: replace(d, P=d.P[:4, :4]), "P"),
])
def test_broken_designs_are_refused(robot, change, name):
    with pytest.raises(ValueError, match=f"^{name} has"):
        change(robot[1]).certify()


@pytest.mark.parametrize("digits", [0, -1, 2.5])
def test_digits_are_checked(robot, digits):
    with pytest.raises(ValueError, match="digits"):
        robot[1].certify(digits=digits)


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
    blocks = d.request.blocks(P, K @ P, exact(ex.gamma) ** 2, exact)
    assert set(blocks) == set(proof.blocks)
    assert all(positive_definite(g) for g in blocks.values())


def positive_definite(matrix):
    """All leading minors are positive."""
    q = len(matrix)
    entries = [[fmpq(e) for e in row] for row in matrix]
    return all(
        fmpq_mat([row[:k] for row in entries[:k]]).det() > 0
        for k in range(1, q + 1)
    )


def test_vertices_prove_nothing_between_them():
    seat = sos.thesis.example_2()
    plants, asked_for = seat.plant, seat.requirements
    d = sos.design_pid(plants, coupling="vertices", **asked_for)
    proof = d.certify()
    assert proof.proven
    assert "not the plants between" in proof.claims[0]


def test_claims_never_say_more_than_was_asked():
    """All digits of what was asked stand in the claims."""
    sigma, rho, gamma = 0.1234567891234, 50.00000001, 1.0000000123
    one = [[1.0]]
    d = sos.design_pid(
        sos.SecondOrderSystem(one, one, one, one, one), gamma=gamma,
        region=sos.PoleRegion(sigma, rho=rho)
        & sos.LMIRegion.sector(1.0, apex=0.25),
    )
    claims = str(d.certify())
    for words in (f"Re s < {-sigma}", str(rho), str(gamma),
                  "half-angle 57.3 degrees with apex 0.25"):
        assert words in claims
    assert np.degrees(1.0) < 57.3


def test_the_mass_that_is_proven_has_no_rounding_error():
    """M - B K_A is formed in exact arithmetic: 0.3 - 0.1 is 0.2."""
    one = [[1.0]]
    d = sos.design_pid(
        sos.SecondOrderSystem([[0.3]], one, one, one), K_A=[[0.1]])
    (v,) = d.request.vertices
    assert v.E[1, 1] != 0.2
    P = exact(np.eye(2))
    found = d.request.blocks(P, exact(d.K) @ P, None, exact)["stability"]
    by_hand = exact(np.array([[0, 1.0], [-1, -1]]))
    by_hand = by_hand + exact(np.array([[0.0], [1]])) @ exact(d.K)
    by_hand = by_hand @ np.diag([fmpq(1), fmpq(1, 5)])
    assert (found == -(by_hand + by_hand.T)).all()


def test_pivots_are_those_of_a_known_matrix():
    hilbert = np.array(
        [[fmpq(1, i + j + 1) for j in range(6)] for i in range(6)])
    assert min(pivots(hilbert)) == fmpq(1, 698544)
    hilbert[5, 5] -= fmpq(1, 698544)
    assert pivots(hilbert)[-1] == 0
    with pytest.raises(ValueError, match="isn't symmetric"):
        pivots(exact(np.array([[1.0, 1e-300], [0, 1]])))


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
    zero, one = exact(np.zeros((1, 1))), exact(np.ones((1, 1)))
    blocks = Blocks([zero, one], [one[None], -one[None]])
    for z in (1.0, 0.5, 1e-3):
        assert repair_multipliers(blocks, [np.full((1, 1), z)] * 2) is None
