"""Procedure 2.5: an observer for a known state feedback."""

from collections.abc import Sequence
from dataclasses import replace
from time import monotonic

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cholesky

from ..analysis.linear import balancing
from ..analysis.lyapunov import lyapunov
from ..analysis.riccati import riccati
from ..exact.definite import inverse, round_digits
from ..exact.rational import decimal, decimals, read_array, read_number
from ..language import Unknown, block
from ..lmi.trusted import TrustedProblem
from ..plants.checks import inverse_by_rows, matrices_of, matrix
from ..plants.descriptor import mean_descriptor, twins
from ..plants.kinds import Plant
from ..plants.records import plant_data, read_plant
from ..runtime.threads import one_thread
from ..runtime.time_limit import OutOfTime, checked_seconds
from ..runtime.time_limit import time_limit as limited
from ..solver.centre import Unbounded
from ..theorems import observer_cost, observer_decay
from ..theorems.lqr import trace_bound
from .error_loop import error_loop, vertices_of
from .observer_design import ObserverDesign
from .pid import TIME_LIMIT
from .riccati_point import riccati_observer

__all__ = ["design_observer"]

REFUSED = (
    "Exact multipliers of the LMIs exclude every observer with this K by Theorem 2.5; "
    "others may do."
)
REFUSED_IN_FLOATS = (
    "Multipliers in floating point exclude every observer with this K by Theorem 2.5; "
    "no exact proof was found. Others may do."
)
NOTHING_FOUND = (
    "The numerics found neither an observer with this K by Theorem 2.5 nor multipliers "
    "that exclude it."
)
TOO_THIN = (
    "The numerics found an observer whose margins are below what floats can tell from "
    "zero."
)
OPTIMUM_GAP = 1e-8  # relative, to which the optimum is known
BOUND_BACKOFF = 1e-4  # a fraction: the proven bound exceeds the optimum by this


@one_thread
def design_observer(
    plant: Plant,
    K: ArrayLike,
    Q_F: ArrayLike,
    R_F: ArrayLike,
    *,
    C: ArrayLike | None = None,
    B_w: ArrayLike | Sequence[ArrayLike] | None = None,
    time_limit: float = TIME_LIMIT,
) -> ObserverDesign:
    """Design an observer for a known state feedback (Theorem 2.5).

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
        Without integrators: an integral is a state of a DescriptorSystem, and
        measured.
    K : (m, N) array_like
        The gain of u = K x.
    Q_F : (2N, k) array_like
        Q = Q_F Q_F' weighs the dual state; its upper half is where
        noise enters the estimate.
    R_F : (q, q) array_like
        R = R_F R_F': covariance of the measurement noise.
    C : (q, N) array_like, optional
        What is measured; the plant's own C without it.
    B_w : (N, p) array_like, or one for each vertex, optional
        Where the noise of the cost (2.44) enters; the plant's own without it, or E
        where the plant has none: then tr J bounds the sum of the variances of the
        error. Of one plant L doesn't depend on it, only the bound does.
    time_limit : float
        Seconds after which the answer is "undecided".

    Returns
    -------
    ObserverDesign
        The observer's gain, and what is known of its loop.

    Raises
    ------
    ValueError
        On bad input.

    Notes
    -----
    Source: thesis (2.43)-(2.45), Procedure 2.5. With Q_F and R_F as
    section 4.3.2 uses them (it prints them under each other's name).
    The theorem divides by E, so neither its vertices nor their pairs
    say anything about the plants between: see `ObserverDesign.analyse`.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem, design_lqr
    >>> plant = SecondOrderSystem([[1]], [[0.1]], [[-1]], [[1]], [[1]])
    >>> K = design_lqr(plant, np.eye(2), [[1]]).K
    >>> observer = design_observer(
    ...     plant, K, Q_F=[[0], [1], [0], [0]], R_F=[[0.1]])
    >>> observer.status, observer.analyse().certify().proven
    ('feasible', True)
    """
    vertices = vertices_of(plant)
    N = len(vertices[0].E)
    C = matrix("C", vertices[0].C if C is None else C, (None, N))
    K = matrix("K", K, (vertices[0].Bu.shape[1], None))
    if K.shape[1] != N:
        raise ValueError(
            f"K has {K.shape[1]} columns, needs {N}: here are no integrators; put the "
            "integral into the matrices of a DescriptorSystem, and measure it (a row "
            "of C)"
        )
    Q_F = matrix("Q_F", Q_F, (2 * N, None))
    if len(C) == 0:
        raise ValueError("C is missing: the plant has no outputs, so say what is seen")
    R_F = matrix("R_F", R_F, (len(C), len(C)))
    if B_w is None:
        own = any(d.Bw.any() for d in vertices)
        noises = [d.Bw if own else d.E for d in vertices]
    else:
        noises = [matrix("B_w", w, (N, None)) for w in matrices_of("B_w", B_w)]
        if len(noises) not in (1, len(vertices)):
            raise ValueError(
                f"B_w has {len(noises)} matrices, needs {len(vertices)} or one"
            )
        noises *= len(vertices) // len(noises)
        if not any(w.any() for w in noises):
            raise ValueError("B_w is zero or has no column: leave it out")
    seconds, begun = checked_seconds(time_limit, needed=True), monotonic()
    try:
        with limited(seconds):
            problem = ObserverProblem(plant, vertices, K, Q_F, R_F, C, noises)
            return problem.solve(plant)
    except OutOfTime as over:
        if over.end < begun + seconds:  # somebody else's limit
            raise
        reason = over.words(seconds)
    except (Unbounded, ArithmeticError, np.linalg.LinAlgError) as error:
        reason = f"The numerics gave up ({error}): are the units far apart?"
    return ObserverDesign(plant, K, C, "undecided", reason=reason)


