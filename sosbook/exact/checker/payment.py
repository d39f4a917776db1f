"""A polytope whose vertices are near the corners of a box, and what its blocks pay.

LMIs at the corners speak for the box alone. A plant of the polytope has the quotient
X = sum b_i (X_i + D) with the corners' X_i = E_i^-1 [A B W]_i, weights b_i, and a D
whose entries `reach` bounds. Each block is T G T' with G affine in X and a regular T
that depends on E alone: so it is enough that at each corner the block of E_i and
E_i (X_i + D) is positive for all those D. `prices` reads from its text how far the
entries of a block may move, H, and sum H_kl |x_k x_l| <= sum H_kl (s_k / s_l) x_k^2 for
any s > 0: with that diagonal subtracted the block must be positive.
"""

from fractions import Fraction

from .arithmetic import Mat, eye, gather, inverse, mul, need, scalar, total
from .families import given_vertices
from .language import Reader, Val

ROUNDING = Fraction(1, 10**8)  # of an entry, between vertices and what is refused
AT_CORNERS = (
    " at the corners of a box (whose entries are the vertices' within 1e-8 of the "
    "largest)"
)
MAY_MOVE = {"name", "neg", "T", "he", "add", "mul", "div", "kron", "block"}


def corners(box, kind, many):
    """The corner of a box that each of so many vertices is near to, as it says."""
    rest = {name: x for name, x in box.items() if name != "corners"}
    there, places = given_vertices({"kind": kind, **rest}), box["corners"]
    good = all(0 <= k < len(there) for k in places)
    need(good and len(places) == many, "each vertex has a corner of the box")
    return [there[k] for k in places]


def close(given, corners):
    """True if each entry is its corner's, within `ROUNDING` of the largest there."""
    names = "MDSBF" if "M" in given[0] else ("E", "A", "B", "B_w")
    given, corners = (
        [[Fraction(e) for x in names for row in v[x] for e in row] for v in several]
        for several in (given, corners)
    )
    sizes = [ROUNDING * max(map(abs, e)) for e in zip(*given)]
    pairs = (zip(*x, sizes) for x in zip(given, corners))
    return all(abs(a - b) <= s for pair in pairs for a, b, s in pair)


def reach(given, near):
    """Bounds of the entries of X(a) - X(t) for vertices and corners (E, [A B W]).

    A plant of the polytope is W(a) = C(t) + G with C(t) in the box and |G| at most the
    largest gap between a vertex and its corner. C(t)'s quotient, and its E^-1, are
    means of the corners' ones, at most X and Q. Let M = Q gap_E. If (I - M)^-1 >= 0,
    the spectral radius of M is below one, E = C_E (I + C_E^-1 G_E) is regular with
    |E^-1| <= (I - M)^-1 Q, and X(a) - X(t) = E^-1 (G_R - G_E X(t)).
    """
    gap_E, gap_R = (
        largest([v[k] + c[k].times(Fraction(-1)) for v, c in zip(given, near)])
        for k in (0, 1)
    )
    back = [inverse(E) for E, _ in near]
    Q, X = largest(back), largest([b @ R for b, (_, R) in zip(back, near)])
    around = inverse(eye(Q.r) + (Q @ gap_E).times(Fraction(-1)))
    good = all(e >= 0 for row in around.a for e in row)
    need(good, "the vertices are too far from the corners of the box")
    return upwards(around @ (Q @ (gap_R + gap_E @ X)))


def joined(*parts):
    """Matrices side by side."""
    rows = [[p.at(i, j) for p in parts for j in range(p.c)] for i in range(parts[0].r)]
    return gather(rows, sum(p.c for p in parts))


def absolute(x):
    if scalar(x):
        return abs(x)
    return Mat(x.r, x.c, [[abs(e) for e in u] for u in x.a], x.d)


def largest(several):
    """The largest absolute value of each entry, rounded up."""
    r, c = several[0].r, several[0].c
    rows = [[max(abs(x.at(i, j)) for x in several) for j in range(c)] for i in range(r)]
    return upwards(gather(rows, c))


def upwards(x):
    """Entries >= 0, rounded up to decimals of few digits."""
    rows = [[upward(x.at(i, j)) for j in range(x.c)] for i in range(x.r)]
    return gather(rows, x.c)


def upward(e):
    short = Fraction(f"{float(e) * 1.001:.4e}")
    return short if short >= e else e


class Sizes(Reader):
    """Bounds of the entries of expressions, where those of some names move.

    What doesn't depend on these is as large as ``reader`` says; ``known`` are the steps
    of their entries, ``times`` of which they are larger.
    """

    def __init__(self, reader, known, times):
        super().__init__({}, sets=reader.sets)
        self.reader, self.moving = reader, set()
        self.known = {name: x.times(Fraction(times)) for name, x in known.items()}

    def moves(self, x):
        if x[:1] == ("name",):
            return self.name(x[1]) in self.moving
        return any(self.moves(y) for y in x if isinstance(y, (tuple, list)))

    def value(self, x):
        if self.moves(x):
            need(x[0] in MAY_MOVE, f"{x[0]} moves")
            return super().value(x)
        at, self.reader.at = self.reader.at, self.at
        size = absolute(self.reader.value(x).v)
        self.reader.at = at
        return Val(size)

    def op_neg(self, a):
        return a

    def defined(self, name, x):
        step = self.known.get(name)
        self.moving -= {name}
        self.moving |= {name} if step or self.moves(x) else set()
        return Val(absolute(self.reader.env[name].v) + step) if step else self.value(x)


def prices(reader, known, program):
    """The diagonal for each statement that moves, with its label as it is written.

    A generator of (label as it is written, label, diagonal).
    """
    low, high = (Sizes(reader, known, times) for times in (0, 1))
    runs = (x.statements(program) for x in (reader, low, high))
    for (sign, label, g, _), (_, _, a, _), (_, _, b, _) in zip(*runs):
        H = total(b.v, mul(Fraction(-1), a.v))
        if H != 0 if scalar(H) else H.any():
            need(sign == ">" and not scalar(H), f"{label} moves")
            yield reader.form, label, price(H, g.v)


def price(H, g):
    """A diagonal that is at least every symmetric matrix with entries up to H."""
    sizes = [float(g.at(k, k)) for k in range(g.r)]
    need(min(sizes) > 0, "a block that must pay isn't positive")
    s = [Fraction(f"{x**0.5:.3e}") for x in sizes]
    n = range(g.r)
    paid = [upward(s[k] * sum(H.at(k, j) / s[j] for j in n)) for k in n]
    return [[str(paid[i]) if i == j else "0" for j in n] for i in n]
