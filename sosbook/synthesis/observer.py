"""Procedure 2.5: an observer for a known state feedback."""

from dataclasses import dataclass, field

import control
import numpy as np
from scipy.linalg import (
    cholesky,
    solve_continuous_are,
    solve_continuous_lyapunov,
)

from ..lmi import Unknown, block
from ..lmi.exact import inverse, round_digits
from ..lmi.problem import LMIProblem
from ..lmi.proof import Proof
from ..plants.checks import matrix
from ..plants.descriptor import descriptors, mean_descriptor
from ..plants.descriptor_system import DescriptorSystem
from ..theorems import observer_cost, observer_decay
from ..theorems.lqr import trace_bound
from .pid import analyse_loop

__all__ = [
    "ObserverCertificate",
    "ObserverDesign",
    "design_observer",
    "observer_loop",
]

GAP = 1e-8  # to which the optimum is known, relative
BACKOFF = 1e-4  # the proven bound exceeds the optimum by this


@dataclass(frozen=True, eq=False)
class ObserverCertificate(Proof):
    """An exact proof of Theorem 2.5 at the vertices, or its failure.

    Parameters
    ----------
    proven, claims, blocks, failed
        As in `Proof`.
    L : (N, q) array
        The gain that the proof is about: rounded to the printed digits.
    """

    L: np.ndarray


@dataclass(frozen=True, eq=False)
class ObserverDesign:
    """An observer and what is known about the loop with it.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
    K : (m, N) array
        The state feedback, u = K x^.
    C : (q, N) array
        What is measured.
    status : {"feasible", "infeasible", "undecided"}
        Of Theorem 2.5, which speaks of the vertices only.
    L : (N, q) array or None
        In E^ x^' = A^ x^ + B^ u + E^ L (C x^ - y): stabilising L are
        mostly negative.
    bound : float or None
        tr J, which bounds the cost of the error at the vertices.
    margins : dict or None
        From a block's name to its smallest eigenvalue, after scaling
        its diagonal to one.
    """

    plant: object
    K: np.ndarray
    C: np.ndarray
    status: str
    L: np.ndarray = None
    bound: float = None
    margins: dict = None
    values: dict = None
    problem: object = field(default=None, repr=False)

    def __repr__(self):
        bound = "" if self.bound is None else f", bound {self.bound:.4g}"
        return f"<ObserverDesign: {self.status}{bound}>"

    def loop(self):
        """E x' = A x of the error and the state, a `DescriptorSystem`."""
        if self.L is None:
            raise ValueError(f"the design is {self.status}: there is no L")
        return observer_loop(self.plant, self.K, self.L, self.C)

    def certify(self, digits=6):
        """Prove Theorem 2.5 at the vertices, in exact arithmetic.

        Parameters
        ----------
        digits : int
            L is rounded to so many significant digits first.

        Returns
        -------
        ObserverCertificate
        """
        if self.L is None:
            raise ValueError(f"the design is {self.status}: there is no L")
        L = round_digits(self.L, digits)
        claims = (
            "at each vertex (not between them) the loop with the observer "
            "is stable",
            f"tr J is at most {self.bound:.6g} there",
        )
        proof = self.problem.bounded(L, self.bound).prove(
            self.values, claims, places=(12,))
        return ObserverCertificate(**vars(proof), L=L)

    def analyse(self, **asked):
        """`analyse_loop` of the whole polytope, with K and L fixed.

        Theorem 2.5 says nothing between the vertices; this does.
        """
        loop = self.loop()
        return analyse_loop(loop.E, loop.A, **asked)

    def controller(self):
        """The controller from y to u as python-control's StateSpace."""
        if self.L is None:
            raise ValueError(f"the design is {self.status}: there is no L")
        d = mean_descriptor(_vertices(self.plant))
        A, B, _ = d.state_space()
        return control.ss(
            A + B @ self.K + self.L @ self.C, -self.L, self.K,
            np.zeros((len(self.K), len(self.C))))


