"""Exact arithmetic of proofs against definitions that are slower."""

import numpy as np
import pytest
from flint import arb, fmpq, fmpq_mat

from sosbook.exact.adjoint import adjoint, slopes_at
from sosbook.exact.checker.arithmetic import Refused, number
from sosbook.exact.definite import definite, exact, pivots, positive, semidefinite
from sosbook.exact.integers import Swift
from sosbook.exact.rational import exact_margin, inverse, log2, rational_matrix
from sosbook.language import Unknown, block, he
from tests.cases import campaign, seeds


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


@pytest.mark.parametrize("seed", seeds(6))
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


def long_rationals(rng, q, digits=150):
    """A rational matrix with q rows; each entry has its own denominator."""
    numbers = [[int(e) for e in rng.integers(1, 2**62, 9)] for _ in range(2 * q * q)]
    large = [sum(e << 62 * k for k, e in enumerate(row)) for row in numbers]
    entries = np.empty((q, q), object)
    entries.flat = [fmpq(a, b) for a, b in zip(large[::2], large[1::2])]
    assert len(str(entries[0, 0])) > digits
    return entries.view(type(exact(np.eye(1))))


@pytest.mark.parametrize("q", [1, 6, *campaign([2, 26])])
@pytest.mark.parametrize("above", [1, 0, -1])
@pytest.mark.parametrize("exponent", [6, 60])
def test_the_sign_of_a_matrix_with_long_entries(q, above, exponent):
    """D (1/e 1' + s e I) D differs from a singular matrix by very little."""
    rng = np.random.default_rng(q)
    D = np.diag(long_rationals(rng, q).diagonal()).view(type(exact(np.eye(1))))
    ones, tiny = exact(np.ones((q, q))), above * fmpq(1, 10**exponent)
    x = D @ (ones + tiny * exact(np.eye(q))) @ D
    at_one = q == 1  # a matrix of one entry is positive without more
    assert positive(x) is (above > 0 or at_one)
    assert semidefinite(x) is (above >= 0 or at_one)
    if q <= 6:
        assert definite(x)[0] is positive(x)


@pytest.mark.parametrize("seed", seeds(6))
def test_singular_matrices_with_long_entries(seed):
    """W Z W' with Z > 0 is semidefinite; less a little along v, it isn't."""
    rng = np.random.default_rng(seed)
    q, rank = 7, int(rng.integers(1, 7))
    W, root = rationals(rng, q, rank), long_rationals(rng, rank)
    x = W @ root @ root.T @ W.T
    order = rng.permutation(q)
    x = x[np.ix_(order, order)]
    v = rationals(rng, q, 1)
    assert semidefinite(x)
    assert not positive(x)
    assert semidefinite(x + fmpq(1, 10**80) * (v @ v.T))
    assert not semidefinite(x - fmpq(1, 10**80) * (v @ v.T))
    assert not semidefinite(-x)


def test_a_matrix_without_an_entry_that_matters():
    zero = exact(np.zeros((3, 3)))
    assert semidefinite(zero)
    assert not positive(zero)
    zero[0, 1] = zero[1, 0] = fmpq(1)
    assert not semidefinite(zero)


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


@pytest.mark.parametrize("seed", seeds(4))
def test_derivatives_are_differences(seed):
    rng = np.random.default_rng(seed)
    expressions, unknowns = blocks(rng)
    Z = [x + x.T for x in (rationals(rng, *g.shape) for g in expressions)]
    assert adjoint(expressions, unknowns, Z).tolist() == by_units(
        expressions, unknowns, Z
    )
    for g in expressions:
        entries = (0, 0), (1, 0), (0, 2)
        for (i, j), slope in zip(entries, slopes_at(g, unknowns, entries), strict=True):
            unit = exact(np.zeros(g.shape))
            unit[i, j] = unit[j, i] = fmpq(1)
            assert slope.tolist() == by_units([g], unknowns, [unit])


def test_balls_give_balls_that_hold_the_rationals():
    rng = np.random.default_rng(7)
    expressions, unknowns = blocks(rng)
    Z = [x + x.T for x in (rationals(rng, *g.shape) for g in expressions)]
    wide = [np.array(z) * arb(1, 1e-9) for z in Z]
    true = adjoint(expressions, unknowns, Z)
    found = adjoint(expressions, unknowns, wide)
    assert all(f.contains(t) and f.rad() < 1 for f, t in zip(found, true))
    assert any(f.rad() > 0 for f in found)


def test_slopes_hold_what_a_ball_around_zero_may_be():
    P, around_zero = Unknown("P", 1), np.array([[arb(0, 1e-9)]], object)
    ((slope,),) = slopes_at(he(around_zero @ P), [P], [(0, 0)])
    assert slope.contains(1.9e-9) and slope.contains(-1.9e-9)


def test_floats_are_refused():
    P = Unknown("P", 2, symmetric=True)
    for expression, Z in ((P / 3, exact(np.eye(2))), (P, np.eye(2))):
        with pytest.raises(TypeError, match="a float is no exact number"):
            adjoint([expression], [P], [Z])


@pytest.mark.parametrize("seed", seeds(8))
def test_a_margin_below_rounding_is_that_of_the_rational_inverse(seed):
    rng = np.random.default_rng(seed)
    q = int(rng.integers(1, 9))
    L = exact(np.tril(rng.integers(-9, 10, (q, q)), -1) + np.eye(q))
    small = fmpq(1, 10 ** int(rng.integers(0, 40)))
    last = [fmpq(1)] * (q - 1) + [small]
    g = (
        L
        @ rational_matrix(
            [[e * (i == k) for k in range(q)] for i, e in enumerate(last)]
        )
        @ L.T
    )
    unit = fmpq(10) ** int(rng.integers(-200, 200))
    d = [2.0 ** round(log2(e) / 2) for e in np.diagonal(g)]
    rows = [[float(e) * a * b for e, b in zip(row, d)] for row, a in zip(inverse(g), d)]
    wanted = 1 / np.linalg.eigvalsh(rows)[-1]
    assert exact_margin(g) == pytest.approx(wanted, rel=1e-9)
    # in another unit the diagonal is scaled to one by another power of four
    assert wanted / 4.1 <= exact_margin(unit * g) <= 4.1 * wanted


@pytest.mark.parametrize("digits", [5, 15, 50, 290])
def test_a_margin_may_be_as_small_as_a_float(digits):
    near = 1 - fmpq(1, 10**digits)
    g = rational_matrix([[fmpq(1), near], [near, fmpq(1)]])
    assert exact_margin(g) == pytest.approx(10.0**-digits, rel=1e-9)


@pytest.mark.parametrize(
    "text", ["-" + 9 * "0" + 300 * "37" + "/0" + 450 * "111", 401 * "7" + "/7", "1/0"]
)
def test_long_fractions_are_read_as_the_checker_reads_them(text):
    try:
        true = number(text)
    except Refused as refused:
        with pytest.raises(Refused, match=str(refused)):
            Swift.read([[text]])
    else:
        assert Swift.read([[text]]).at(0, 0) == true
