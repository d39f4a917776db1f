"""Inverses of triangular matrices, against LAPACK's of one at a time."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.linalg import solve_triangular

from sosbook.solver.triangular import inverse_of_lower


@given(st.integers(1, 50), st.integers(0, 6), st.booleans(), st.integers(0, 2**32 - 1))
def test_inverses_are_those_of_one_at_a_time(q, count, imaginary, seed):
    rng = np.random.default_rng(seed)
    X = rng.normal(size=(count, q, q + 2))
    if imaginary:
        X = X + 1j * rng.normal(size=X.shape)
    L = np.linalg.cholesky(X @ X.conj().swapaxes(1, 2) + np.eye(q))
    found = inverse_of_lower(L)
    assert found.dtype == L.dtype and found.shape == L.shape
    for one, inverse in zip(L, found, strict=True):
        exact = solve_triangular(one, np.eye(q), lower=True)
        assert_allclose(inverse, exact, rtol=0, atol=1e-12 * np.abs(exact).max())