def observer_loop(plant, K, L, C):
    """The loop with the observer: E x' = A x, x = [e; state] (2.40).

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
    K : (m, N), L : (N, q), C : (q, N) array_like

    Returns
    -------
    DescriptorSystem
        With a vertex for each of the plant's, e = x - x^. The
        observer's matrices are the means over the vertices.
    """
    vertices = _vertices(plant)
    N = len(vertices[0].E)
    C = matrix("C", C, (None, N))
    K = matrix("K", K, (vertices[0].Bu.shape[1], N))
    L = matrix("L", L, (N, len(C)))
    mean = mean_descriptor(vertices)
    loops = [error_loop(d, mean, K) for d in vertices]
    inject = np.zeros((2 * N, 2 * N))
    inject[:N, :N] = mean.E @ L @ C
    return DescriptorSystem(
        [E for E, _ in loops], [A + inject for _, A in loops])


def design_observer(plant, K, Q_F, R_F, C=None, B_w=None):
    """Design an observer for a known state feedback (Theorem 2.5).

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
        With the controller of `design_lqr` and no integrators.
    K : (m, N) array_like
    Q_F : (2N, k) array_like
        Q = Q_F Q_F' weighs the dual state; its upper half is where
        noise enters the estimate.
    R_F : (q, q) array_like
        R = R_F R_F': covariance of the measurement noise.
    C : (q, N) array_like, optional
        What is measured; the plant's own C without it.
    B_w : (N, p) array_like, or one for each vertex, optional
        Where the noise of the cost (2.44) enters; the plant's own
        without it.

    Returns
    -------
    ObserverDesign

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
    >>> found = design_observer(
    ...     plant, K, Q_F=[[0], [1], [0], [0]], R_F=[[0.1]])
    >>> found.status, found.analyse().certify().proven
    ('feasible', True)
    """
    vertices = _vertices(plant)
    N = len(vertices[0].E)
    C = matrix("C", vertices[0].C if C is None else C, (None, N))
    K = matrix("K", K, (vertices[0].Bu.shape[1], N))
    Q_F = matrix("Q_F", Q_F, (2 * N, None))
    R_F = matrix("R_F", R_F, (len(C), len(C)))
    if B_w is None:
        noises = [d.Bw for d in vertices]
    else:
        several = [B_w] * len(vertices) if np.ndim(B_w) == 2 else B_w
        noises = [matrix("B_w", b, (N, None)) for b in several]
    if noises[0].shape[1] == 0:
        raise ValueError("B_w is missing: the plant has no F")
    problem = _Problem(vertices, K, Q_F, R_F, C, noises)
    return problem.solve(plant)


def _vertices(plant):
    if isinstance(plant, DescriptorSystem):
        return plant.vertices
    return descriptors(plant)


def error_loop(d, mean, K):
    """E-bar and A-tilde of (2.40)."""
    off_B = mean.Bu - d.Bu
    E = block([[mean.E, d.E - mean.E], [0, d.E]])
    A = block([
        [mean.A + off_B @ K, d.A - mean.A - off_B @ K],
        [-d.Bu @ K, d.A + d.Bu @ K],
    ])
    return E, A


