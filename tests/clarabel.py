"""Blocks solved by Clarabel, which shares nothing with the package's solver."""

import clarabel
import numpy as np
from scipy import sparse


class Explicit:
    """Blocks G_k(x) = G_k0 + sum_a x_a G_ka by their ``constants`` and ``slopes``."""

    def __init__(self, constants, slopes):
        self.constants, self.slopes = list(constants), list(slopes)
        self.variables = len(self.slopes[0])

    def __call__(self, x):
        return [c + np.tensordot(x, s, 1) for c, s in zip(self.constants, self.slopes)]


def minimize(blocks, cost):
    """Clarabel's last point for min cost.x over G_k(x) >= 0, and its verdict."""
    cones, rows, constants = [], [], []
    for c, s in zip(blocks.constants, blocks.slopes):
        # upper triangle column by column, off-diagonal times sqrt 2
        j, i = np.tril_indices(len(c))
        weight = np.where(i == j, 1.0, np.sqrt(2.0))
        rows.append(-(s[:, i, j] * weight).T)
        constants.append(c[i, j] * weight)
        cones.append(clarabel.PSDTriangleConeT(len(c)))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    k = blocks.variables
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix((k, k)),
        np.asarray(cost, float),
        sparse.csc_matrix(np.vstack(rows)),
        np.concatenate(constants),
        cones,
        settings,
    ).solve()
    return np.array(solution.x), str(solution.status)


def deepest(blocks):
    """x, the largest t <= 1 with G_k(x) >= t I, and Clarabel's verdict."""
    lifted = Explicit(
        [*blocks.constants, np.eye(1)],
        [
            np.concatenate([s, -np.eye(s.shape[1])[None]])
            for s in [*blocks.slopes, np.zeros((blocks.variables, 1, 1))]
        ],
    )
    x, status = minimize(lifted, np.append(np.zeros(blocks.variables), -1.0))
    return x[:-1], x[-1], status
