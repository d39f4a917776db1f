"""Poles that are moved, and others that stay: against Ackermann's formula."""

import control
import numpy as np
import pytest

import sosbook as sos
from sosbook import place_poles

CHAIN = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
GYRO = np.array([[0, 0.4, 0], [-0.4, 0, 0], [0, 0, 0]])
PLANTS = {
    "undamped": ([10, 10, 10], 0 * CHAIN, 40 * (CHAIN - np.diag([0, 0, 1])), [1, 2, 4]),
    "lightly damped": ([0.3, 9.81, 1], 0.05 * CHAIN, 9.81 * CHAIN, [1, 0, 0.3]),
    "unsymmetric": (
        [1, 1, 1],
        0.1 * np.eye(3) + GYRO,
        np.diag([1.0, 4, 9]) + 0.1 * np.eye(3, k=1),
        [1, 1, 1],
    ),
    "free": ([0.3, 9.81, 1], 0 * CHAIN, CHAIN - np.diag([1.0, 0, 1]), [1, 0, 0]),
}


def plant(name):
    M, D, S, b = PLANTS[name]
    return sos.SecondOrderSystem(np.diag(M).astype(float), D, S, np.c_[b])


def matrices(plant):
    n, back = plant.n, np.linalg.inv(plant.M)
    lower = np.hstack([-back @ plant.S, -back @ plant.D])
    A = np.vstack([np.eye(n, 2 * n, n), lower])
    return A, np.vstack([np.zeros((n, 1)), back @ plant.B])


@pytest.mark.parametrize("name", PLANTS)
def test_the_gain_is_ackermanns_and_the_others_stay(name):
    """The gain of one input is unique, so his formula for all places has it."""
    it = plant(name)
    A, b = matrices(it)
    before = np.linalg.eigvals(A)
    moved = before[before.imag > 0.1]
    moved = moved[np.argmin(abs(moved))]
    place = -1 + 0.5j
    found = place_poles(it, [moved.round(2)], [place])
    stay = before[
        abs(before.real - moved.real) + abs(abs(before.imag) - moved.imag) > 1e-9
    ]
    wanted = np.append([place, place.conjugate()], stay)
    true = -control.acker(A, b, wanted)
    assert found.K == pytest.approx(np.reshape(true, (1, -1)), rel=1e-5, abs=1e-6)
    after = np.linalg.eigvals(A + b @ found.K)
    assert np.poly(after) == pytest.approx(np.poly(wanted), rel=1e-8, abs=1e-8)
    assert found.miss < 1e-11 and found.spill < 1e-6
    seen = max(abs(after - x).min() for x in stay)
    assert seen <= found.spill + 1e-6
    assert (
        sos.analyse_pid(it, found.K, region=sos.PoleRegion(rho=99)).effort is not None
    )


def test_the_proof_is_of_the_printed_numbers():
    """A gain of fewer digits is another gain; its poles lie elsewhere."""
    it = plant("undamped")
    found = place_poles(it, [0.89j], [-1 + 0.5j])
    rough = sos.analyse_pid(it, found.K.round(3)).poles()
    assert abs(rough - (-1 + 0.5j)).min() > 1e3 * found.miss
    said = float(str(found).split("within ")[1].split(" ")[0])
    assert found.miss <= said <= 1.2 * found.miss


def test_two_real_poles_become_a_pair():
    damped = sos.SecondOrderSystem(
        np.eye(2), np.diag([5, 0.1]), np.diag([4, 9]), [[1], [2]]
    )
    found = place_poles(damped, [-1, -4], [-2 + 1j])
    p = sos.analyse_pid(damped, found.K).poles()
    for x in (-2 + 1j, *np.roots([1, 0.1, 9])):
        assert abs(p - x).min() < 1e-9
    assert found.spill < 1e-12


@pytest.mark.parametrize(
    "call, words",
    [
        (
            lambda it: place_poles(it, [7j], [-1 + 1j]),
            "poles must be some of the plant's",
        ),
        (lambda it: place_poles(it, [0.89j], [-1]), "2 poles can't be moved to 1"),
        (lambda it: place_poles(it, [np.nan], [-1]), "poles must be some finite"),
        (lambda it: place_poles(sos.Polytope([it, it]), [1j], [-1j]), "one input"),
        (lambda it: place_poles(two_inputs(it), [1j], [-1j]), "whose B is B g"),
        (lambda it: place_poles(unseen(), [2j], [-1 + 2j]), "doesn't reach"),
    ],
)
def test_what_is_wrong_is_said(call, words):
    with pytest.raises(ValueError, match=words):
        call(plant("undamped"))


def two_inputs(it):
    return sos.SecondOrderSystem(it.M, it.D, it.S, np.eye(3)[:, :2])


def unseen():
    return sos.SecondOrderSystem(
        np.eye(2), np.zeros((2, 2)), np.diag([1, 4]), [[1], [0]]
    )