class _Problem:
    """Theorem 2.5 in coordinates near those of its solution.

    The dual state is T xi with T = diag(T1, T2), rounded to six digits
    and read as exact.
    """

    def __init__(self, vertices, K, Q_F, R_F, C, noises):
        self.vertices, self.K, self.C = vertices, K, C
        self.Q_F, self.R_F, self.noises = Q_F, R_F, noises
        mean = mean_descriptor(vertices)
        A, B, _ = mean.state_space()
        N = len(A)
        source = Q_F[:N] @ Q_F[:N].T
        small = 1e-6 * (np.trace(source) / N or 1.0) * np.eye(N)
        if np.linalg.eigvals(A + B @ K).real.max() >= 0:
            raise ValueError(
                "K doesn't stabilise the mean plant: design it first")
        if np.linalg.matrix_rank(R_F) < len(R_F):
            raise ValueError("R_F must be regular: each output has noise")
        try:
            X = solve_continuous_are(A.T, C.T, source + small, R_F @ R_F.T)
        except np.linalg.LinAlgError:
            raise ValueError(
                "C doesn't see an unstable mode of the mean plant (or one "
                "on the imaginary axis): measure more, or take that state "
                "out"
            ) from None
        rest = solve_continuous_lyapunov(A + B @ K, -X)
        self.T = [
            round_digits(np.linalg.inv(cholesky(x, lower=True)).T, 6)
            for x in (X, rest)
        ]
        self.left = round_digits(np.linalg.inv(mean.E @ self.T[0]), 6)
        self.unit = float(round_digits(max(
            np.linalg.norm(self.left @ w, 2) for w in noises), 2))

    def unknowns(self, L=None):
        """P1, P2, Y (left out where L is given) and J."""
        N = len(self.T[0])
        found = [
            Unknown("P1", N, symmetric=True),
            Unknown("P2", N, symmetric=True),
            Unknown("Y", len(self.C), N),
            Unknown("J", self.noises[0].shape[1], symmetric=True),
        ]
        return found if L is None else [*found[:2], found[3]]

    def blocks(self, values, number=lambda x: x, L=None, bound=None):
        """All blocks, by name; with L given Y = L' P1 is put in."""
        T1, T2 = map(number, self.T)
        N = len(T1)
        T = block([[T1, 0], [0, T2]])
        back, back1 = inverse(T).T, inverse(T1).T
        left, unit = number(self.left), number(np.array(self.unit)).item()
        C, Q_F, R_F = number(self.C) @ back1, number(self.Q_F), self.R_F
        P1, P2, J = (values[name] for name in ("P1", "P2", "J"))
        Y = values["Y"] if L is None else (number(L).T @ T1) @ P1
        found = {"P1": P1, "P2": P2}
        if bound is not None:
            limit = number(np.array(bound)).item() / unit**2
            found["trace"] = trace_bound(J, limit)
        mean = mean_descriptor(self.vertices).map(number)
        gain = number(self.K)
        for i, (vertex, noise) in enumerate(
            zip(self.vertices, self.noises), 1
        ):
            d = vertex.map(number)
            E, A = error_loop(d, mean, gain)
            loop = T.T @ (inverse(E) @ A) @ back
            found[f"decay {i}"] = observer_decay(
                loop, C, P1, P2, Y, T.T @ Q_F, number(R_F))
            found[f"cost {i}"] = observer_cost(
                left @ d.E @ T1, left @ number(noise) / unit, P1, J)
        return found

    def solve(self, plant):
        channels = self.noises[0].shape[1]
        found = LMIProblem(self.blocks, self.unknowns()).minimize(
            {"J": np.eye(channels)}, GAP)
        if found.values is None:
            return ObserverDesign(plant, self.K, self.C, found.status)
        known = found.values
        T1 = self.T[0]
        L = np.linalg.solve(
            T1.T, np.linalg.solve(known["P1"], known["Y"].T))
        least = float(np.trace(known["J"])) * self.unit**2
        bound = float(f"{least * (1 + BACKOFF):.5e}")
        return self.certain(plant, L, bound)

    def certain(self, plant, L, bound):
        """The design of this L, with P1, P2 and J for the bound."""
        found = self.bounded(L, bound).solve()
        if found.values is None:
            return ObserverDesign(plant, self.K, self.C, "undecided")
        return ObserverDesign(
            plant, self.K, self.C, found.status, L, bound, found.margins,
            found.values, self)

    def bounded(self, L, bound):
        """The `LMIProblem` of this L and a bound of tr J."""
        return LMIProblem(
            lambda values, number: self.blocks(values, number, L, bound),
            self.unknowns(L))
