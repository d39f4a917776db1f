"""Encoders' counters of a few bits, which begin anew behind their last number."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Counter"]

LEAST_BITS, MOST_BITS = 8, 32
CLEAR_SHARE = 0.25  # of all numbers, turned between two samples: more could be less
LIKE_OTHERS = 2.0  # times the largest other step that one over the end may be
GLITCH_SHARE = 0.02  # of all steps; where more are wild the wheel is too fast


@dataclass(frozen=True, eq=False)
class Counter:
    """The counter behind a column of counts.

    ``bits``: the fewest that hold its numbers, as counts from zero or with a sign;
    ``wraps``, (k,) of int: samples before which it goes over its end: a step of more
    than half of all numbers; ``wild``, (j,) of int: samples before which a step, taken
    the other way round too, is like no other, or so long that it may as well go the
    other way; ``counts``, (N,): the counts of a counter that goes on, where no step is
    wild; else as given.
    """

    bits: int
    wraps: np.ndarray
    wild: np.ndarray
    counts: np.ndarray

    @classmethod
    def of(cls, counts):
        """The counter of the ``counts``; None where none of them goes over an end."""
        counts = np.asarray(counts, float)
        low, high = counts.min(initial=0), counts.max(initial=0)
        bits = LEAST_BITS
        while bits <= MOST_BITS and not (
            (low >= 0 and high < 2**bits)
            or (low >= -(2 ** (bits - 1)) and high < 2 ** (bits - 1))
        ):
            bits += 1
        size, step = 2.0**bits, np.diff(counts)
        over = abs(step) > size / 2
        whole = (counts == np.round(counts)).all()
        if bits > MOST_BITS or not whole or not over.any():
            return None
        turned = step - size * np.round(step / size)
        others = abs(step[~over]).max(initial=0)
        wild = abs(turned) > CLEAR_SHARE * size
        wild |= over & (abs(turned) > LIKE_OTHERS * (others + 1))
        if not wild.any():
            start = counts[0] - size * (counts[0] >= size / 2)
            counts = start + np.append(0, np.cumsum(turned))
        return cls(bits, *(np.flatnonzero(x) + 1 for x in (over, wild)), counts)

    @property
    def too_fast(self):
        """True if so many steps are wild that they are no glitches."""
        return len(self.wild) > GLITCH_SHARE * len(self.counts)
