"""A bound of an output in words, and those of what sensors and set points do to it."""

from dataclasses import dataclass
from decimal import ROUND_CEILING
from typing import Any

import numpy as np
from flint import arb

from ..exact.proof import Stopped, proven_within
from ..runtime.time_limit import checked_seconds
from .bounds import bounded_output, four_digits, rounded, sizes_of
from .signals import known_index

SECONDS = 60.0  # for a bound; the count of its cells ends most sooner


@dataclass(frozen=True)
class Bounded:
    """A bound of an output: proven for every plant, and what floats see at corners.

    Parameters
    ----------
    proven : float or None
        No plant exceeds it; None where the cells ended before.
    seen : float
        The largest at the vertices, in floats.
    unit : str
        Of both.
    stopped : float or None
        The seconds after which the search for a bound was stopped, if it was.
    """

    proven: float | None
    seen: float
    unit: str = ""
    stopped: float | None = None

    @classmethod
    def within(cls, seconds: float, work: Any, seen: float, unit: str) -> "Bounded":
        """The bound that ``work`` proves in some ``seconds``: a number, None, or a
        Bounded.

        ``seen``, ``unit``: of the bound.
        """
        found = proven_within(checked_seconds(seconds, needed=True), work)
        if isinstance(found, Bounded):
            return found
        if isinstance(found, Stopped):
            return cls(None, seen, unit, float(seconds))
        return cls(found, seen, unit)

    def __str__(self):
        unit = f" {self.unit}" if self.unit else ""
        if self.proven is None:
            late = ""
            if self.stopped is not None:
                late = f" within {self.stopped:g} s (a longer time_limit goes on)"
            seen = f"{self.seen:.4g}{unit} at the corners"
            return f"no bound found{late}" + (
                f"; {seen}" if self.seen == self.seen else ""
            )
        most = four_digits(self.proven, ROUND_CEILING)
        return f"at most {most}{unit} ({self.seen:.4g} at the corners)"


def of_noise(c, off, output, seconds):
    """The `Bounded` of an ``output`` of c where readings are ``off`` by so much at
    most; ``seconds`` for the proof.
    """
    known_index("output", output, c.outputs)
    known = np.flatnonzero(off > 0)

    def work():
        total = arb(0)
        for k in known:
            found = bounded_output(c, c.B[:, [k]], c.D[:, [k]], output)
            if found is None:
                return None
            total += arb(float(off[k])) * arb(found)
        return rounded(total, np.inf)

    sizes = [sizes_of(x, x.noise, x.direct, output).sum(axis=0) for x in c.loops]
    seen = max(float(h[known] @ off[known]) for h in sizes)
    return Bounded.within(seconds, work, seen, c.outputs[output].unit)


def of_motion(c, x, size, set_point, output, seconds, peak=False):
    """The `Bounded` of an ``output`` of c while ``set_point`` moves by ``size`` a tick,
    or at its step (``peak``); x: see `rest`; ``seconds`` for the proof.
    """
    known_index("output", output, c.outputs)
    own, direct = c.B_r[:, [set_point]], c.D_r[:, [set_point]]

    def work():
        found = bounded_output(c, own, direct, output, -x, peak)
        return None if found is None else rounded(arb(size) * arb(found), np.inf)

    most, moved = np.max if peak else np.sum, (-x.astype(float), 0 * direct)
    seen = max(most(sizes_of(loop, *moved, output)) for loop in c.loops)
    unit = c.outputs[output].unit
    return Bounded.within(seconds, work, float(size) * float(seen), unit)
