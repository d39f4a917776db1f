"""Exact matrices: integers over one denominator, and whether they are positive.

Exponentials and norms, which aren't rational, are enclosed: see `Mat`. It knows no
control, and standard Python is all that it needs.
"""

import re
from contextlib import contextmanager
from fractions import Fraction
from math import factorial, gcd, isqrt, lcm

MOST_DIGITS, LARGEST = 100_000, 2000
BALL = 128  # bits after the point of what is enclosed
LARGEST_EXPONENT = 64  # of an exponential: e^64 is beyond all loops
LONG = 16  # entries of a row
BITS = 32  # twice as many after the point: eigenvalues below 1e-18 are for full length


class Refused(Exception):
    """The file proves nothing; the texts say why."""

    def __str__(self):
        return ", ".join(map(str, self.args))


class Beyond(Exception):
    """The file may be right, but it is too large to tell."""


def need(condition, *words):
    if not condition:
        raise Refused(*words)


@contextmanager
def named(place):
    """Name the ``place`` in each refusal of what stands in this block."""
    try:
        yield
    except Refused as why:
        raise Refused(f"{place}: {why}") from None


class Mat:
    """r x c rationals: rows ``a`` of integers over ``d``.

    With ``e`` > 0 it is a ball: it stands for one of the matrices that differ from this
    one by a map whose norm is at most e / 2^BALL, and d is 2^BALL. What is made of
    balls encloses what is made of any of their matrices.
    """

    __slots__ = "a", "c", "d", "e", "r"

    def __init__(self, r, c, a, d=1, e=0):
        self.r, self.c, self.a, self.d, self.e = r, c, a, d, e

    def near(self, e=0):
        """A ball of short integers around it; e: how far off it was before.

        Each entry is rounded by less than one unit, the norm by less than the root of
        their number.
        """
        if self.d == 1 << BALL:
            return Mat(self.r, self.c, self.a, self.d, e or 1)
        a = [[(x << BALL) // self.d for x in u] for u in self.a]
        return Mat(self.r, self.c, a, 1 << BALL, e + isqrt(self.r * self.c) + 1)

    def exact(self):
        need(not self.e, "an enclosed matrix where an exact one is needed")
        return self

    def long(self):
        """A number above the norm, in units of 2^-BALL: the squares' root, and e."""
        squares = sum(x * x for u in self.a for x in u)
        return isqrt((squares << 2 * BALL) // self.d**2) + 1 + self.e

    def below(self):
        """An exact matrix that X + X' exceeds, or equals, for each X that it encloses.

        Itself where it is exact.
        """
        if not self.e:
            return self
        x = self + self.T
        less = eye(x.r).times(Fraction(-x.e, 1 << BALL))
        return Mat(x.r, x.c, x.a, x.d) + less

    def __add__(self, o):
        need((self.r, self.c) == (o.r, o.c), "a sum of two shapes")
        d = lcm(self.d, o.d)
        p, q = d // self.d, d // o.d
        rows = zip(self.a, o.a)
        a = [[p * x + q * y for x, y in zip(u, v)] for u, v in rows]
        return ball(Mat(self.r, self.c, a, d), self.e + o.e)

    def times(self, f):
        n, d = f.numerator, f.denominator
        x = Mat(self.r, self.c, [[n * x for x in u] for u in self.a], self.d * d)
        return ball(x, self.e and abs(n) * self.e // d + 1)

    def __matmul__(self, o):
        need(self.c == o.r, "a product of shapes that don't fit")
        rows = product(self.a, o.a, o.c)
        e = (self.e or o.e) and (self.e * o.long() + self.long() * o.e >> BALL) + 1
        return ball(Mat(self.r, o.c, rows, self.d * o.d), e)

    @property
    def T(self):
        rows = (
            [list(v) for v in zip(*self.a)] if self.r else [[] for _ in range(self.c)]
        )
        return Mat(self.c, self.r, rows, self.d, self.e)

    def __eq__(self, o):
        rows = zip(self.exact().a, o.exact().a)
        same = (x * o.d == y * self.d for u, v in rows for x, y in zip(u, v))
        return (self.r, self.c) == (o.r, o.c) and all(same)

    @property
    def shortest(self):
        """Its numbers as those of all matrices of its height that equal it."""
        flat = [e for u in self.a for e in u]
        common = gcd(self.d, *flat)
        return self.d // common, *(e // common for e in flat)

    def any(self):
        return any(map(any, self.a))

    def cut(self, i, r, j, c):
        return Mat(r, c, [u[j : j + c] for u in self.a[i : i + r]], self.d, self.e)

    def dot(self, o):
        rows = zip(self.exact().a, o.exact().a)
        return Fraction(sum(x * y for u, v in rows for x, y in zip(u, v)), self.d * o.d)

    def at(self, i, j):
        return Fraction(self.exact().a[i][j], self.d)


def product(a, b, c):
    """The rows of a product of integers, of rows a and of rows b of length c.

    Long ones are multiplied as one integer each: entries stand ``size`` bytes apart,
    where no sum reaches half of that, and half is added so that none is negative.
    """
    if c < LONG:
        rows = []
        for u in a:
            total = [0] * c
            for x, v in zip(u, b):
                for j, y in enumerate(v if x else ()):
                    if y:
                        total[j] += x * y
            rows.append(total)
        return rows
    bits = [max((abs(x).bit_length() for u in y for x in u), default=0) for y in (a, b)]
    size = (sum(bits) + len(b).bit_length() + 9) // 8
    half = 1 << 8 * size - 1
    halves = int.from_bytes(half.to_bytes(size, "little") * c, "little")

    def packed(v):
        parts = b"".join((y + half).to_bytes(size, "little") for y in v)
        return int.from_bytes(parts, "little") - halves

    def unpacked(x):
        parts = (x + halves).to_bytes(size * c, "little")
        return [
            int.from_bytes(parts[k : k + size], "little") - half
            for k in range(0, size * c, size)
        ]

    b = [packed(v) for v in b]
    return [unpacked(sum(x * v for x, v in zip(u, b) if x)) for u in a]


def eye(n):
    return Mat(n, n, [[int(i == j) for j in range(n)] for i in range(n)])


def zeros(r, c):
    return Mat(r, c, [[0] * c for _ in range(r)])


def kron(p, q):
    need(p.r * q.r * p.c * q.c <= LARGEST**2, "a Kronecker product is too large")
    rows = [[x * y for x in u for y in v] for u in p.exact().a for v in q.exact().a]
    return Mat(p.r * q.r, p.c * q.c, rows, p.d * q.d)


def trace(x):
    need(x.r == x.c, "the trace of a matrix that isn't square")
    return Fraction(sum(x.exact().a[i][i] for i in range(x.r)), x.d)


def inverse(x):
    """By Gauss and Jordan."""
    need(x.r == x.c, "the inverse of a matrix that isn't square")
    n = x.r
    rows = [[Fraction(e, x.d) for e in u] + [Fraction(i == j) for j in range(n)]
            for i, u in enumerate(x.exact().a)]  # fmt: skip
    for k in range(n):
        top = next((i for i in range(k, n) if rows[i][k]), None)
        need(top is not None, "a matrix that must be regular is singular")
        rows[k], rows[top] = rows[top], rows[k]
        rows[k] = [e / rows[k][k] if e else e for e in rows[k]]
        for i in range(n):
            f = rows[i][k]
            if i != k and f:
                rows[i] = [e - f * g if g else e for e, g in zip(rows[i], rows[k])]
    return gather([u[n:] for u in rows], n)


def joined(r, c, parts):
    """The r x c matrix of some ``parts``, (top, left, matrix), zero elsewhere."""
    d = lcm(*(x.d for *_, x in parts))
    rows = [[0] * c for _ in range(r)]
    for top, left, x in parts:
        for k, u in enumerate(x.a, top):
            rows[k][left : left + x.c] = [d // x.d * e for e in u]
    return ball(Mat(r, c, rows, d), sum(x.e for *_, x in parts))


def ball(x, e):
    """x where e is zero, else a ball around it."""
    return x.near(e) if e else x


def exponential(x):
    """The exponential of a square matrix, enclosed.

    It is squared back from that of y = x / 2^s with a norm of at most 1/8, of whose
    series 20 terms count: the rest is below 2 (1/8)^21 / 21! < 2^-BALL. The terms are
    taken by fours, as a polynomial in y^4: that takes 8 products.
    """
    need(x.r == x.c, "the exponential of a matrix that isn't square")
    y, s = x.near(x.e), 0
    need(y.long() < LARGEST_EXPONENT << BALL, "an exponential is too large")
    while y.long() << 3 > 1 << BALL + s:
        s += 1
    y = y.times(Fraction(1, 1 << s))
    square = y @ y
    powers, fourth = [eye(x.r), y, square, square @ y], square @ square
    z = eye(x.r).times(Fraction(1, factorial(20)))
    for k in range(16, -1, -4):
        z = z @ fourth
        for i, power in enumerate(powers):
            z = z + power.times(Fraction(1, factorial(k + i)))
    z.e += 1
    for _ in range(s):
        z = z @ z
    return z


def norm(x):
    """A number above the norms of all matrices in x, of an exact one by 12 % at most.

    The 16th power of the norm of y is the norm of (y'y)^8, which the root of the sum of
    its squares bounds.
    """
    size = Fraction(x.long(), 1 << BALL)
    y = x.near(x.e).times(1 / size)
    y = y.T @ y if y.c < y.r else y @ y.T
    for _ in range(3):
        y = y @ y
    root = y.long()
    for _ in range(4):
        root = isqrt(root << BALL) + 1
    return size * min(Fraction(root, 1 << BALL), 1)


def gather(rows, c):
    d = lcm(*(e.denominator for u in rows for e in u))
    a = [[e.numerator * (d // e.denominator) for e in u] for u in rows]
    return Mat(len(rows), c, a, d)


NUMBER = re.compile(r"-?(\d+(\.\d+)?(e[-+]?\d{1,3})?|\d+/0*[1-9]\d*)", re.ASCII)


def number(text):
    """A decimal, or a fraction, in a string."""
    good = isinstance(text, str) and NUMBER.fullmatch(text)
    need(good, f"{text!r:.40} isn't a number")
    top, _, bottom = text.partition("/")
    top, _, power = top.partition("e")
    first, _, rest = top.partition(".")
    over, under = integer(first + rest), integer(bottom or "1")
    power = int(power or 0) - len(rest)
    return Fraction(over * 10 ** max(power, 0), under * 10 ** max(-power, 0))


def integer(text):
    """Of any length: Python itself reads 4300 digits at once."""
    need(len(text) <= MOST_DIGITS + 1, "a number is too long")
    if len(text) <= 4000:
        return int(text)
    value, unsigned = 0, text.removeprefix("-")
    for k in range(0, len(unsigned), 4000):
        part = unsigned[k : k + 4000]
        value = value * 10 ** len(part) + int(part)
    return -value if text[0] == "-" else value


def read(x):
    """A number, or a matrix; {"zeros": [r, c]} stands for one without entries."""
    if isinstance(x, dict):
        return zeros_of(x)
    if not isinstance(x, list):
        return number(x)
    good = x and all(isinstance(u, list) and len(u) == len(x[0]) > 0 for u in x)
    need(good, "the rows of a matrix differ in length")
    return gather([[number(e) for e in u] for u in x], len(x[0]))


def zeros_of(x):
    """The matrix of {"zeros": [r, c]}."""
    size = x.get("zeros")
    good = set(x) == {"zeros"} and isinstance(size, list) and len(size) == 2
    good = good and all(type(k) is int and 0 <= k < LARGEST for k in size)
    need(good, "an odd matrix")
    return zeros(*size)


def scalar(x):
    return isinstance(x, Fraction)


def mul(x, y):
    if scalar(x):
        return x * y if scalar(y) else y.times(x)
    return x.times(y) if scalar(y) else x @ y


def turned(x):
    return x if scalar(x) else x.T


def total(x, y):
    """The sum; a number stands for that multiple of the identity."""
    if scalar(x) != scalar(y):
        f, x = (x, y) if scalar(x) else (y, x)
        need(x.r == x.c, "a number and a matrix that isn't square")
        y = eye(x.r).times(f)
    return x + y


def definite(x, semi=False):
    """True if x is positive definite, or ``semi`` definite, exactly.

    Where it may be, its entries are rounded first, down to BITS bits after the point of
    a diagonal of about one. What that leaves has entries of [0, 1) in the last place,
    and no eigenvalue below -n: a rounded matrix that exceeds n there is enough, and its
    integers are short.
    """
    if scalar(x):
        return x >= 0 if semi else x > 0
    if x.r != x.c or x != x.T:
        return False
    half = [max(u[i], 0).bit_length() // 2 for i, u in enumerate(x.a)]
    short = [[(e << 2 * BITS) >> s + t for e, t in zip(u, half)]
             for u, s in zip(x.a, half)]  # fmt: skip
    for i, u in enumerate(short):
        u[i] -= x.r
    return eliminated(short) or eliminated(x.a, semi)


def eliminated(a, semi=False):
    """The same of symmetric integers, by Bareiss: the pivots are leading minors."""
    common = gcd(*(e for u in a for e in u)) or 1
    rows, last = [[e // common for e in u[i:]] for i, u in enumerate(a)], 1
    while rows:  # of the upper triangle
        head, rows = rows[0], rows[1:]
        p = head[0]
        if p < 0 or (p == 0 and (not semi or any(head))):
            return False
        if p:
            rows = [[(p * b - f * a) // last for a, b in zip(head[i:], r)]
                    for i, (r, f) in enumerate(zip(rows, head[1:]), 1)]  # fmt: skip
            last = p
    return True
