"""The checker's enclosed matrices in floats, with a bound of all their errors.

What is sure here is true, under the assumptions of `sosbook.exact.balls`: each product
of matrices is a sum of products, in any order, of floats of IEEE 754. Often it can't
tell, and then the balls of python-flint decide. What the text leaves exact is exact.
"""

from fractions import Fraction
from math import ceil, exp, hypot, log2, sqrt

import numpy as np

from .balls import LARGEST, MORE, TINY, UNIT, Unsure, nearest, surely_positive
from .checker import kernel
from .checker.arithmetic import LARGEST_EXPONENT, Beyond, Refused, need, scalar
from .definite import positive
from .enclosing import Enclosing
from .integers import Integers, Swift

SUM = 1 + 2.0**-28  # times the root of a sum of up to 2^22 squares
TERMS = 10  # of a series for a norm of 1/8: the rest is below 1e-17


class Rounded(Integers):
    """An enclosed `Mat`: floats ``m``, less than ``off`` away in the norm, whose own
    norm is below ``long``. What needs integers refuses it.
    """

    __slots__ = "long", "m", "off"

    def __init__(self, m, off):
        need(max(m.shape) < LARGEST, "a matrix is too large for floats")
        self.r, self.c = m.shape
        flat = m.ravel()
        self.m, self.e = m, 1
        self.long = SUM * sqrt(flat @ flat) + TINY
        self.off = MORE * off + TINY

    @classmethod
    def of(cls, x):
        """It holds a `Mat` x: the floats nearest to it."""
        if isinstance(x, cls):
            return x
        x = Integers.of(x)
        if not isinstance(x.ball, cls):
            flat = [int(e) / x.d for e in x.z.entries()]
            x.ball = cls(np.reshape(flat, (x.r, x.c)), 0.0).rounded(UNIT)
        return x.ball

    def rounded(self, unit):
        """It, where each entry may also be off by a ``unit`` of it."""
        self.off = MORE * (self.off + unit * self.long)
        return self

    @property
    def z(self):
        """Refused: it has no integers."""
        return self.exact()

    d = z

    def __add__(self, o):
        need((self.r, self.c) == (o.r, o.c), "a sum of two shapes")
        o = Rounded.of(o)
        return Rounded(self.m + o.m, self.off + o.off).rounded(UNIT)

    __radd__ = __add__

    def times(self, f):
        """Its product with a number ``f``."""
        g = nearest(f)
        return Rounded(self.m * g, abs(g) * self.off * MORE).rounded(3 * UNIT)

    def __matmul__(self, o):
        need(self.c == o.r, "a product of shapes that don't fit")
        o = Rounded.of(o)
        both = self.c * UNIT * MORE * self.long * o.long
        off = self.off * (o.long + o.off) + self.long * o.off
        return Rounded(self.m @ o.m, off + both)

    def __rmatmul__(self, o):
        return Rounded.of(o) @ self

    @property
    def T(self):
        """The transpose."""
        return Rounded(self.m.T, self.off)

    def cut(self, i, r, j, c):
        """See `Integers.cut`."""
        return Rounded(self.m[i : i + r, j : j + c], self.off)

    def below(self):
        """Itself: see `surely`."""
        return self

    def positive(self):
        """True if X + X' is certainly positive definite for each X in it."""
        x = Rounded(self.m + self.m.T, 2 * self.off).rounded(UNIT)
        m = x.m - x.off * np.eye(self.r)
        return surely_positive(m, 2 * UNIT * np.abs(m) + TINY)

    def exponential(self):
        """See `arithmetic.exponential`.

        Of a norm y of at most 1/8 the series by Horner is off by less than ``off``: a
        step's product, quotient and sum add (n/8 + 2) units of sqrt(n) + .15 at most,
        and later steps leave less than 1/7 more of it. A square of Z, whose norm is
        below b, is off by 2 b off + off^2 and what is rounded.
        """
        need(self.r == self.c, "the exponential of a matrix that isn't square")
        n, size = self.r, self.long + self.off
        need(size < LARGEST_EXPONENT, "an exponential is too large")
        halvings = max(0, ceil(log2(8 * size)))
        share, one = 0.5**halvings, np.eye(n)
        y, z = share * self.m, one
        need(share * self.off < 0.01, "a ball is too large")
        for k in range(TERMS, 0, -1):
            z = one + y @ z / k
        off = UNIT * sqrt(n) * (n + 10) + 1.2 * share * self.off + TINY
        for k in range(halvings):
            b = MORE * exp(size * share * 2.0**k)
            long = SUM * np.linalg.norm(z) + TINY
            z, off = z @ z, MORE * (off * (2 * b + off) + n * UNIT * long**2)
        return Rounded(z, off)

    def norm(self):
        """See `arithmetic.norm`: the floats' products are off by less than ``off``."""
        size = self.long + self.off
        y = self.m / size
        y = y.T @ y if self.c < self.r else y @ y.T
        for _ in range(3):
            y = y @ y
        off = UNIT * (15 * max(self.r, self.c) + 20)
        root = (SUM * np.linalg.norm(y) + off) ** (1 / 16)
        return Fraction(float(MORE * (size * min(root, 1.0) + self.off)))


class Rounding(Enclosing):
    """A reader of such floats.

    For ``data``, ``unknowns``, ``sets`` and ``point`` see `Reader`.
    """

    ball = Rounded

    @staticmethod
    def joined(r, c, parts):
        """The r x c matrix of ``parts``: see `arithmetic.joined`."""
        if not any(x.e for *_, x in parts):
            return Swift.joined(r, c, parts)
        m, off = np.zeros((r, c)), []
        for top, left, x in parts:
            x = Rounded.of(x)
            m[top : top + x.r, left : left + x.c] = x.m
            off.append(x.off)
        return Rounded(m, MORE * hypot(*off))


def surely(whole):
    """True if all that the point of a ``whole`` file claims of enclosed matrices is
    certainly so; False tells nothing.
    """

    def decide(label, x, semi):
        if scalar(x):
            return x >= 0 if semi else x > 0
        if isinstance(x, Rounded):
            return x.positive()
        if x != x.T:
            raise Unsure("an exact block isn't symmetric")
        return positive(Integers.of(x))

    try:
        with np.errstate(all="ignore"):
            return "point" in whole and bool(kernel.check(whole, decide, Rounding))
    except (Beyond, Refused, *kernel.MALFORMED, MemoryError):
        return False
