"""When a law runs: by a clock, or at once and late."""

from dataclasses import dataclass
from typing import Any

from ..exact.rational import exact


@dataclass(frozen=True)
class Clock:
    """A law that runs every ``T`` s, ``jitter`` s early or late, and whose input comes
    ``delay`` s, a number or (low, high), after its sample.
    """

    T: float
    delay: Any = 0.0
    jitter: float = 0.0


@dataclass(frozen=True)
class Late:
    """A law in continuous time, its input ``tau`` s late, give or take ``mu``."""

    tau: float
    mu: float = 0.0


def clock_of(controller):
    """The `Clock` of a ``controller``, with the jitter and the delays it was made for.

    >>> from types import SimpleNamespace
    >>> clock_of(SimpleNamespace(T=0.1, clock=((0.08, 0.12), (0.0, 0.05))))
    Clock(T=0.1, delay=(0.0, 0.05), jitter=0.02)
    """
    if controller.clock is None:
        return Clock(controller.T, controller.delay)
    (early, _), delays = controller.clock
    late = delays if delays[0] < delays[1] else delays[1]
    return Clock(controller.T, late, float(exact(controller.T) - exact(early)))
