"""A bound of the H-infinity norm from w to an output (Theorem 2.1)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from .. import analysis, theorems
from ..exact.rational import decimal
from ..language import Unknown
from ..plants.checks import positive
from ..plants.outputs import Output
from ..runtime.read_only import put
from .channel import Channel
from .vocabulary import GAMMA


@dataclass(frozen=True, eq=False)
class HInfinity(Channel):
    """The H-infinity norm from w to y stays below gamma (Theorem 2.1).

    Parameters
    ----------
    gamma : float or None
        The bound; None where it is to be minimised.
    mu : float, optional
        The P of the theorem is mu times the P of the other requirements.
        Any positive value keeps the theorem true; 1 is the printed one.
        Without it mu is free: where another requirement fixes the size of P,
        mu is one more unknown.
    outputs : Output, optional
        The y that is bounded; the displacement z, or the C of a `DescriptorSystem`,
        without it.
    inputs : sequence of int, optional
        Which disturbances, the columns of F or B_w counted from 0; all without it.
    name : str
        Tells several of them apart; one that isn't "gamma" is also what
        ``minimize`` takes.
    step : float, optional
        As in `Requirement`: a request sets it.

    Examples
    --------
    >>> import sosbook as sos
    >>> cart = sos.SecondOrderSystem(2, 0.1, 1, B=1, F=1)
    >>> felt = sos.Output(acceleration=1, name="comfort") & sos.Output(input=0.1)
    >>> design = sos.design_pid(cart, requirements=[sos.HInfinity(0.8, outputs=felt)])
    >>> print(design.certify())
    proven:
    - the plant, under u = K x, is stable
    - its H-infinity norm to comfort = 1 z''; 0.1 u is below 0.8
    """

    gamma: float | None = None
    mu: float | None = None
    outputs: Output | None = None
    inputs: Sequence[int] | None = None
    name: str = "gamma"
    step: float | None = None

    kind = "gamma"
    plain = GAMMA
    implies_stability = needs_disturbance = True
    affine_in_quotient = True
    rank = 20
    titles = {"hinf": "H∞ bound γ"}

    def __post_init__(self):
        super().__post_init__()
        if self.mu is not None:
            put(self, mu=positive("mu", self.mu))

    @property
    def tied(self) -> str:
        return "" if self.mu is None else f"mu = {decimal(self.mu)}"

    def untied(self) -> "HInfinity":
        return replace(self, mu=None)

    @property
    def _mu(self):
        return 1.0 if self.mu is None else self.mu

    def pair(self, loop, c):
        mu = loop.scalar(self._mu)
        yield "hinf", theorems.bounded_real(c, loop.level(self), mu, loop.step(self))

    def slack(self, loop, c, i):
        mu = loop.scalar(self._mu)
        how = mu, loop.epsilon, loop.step(self)
        yield "hinf", theorems.slack_bounded_real(c, loop.level(self), *how)

    def known_gain(self, c):
        yield "mu", c.mu
        yield "hinf", theorems.free_bounded_real(c, c.level(self), c.step(self))

    def known_gain_unknowns(self, c):
        return {Unknown("mu", 1, symmetric=True): c.reach**2 / c.rate or 1.0}

    def truth(self, loops, K, K_A=None):
        norm = partial(analysis.hinf_norm, step=self.step)
        return max(norm(self.seen(d), K) for d in loops)

    def bounds_response(self):
        return self.gamma
