"""Matrix-affine expressions against plain numpy."""

import cvxpy
import numpy as np
import pytest

from sosbook.lmi import Affine, Unknown, block, eye, he

rng = np.random.default_rng(1)


@pytest.mark.parametrize("transposed", [False, True])
def test_value_of_a_sum_of_products(transposed):
    X, Y = Unknown("X", 3, symmetric=True), Unknown("Y", 2, 3)
    L, R, C = (rng.standard_normal(s) for s in [(2, 3), (3, 4), (2, 4)])
    x, y = he(rng.standard_normal((3, 3))), rng.standard_normal((2, 3))
    found = 2 * (L @ X @ R) - Y @ R / 4 + C
    wanted = 2 * (L @ x @ R) - y @ R / 4 + C
    if transposed:
        found, wanted = found.T, wanted.T
    assert found.shape == wanted.shape
    assert np.allclose(found.value({X: x, Y: y}), wanted, atol=1e-14)


@pytest.mark.parametrize("symmetric", [False, True])
@pytest.mark.parametrize("transposed", [False, True])
def test_jacobian_is_the_difference_quotient(symmetric, transposed):
    X = Unknown("X", 3, symmetric=symmetric)
    L, R = rng.standard_normal((2, 3)), rng.standard_normal((3, 4))
    g = L @ (X.T if transposed else X) @ R + np.ones((2, 4))
    at, step = rng.standard_normal(X.size), 0.5
    for k, slope in enumerate(g.jacobian(X)):
        moved = at + step * np.eye(X.size)[k]
        change = g.value({X: X.unpack(moved)}) - g.value({X: X.unpack(at)})
        assert np.allclose(change, step * slope, atol=1e-13)


@pytest.mark.parametrize("symmetric", [False, True])
def test_pack_undoes_unpack(symmetric):
    X = Unknown("X", 4, symmetric=symmetric)
    entries = rng.standard_normal(X.size)
    assert np.array_equal(X.pack(X.unpack(entries)), entries)
    assert np.array_equal(X.unpack(entries).T, X.unpack(entries)) == symmetric


def test_block_fills_zeros_in_every_arithmetic():
    Y, y = Unknown("Y", 2, 3), rng.standard_normal((2, 3))
    wanted = np.zeros((6, 6))
    wanted[:3, :3], wanted[3:5, :3], wanted[5:, 3:5] = np.eye(3), y, 7
    seven = np.full((1, 2), 7)

    def layout(x):
        return block(
            [[eye(3), np.zeros((3, 2)), np.zeros((3, 1))], [x, 0, 0], [0, seven, 0]]
        )

    variable = cvxpy.Variable((2, 3))
    variable.value = y
    assert np.array_equal(layout(y), wanted)
    assert np.array_equal(layout(Y).value({Y: y}), wanted)
    assert np.array_equal(layout(variable).value, wanted)


def test_a_one_by_one_unknown_scales_a_matrix():
    g = Unknown("g", 1)
    matrix = rng.standard_normal((3, 2))
    assert np.allclose((g * matrix).value({g: np.array([[2.5]])}), 2.5 * matrix)


def test_sizes_that_do_not_fit_are_refused():
    X, Y = Unknown("X", 2), Unknown("Y", 3)
    with pytest.raises(ValueError, match="don't add up"):
        X + Y
    with pytest.raises(ValueError, match="don't fit"):
        block([[X, Y], [Y, X]])
    with pytest.raises(ValueError, match="don't fit"):
        block([[X, 0], [0, 0]])
    with pytest.raises(ValueError, match="symmetric but not square"):
        Unknown("Z", 2, 3, symmetric=True)
    for shape in ((2, 6), 2.0, -1, "2"):
        with pytest.raises(ValueError, match=r'as in Unknown\("Y", 2, 6\)'):
            Unknown("Y", shape)
    with pytest.raises(ValueError, match="1 x 1"):
        X * np.ones((2, 2))


def test_products_of_unknowns_are_refused():
    X = Unknown("X", 2)
    for product in (lambda: X @ X, lambda: X * X):
        with pytest.raises(TypeError, match="isn't affine"):
            product()


def test_numpy_leaves_operators_to_affine():
    X = Unknown("X", 2)
    for g in (np.ones((2, 2)) + X, np.ones((2, 2)) - X, np.ones((2, 2)) @ X):
        assert isinstance(g, Affine)
    found = (np.ones((2, 2)) - X).value({X: np.eye(2)})
    assert np.array_equal(found, np.ones((2, 2)) - np.eye(2))
