"""The quadratic cost of a loop that is driven by white noise (Theorem 2.4)."""

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .. import analysis, theorems
from ..analysis.linear import gramian, unstable
from ..analysis.riccati import lyapunov
from ..exact.definite import definite, exact, inverse
from ..language import Unknown, eye, he
from ..plants.checks import is_word, matrix, numbers, positive
from ..plants.coupled import Coupled, SlackVertex
from ..plants.descriptor import Descriptor
from ..runtime.array_like import ArrayLike
from ..runtime.read_only import put
from .base import Requirement
from .known_gain import KnownVertex
from .posed import PosedLoop
from .vocabulary import COST, ONE_BY_ONE


@dataclass(frozen=True, eq=False)
class QuadraticCost(Requirement):
    r"""The mean of :math:`x^\top Q x + u^\top R u` under white noise (2.33).

    Parameters
    ----------
    Q : (s, s) array_like
        Weight of the state [z; z'; x3], symmetric and positive semidefinite. What
        roundings have spoilt is mended, to one part in 1e12: Q is symmetrised, and
        its diagonal is raised until Q is semidefinite as it is written in decimals.
        Proofs are about that matrix, ``cost.Q``.
    R : (m, m) array_like
        Weight of the input, symmetric and positive definite; [] for a loop
        without an input.
    noise : {"F", "states"}
        Where the noise enters, one white noise of intensity one each: on
        the plant's disturbance channels F, or on every state. With
        "states" the least cost of one plant is tr X for the stabilising
        solution X of the Riccati equation.
    bound : float, optional
        A requirement: the cost stays below it. None where it is to be
        minimised.
    C : (q, s) array_like, optional
        Weighs the output y = C x instead: Q = C' C, exactly. ``cost.Q`` is that
        matrix in floats then.
    N : (s, m) array_like, optional
        Weighs 2 x' N u, too. [Q N; N' R] is semidefinite, and mended as Q is.
    step : float, optional
        As in `Requirement`: a request sets it. Of a plant of discrete time the cost is
        the mean over the ticks.

    Raises
    ------
    ValueError
        If Q isn't semidefinite or R isn't definite, other than by rounding, or if
        not one of Q and C is given.

    Examples
    --------
    >>> QuadraticCost([[1, 2], [2, 4]], [[1]]).Q.tolist()
    [[1.0, 2.0], [2.0, 4.0]]
    >>> QuadraticCost(C=[[0.1, 0.3]], R=[[1]]).C.tolist()
    [[0.1, 0.3]]
    """

    Q: np.ndarray | None = None
    R: np.ndarray | None = None
    noise: str = "states"
    bound: float | None = None
    C: np.ndarray | None = None
    N: np.ndarray | None = None
    step: float | None = None

    kind = name = promise = "cost"
    parameter = COST
    implies_stability = affine_in_quotient = lossless = True
    rank = 30
    of_two = ONE_BY_ONE.format("requirements=[...]")
    titles = {
        "lqr": "decay of the cost",
        "cost": "noise's share of the cost",
        "trace": "bound of the cost",
    }

    if TYPE_CHECKING:  # what the constructor takes

        def __init__(
            self,
            Q: ArrayLike | None = None,
            R: ArrayLike | None = None,
            noise: Literal["F", "states"] = "states",
            bound: float | None = None,
            C: ArrayLike | None = None,
            N: ArrayLike | None = None,
            step: float | None = None,
        ) -> None: ...

    def __post_init__(self):
        """Check the weights and the noise."""
        from .weights import semidefinite_weight, symmetric_weight

        if (self.Q is None) == (self.C is None):
            raise ValueError("give one of Q and C: the cost weighs x' Q x, or |C x|^2")
        if self.R is None:
            raise ValueError("R is missing: it weighs the input")
        if self.C is not None:
            put(self, C=matrix("C", self.C))
            put(self, Q=semidefinite_weight("C' C", self.C.T @ self.C))
        else:
            put(self, Q=semidefinite_weight("Q", self.Q))
        R = numbers("R", self.R)
        R = R if R.size else np.zeros((0, 0))  # [] for a loop without an input
        R = symmetric_weight("R", R)
        if len(R) and not definite(exact(R))[0]:
            raise ValueError(
                "R must be positive definite: each input needs a price above zero"
            )
        put(self, R=R)
        if self.N is not None:
            self._mix()
        if not is_word(self.noise, ("F", "states")):
            raise ValueError(f'noise must be "F" or "states", got {self.noise!r}')
        if self.bound is not None:
            put(self, bound=positive("bound", self.bound))

    def _mix(self):
        """Check N, and mend [Q N; N' R] until it is semidefinite as it is written."""
        from .weights import semidefinite_weight

        if self.C is not None:
            raise ValueError("N goes with Q: give Q in the place of C")
        k = len(self.Q)
        N = matrix("N", self.N, (k, len(self.R)))
        whole = np.block([[self.Q, N], [N.T, self.R]])
        whole = semidefinite_weight("[Q N; N' R]", whole)
        put(self, Q=whole[:k, :k].copy(), R=whole[k:, k:].copy(), N=N.copy())

    @cached_property
    def mixed(self) -> Any:
        """N R^-1 in rationals; None without N. The cost is that of v = u + (N R^-1)' x,
        weighed by R, and of the rest of Q.
        """
        return None if self.N is None else exact(self.N) @ inverse(exact(self.R))

    @cached_property
    def factors(self) -> tuple:
        """Rationals L, W with Q - N R^-1 N' = L W^-1 L', W diagonal, and R^-1."""
        from .weights import square_factors

        R = inverse(exact(self.R))
        if self.C is not None:
            return exact(self.C.T), exact(np.eye(len(self.C))), R
        Q = exact(self.Q)
        Q = Q if self.mixed is None else Q - self.mixed @ exact(self.N).T
        return *square_factors(Q), R

    def with_bound(self, bound: float) -> "Requirement":
        Q = self.Q if self.C is None else None
        return replace(self, Q=Q, bound=bound)

    def joined(self, parts: Any) -> "Requirement":
        c, N = len(parts.states), parts.rows.shape[1]
        if not c or N != (self.Q if self.C is None else self.C).shape[1]:
            return self
        more, none = (0, c), (0, 0)
        if self.C is not None:
            return replace(self, Q=None, C=np.pad(self.C, (none, more)))
        mixed = None if self.N is None else np.pad(self.N, (more, none))
        return replace(self, Q=np.pad(self.Q, (more, more)), N=mixed)

    def data(self) -> dict:
        left_out = ["C" if self.C is None else "Q", *["N"] * (self.N is None)]
        return {k: v for k, v in super().data().items() if k not in left_out}

    def check(self, request: Any) -> None:
        """Raise ValueError if weights or noise don't fit the ``request``."""
        weight = "Q" if self.C is None else "C"
        rows = request.order if self.C is None else None
        matrix(weight, getattr(self, weight), (rows, request.order))
        matrix("R", self.R, (request.plant.m, request.plant.m))
        if self.noise == "F" and request.plant.p == 0:
            raise ValueError('noise="F", but the plant has no F: take "states"')
        if self.noise == "F" and any(d.Uw is not None for d in request.vertices):
            raise ValueError(
                "cost: the noise of a sensor is in u at once, so that the cost of "
                'white noise is infinite: take a DynamicLaw, or noise="states"'
            )
        if self.bound is None:
            raise ValueError(
                "cost: bound is None: give a number, or let "
                'minimize="cost" or design_lqr find it'
            )

    def unknowns(self, request: Any) -> tuple:
        """The J of Theorem 2.4, for a request."""
        channels = request.order if self.noise == "states" else request.plant.p
        return (Unknown("J", channels, symmetric=True),)

    def once(self, loop: PosedLoop) -> Iterable:
        J = loop.own["J"]
        level = self._level(loop.level(self), loop.step(self))
        yield "trace", (), theorems.trace_bound(J, level)
        if self.noise == "states" and loop.epsilon is None:
            yield "cost", (), theorems.lqr_cost(loop.near(loop.P), self._one(loop), J)

    def pair(self, loop: PosedLoop, c: Coupled) -> Iterable:
        c, weights = self._mixed_into(c, c.EP, loop), self._weights(loop)
        yield "lqr", theorems.lqr_decay(c, *weights, loop.step(self))
        if self.noise == "F":
            yield "cost", theorems.lqr_cost(c.EPE, c.Bw, loop.own["J"])

    def slack(self, loop: PosedLoop, c: SlackVertex, i: int) -> Iterable:
        inner, noise = he(c.EVE) - c.EPE, c.Bw
        if self.noise == "states":
            inner = he(loop.near(c.V)) - loop.near(c.P)
            noise = self._one(loop)
        yield "cost", theorems.lqr_cost(inner, noise, loop.own["J"])
        c, weights = self._mixed_into(c, c.EV, loop), self._weights(loop)
        how = loop.epsilon, loop.step(self)
        yield "lqr", theorems.slack_lqr_decay(c, *weights, *how)

    def known_gain(self, c: KnownVertex) -> Iterable:
        yield "mu", c.mu
        yield "lqr", theorems.free_lqr_decay(c, self._known_weight(c), c.step(self))
        J = c.own.get("J")
        if self.noise == "states":
            noise = c.state(exact(np.eye(len(c.E))))
            J = noise.T @ c.P @ noise
        else:
            yield "cost", theorems.free_gramian(c, J, c.own["H"])
        level = self._level(c.level(self) * c.mu, c.step(self))
        yield "trace", theorems.trace_bound(J, level)

    def known_gain_unknowns(self, c: KnownVertex) -> dict:
        mu = c.rate / np.linalg.norm(self._known_weight(c), 2)
        units = {Unknown("mu", 1, symmetric=True): mu}
        if self.noise == "F":
            N, p = c.B.shape
            units[Unknown("J", p, symmetric=True)] = c.reach**2 or 1.0
            units[Unknown("H", N, N)] = 1.0
        return units

    def _level(self, level, step):
        """The bound of tr J. From tick to tick x' P x falls by ``step`` times the cost;
        noise on x(k+1) adds tr P, and B_w w adds step^2 B_w' E'^-1 P E^-1 B_w.
        """
        if not step:
            return level
        return level * step if self.noise == "states" else level / step

    def _known_weight(self, c):
        """Q + K' R K in the arithmetic and coordinates of a vertex."""
        Q, R, K = exact(self.Q), exact(self.R), c.loop.K
        if self.C is not None:
            Q = exact(self.C).T @ exact(self.C)
        weight = Q + K.T @ R @ K
        if self.N is not None:
            weight = weight + exact(self.N) @ K + (exact(self.N) @ K).T
        return c.rows(c.rows(weight).T) if not c.exact else weight

    def _one(self, loop):
        """Where noise on the states enters, in these coordinates."""
        return eye(loop.request.order) if loop.back is None else loop.back

    def _weights(self, loop):
        L, W, V = self.factors
        if not loop.exact:
            L, W, V = (w.astype(float) for w in (L, W, V))
        return (L if loop.T is None else loop.T.T @ L), W, V / loop.scale**2

    def _mixed_into(self, c, EP, loop):
        """A vertex or pair c whose input is v = u + (N R^-1)' x; see `mixed`."""
        if self.mixed is None:
            return c
        turn = self.mixed if loop.exact else self.mixed.astype(float)
        turn = (turn if loop.T is None else loop.T.T @ turn) / loop.scale
        c, EY = copy(c), c.EY + EP @ turn
        vars(c)["EY"] = EY
        return c

    def claim(self) -> str:
        from ..exact.checker.requirements import claim

        return claim(self.data())

    def truth(
        self, loops: Sequence[Descriptor], K: np.ndarray, K_A: np.ndarray | None = None
    ) -> float:
        return max(noise_cost(d, K, self) for d in loops)

    def noise_input(self, d: Descriptor) -> np.ndarray:
        """Where the noise enters x', or x(k+1), of a vertex ``d``, (N, q)."""
        if self.noise == "states":
            return np.eye(len(d.E))
        return np.linalg.solve(d.E, d.Bw) * (self.step or 1.0)

    def slopes(self, d: Descriptor, K: np.ndarray) -> tuple | None:
        if self.step is not None:
            return None
        A, noise = analysis.loop_matrix(d, K), self.noise_input(d)
        X = lyapunov(A.T, -_weight(self, K))
        Y = lyapunov(A, -noise @ noise.T)
        of_noise = 2 * X @ noise if self.noise == "F" else 0 * d.Bw
        pushed = self.R @ K if self.N is None else self.R @ K + self.N.T
        return 2 * X @ Y, 2 * pushed @ Y, of_noise

    def riccati(self) -> Any:
        return self.Q, self.R


def noise_cost(d, K, cost):
    """The true cost of a vertex ``d`` under u = ``K`` x by the weights and noise of a
    ``cost``, (2.30) and (2.31) with W = I; infinite for an unstable loop.
    """
    A, weight, step = analysis.loop_matrix(d, K), _weight(cost, K), cost.step
    if unstable(A, step):
        return np.inf
    if step is None:
        X = lyapunov(A.T, -weight)
    else:
        X = gramian(A.T, weight / step, step)
    noise = cost.noise_input(d)
    return float(np.trace(noise.T @ X @ noise))


def _weight(cost, K):
    """The weight of x under u = K x, in floats."""
    weight = cost.Q + K.T @ cost.R @ K
    return weight if cost.N is None else weight + cost.N @ K + (cost.N @ K).T


def checked_cost(cost):
    """The ``cost``; a ValueError if it is no `QuadraticCost`."""
    if not isinstance(cost, QuadraticCost):
        raise ValueError("cost must be a QuadraticCost(Q, R)")
    return cost
