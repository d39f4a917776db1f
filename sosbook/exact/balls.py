"""Blocks that floats prove positive definite, with bounds of all their rounding errors.

What is sure here is true: `certain` never says more than the kernel in rationals would,
and often it can't tell. It assumes that each addition, product, quotient and decimal is
rounded to the nearest float of IEEE 754 (relative error at most `UNIT`, or less than
`TINY` where it underflows), and that products of matrices are sums of products, in any
order, with or without fused operations. How LAPACK factorises is left open: L L' is
multiplied again, and compared.
"""

from fractions import Fraction

import numpy as np

from ..runtime.time_limit import check_time
from .checker import arithmetic, kernel
from .checker.arithmetic import Beyond, Mat, Refused, need, scalar
from .checker.language import Reader, Val

UNIT = 2.0**-53  # half the distance from 1 to the next float
TINY = 1e-290  # beside which errors of underflow vanish, however many
MORE = 1 + 2.0**-40  # times a bound, for the roundings in the bound itself
LARGEST = 2**11  # rows and columns: times `UNIT` a quarter of what `MORE` leaves
NUMBERS = 2**17  # of a stack: a loop's rounds are computed so many at a time


class Unsure(Beyond):
    """Floats can't tell."""


class Ball(Mat):
    """A stack of r x c matrices within ``e``, entry by entry, of floats ``m``.

    ``even``: each is certainly symmetric; ``given``: the floats nearest to decimals;
    ``image``: what it is the transpose of; ``decimals``: `exact`, once it was asked.
    """

    __slots__ = "decimals", "e", "even", "given", "image", "m"

    def __init__(self, m, e, even=False):
        self.m, self.e, self.even = m, e, even
        self.given = self.image = self.decimals = None
        self.r, self.c = m.shape[-2:]

    @classmethod
    def of(cls, x):
        """A `Mat` x as one of these."""
        if isinstance(x, cls):
            return x
        rows = [[e and nearest(Fraction(e, x.d)) for e in u] for u in x.exact().a]
        m = np.array(rows, float).reshape(x.r, x.c)
        return cls(m, UNIT * np.abs(m), x.r == x.c and x == x.T)

    @property
    def a(self):
        return self.exact().a

    @property
    def d(self):
        return self.exact().d

    def exact(self):
        """The `Mat` of the decimals."""
        if self.given is None:
            raise Unsure("only bounds are known")
        if self.decimals is None:
            self.decimals = arithmetic.read(self.given)
        return self.decimals

    def below(self):
        return self

    def __eq__(self, o):
        if self.given is None or o.given is None:
            raise Unsure("only bounds are known")
        return np.array_equal(self.m, o.m)

    def __add__(self, o):
        need((self.r, self.c) == (o.r, o.c), "a sum of two shapes")
        o = Ball.of(o)
        m = self.m + o.m
        return Ball(m, MORE * (self.e + o.e + UNIT * np.abs(m)), self.even and o.even)

    __radd__ = __add__

    def times(self, f):
        g = nearest(f)
        m = self.m * g
        e = MORE * (abs(g) * self.e + 3 * UNIT * np.abs(m)) + TINY
        return Ball(m, e, self.even)

    def __matmul__(self, o):
        need(self.c == o.r, "a product of shapes that don't fit")
        need(self.c < LARGEST, "a product of too many terms")
        o = Ball.of(o)
        size, error = np.abs(o.m), MORE * self.c * UNIT
        e = np.abs(self.m) @ (o.e + error * size) + self.e @ (size + o.e)
        return Ball(self.m @ o.m, MORE * e + TINY)

    def __rmatmul__(self, o):
        return Ball.of(o) @ self

    @property
    def T(self):
        x = Ball(_turned(self.m), _turned(self.e), self.even)
        x.image, x.given = self, self.given and [list(u) for u in zip(*self.given)]
        return x

    def cut(self, i, r, j, c):
        m, e = (x[..., i : i + r, j : j + c] for x in (self.m, self.e))
        return Ball(m, e, self.even and (i, r) == (j, c))


def _turned(x):
    return np.swapaxes(x, -1, -2)


def nearest(f):
    """The float nearest to a rational f: relative error at most `UNIT`."""
    g = float(f)
    if f and not TINY < abs(g) < 1 / TINY:
        raise Unsure("a number is too large or too small")
    return g


