"""The checker's matrices, in the integers of python-flint."""

import re
from decimal import Decimal
from fractions import Fraction
from itertools import chain
from math import isqrt, lcm

import numpy as np
from flint import arb, arb_mat, ctx, fmpq, fmpz_mat

from .checker.arithmetic import (
    BALL,
    LARGEST,
    LARGEST_EXPONENT,
    Mat,
    ball,
    need,
    number,
    read,
    scalar,
)
from .checker.language import Reader, Val, certain
from .rational import Rational, rational_matrix

AT_ONCE = 400  # letters of a decimal that the standard library reads
DECIMAL = re.compile(r"-?\d+(\.\d+)?(e[-+]?\d{1,3})?", re.ASCII)


class Integers(Mat):
    """A `Mat` of rationals: ``z``, a fmpz_mat, over d, an int."""

    __slots__ = ("z",)

    def __init__(self, z, d=1):
        self.r, self.c, self.z, self.d, self.e = z.nrows(), z.ncols(), z, d, 0

    @classmethod
    def of(cls, x):
        """A `Mat` x as one of these."""
        if isinstance(x, cls):
            return x
        flat = [e for row in x.exact().a for e in row]
        return cls(fmpz_mat(x.r, x.c, flat), x.d)

    @property
    def a(self):
        """The integers as rows of ints."""
        c, flat = self.c, [int(e) for e in self.z.entries()]
        return [flat[k * c : k * c + c] for k in range(self.r)]

    def over(self, d):
        """The integers over d, a multiple of the own denominator."""
        return self.z if d == self.d else self.z * (d // self.d)

    def any(self):
        """True if an entry isn't zero."""
        return not self.z.is_zero()

    def __add__(self, o):
        need((self.r, self.c) == (o.r, o.c), "a sum of two shapes")
        o, d = Integers.of(o), lcm(self.d, o.d)
        return Integers(self.over(d) + o.over(d), d)

    __radd__ = __add__

    def times(self, f):
        """Its product with a number ``f``."""
        return Integers(self.z * f.numerator, self.d * f.denominator)

    def __matmul__(self, o):
        need(self.c == o.r, "a product of shapes that don't fit")
        o = Integers.of(o)
        return Integers(self.z * o.z, self.d * o.d)

    def __rmatmul__(self, o):
        return Integers.of(o) @ self

    @property
    def T(self):
        """The transpose."""
        return Integers(self.z.transpose(), self.d)

    def __eq__(self, o):
        if (self.r, self.c) != (o.r, o.c):
            return False
        o, d = Integers.of(o), lcm(self.d, o.d)
        return self.over(d) == o.over(d)

    def cut(self, i, r, j, c):
        """The ``r`` rows from ``i`` on, of ``c`` columns from ``j`` on."""
        flat = self.z.entries()
        rows = [k * self.c + j for k in range(i, i + r)]
        flat = [e for k in rows for e in flat[k : k + c]]
        return Integers(fmpz_mat(r, c, flat), self.d)

    def at(self, i, j):
        """The entry ``i``, ``j``, a Fraction."""
        return Fraction(int(self.z[i, j]), self.d)

    def dot(self, o):
        """The sum of the products of its entries and those of a matrix ``o``."""
        pairs = zip(self.z.entries(), Integers.of(o).z.entries())
        return Fraction(int(sum(x * y for x, y in pairs)), self.d * o.d)


class Swift(Reader):
    """A `Reader` of such matrices: see it for ``data``, ``unknowns``, ``sets``,
    ``point``. What a loop's rounds share is computed once.
    """

    def __init__(self, data, unknowns=(), sets=(), point=False):
        super().__init__(data, unknowns, sets, point)
        self.shared, self.numbers = {}, {}

    def statements(self, program):
        """See `Reader.statements`, of a ``program``."""
        for step in program:
            if step[0] == "for":
                self.shared = {}
                step = *step[:3], list(_marked(step))
            yield from super().statements([step])

    def op_once(self, names, x):
        """The value of x, of which a round needs the loop's ``names`` alone."""
        key = id(x), *(self.at[k] for k in names)
        if key not in self.shared:
            self.shared[key] = super().value(x)
        return self.shared[key]

    def value(self, x):
        """The value of a step x."""
        if x[0] == "number":
            if x not in self.numbers:
                self.numbers[x] = super().value(x)
            return self.numbers[x]
        return self.op_once(*x[1:]) if x[0] == "once" else super().value(x)

    @staticmethod
    def read(x):
        """A number, or a matrix, of the JSON x: see `arithmetic.read`."""
        if not isinstance(x, list):
            value = read(x)
            return value if scalar(value) else Integers.of(value)
        good = x and all(isinstance(u, list) and len(u) == len(x[0]) > 0 for u in x)
        need(good, "the rows of a matrix differ in length")
        pairs = [_ratio(e) for row in x for e in row]
        d = lcm(*{q for _, q in pairs})
        return Integers(
            fmpz_mat(len(x), len(x[0]), [p * (d // q) for p, q in pairs]), d
        )

    @staticmethod
    def kron(p, q):
        """The Kronecker product of p and q: see `arithmetic.kron`."""
        need(p.r * q.r * p.c * q.c <= LARGEST**2, "a Kronecker product is too large")
        if p.r == p.c == 1:
            return q.times(p.at(0, 0))
        places = [(i, j) for i in range(p.r) for j in range(p.c)]
        parts = [(i * q.r, j * q.c, q.times(p.at(i, j))) for i, j in places]
        return Swift.joined(p.r * q.r, p.c * q.c, parts)

    @staticmethod
    def joined(r, c, parts):
        """The r x c matrix of ``parts``: see `arithmetic.joined`."""
        parts = [(top, left, Integers.of(x)) for top, left, x in parts]
        d, flat = lcm(*(x.d for *_, x in parts)), [0] * (r * c)
        for top, left, x in parts:
            entries = x.over(d).entries()
            for k in range(x.r):
                at = (top + k) * c + left
                flat[at : at + x.c] = entries[k * x.c : k * x.c + x.c]
        return Integers(fmpz_mat(r, c, flat), d)


class Enclosing(Reader):
    """A `Reader` of enclosed matrices: exponentials and products are python-flint's,
    which take more than half of the time of a proof where they are Python's.
    """

    def op_exp(self, a):
        """A ball around the exponential of ``a``: see `arithmetic.exponential`."""
        return Val(_exponential(certain(a)))

    def op_mul(self, a, b):
        """The product of a and b: see `Reader.op_mul`."""
        x, y = a.v, b.v
        if scalar(x) or scalar(y) or a.back is not None or b.back is not None:
            return super().op_mul(a, b)
        need(x.c == y.r, "a product of shapes that don't fit")
        e = (x.e or y.e) and (x.e * y.long() + x.long() * y.e >> BALL) + 1
        left, right = (fmpz_mat(z.r, z.c, list(chain(*z.a))) for z in (x, y))
        both = left * right
        flat, c = [int(z) for z in both.entries()], y.c
        rows = [flat[k * c : k * c + c] for k in range(x.r)]
        return Val(ball(Mat(x.r, c, rows, x.d * y.d), e))


def _exponential(x):
    """The enclosure of `arithmetic.exponential`, by arb's balls of each entry.

    e^64 takes 93 bits before the point, BALL come after it: twice BALL are enough.
    """
    need(x.r == x.c, "the exponential of a matrix that isn't square")
    x = x.near(x.e)
    need(x.long() < LARGEST_EXPONENT << BALL, "an exponential is too large")
    with ctx.workprec(2 * BALL):
        unit = arb(2) ** -BALL
        off = arb(0, x.e)
        flat = [(arb(e) + off) * unit for row in x.a for e in row]
        found = arb_mat(x.r, x.r, flat).exp().entries()
        need(all(e.is_finite() for e in found), "an exponential is too large")
        flat = [_units(e.mid()) for e in found]
        radii = [_units(e.rad()) + 2 for e in found]  # it and the middle are cut off
    rows = [flat[k : k + x.r] for k in range(0, len(flat), x.r)]
    return Mat(x.r, x.r, rows, 1 << BALL, isqrt(sum(e * e for e in radii)) + 1)


def _units(x):
    """The largest whole number of 2^-BALL below an exact x."""
    n, power = x.man_exp()
    n, power = int(n), int(power) + BALL
    return n << power if power >= 0 else n >> -power


def swiftest(whole):
    """The `Reader` of a ``whole`` file: of enclosed matrices, or of rational ones."""
    from .checker.verdict import FOLDED  # a first design needs no verdict

    return Enclosing if whole.get("kind") == FOLDED else Swift


def _marked(loop):
    """The steps of a ``loop``, in which "once" stands before what rounds share."""
    index, bound = set(loop[1]), {step[1] for step in loop[3] if step[0] == "let"}

    def marked(x):
        """x and the names of the loop that it needs."""
        if x[0] == "name":
            own = index.intersection(x[1].split(".")[1:])
            return x, index if x[1] in bound else own
        if x[0] in ("number", "mirror"):
            return x, set()
        rows = x[1] if x[0] == "block" else [x[1:]]
        rows = [[marked(y) for y in row] for row in rows]
        needed = set().union(*(names for row in rows for _, names in row))
        if needed == index:
            rows = [[once(y, names) for y, names in row] for row in rows]
            x = (x[0], rows) if x[0] == "block" else (x[0], *rows[0])
        return x, needed

    def once(x, names):
        plain = names == index or x[0] in ("name", "number", "mirror")
        return x if plain else ("once", tuple(names), x)

    for step in loop[3]:
        yield *step[:2], *(once(*marked(x)) for x in step[2:])


def _ratio(text):
    """(numerator, denominator) of a number's ``text``: see `arithmetic.number`."""
    good = isinstance(text, str) and len(text) < AT_ONCE and DECIMAL.fullmatch(text)
    return (Decimal(text) if good else number(text)).as_integer_ratio()


def as_rational(x):
    """A number or a matrix x of the checker as a `Rational` matrix."""
    if scalar(x):
        return rational_matrix([[fmpq(x.numerator, x.denominator)]])
    x = Integers.of(x)
    entries = np.array([fmpq(e, x.d) for e in x.z.entries()], object)
    return entries.reshape(x.r, x.c).view(Rational)
