"""The checker's enclosed matrices, in the balls of python-flint."""

from fractions import Fraction
from math import hypot
from typing import Any

from flint import arb, arb_mat, ctx, fmpz_mat

from .checker.arithmetic import BALL, LARGEST_EXPONENT, need
from .checker.language import Val, certain
from .integers import Integers, Swift, placed

FARTHEST = 1e200  # of all that is enclosed


class Ball(Integers):
    """An enclosed `Mat`, with a ball for each entry: ``m``, an arb_mat. What needs
    integers refuses it.
    """

    __slots__ = ("m",)

    def __init__(self, m):
        self.r, self.c, self.m, self.e = m.nrows(), m.ncols(), m, 1

    @classmethod
    def of(cls, x):
        """A ball around a `Mat` x."""
        if isinstance(x, cls):
            return x
        if x.e:
            off = arb(0, x.e)
            flat = [(arb(e) + off) / x.d for row in x.a for e in row]
            return cls(arb_mat(x.r, x.c, flat))
        x = Integers.of(x)
        if not isinstance(x.ball, cls):
            x.ball = cls(arb_mat(x.z) * (1 / arb(x.d)))
        return x.ball

    @property
    def z(self):
        """Refused: it has no integers."""
        return self.exact()

    d = z

    def __add__(self, o):
        need((self.r, self.c) == (o.r, o.c), "a sum of two shapes")
        return Ball(self.m + Ball.of(o).m)

    __radd__ = __add__

    def times(self, f):
        """Its product with a number ``f``."""
        return Ball(self.m * (arb(f.numerator) / f.denominator))

    def __matmul__(self, o):
        need(self.c == o.r, "a product of shapes that don't fit")
        return Ball(self.m * Ball.of(o).m)

    def __rmatmul__(self, o):
        return Ball.of(o) @ self

    @property
    def T(self):
        """The transpose."""
        return Ball(self.m.transpose())

    def cut(self, i, r, j, c):
        """See `Integers.cut`."""
        some = [self.m[k, n] for k in range(i, i + r) for n in range(j, j + c)]
        return Ball(arb_mat(r, c, some))

    def long(self):
        """See `Mat.long`."""
        return _above(_length(self.m.entries())) + 1

    def below(self):
        """See `Mat.below`."""
        n, both = self.r, (self.m + self.m.transpose()).entries()
        far = hypot(*(float(e.rad()) for e in both)) * (1 + 2.0**-40)
        need(far < FARTHEST, "a ball is too large")
        less = int(far * 2.0**BALL) + n + 2  # cut off
        flat = [0] * (n * n)
        for i in range(n):
            for j in range(i, n):
                k = i * n + j
                flat[k] = flat[j * n + i] = _units(both[k].mid())
            flat[i * n + i] -= less
        return Integers(fmpz_mat(n, n, flat), 1 << BALL)

    def exponential(self):
        """See `arithmetic.exponential`.

        It is that of the rows and columns of which one isn't zero, beside ones; and e^x
        takes 1.5 x bits before the point, its inverse as many.
        """
        need(self.r == self.c, "the exponential of a matrix that isn't square")
        long, n = self.long(), self.r
        need(long < LARGEST_EXPONENT << BALL, "an exponential is too large")
        flat = self.m.entries()
        rest = [e.is_zero() for e in flat]
        moves = [k for k in range(n)
                 if not (all(rest[k::n]) and all(rest[k * n : k * n + n]))]  # fmt: skip
        some = [flat[i * n + j] for i in moves for j in moves]
        with ctx.workprec(ctx.prec + (3 * long >> BALL)):
            some = arb_mat(len(moves), len(moves), some).exp().entries()
        flat = [int(k % (n + 1) == 0) for k in range(n * n)]
        for k, i in enumerate(moves):
            for j, e in zip(moves, some[k * len(moves) :]):
                flat[i * n + j] = e
        return Ball(arb_mat(n, n, flat))

    def norm(self):
        """See `arithmetic.norm`."""
        size = Fraction(self.long(), 1 << BALL)
        y = self.times(1 / size)
        y = (y.T @ y if y.c < y.r else y @ y.T).m
        for _ in range(3):
            y = y * y
        root = _length(y.entries())
        for _ in range(4):
            root = root.sqrt()
        return size * min(Fraction(_above(root) + 1, 1 << BALL), 1)


class Enclosing(Swift):
    """A `Swift` reader of such balls, of as many bits as python-flint works with.

    For ``data``, ``unknowns``, ``sets`` and ``point`` see `Reader`.
    """

    bits = 96, 2 * BALL
    ball: Any = Ball  # of which class

    def op_near(self, a):
        """A ball around the value a."""
        return Val(self.ball.of(certain(a)))

    def op_exp(self, a):
        """The exponential of the value a."""
        return Val(self.ball.of(certain(a)).exponential())

    def op_norm(self, a):
        """A number above the norms of the value a."""
        return Val(self.ball.of(certain(a)).norm())

    @staticmethod
    def joined(r, c, parts):
        """The r x c matrix of ``parts``: see `arithmetic.joined`."""
        if not any(x.e for *_, x in parts):
            return Swift.joined(r, c, parts)
        return Ball(placed(arb_mat, r, c, [(*p, Ball.of(p[2]).m) for p in parts]))


def _length(entries):
    """A number above the root of the sum of the squares of ``entries``, a ball."""
    return sum((e * e for e in entries), arb(0)).upper().sqrt()


def _above(x):
    """A whole number of 2^-BALL above all of a ball x."""
    need(x.is_finite(), "a ball is too large")
    return -_units(-x.upper())


def _units(x):
    """The largest whole number of 2^-BALL below an exact x."""
    n, power = x.man_exp()
    n, power = int(n), int(power) + BALL
    return n << power if power >= 0 else n >> -power