class BallReader(Reader):
    """A `Reader` of such stacks: the rounds of a loop are computed together."""

    def __init__(self, data, unknowns=(), sets=(), point=False):
        super().__init__(data, unknowns, sets, point)
        self.rounds, self.bound, self.stacks = {}, {}, {}

    @staticmethod
    def read(x):
        """A number, or a matrix: see `arithmetic.read`."""
        if not isinstance(x, list) or any("/" in e for u in x for e in u):
            value = arithmetic.read(x)
            return value if scalar(value) else Ball.of(value)
        good = x and all(isinstance(u, list) and len(u) == len(x[0]) > 0 for u in x)
        need(good, "the rows of a matrix differ in length")
        m = np.array([[float(e) for e in u] for u in x])
        small = zip(*np.nonzero(~((np.abs(m) > TINY) & (np.abs(m) < 1 / TINY))))
        if any(x[i][j] != "0" for i, j in small):
            raise Unsure("a number is too large or too small")
        value = Ball(m, UNIT * np.abs(m), np.array_equal(m, m.T))
        value.given = x
        return value

    @staticmethod
    def joined(r, c, parts):
        """See `arithmetic.joined`; even where its parts mirror each other."""
        if not any(isinstance(x, Ball) for *_, x in parts):
            return arithmetic.joined(r, c, parts)
        parts = {(i, j): Ball.of(x) for i, j, x in parts}
        rounds = np.broadcast_shapes(*(x.m.shape[:-2] for x in parts.values()))
        m, e, even = np.zeros((*rounds, r, c)), np.zeros((*rounds, r, c)), r == c
        for (i, j), x in parts.items():
            m[..., i : i + x.r, j : j + x.c] = x.m
            e[..., i : i + x.r, j : j + x.c] = x.e
            other = parts.get((j, i))
            even = even and other is not None and (
                x.even if i == j else x.image is other or other.image is x
            )  # fmt: skip
        return Ball(m, e, even)

    @staticmethod
    def kron(p, q):
        """See `arithmetic.kron`."""
        if not isinstance(q, Ball):
            return arithmetic.kron(p, q)
        need(p.r * q.r * p.c * q.c <= arithmetic.LARGEST**2, "it is too large")
        places = [(i, j) for i in range(p.r) for j in range(p.c)]
        parts = [(i * q.r, j * q.c, q.times(p.at(i, j))) for i, j in places]
        x = BallReader.joined(p.r * q.r, p.c * q.c, parts)
        x.even = q.even and p.r == p.c and p.a == p.T.a
        return x

    def op_he(self, a):
        x = super().op_he(a)
        if isinstance(x.v, Ball):
            x.v.even = True
        return x

    def name(self, text):
        """The name in the first of the rounds."""
        return self.in_round(text, 0) if self.rounds else super().name(text)

    def in_round(self, text, k):
        """The name in a loop's k-th round."""
        head, *rest = text.split(".")
        named = (self.rounds[x][k] if x in self.rounds else x for x in rest)
        return ".".join([head, *named])

    def value(self, x):
        if x[0] != "name" or not self.rounds:
            return super().value(x)
        text = x[1]
        if text in self.bound:
            return self.bound[text]
        if not self.rounds.keys() & set(text.split(".")[1:]):
            return super().value(x)
        if text not in self.stacks:
            self.stacks[text] = self.stacked(text)
        return self.stacks[text]

    def stacked(self, text):
        """The values of a name in all rounds."""
        several = len(next(iter(self.rounds.values())))
        names = [self.in_round(text, k) for k in range(several)]
        place = {name: k for k, name in enumerate(dict.fromkeys(names))}
        values = [super(BallReader, self).value(("name", name)).v for name in place]
        if any(map(scalar, values)):
            if values != values[:1] * len(values):
                raise Unsure("numbers that differ from round to round")
            return Val(values[0])
        values, at = [Ball.of(x) for x in values], [place[name] for name in names]
        m, e = (np.stack([getattr(x, k) for x in values])[at] for k in "me")
        return Val(Ball(m, e, all(x.even for x in values)))

    def statements(self, program):
        """See `Reader.statements`, of a ``program``; rounds are computed together."""
        for step in program:
            if step[0] != "for":
                yield from super().statements([step])
                continue
            _, names, key, steps = step
            need(key in self.sets, f"there is no set {key}")
            sizes = [x.v.r * x.v.c for x in self.env.values() if not scalar(x.v)]
            several = max(1, NUMBERS // max(sizes, default=1))
            words = self.sets[key]
            for k in range(0, len(words), several):
                check_time()
                some = list(zip(*words[k : k + several], strict=True))
                need(len(some) == len(names), "a set of another length")
                self.rounds, self.bound, self.stacks = dict(zip(names, some)), {}, {}
                yield from self.together(steps)
                self.keep_rounds(len(words[k : k + several]))
            self.rounds, self.bound, self.stacks = {}, {}, {}

    def together(self, steps):
        """The statements of some rounds, and the definitions in ``bound``."""
        for step in steps:
            if step[0] == "let":
                self.bound[step[1]] = self.value(step[2])
            else:
                yield from super().statements([step])

    def keep_rounds(self, several):
        """Keep all that the rounds have defined, each under its own name."""
        for text, x in self.bound.items():
            own = self.rounds.keys() & set(text.split(".")[1:])
            for k in range(several) if own else ():
                name = self.in_round(text, k)
                need(name not in self.given, f"{name} is defined by the file")
                v = x.v
                if not scalar(v) and v.m.ndim > 2:
                    v = Ball(v.m[k], v.e[k], v.even)
                self.env[name] = Val(v)


def certain(whole):
    """True if all that the point of a ``whole`` file claims is certainly so; False
    tells nothing.
    """

    def decide(label, x, semi):
        if scalar(x):
            return x >= 0 if semi else x > 0
        x = Ball.of(x)
        if not x.even or not x.r or not surely_positive(x.m, x.e):
            raise Unsure("a block isn't certainly positive definite")
        return True

    try:
        with np.errstate(all="ignore"):
            return "point" in whole and bool(kernel.check(whole, decide, BallReader))
    except (Beyond, Refused, *kernel.MALFORMED, MemoryError):
        return False


def surely_positive(m, e):
    """True if all symmetric matrices within e of m, entry by entry, are certainly
    positive definite. ``m`` and ``e`` are floats, (..., n, n), of symmetric matrices:
    of both, the lower triangles count.

    After a scaling by powers of two, which is exact, a matrix S of m has a diagonal of
    about one. For any L the least eigenvalue of S is at least that of the diagonal
    matrix S - B less the norm of B - L L', whatever B is: B is S less a shift, and L
    its Cholesky factor in floats. What e adds is at most the largest sum of a row.

    >>> thin = np.array([[1.0, 1.0], [1.0, 1.0 + 1e-12]])
    >>> surely_positive(thin, 0 * thin), surely_positive(thin, 1e-12 + 0 * thin)
    (True, False)
    """
    n = m.shape[-1]
    d = np.diagonal(m, axis1=-2, axis2=-1)
    if not ((d > 1e-200) & (d < 1e200)).all() or n >= LARGEST:
        return False
    s = np.ldexp(1.0, -(np.frexp(d)[1] // 2))
    m, e = (np.tril(x) * s[..., None] * s[..., None, :] for x in (m, e))
    e = e + _turned(np.tril(e, -1))
    m = m + _turned(np.tril(m, -1))
    if not (np.isfinite(m).all() and np.isfinite(e).all()):
        return False
    spread = 1.01 * e.sum(axis=-1).max(axis=-1)
    error = 1.01 * n * UNIT
    diagonal = np.diagonal(m, axis1=-2, axis2=-1)
    shift = 2 * spread + 4 * error * diagonal.sum(axis=-1) + 1e-80
    B, at = m.copy(), np.arange(n)
    B[..., at, at] -= shift[..., None]
    try:
        L = np.linalg.cholesky(B)
    except np.linalg.LinAlgError:
        return False
    shifted = diagonal - np.diagonal(B, axis1=-2, axis2=-1)
    rest = np.sqrt(((B - L @ _turned(L)) ** 2).sum(axis=(-2, -1)))
    rest += error * (L**2).sum(axis=(-2, -1)) + spread + 1e-90
    return bool((shifted.min(axis=-1) > 1.01 * rest).all())
