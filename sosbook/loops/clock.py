"""When a law runs: by a clock, or at once and late."""

from dataclasses import dataclass
from typing import Any


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
