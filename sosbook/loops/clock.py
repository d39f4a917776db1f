"""When a law runs: by a clock, or at once and late."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exact.rational import exact


@dataclass(frozen=True)
class Clock:
    """A law that runs every ``T`` s, ``jitter`` s early or late, and whose input comes
    ``delay`` s, a number or (low, high), after its sample.
    """

    T: float
    delay: Any = 0.0
    jitter: float = 0.0

    @property
    def latest(self) -> float:
        """The latest time from a sample to the input, in s."""
        return max(self.delay) if isinstance(self.delay, tuple) else self.delay

    @property
    def varies(self) -> bool:
        """True if ticks or delays aren't all the same."""
        return bool(self.jitter) or isinstance(self.delay, tuple)

    @property
    def ranges(self) -> tuple:
        """T and delay; (low, high) of both where one varies.

        >>> Clock(0.1, (0.0, 0.05), 0.02).ranges
        ((0.08, 0.12), (0.0, 0.05))
        """
        if not self.varies:
            return self.T, self.delay
        T, off = exact(self.T), exact(self.jitter)
        late = self.delay if isinstance(self.delay, tuple) else (self.delay,) * 2
        return (float(T - off), float(T + off)), late


@dataclass(frozen=True)
class Late:
    """A law in continuous time, its input ``tau`` s late, give or take ``mu``."""

    tau: float
    mu: float = 0.0

    def __post_init__(self):
        """Check that there is one delay."""
        one_delay(self.tau)


def one_delay(tau):
    """Raise where ``tau`` is more than one number."""
    if np.ndim(tau):
        raise ValueError(
            f"tau = {tau!r:.80}: a late loop has one delay, that of all its inputs. "
            "With one for each input take the loop at a computer's ticks: A and B of "
            "sosbook.sampled.c2d(plant, T), with each input's values of the ticks "
            "before as states, are a DescriptorSystem(..., dt=T) that is proven; the "
            'manual\'s page "One loop" has the lines'
        )
