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
from functools import reduce

from .arithmetic import (
    Mat,
    eye,
    gather,
    inverse,
    kron,
    mul,
    need,
    scalar,
    total,
    turned,
    zeros,
)
from .families import given_vertices
from .language import sizes as sizes_of


def corners(box, kind, many):
    """The corner of a box that each of so many vertices is near to, as it says."""
    rest = {name: x for name, x in box.items() if name != "corners"}
    there, places = given_vertices({"kind": kind, **rest}), box["corners"]
    good = all(type(k) is int and 0 <= k < len(there) for k in places)
    need(good and len(places) == many, "each vertex has a corner of the box")
    return [there[k] for k in places]


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
    good = all(e >= 0 for row in around.a for e in row) and around.d > 0
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


class Moves:
    """How far the entries of an expression move, where those of some names do.

    Parameters
    ----------
    reader : language.Reader
        Has the values.
    known : dict
        For names that move, bounds of their entries' steps.
    """

    def __init__(self, reader, known):
        self.reader, self.known, self.now = reader, known, {}

    def of(self, x):
        """The bounds, or None where nothing moves."""
        op, *parts = x
        if op == "number":
            return None
        if op == "name":
            return self.now.get(self.reader.name(x[1]))
        if op == "block":
            return self.block(parts[0])
        steps = [self.of(y) for y in parts]
        if not any(steps):
            return None
        need(op in ("neg", "T", "he", "add", "mul", "div", "kron"), f"{op} moves")
        sizes = [absolute(self.reader.value(y).v) for y in parts]
        first, second = (*steps, None)[:2]
        if op in ("neg", "T"):
            return first if op == "neg" else turned(first)
        if op == "he":
            return first + turned(first)
        if op == "add":
            return total(first, second) if first and second else first or second
        need(op == "mul" or (first if op == "kron" else second) is None, f"{op} moves")
        if op == "kron":
            return kron(sizes[0], second)
        if op == "div":
            return mul(1 / sizes[1], first)
        ways = ((first, sizes[1]), (sizes[0], second), (first, second))
        several = [mul(a, b) for a, b in ways if a and b]
        return reduce(total, several)

    def block(self, table):
        """The bounds of a block matrix."""
        e = [[None if x == ("mirror",) else x for x in row] for row in table]
        places = [(i, j) for i, row in enumerate(e) for j in range(len(row))]
        flip = {(i, j): e[i][j] is None for i, j in places}
        trees = {(i, j): e[j][i] if flip[i, j] else e[i][j] for i, j in places}
        steps = {at: self.of(x) for at, x in trees.items()}
        if not any(steps.values()):
            return None
        values = [[self.reader.value(trees[i, j]) for j in range(len(e))]
                  for i in range(len(e))]  # fmt: skip
        for (i, j), turn in flip.items():
            if turn:
                values[i][j] = self.reader.op_T(values[i][j])
        nought = {at: x == ("number", "0") for at, x in trees.items()}
        high, wide = sizes_of(values, nought)
        need(high == wide, "a block that isn't square moves")
        whole = []
        for i, h in enumerate(high):
            row = []
            for j, w in enumerate(wide):
                step = steps[i, j]
                if step and flip[i, j]:
                    step = turned(step)
                if step and scalar(step):
                    step = eye(h).times(step)
                row.append(step or zeros(h, w))
            whole += [[x.at(k, j) for x in row for j in range(x.c)] for k in range(h)]
        return gather(whole, sum(wide))

    def prices(self, program):
        """The diagonal for each statement that moves, by label; and the labels' forms.

        A generator of (label as it is written, label, diagonal).
        """
        reader = self.reader
        for step in program:
            if step[0] == "for":
                for words in reader.sets[step[2]]:
                    reader.at = dict(zip(step[1], words))
                    yield from self.prices(step[3])
                reader.at = {}
            elif step[0] == "let":
                name = reader.name(step[1])
                reader.env[name] = reader.value(step[2])
                self.now[name] = self.known.get(name) or self.of(step[2])
            else:
                H, form = self.of(step[2]), step[1]
                if H:
                    need(step[0] == ">", f"{form} moves")
                    yield form, reader.name(form), price(H, reader.value(step[2]).v)


def price(H, g):
    """A diagonal that is at least every symmetric matrix with entries up to H."""
    sizes = [float(g.at(k, k)) for k in range(g.r)]
    need(min(sizes) > 0, "a block that must pay isn't positive")
    s = [Fraction(f"{x**0.5:.3e}") for x in sizes]
    n = range(g.r)
    paid = [upward(s[k] * sum(H.at(k, j) / s[j] for j in n)) for k in n]
    return [[str(paid[i]) if i == j else "0" for j in n] for i in n]
