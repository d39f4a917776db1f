"""The LMIs of Theorem 2.5 for a plant, a state feedback and weights."""

from dataclasses import replace

import numpy as np
from scipy.linalg import cholesky

from ..analysis.linear import balancing
from ..analysis.riccati import lyapunov, riccati
from ..exact.definite import inverse, round_digits
from ..exact.rational import decimal, decimals
from ..language import Unknown, block
from ..lmi.problem import TrustedProblem
from ..plants.as_data import plant_data
from ..plants.checks import check_rank, inverse_by_rows
from ..plants.descriptor import mean_descriptor, twins
from ..theorems import observer_cost, observer_decay
from ..theorems.lqr import trace_bound
from .error_loop import error_loop

OPTIMUM_GAP = 1e-8  # relative, to which the optimum is known


class ObserverProblem:
    """Theorem 2.5 in coordinates near those of its solution.

    The dual state is T xi with T = diag(T1, T2), rounded to six digits
    and read as exact.

    ``plant``: as in `design_observer`, like K, Q_F, R_F and C; ``vertices``: the
    plant's; ``K``, ``Q_F``, ``R_F``, ``C``: the state feedback, the weights and what is
    measured; ``noises``, list of (N, p) arrays: B_w of each vertex. Raises ValueError
    if there is no observer of the mean plant.
    """

    def __init__(self, plant, vertices, K, Q_F, R_F, C, noises):
        self.plant, self.vertices, self.K, self.C = plant, vertices, K, C
        self.Q_F, self.R_F, self.noises = Q_F, R_F, noises
        mean = mean_descriptor(vertices)
        A, B, _ = mean.state_space()
        N = len(A)
        units = balancing(A + B @ K)  # x = units xi
        A, B = A / units[:, None] * units, B / units[:, None]
        K, C = K * units, C * units
        source = Q_F[:N] @ Q_F[:N].T / np.outer(units, units)
        small = 1e-6 * (np.trace(source) / N or 1.0) * np.eye(N)
        if np.linalg.eigvals(A + B @ K).real.max() >= 0:
            raise ValueError("K doesn't stabilise the mean plant: design it first")
        check_rank(R_F, "R_F must be regular: each output has noise")
        try:
            X = riccati(A.T, C.T, source + small, R_F @ R_F.T)
            errors = A - X @ C.T @ np.linalg.solve(R_F @ R_F.T, C)
            if not np.linalg.eigvals(errors).real.max() < 0:
                raise np.linalg.LinAlgError("the error doesn't decay")
        except np.linalg.LinAlgError:
            raise ValueError(
                "C doesn't see an unstable mode of the mean plant (or one "
                "on the imaginary axis): measure more, or take that state "
                "out"
            ) from None
        rest = lyapunov(A + B @ K, -X)
        self.T = [
            round_digits(np.linalg.inv(cholesky(x, lower=True)).T / units[:, None], 6)
            for x in (X, rest)
        ]
        self.left = round_digits(inverse_by_rows(mean.E @ self.T[0]), 6)
        self.unit = float(
            round_digits(max(np.linalg.norm(self.left @ w, 2) for w in noises), 2)
        )

    def data(self):
        """The plant and what was asked, as decimals."""
        return {
            "plant": plant_data(self.plant),
            **{
                name: decimals(getattr(self, name)) for name in ("K", "C", "Q_F", "R_F")
            },
            "noises": [decimals(w) for w in self.noises],
            "model": {
                name: decimals(getattr(mean_descriptor(self.vertices), name))
                for name in ("E", "A", "Bu")
            },
            "coordinates": {
                "T": [decimals(x) for x in self.T],
                "left": decimals(self.left),
                "unit": decimal(self.unit),
            },
        }

    def unknowns(self, L=None):
        """P1, P2, Y (left out where L is given) and J."""
        N = len(self.T[0])
        unknowns = [
            Unknown("P1", N, symmetric=True),
            Unknown("P2", N, symmetric=True),
            Unknown("Y", len(self.C), N),
            Unknown("J", self.noises[0].shape[1], symmetric=True),
        ]
        return unknowns if L is None else [*unknowns[:2], unknowns[3]]

    def blocks(self, values, number=lambda x: x, L=None, bound=None):
        """All blocks, by name.

        ``values``: the unknowns by name: matrices, or expressions; ``number``: turns
        the arrays of the problem into the numbers of ``values``; ``L``, (N, q): Y = L'
        P1 is put in; ``bound``: of tr J. Returns dict: from a block's name to what must
        be positive definite.
        """
        T1, T2 = map(number, self.T)
        T = block([[T1, 0], [0, T2]])
        back, back1 = inverse(T).T, inverse(T1).T
        left, unit = number(self.left), number(np.array(self.unit)).item()
        C, Q_F, R_F = number(self.C) @ back1, number(self.Q_F), self.R_F
        P1, P2, J = (values[name] for name in ("P1", "P2", "J"))
        Y = values["Y"] if L is None else (number(L).T @ T1) @ P1
        blocks = {"P1": P1, "P2": P2}
        if bound is not None:
            limit = number(np.array(bound)).item() / unit**2
            blocks["trace"] = trace_bound(J, limit)
        mean = mean_descriptor(self.vertices).map(number)
        gain = number(self.K)
        noisy = [replace(d, Bw=w) for d, w in zip(self.vertices, self.noises)]
        for k in sorted(set(twins(noisy))):  # repetitions count once
            i, noise = k + 1, self.noises[k]
            d = self.vertices[k].map(number)
            E, A = error_loop(d, mean, gain)
            loop = T.T @ (inverse(E) @ A) @ back
            blocks[f"decay {i}"] = observer_decay(
                loop, C, P1, P2, Y, T.T @ Q_F, number(R_F)
            )
            blocks[f"cost {i}"] = observer_cost(
                left @ d.E @ T1, left @ number(noise) / unit, P1, J
            )
        return blocks

    def open(self):
        """The `LMIProblem` with L to be found and no bound of tr J."""
        return TrustedProblem(self.blocks, self.unknowns())

    def optimum(self):
        """The `LMISolution` of least tr J."""
        channels = self.noises[0].shape[1]
        return self.open().minimize({"J": np.eye(channels)}, OPTIMUM_GAP)

    def bounded(self, L, bound):
        """The `LMIProblem` of this L and a bound of tr J."""
        return TrustedProblem(
            lambda values, number: self.blocks(values, number, L, bound),
            self.unknowns(L),
        )
