"""Exact arithmetic of proofs against definitions that are slower."""

import numpy as np
import pytest
from flint import arb, fmpq, fmpq_mat

from sosbook.lmi.adjoint import adjoint, slope
from sosbook.lmi.exact import exact, pivots
from sosbook.lmi.expression import Unknown, block, he


def rationals(rng, *shape):
    """Rationals with denominators of their own."""
    found = np.empty(shape, object)
    found.flat = [
        fmpq(int(p), int(q))
        for p, q in zip(
            rng.integers(-99, 99, found.size), rng.integers(1, 99, found.size)
        )
    ]
    return found.view(type(exact(np.eye(1))))


@pytest.mark.parametrize("seed", range(6))
def test_pivots_are_quotients_of_leading_minors(seed):
    rng = np.random.default_rng(seed)
    size = int(rng.integers(1, 9))
    root = rationals(rng, size, size)
    x = root @ root.T - fmpq(3 * (seed % 2)) * exact(np.eye(size))
    minors = [fmpq(1)]
    for k in range(1, size + 1):
        minors.append(fmpq_mat(k, k, x[:k, :k].ravel().tolist()).det())
        if minors[-1] <= 0 < minors[-2]:
            break
    assert pivots(x) == [b / a for a, b in zip(minors, minors[1:])]


def test_a_singular_matrix_ends_in_a_pivot_of_zero():
    x = exact(np.array([[1.0, 2.0, 0], [2.0, 4.0, 0], [0, 0, 1.0]]))
    assert pivots(x) == [1, 0]


def blocks(rng):
    """Two symmetric blocks in a symmetric, a rectangular and an idle unknown."""
    P, Y, idle = Unknown("P", 3, symmetric=True), Unknown("Y", 2, 3), Unknown("N", 2)
    A, B, C = (rationals(rng, 3, k) for k in (3, 2, 3))
    first = he(A @ P + B @ Y) + exact(np.eye(3))
    second = block([[P, C @ Y.T], [Y @ C.T, exact(np.eye(2))]])
    return [first, second], [P, Y, idle]


def by_units(expressions, unknowns, Z):
    """<G, Z> at each unit of the variables less that at zero."""
    zero = {u: exact(np.zeros(u.shape)) for u in unknowns}
    found = []
    for u in unknowns:
        for k in range(u.size):
            unit = u.unpack(exact(np.eye(u.size)[k]))
            found.append(
                sum(
                    ((g.value(zero | {u: unit}) - g.value(zero)) * z).sum()
                    for g, z in zip(expressions, Z)
                )
            )
    return found


@pytest.mark.parametrize("seed", range(4))
def test_derivatives_are_differences(seed):
    rng = np.random.default_rng(seed)
    expressions, unknowns = blocks(rng)
    Z = [x + x.T for x in (rationals(rng, *g.shape) for g in expressions)]
    assert adjoint(expressions, unknowns, Z).tolist() == by_units(
        expressions, unknowns, Z
    )
    for g in expressions:
        for i, j in ((0, 0), (1, 0), (0, 2)):
            unit = exact(np.zeros(g.shape))
            unit[i, j] = unit[j, i] = fmpq(1)
            assert slope(g, unknowns, i, j).tolist() == by_units([g], unknowns, [unit])


def test_balls_give_balls_that_hold_the_rationals():
    rng = np.random.default_rng(7)
    expressions, unknowns = blocks(rng)
    Z = [x + x.T for x in (rationals(rng, *g.shape) for g in expressions)]
    wide = [np.array(z) * arb(1, 1e-9) for z in Z]
    true = adjoint(expressions, unknowns, Z)
    found = adjoint(expressions, unknowns, wide)
    assert all(f.contains(t) and f.rad() < 1 for f, t in zip(found, true))
    assert any(f.rad() > 0 for f in found)


def test_floats_are_refused():
    P = Unknown("P", 2, symmetric=True)
    for expression, Z in ((P / 3, exact(np.eye(2))), (P, np.eye(2))):
        with pytest.raises(TypeError, match="a float is no exact number"):
            adjoint([expression], [P], [Z])