def _bound(least):
    return float(f"{least * (1 + BOUND_BACKOFF):.5e}")


class ObserverProblem:
    """Theorem 2.5 in coordinates near those of its solution.

    The dual state is T xi with T = diag(T1, T2), rounded to six digits
    and read as exact.
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
        if np.linalg.matrix_rank(R_F) < len(R_F):
            raise ValueError("R_F must be regular: each output has noise")
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

    @classmethod
    def read(cls, data):
        """The problem of `data`, in the same coordinates."""
        problem = object.__new__(cls)
        problem.plant = read_plant(data["plant"])
        problem.vertices = vertices_of(problem.plant)
        N = len(problem.vertices[0].E)
        for name in ("K", "C", "Q_F", "R_F"):
            setattr(problem, name, read_array(data[name], None, None))
        problem.noises = [read_array(w, N, None) for w in data["noises"]]
        there = data["coordinates"]
        problem.T = [read_array(x, N, N) for x in there["T"]]
        problem.left = read_array(there["left"], N, N)
        problem.unit = read_number(there["unit"])
        shapes = (problem.vertices[0].Bu.shape[1], N), (len(problem.C), N)
        if (problem.K.shape, problem.C.shape) != shapes or len(problem.T) != 2:
            raise ValueError("K, C or T has a wrong shape")
        if len(problem.noises) != len(problem.vertices) or len(problem.Q_F) != 2 * N:
            raise ValueError("noises or Q_F has a wrong length")
        return problem

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
        """All blocks, by name; with L given Y = L' P1 is put in."""
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

    def solve(self, plant):
        near = riccati_observer(self, _bound)
        if near is not None:
            design = self.certain(plant, *near)
            if design.status == "feasible":
                return design
        channels = self.noises[0].shape[1]
        optimum = self.open().minimize({"J": np.eye(channels)}, OPTIMUM_GAP)
        if optimum.values is None:
            refused = ObserverDesign(
                plant,
                self.K,
                self.C,
                "undecided",
                problem=self,
                multipliers=optimum.multipliers,
                reason=REFUSED_IN_FLOATS
                if optimum.verdict == "infeasible"
                else NOTHING_FOUND,
            )
            proof = refused.infeasibility
            if proof is not None and proof.proven:
                return replace(refused, status="infeasible", reason=REFUSED)
            return refused
        known = optimum.values
        T1 = self.T[0]
        L = np.linalg.solve(T1.T, np.linalg.solve(known["P1"], known["Y"].T))
        least = float(np.trace(known["J"])) * self.unit**2
        return self.certain(plant, L, _bound(least), known)

    def certain(self, plant, L, bound, near=None):
        """The design of this L, with P1, P2 and J for the bound, ``near`` these."""
        solution = self.bounded(L, bound).solve(start=near)
        if solution.values is None:
            reason = (
                f"The numerics found an observer, but no proof of tr J < {bound:g}."
            )
            return ObserverDesign(
                plant, self.K, self.C, "undecided", problem=self, reason=reason
            )
        return ObserverDesign(
            plant,
            self.K,
            self.C,
            solution.status,
            L,
            bound,
            solution.margins,
            solution.values,
            self,
            reason="" if solution.status == "feasible" else TOO_THIN,
        )

    def open(self):
        """The `LMIProblem` with L to be found and no bound of tr J."""
        return TrustedProblem(self.blocks, self.unknowns())

    def of_mean(self):
        """The same for the mean plant alone."""
        mean, noise = mean_descriptor(self.vertices), sum(self.noises)
        return ObserverProblem(
            None,
            (mean,),
            self.K,
            self.Q_F,
            self.R_F,
            self.C,
            [noise / len(self.noises)],
        )

    def bounded(self, L, bound):
        """The `LMIProblem` of this L and a bound of tr J."""
        return TrustedProblem(
            lambda values, number: self.blocks(values, number, L, bound),
            self.unknowns(L),
        )
