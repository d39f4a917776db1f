"""The least H-infinity norm that any gain leaves, from second-order matrices."""

import numpy as np
from scipy.linalg import eigvals, null_space


def least_norm(M, D, S, B, F):
    """A lower bound: N' B = 0 gives N' (S + j w D - w^2 M) z = N' F in every loop."""
    N = null_space(B.T).T
    if not len(N):
        return 0.0
    rates = np.sqrt(np.abs(eigvals(S, M)))
    rates = rates[np.isfinite(rates) & (rates > 0)]  # M may be singular, and S
    rates = rates if len(rates) else np.ones(1)
    w = np.r_[0, np.geomspace(rates.min() / 30, rates.max() * 30, 2000)][:, None, None]
    left = np.linalg.pinv(N @ (S + 1j * w * D - w**2 * M)) @ N @ F
    return np.linalg.norm(left, 2, axis=(1, 2)).max()
