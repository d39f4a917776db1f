"""The checker's matrices, in the integers of python-flint."""

import re
from decimal import Decimal
from fractions import Fraction
from math import lcm

import numpy as np
from flint import fmpq, fmpz, fmpz_mat

from .checker.arithmetic import (
    BALL,
    LARGEST,
    MOST_DIGITS,
    Mat,
    need,
    number,
    read,
    scalar,
)
from .checker.language import Reader
from .rational import Rational, rational_matrix

AT_ONCE = 400  # letters of a decimal that the standard library reads
DECIMAL = re.compile(r"-?\d+(\.\d+)?(e[-+]?\d{1,3})?", re.ASCII)
FRACTION = re.compile(r"-?\d+/0*[1-9]\d*", re.ASCII)


class Integers(Mat):
    """A `Mat` of rationals: ``z``, a fmpz_mat, over d, an int.

    ``ball``: the enclosed matrix of a reader around it, once it was asked for.
    """

    __slots__ = "ball", "z"

    def __init__(self, z, d=1):
        self.r, self.c, self.z, self.d, self.e = z.nrows(), z.ncols(), z, d, 0
        self.ball = None

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
    ``point``. What a loop's rounds share is computed once. ``bits``: with which
    python-flint works, where fewer ones may do, first.
    """

    bits: tuple[int, ...] = (2 * BALL,)

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
    def inverse(x):
        """The inverse of x: see `arithmetic.inverse`."""
        need(x.r == x.c, "the inverse of a matrix that isn't square")
        x = Integers.of(x)
        try:
            z, d = x.z.inv().numer_denom()
        except ZeroDivisionError:
            need(False, "a matrix that must be regular is singular")
        return Integers(z * x.d, int(d))

    @staticmethod
    def joined(r, c, parts):
        """The r x c matrix of ``parts``: see `arithmetic.joined`."""
        parts = [(top, left, Integers.of(x)) for top, left, x in parts]
        d = lcm(*(x.d for *_, x in parts))
        return Integers(placed(fmpz_mat, r, c, [(*p, p[2].over(d)) for p in parts]), d)


def placed(kind, r, c, parts):
    """The r x c matrix of a ``kind`` of python-flint with some ``parts``: each is
    (top, left, `Mat`, its).
    """
    flat = [0] * (r * c)
    for top, left, x, matrix in parts:
        entries = matrix.entries()
        for k in range(x.r):
            at = (top + k) * c + left
            flat[at : at + x.c] = entries[k * x.c : k * x.c + x.c]
    return kind(r, c, flat)


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
    short = isinstance(text, str) and len(text) < AT_ONCE
    if short and DECIMAL.fullmatch(text):
        return Decimal(text).as_integer_ratio()
    good = isinstance(text, str) and len(text) <= MOST_DIGITS
    if good and FRACTION.fullmatch(text):  # flint's gcd is swift
        ratio = fmpq(*(fmpz(part) for part in text.split("/")))
        return int(ratio.p), int(ratio.q)
    return number(text).as_integer_ratio()


def as_rational(x):
    """A number or a matrix x of the checker as a `Rational` matrix."""
    if scalar(x):
        return rational_matrix([[fmpq(x.numerator, x.denominator)]])
    x = Integers.of(x)
    entries = np.array([fmpq(e, x.d) for e in x.z.entries()], object)
    return entries.reshape(x.r, x.c).view(Rational)
