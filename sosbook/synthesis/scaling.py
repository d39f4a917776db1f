"""Coordinates in which the LMIs of a request are well conditioned."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import (
    cholesky,
    matrix_balance,
    solve_continuous_are,
    solve_continuous_lyapunov,
)

from ..lmi.exact import round_digits
from ..plants.descriptor_system import DescriptorSystem

__all__ = ["Frame", "typical_rate"]


@dataclass(frozen=True, eq=False)
class Frame:
    """Coordinates x = T xi, u = scale v in which the LMIs are solved.

    The blocks only undergo congruences: neither the feasible set nor
    its centre depends on the frame, only the accuracy does. Entries
    are rounded to six digits, which keeps exact arithmetic short.
    `gain` is that of the Riccati equation, v = gain xi.
    """

    left: np.ndarray
    T: np.ndarray
    back: np.ndarray
    scale: float
    gain: np.ndarray = None

    @classmethod
    def of(cls, request):
        """From the Riccati equation of the mean vertex."""
        mean = _typical(request)
        A, B, Bw = mean.state_space()
        omega = typical_rate(request)
        for r in request.requirements:
            if r.riccati() is not None:
                return cls._of_riccati(request, A, B, *r.riccati())
        if request.plant.m == 0:
            return cls._of_loop(request, A)
        weight = _energy(request, omega)
        effort = (B.T * weight) @ B / omega**2
        effort = np.diag(np.where(np.diag(effort) > 0, np.diag(effort), 1))
        try:
            shift = A + 0.1 * omega * np.eye(len(A))
            X = solve_continuous_are(
                shift / omega, B / omega, np.diag(weight), effort
            )
            T = np.linalg.inv(cholesky(X, lower=True)).T
            gain = -np.linalg.solve(effort, B.T @ X) / omega
        except (np.linalg.LinAlgError, ValueError):  # no such solution
            T, gain = np.diag(1 / np.sqrt(weight)), None
        size = max(
            (r.reach(T, Bw, omega) for r in request.requirements), default=0.0)
        T = T * np.sqrt(size or 1.0)
        push = np.linalg.solve(mean.E @ T, mean.Bu)
        scale = omega / (np.linalg.norm(push, 2) or 1.0)
        gain = None if gain is None else gain @ T / scale
        return cls.at(request, T, scale, gain)

    @classmethod
    def _of_riccati(cls, request, A, B, Q, R):
        """From the equation that a requirement is about: P is near I."""
        try:
            X = solve_continuous_are(A, B, Q, R)
            T = np.linalg.inv(cholesky(X, lower=True)).T
        except np.linalg.LinAlgError:  # a mode that no weight sees
            return cls.at(request, np.eye(len(A)), 1.0)
        gain = -np.linalg.solve(R, B.T @ X)
        scale = np.linalg.norm(gain @ T, 2) or 1.0
        return cls.at(request, T, scale, gain @ T / scale)

    @classmethod
    def _of_loop(cls, request, A):
        """From Lyapunov's equation of the loop, a little faster."""
        rates = np.linalg.eigvals(A).real
        shift = A - min(0.9 * rates.max(), 0.0) * np.eye(len(A))
        try:
            balance = matrix_balance(shift, separate=True)[1][0]
            weight = 1 / balance**2
            X = solve_continuous_lyapunov(shift.T, -np.diag(weight))
            T = np.linalg.inv(cholesky(X, lower=True)).T
        except np.linalg.LinAlgError:
            T = np.eye(len(A))
        return cls.at(request, T, 1.0)

    @classmethod
    def at(cls, request, T, scale, gain=None):
        """With given coordinates of x and u."""
        T = round_digits(T, 6)
        left = np.linalg.inv(request.mean.E @ T)
        return cls(
            round_digits(left, 6), T, round_digits(np.linalg.inv(T), 6),
            float(round_digits(scale, 6)), gain,
        )

    def guess(self, unknowns):
        """Variables to start from: P = I and Y = gain; None for others."""
        values = {"P": np.eye(len(self.T)), "Y": self.gain}
        if self.gain is None or {u.name for u in unknowns} - values.keys():
            return None
        return np.concatenate([u.pack(values[u.name]) for u in unknowns])


def _typical(request):
    """The mean vertex; the first one where the mean has hardly an input."""
    mean, vertices = request.mean, request.vertices
    most = max(np.linalg.norm(d.Bu) for d in vertices)
    return mean if np.linalg.norm(mean.Bu) > 0.1 * most else vertices[0]


def typical_rate(request):
    """A typical angular frequency of the closed loop, in rad/s."""
    rates = [r.rate() for r in request.requirements]
    rates = [rate for rate in rates if rate is not None]
    if rates:
        return min(rates, key=lambda rate: rate[0])[1]
    A, _, _ = request.mean.state_space()
    return np.abs(np.linalg.eigvals(A)).max() or 1.0


def _energy(request, omega):
    """Diagonal weights of x that have the unit of energy."""
    if isinstance(request.plant, DescriptorSystem):
        return np.ones(request.order)
    plants = request.plant.vertices
    n = plants[0].n
    d = request.vertices[0]
    inertia = sum(
        np.abs(v.M) + np.abs(v.D) / omega + np.abs(v.S) / omega**2
        for v in plants
    ).diagonal() / len(plants)
    inertia = np.where(inertia > 0, inertia, 1.0)
    U = d.A[2 * n:, :n]  # x3 is of the size of U z / omega
    return np.concatenate(
        [omega**2 * inertia, inertia, omega**4 / (U**2 @ (1 / inertia))]
    )
