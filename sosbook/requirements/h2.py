"""A bound of the H2 norm from w to an output."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .. import theorems
from ..analysis.linear import gramian, loop_matrix, unstable
from ..analysis.riccati import lyapunov
from ..language import Unknown
from ..plants.coupled import Coupled, SlackVertex
from ..plants.descriptor import Descriptor
from ..plants.outputs import Output
from .channel import Channel
from .known_gain import KnownVertex
from .posed import PosedLoop
from .vocabulary import H2_NORM


@dataclass(frozen=True, eq=False)
class H2(Channel):
    """The H2 norm from w to y stays below h2: the root mean square under white noise.

    Parameters
    ----------
    h2 : float or None
        The bound; None where it is to be minimised.
    outputs : Output, optional
        As in `HInfinity`. No part of w may pass to y at once, or the norm is infinite.
    inputs : sequence of int, optional
        As in `HInfinity`.
    name : str
        Tells several of them apart; one that isn't "h2" is also what ``minimize``
        takes.
    step : float, optional
        As in `Requirement`: a request sets it.

    Notes
    -----
    `QuadraticCost` bounds the square of the same norm with weights of x and u. Its
    inequality is about the Gramian of what y sees; that of H2 about the one of what w
    reaches, which loses nothing more with a slack matrix. With a known gain and
    multipliers both have that of what y sees.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(2, 0.1, 1, B=1, F=1)
    >>> y = sos.Output(position=1) & sos.Output(input=0.5)
    >>> design = sos.design_pid(cart, requirements=[H2(0.9, outputs=y)])
    >>> print(design.certify())
    proven:
    - the plant, under u = K x, is stable
    - its H2 norm to 1 z; 0.5 u is below 0.9
    """

    h2: float | None = None
    outputs: Output | None = None
    inputs: Sequence[int] | None = None
    name: str = "h2"
    step: float | None = None

    kind = "h2"
    plain = H2_NORM
    implies_stability = needs_disturbance = affine_in_quotient = lossless = True
    rank = 25
    titles = {
        "noise": "what noise reaches",
        "output": "what is seen of it",
        "trace": "H₂ bound h₂",
    }

    def seen(self, d: Descriptor) -> Descriptor:
        return replace(super().seen(d).explicit(), Dw=None)

    def check(self, request: Any) -> None:
        super().check(request)
        for d in request.ground.certain:
            through = Channel.seen(self, d).explicit().Dw
            if through is not None and (through != 0).any():
                raise ValueError(
                    f"{self.name}: w enters the output at once, as by an acceleration, "
                    "so that its H2 norm is infinite: filter w, or weigh another signal"
                )

    needs_equations = True

    @property
    def _J(self):
        return "J " + self.name

    def unknowns(self, request: Any) -> tuple:
        q = len(self.seen(request.vertices[0]).C)
        return (Unknown(self._J, q, symmetric=True),)

    def once(self, loop: PosedLoop) -> Iterable:
        yield "trace", (), theorems.trace_bound(loop.own[self._J], loop.level(self))

    def pair(self, loop: PosedLoop, c: Coupled) -> Iterable:
        yield "noise", theorems.h2_noise(c, loop.step(self))
        yield "output", theorems.h2_output(c.EPC, c.EPE, loop.own[self._J])

    def slack(self, loop: PosedLoop, c: SlackVertex, i: int) -> Iterable:
        yield "noise", theorems.slack_h2_noise(c, loop.epsilon, loop.step(self))
        yield "output", theorems.h2_output(c.EVC, c.EPE, loop.own[self._J])

    def known_gain(self, c: KnownVertex) -> Iterable:
        yield "mu", c.mu
        step, level = c.step(self), c.level(self) * c.mu
        yield "decay", theorems.free_lqr_decay(c, c.C.T @ c.C, step)
        yield "noise", theorems.free_gramian(c, c.own["J"], c.own["H"])
        level = level / step if step else level
        yield "trace", theorems.trace_bound(c.own["J"], level)

    def known_gain_unknowns(self, c: KnownVertex) -> dict:
        N, p = c.B.shape
        return {
            Unknown("mu", 1, symmetric=True): c.rate / np.linalg.norm(c.C, 2) ** 2,
            Unknown("J", p, symmetric=True): c.reach**2 or 1.0,
            Unknown("H", N, N): 1.0,
        }

    def truth(
        self, loops: Sequence[Descriptor], K: np.ndarray, K_A: np.ndarray | None = None
    ) -> float:
        return max(h2_norm(self.seen(d), K, self.step) for d in loops)


def h2_norm(d, K, step=None):
    """The H2 norm of a `Descriptor` d under u = K x; infinite for an unstable loop.
    With a ``step`` d is the change from tick to tick.
    """
    A, (_, _, B) = loop_matrix(d, K), d.state_space()
    if unstable(A, step):
        return np.inf
    X = lyapunov(A, -B @ B.T) if step is None else gramian(A, step * B @ B.T, step)
    C = d.output(K)
    return float(np.sqrt(np.trace(C @ X @ C.T)))
