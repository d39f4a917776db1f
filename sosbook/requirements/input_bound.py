"""A bound of the input from a given initial state (Lemma 2.2)."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import analysis, theorems
from ..exact.rational import exact
from ..language import Unknown, block, eye
from ..plants.checks import matrix, numbers
from ..plants.coupled import Coupled, SlackVertex
from ..plants.descriptor import Descriptor
from ..runtime.array_like import ArrayLike
from ..runtime.read_only import put
from .base import ONE_BY_ONE, Requirement
from .known_gain import KnownVertex
from .posed import PosedLoop
from .vocabulary import U_MAX


@dataclass(frozen=True, eq=False)
class Saturation(Requirement):
    """The requirement |K x(t)| <= u_max from x(0) = x0 (Lemma 2.2).

    Parameters
    ----------
    u_max : float or None
        Bound of the Euclidean norm of K x, in the unit of u. None where
        it is to be minimised.
    x0 : (N,) array_like
        Initial state [z(0); z'(0); x3(0)]. With a law the plant's is enough: integrals
        start at zero, filters at what is measured, and free dynamics at zero.
    acceleration : bool
        Bound the whole signal u = K x + K_A z'' instead, which the
        lemma as printed doesn't. ``M - B K_A`` must be certain.
    """

    u_max: float
    x0: np.ndarray
    acceleration: bool = False

    kind, name, promise = "input", "saturation", "u_max"
    parameter = U_MAX
    affine_in_quotient = True
    rank = 40
    of_two = ONE_BY_ONE.format("saturation=...")
    titles = {"x0": "x(0) in the ellipsoid", "u_max": "input bound u_max"}

    if TYPE_CHECKING:  # what the constructor takes

        def __init__(
            self, u_max: float | None, x0: ArrayLike, acceleration: bool = False
        ) -> None: ...

    def __post_init__(self):
        super().__post_init__()
        x0 = numbers("x0", self.x0)
        if x0.ndim != 1:
            raise ValueError("x0 must be a vector of finite numbers")
        put(self, x0=matrix("x0", [x0])[0])
        if not isinstance(self.acceleration, bool):
            raise ValueError(
                f"acceleration must be True or False, got {self.acceleration!r}"
            )

    def joined(self, parts: Any) -> "Saturation":
        if len(self.x0) != parts.rows.shape[1]:  # a file has the law's states, too
            return self
        return replace(self, x0=parts.rest.astype(float) @ self.x0)

    def check(self, request: Any) -> None:
        """Raise ValueError if ``request`` has no input, or x0 doesn't fit."""
        super().check(request)
        if request.plant.m == 0:
            raise ValueError(
                "saturation bounds the input, but the plant has no B: give its input "
                "as the B of a DescriptorSystem to analyse_pid"
            )
        first = request.ground.certain[0].E
        if self.acceleration and any(
            not np.array_equal(d.E, first) for d in request.ground.certain
        ):
            raise ValueError(
                "saturation: acceleration=True needs the same M - B K_A "
                "at every vertex; bound K x only"
            )
        if len(self.x0) != request.order:
            states = request.applied.states
            raise ValueError(
                f"x0 has {len(self.x0)} entries, needs "
                f"{states[0]} = {request.order}: {states[1]}"
            )

    def once(self, loop: PosedLoop) -> Iterable:
        if loop.epsilon is not None:
            return
        yield "x0", (), theorems.initial_state(loop.near(loop.P), loop.state(self.x0))
        whole = self._whole(loop)
        for i in range(len(loop.plain)) if whole else (0,):
            vertices = (i,) if whole else ()
            yield "u_max", vertices, self._bound(loop, loop.P, loop.P, loop.Y, i)

    def bounds_input_from(self) -> np.ndarray | None:
        return None if self.acceleration else self.x0

    def pair(self, loop: PosedLoop, c: Coupled) -> Iterable:
        return ()

    def slack(self, loop: PosedLoop, c: SlackVertex, i: int) -> Iterable:
        x0 = loop.state(self.x0)
        yield "x0", theorems.slack_initial_state(loop.near(c.P), loop.near(c.V), x0)
        yield "u_max", self._bound(loop, c.P, c.V.T, c.Y, i)

    @property
    def takes_multipliers(self) -> bool:
        return not self.acceleration

    def known_gain(self, c: KnownVertex) -> Iterable:
        x0 = c.state(exact(self.x0)[:, None])
        K = c.mu * c.rows(c.loop.K)
        yield "decay", theorems.free_stability(c)
        yield "x0", c.mu - x0.T @ c.P @ x0
        limit = c.level(self) * c.mu * eye(len(c.loop.K))
        yield "u_max", block([[c.P, K.T], [K, limit]])

    def known_gain_unknowns(self, c: KnownVertex) -> dict:
        x0 = c.state(exact(self.x0)[:, None])
        return {Unknown("mu", 1, symmetric=True): float((x0**2).sum()) or 1.0}

    def _whole(self, loop):
        """True if the accelerations' part is bounded, too."""
        return self.acceleration and loop.request.K_A is not None

    def _bound(self, loop, P, X, Y, i):
        """The block of vertex i, where K = Y X^-1."""
        u_max2 = loop.level(self) / loop.scale**2
        if not self._whole(loop):
            return theorems.control_bound(P, Y, u_max2)
        d, n = loop.plain[i], loop.request.plant.n
        K_A = loop.number(np.array(loop.request.K_A, float))
        second = slice(n, 2 * n)  # the rows of M z'' = ..
        row = loop.row(d.A[second])
        mass, push = d.E[second, second], d.Bu[second]
        return theorems.whole_control_bound(P, X, Y, K_A, mass, row, push, u_max2)

    def claim(self) -> str:
        from ..exact.checker.requirements import claim

        return claim(self.data())

    def truth(
        self, loops: Sequence[Descriptor], K: np.ndarray, K_A: np.ndarray | None = None
    ) -> float:
        K_A = K_A if self.acceleration else None
        return max(analysis.peak_input(d, K, self.x0, K_A) for d in loops)
