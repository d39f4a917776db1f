r"""Delays of several ticks that vary: the plant holds the newest command that came.

A command u(k) arrives at k T + d_k, with any d_k of [d_0, d_1]. At each instant the
plant holds the newest of those that have arrived; one that comes after a newer one is
never used. So from t = k T + s on, for s in [0, T), it holds u(k - j), whose *age* j
falls with s, and j T is between d_0 - s and d_1 + T - s.

**Theorem.** Cut [0, T] into pieces, at d_0 and d_1 less whole ticks, too. Let F_c be
the loops where in each piece one age is held, for all sequences c of ages that don't
rise and that d_0 and d_1 allow. Then the loop of a tick, of any sequence of delays, is

.. math::

    F = \sum_c \tau_c F_c + \sum_i \beta_i h^2 G'(t_i) (u_i - u_{i+1}), \qquad
    0 \le \beta_i \le \tfrac18, \quad G(s) = e^{A (T - s)} B ,

a mean of the F_c, and for each age i, of the input u_i, one term of second order in the
longest piece's length h, with G' in its hull over the tick.

*Proof.* For v in (0, 1) let c(v) be the ages at the share v of each piece: they don't
rise. The mean of F_c(v) over v has each age in each piece for as long as F has; what
remains is the integral of (G(s) - its mean over the piece) times the input that is held
at s. That input changes by u_i - u_{i+1} where age i begins. From there to the piece's
end the integral of G less its mean is zero at both ends of the piece, so it is that of
Green's function, which has one sign and the integral (t - a)(b - t)/2 <= h^2/8, times
G'. []

So a Lyapunov matrix for all F_c, with that bound of the rest, is one for every sequence
of delays (`sosbook.sampled.cells`). It asks a little more than is needed: that a tick
may begin with an older input than the one before ended with. Cloosterman, van de Wouw,
Heemels and Nijmeijer (Automatica 46, 2010) hold the newest command, too.
"""

from dataclasses import dataclass, replace
from typing import Any

from flint import fmpq

from ..exact.definite import exact
from .discretize import SampleTiming

__all__ = ["ManyTicks"]

PARTS = 1, 2, 3, 4, 6, 8  # into which the longest piece of a tick is cut, in turn
MOST = 60  # sequences of ages, where a tick is cut
MOST_TICKS = 8  # over which a delay varies


@dataclass(frozen=True)
class Aged(SampleTiming):
    """A tick with inputs of several ``ages``, (age, seconds) in their order; ``oldest``
    is how many older inputs the loop holds.
    """

    ages: tuple = ()
    oldest: int = 0

    @property
    def acting(self):
        return self.ages

    @property
    def n_past_inputs(self):
        return self.oldest

    def follows(self, before):
        return self.ages[0][0] <= before.ages[-1][0] + 1

    @property
    def words(self):
        several = ", ".join(f"{age} for {float(s):.4g} s" for age, s in self.ages)
        return f"inputs of so many ticks ago: {several}"


@dataclass(frozen=True)
class ManyTicks:
    """The clock ``T``, (T, T), with delays between two ``ends`` of several ticks, in s;
    the longest piece of a tick is cut into ``parts``.
    """

    T: tuple
    ends: tuple
    parts: int = 1

    varies, empty, cuts = True, False, False

    @classmethod
    def of(cls, first, last):
        """That from a ``first`` to a ``last`` `SampleTiming` with one T."""
        several = last.whole_samples - first.whole_samples + (last.remainder > 0)
        if several > MOST_TICKS:
            raise ValueError(
                f"delay varies over {several} ticks of T = {float(first.T):g} s, and "
                f"here over {MOST_TICKS} at most: narrow it, or take a longer T"
            )
        ends = (x.whole_samples * x.T + x.remainder for x in (first, last))
        return cls((first.T,) * 2, tuple(ends))

    def cut(self, parts):
        """The same with so many ``parts`` of a tick; a ValueError of others."""
        if parts not in PARTS:
            raise ValueError(f"a tick has {parts!r} parts")
        return replace(self, parts=parts)

    @property
    def finer(self):
        """The same, with more and more parts."""
        for box in map(self.cut, PARTS):
            if box.parts == 1 or len(box.corners) <= MOST:
                yield box

    @property
    def pieces(self):
        """The ends of each piece of a tick, less the tick's begin."""
        T = self.T[0]
        cuts = sorted({fmpq(0), T, *(x - (x / T).floor() * T for x in self.ends)})
        found, longest = [], max(b - a for a, b in zip(cuts, cuts[1:])) / self.parts
        for a, b in zip(cuts, cuts[1:]):
            count = int(((b - a) / longest).ceil())
            found += [(a + (b - a) * k / count, a + (b - a) * (k + 1) / count)
                      for k in range(count)]  # fmt: skip
        return found

    @property
    def corners(self):
        """The `Aged` of each sequence of ages, which don't rise."""
        T, (early, late) = self.T[0], self.ends
        several = [()]
        for a, b in self.pieces:
            newest = max(0, int(((early - b) / T).floor()) + 1)
            oldest = int(((late - a) / T).ceil())
            several = [
                (*before, (age, b - a))
                for before in several
                for age in range(newest, oldest + 1)
                if not before or age <= before[-1][0]
            ]
        return [Aged(T, 0, fmpq(0), ages=x, oldest=self.oldest) for x in several]

    @property
    def oldest(self):
        """The age of the oldest input that is held."""
        return int((self.ends[1] / self.T[0]).ceil())

    def of_controller(self, _: Any):
        """A timing with the inputs that the loop holds."""
        return self.corners[0]

    def written(self, delay):
        """The ends of T and of the ``delay``, as a file has them."""
        pairs = zip(delay, self.ends)
        ends = [float(y) if exact(float(y)) == y else float(x) for x, y in pairs]
        return [float(x) for x in self.T], ends

    @property
    def whole(self):
        """A tick on which each age acts, for a second."""
        ages = tuple((age, fmpq(1)) for age in range(self.oldest + 1))
        return Aged(self.T[0], 0, fmpq(0), ages=ages, oldest=self.oldest)
