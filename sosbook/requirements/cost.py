"""The quadratic cost of a loop that is driven by white noise."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from ..analysis.linear import loop_matrix
from ..lmi.exact import exact, inverse
from ..plants.checks import matrix, positive

__all__ = ["QuadraticCost", "noise_cost", "noise_input"]


@dataclass(frozen=True, eq=False)
class QuadraticCost:
    r"""The mean of :math:`x^\top Q x + u^\top R u` under white noise (2.33).

    Parameters
    ----------
    Q : (N, N) array_like
        Weight of the state [z; z'; x3], symmetric, not negative.
    R : (m, m) array_like
        Weight of the input, symmetric and positive definite.
    noise : {"F", "states"}
        Where the noise enters, one white noise of intensity one each: on
        the plant's disturbance channels F, or on every state. With
        "states" the cost is tr X for the solution X of the Riccati
        equation.
    bound : float, optional
        A requirement: the cost stays below it. None where it is to be
        minimised.
    """

    Q: np.ndarray
    R: np.ndarray
    noise: str = "states"
    bound: float = None

    def __post_init__(self):
        put = object.__setattr__
        for name in ("Q", "R"):
            value = matrix(name, getattr(self, name))
            if value.shape[0] != value.shape[1] or not np.allclose(
                value, value.T, rtol=1e-12, atol=0
            ):
                raise ValueError(f"{name} must be symmetric")
            put(self, name, value)
        if np.linalg.eigvalsh(self.Q)[0] < -1e-12 * np.abs(self.Q).max():
            raise ValueError("Q has a negative eigenvalue")
        if np.linalg.eigvalsh(self.R)[0] <= 0:
            raise ValueError("R must be positive definite")
        if self.noise not in ("F", "states"):
            raise ValueError(
                f'noise must be "F" or "states", got {self.noise!r}')
        if self.bound is not None:
            put(self, "bound", positive("bound", self.bound))

    def factors(self):
        """Rationals L, W with Q = L W^-1 L', W diagonal, and R^-1."""
        rest, columns, sizes = exact(self.Q), [], []
        for k in range(len(rest)):
            pivot = rest[k, k]
            if pivot > 0:
                column = rest[:, k:k + 1] / pivot
                rest = rest - pivot * (column @ column.T)
                columns.append(column)
                sizes.append(1 / pivot)
        L = np.hstack(columns) if columns else rest[:, :0]
        W = exact(np.zeros((len(sizes), len(sizes))))
        W[range(len(sizes)), range(len(sizes))] = sizes
        return L, W, inverse(exact(self.R))


def noise_input(d, cost):
    """Where the noise enters x' of a `Descriptor`, (N, q)."""
    if cost.noise == "states":
        return np.eye(len(d.E))
    return np.linalg.solve(d.E, d.Bw)


def noise_cost(d, K, cost):
    """The true cost of one vertex; infinite for an unstable loop.

    Parameters
    ----------
    d : Descriptor
    K : (m, N) array
    cost : QuadraticCost

    Notes
    -----
    Source: thesis (2.30), (2.31), with W = I.
    """
    A = loop_matrix(d, K)
    if np.linalg.eigvals(A).real.max() >= 0:
        return np.inf
    X = solve_continuous_lyapunov(A.T, -(cost.Q + K.T @ cost.R @ K))
    push = noise_input(d, cost)
    return float(np.trace(push.T @ X @ push))
