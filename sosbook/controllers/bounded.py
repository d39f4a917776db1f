"""A bound of an output, in words, and the plants at which outputs are seen."""

from dataclasses import dataclass
from decimal import ROUND_CEILING
from itertools import product
from typing import Any

from ..exact.proof import Stopped, proven_within
from ..exact.rational import exact
from ..runtime.time_limit import checked_seconds
from .bounds import four_digits
from .clock import vertices_of

SEEN = {1: 9, 2: 5, 3: 3}  # values of each of so many parameters; of more, the ends
SECONDS = 60.0  # for a bound; the count of its cells ends most sooner


@dataclass(frozen=True)
class Bounded:
    """A bound of an output: proven for every plant, and what floats see at corners.

    The bound is an enclosure of one program, this package: no file holds it.

    Parameters
    ----------
    proven : float or None
        No plant exceeds it; None where the cells ended before.
    seen : float
        The largest at the vertices, in floats.
    unit : str
        Of both; with "%" they are shares: 0.05 prints as 5 %.
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
        times = 100 if self.unit == "%" else 1
        at_corners = f"{self.seen * times:.4g}"
        if self.proven is None:
            late = ""
            if self.stopped is not None:
                late = f" within {self.stopped:g} s (a longer time_limit goes on)"
            seen = f"{at_corners}{unit} at the corners"
            return f"no bound found{late}" + (
                f"; {seen}" if self.seen == self.seen else ""
            )
        most = four_digits(self.proven, ROUND_CEILING, times)
        return f"at most {most}{unit} ({at_corners} at the corners)"


def plants_of(c):
    """(name, plant, Descriptor) of plants of a controller c to look at: of a family by
    the values of its parameters, from one end to the other.
    """
    family, many = getattr(c.plant, "family", None), len(c.plant.vertices) > 1
    if family is None:
        pairs = enumerate(zip(c.plant.vertices, c.vertices), 1)
        return [(f"vertex {k}" if many else "the plant", *both) for k, both in pairs]
    box, found = family.box, []
    steps = SEEN.get(len(box.names), 2)
    shares = [exact(k) / (steps - 1) for k in range(steps)]
    ends = zip(box.low, box.high)
    for point in product(*([a + (b - a) * s for s in shares] for a, b in ends)):
        words = (f"{x} = {float(v):.6g}" for x, v in zip(box.names, point))
        plant = family.exactly_at(list(point))
        found.append((", ".join(words), plant, vertices_of(plant)[0]))
    return found
