"""Clocks that vary: boxes of intervals and delays."""

from dataclasses import dataclass, replace
from itertools import product

from ..exact.definite import exact
from ..laws.taken import is_controller
from ..plants.checks import finite
from .ages import ManyTicks
from .discretize import SampleTiming

__all__ = ["TimeBox"]


@dataclass(frozen=True)
class TimeBox:
    """All intervals and delays of a box; no delay is longer than its interval.

    ``T``, (fmpq, fmpq): the shortest and the longest time between two samples, in s;
    ``late``, (fmpq, fmpq): between which times a delay is, in s, less its whole
    samples; ``whole_samples``: how many whole samples a delay lasts; ``shared`` and
    ``steps``: as in `SampleTiming`.
    """

    T: tuple
    late: tuple
    whole_samples: int
    shared: bool
    steps: bool = False
    cuts = True

    @property
    def finer(self):
        """The box itself: cells of it are cut where that is needed."""
        return (self,)

    @classmethod
    def only(cls, timing):
        """The box of one ``timing``, a `SampleTiming`."""
        late = timing.remainder
        own = timing.whole_samples, late > 0, timing.steps
        return cls((timing.T,) * 2, (late,) * 2, *own)

    @classmethod
    def of(cls, T, delay):
        """The box of a ``T`` and a ``delay``, each a number or two ends; a ValueError
        of bad ones.
        """
        (short, long), (early, late) = _ends("T", T), _ends("delay", delay)
        first, last = SampleTiming.of(short, early), SampleTiming.of(long, late)
        ends, whole = (first.remainder, last.remainder), first.whole_samples
        longer = last.whole_samples - whole
        if early < late and longer == 1 and not last.remainder:
            ends, longer = (first.remainder, last.T), 0
        if short < long:
            ends, whole = (exact(early), exact(late)), 0
            longer = ends[0] > first.T or ends[1] > last.T
        if longer and short == long:
            return ManyTicks.of(first, last)
        if longer:
            raise ValueError(
                f"delay = {delay!r} isn't always within one interval of T = {T!r}: "
                "beside intervals that vary, let whole samples of a delay be registers "
                "of the controller, and the delay what is left of it; beside one T a "
                "delay may vary over several"
            )
        return cls((first.T, last.T), ends, whole, ends[1] > 0)

    @property
    def varies(self):
        """True if there is more than one clock."""
        return self.T[0] < self.T[1] or self.late[0] < self.late[1]

    @property
    def corners(self):
        """The `SampleTiming` of each corner, where the delay may be too long."""
        return [
            SampleTiming(T, self.whole_samples, late, self.shared, self.steps)
            for T, late in product(*(sorted(set(x)) for x in (self.T, self.late)))
        ]

    @property
    def empty(self):
        """True if every delay is longer than the interval, or as long at one corner.

        That corner belongs to a neighbour, too.
        """
        return self.varies and self.late[0] >= self.T[1]

    def written(self, delay):
        """The ends of T and of the ``delay`` that a file has, as floats.

        A delay that counts as whole samples is that many times T where a float is.
        """
        T = [float(x) for x in self.T]
        delay = [exact(x) for x in _ends("delay", delay)]
        late = [x + self.whole_samples * self.T[0] for x in self.late]
        written = [y if exact(float(y)) == y else x for x, y in zip(delay, late)]
        return T, [float(x) for x in written]

    def at(self, timing):
        """The box of one ``timing``, a `SampleTiming`."""
        return replace(self, T=(timing.T,) * 2, late=(timing.remainder,) * 2)

    @property
    def wider(self):
        """ "T" or "delay": which one has the wider range."""
        T, late = (high - low for low, high in (self.T, self.late))
        return "T" if T >= late else "delay"

    def halves(self, name):
        """The two halves, by a name: "T" or "delay"."""
        which = {"T": "T", "delay": "late"}[name]
        low, high = getattr(self, which)
        ends = (low, (low + high) / 2), ((low + high) / 2, high)
        return [replace(self, **{which: x}) for x in ends]

    def of_controller(self, K):
        """The timing that a gain or controller K is made for."""
        T = self.T[0]
        if is_controller(K) and K.dt is not None and K.dt is not True:
            T = exact(K.dt)
            if self.varies and not self.T[0] <= T <= self.T[1]:
                low, high = map(float, self.T)
                raise ValueError(
                    f"K is sampled with dt = {K.dt!r}, which isn't in T = "
                    f"[{low!r}, {high!r}]"
                )
        if not self.varies:
            T = self.T[0]
        return replace(self.corners[0], T=T)


def _ends(name, x):
    """The ends of a range, from a pair or from one number."""
    pair = x if isinstance(x, (tuple, list)) else (x, x)
    if len(pair) != 2:
        raise ValueError(f"{name} must be a number or (low, high), got {x!r}")
    low, high = (finite(name, end) for end in pair)
    if low > high:
        raise ValueError(f"{name} = {x!r}: the first end must be the smaller one")
    return low, high
