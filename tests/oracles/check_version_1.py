"""The checker of proof files of version 1, which the project shipped before texts.

Its formulas are written from the theorems, as matrices of fractions; it shares no line
with the package nor with the kernel. `check` is all that is asked of it.
"""

import hashlib
import json
import re
from copy import copy
from fractions import Fraction
from functools import cache
from math import comb, lcm, prod

MOST_BYTES, MOST_DIGITS, MOST_VERTICES, DEEPEST = 200_000_000, 100_000, 4096, 200
MOST_FAMILY = 256  # vertices of a plant with parameters
NAME, DIGITS = r"[A-Za-z_][A-Za-z0-9_]*", rf"[0-9]{{1,{MOST_DIGITS}}}"
FACTOR = (rf"(?:{DIGITS}/{DIGITS}|{DIGITS}(?:[.]{DIGITS})?(?:e[-+]?[0-9]{{1,3}})?"
          rf"|{NAME}(?:\^[0-9]{{1,2}})?)")  # fmt: skip


class Refused(Exception):
    """The file proves nothing; the text says why."""


class Beyond(Exception):
    """The file may be right, but this checker can't tell."""


def need(condition, words):
    if not condition:
        raise Refused(words)


# ---- 1. Matrices of rationals


class Matrix(list):
    """Rows of rationals, at least one, with at least one column."""

    def __add__(self, other):
        return Matrix([[a + b for a, b in zip(r, s)] for r, s in zip(self, other)])

    __iadd__ = __add__  # a list would grow

    def __sub__(self, other):
        return self + -1 * other

    def __rmul__(self, factor):
        return Matrix([[factor * a for a in row] for row in self])

    def __matmul__(self, other):
        product = zeros(len(self), len(other[0]))
        for row, total in zip(self, product):
            for a, line in zip(row, other):
                for j, b in enumerate(line if a else ()):
                    if b:
                        total[j] += a * b
        return product

    @property
    def T(self):
        return Matrix(map(list, zip(*self)))


def eye(n):
    return Matrix([[Fraction(i == j) for j in range(n)] for i in range(n)])


def zeros(rows, columns):
    return Matrix([[Fraction(0)] * columns for _ in range(rows)])


def he(x):
    return x + x.T


def symmetric(*diagonal, **off):
    """A block matrix; b12=X puts X into row 1, column 2, and X' opposite."""
    starts = [sum(map(len, diagonal[:k])) for k in range(len(diagonal) + 1)]
    matrix = zeros(starts[-1], starts[-1])
    parts = [(k, k, x) for k, x in enumerate(diagonal)]
    for place, x in off.items():
        i, j = int(place[1]) - 1, int(place[2]) - 1
        parts += [(i, j, x), (j, i, x.T)]
    for i, j, x in parts:
        for r, row in enumerate(x):
            matrix[starts[i] + r][starts[j] : starts[j] + len(row)] = row
    return matrix


def kron(a, x):
    rows = ([[f * b for f in row for b in line] for line in x] for row in a)
    return Matrix([line for group in rows for line in group])


def definite(x, semi=False):
    """Whether x is symmetric and positive definite (or semidefinite).

    By elimination in integers (Bareiss): the pivots are leading minors. A
    pivot of zero needs a row of zeros.
    """
    if x != x.T:
        return False
    scale = lcm(*(Fraction(a).denominator for row in x for a in row))
    rows, last = [[int(a * scale) for a in row] for row in x], 1
    while rows:
        head, rest = rows[0], rows[1:]
        p = head[0]
        if p < 0 or (p == 0 and (not semi or any(head))):
            return False
        if p:
            rest = [[0] + [(p * b - r[0] * a) // last for a, b in zip(head[1:], r[1:])]
                    for r in rest]  # fmt: skip
            last = p
        rows = [r[1:] for r in rest]
    return True


def solve(a, b):
    """a^-1 b; a singular matrix is refused."""
    n, rows = len(a), [list(r) + list(s) for r, s in zip(a, b)]
    for k in range(n):
        top = next((r for r in range(k, n) if rows[r][k]), None)
        need(top is not None, "a matrix that must be regular is singular")
        rows[k], rows[top] = rows[top], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for r in range(n):
            if r != k and rows[r][k]:
                rows[r] = [x - rows[r][k] * y for x, y in zip(rows[r], rows[k])]
    return Matrix([r[n:] for r in rows])


# ---- 2. Reading


def keys(what, names):
    need(set(what) == set(names.split()), f"the keys must be {names}")


def sane(name):
    """A name: one line, and no sentence."""
    sign = r"(?=[\w(])([\w (),#-]|[.](?! ))+(?<! )"
    good = isinstance(name, str) and re.fullmatch(sign, name)
    need(good, f"{name!r:.40} is no name: one line of letters, digits, spaces, hyphens")
    return name


def number(text):
    """A decimal in its shortest form, in a string; what is read already stays."""
    if isinstance(text, Fraction):
        return text
    good = isinstance(text, str) and re.fullmatch(r"[-+.e0-9]{1,30}", text, re.ASCII)
    shortest = repr(float(text) + 0.0) if good else ""
    if shortest.endswith(".0"):
        shortest = shortest[:-2]
    need(good and text == shortest, f"{text!r:.40} isn't a decimal number in a string")
    return Fraction(text)


def positive(text):
    need(number(text) > 0, f"{text} must be positive")
    return number(text)


def ratio(text):
    """A fraction in lowest terms, in a string."""
    digits = rf"\d{{1,{MOST_DIGITS}}}"
    form = rf"-?{digits}(/{digits})?"
    good = isinstance(text, str) and re.fullmatch(form, text, re.ASCII)
    need(good and not re.search("/0+$", text), f"{text!r:.40} isn't a fraction")
    need(str(Fraction(text)) == text, f"{text!r:.40} isn't in lowest terms")
    return Fraction(text)


def matrix(rows, height, width=None, number=number):
    good = isinstance(rows, list) and len(rows) == height
    good = good and all(isinstance(r, list) for r in rows)
    width = len(rows[0]) if good and rows and width is None else width
    need(
        good and all(len(r) == width for r in rows),
        f"a matrix has a wrong shape: {height} x {width} is needed",
    )
    return Matrix([[number(a) for a in row] for row in rows])


def words_of(rows):
    return "[" + ", ".join("[" + ", ".join(row) + "]" for row in rows) + "]"


class Vertex:
    """E x' = A x + B u + W w, y = C x + D u."""

    def __init__(self, E, A, B, W, C, D=None):
        N = len(E)  # what has no column gets one of zeros, which does nothing
        self.E, self.A, self.C = E, A, C or zeros(1, N)
        self.B, self.W = (x if x[0] else zeros(N, 1) for x in (B, W))
        self.D = D or zeros(len(self.C), len(self.B[0]))

    def changed(self, c):
        """In the coordinates x = T xi, u = scale v; rows times ``left``."""
        E, A, B, W = (c.left @ x for x in (self.E, self.A, self.B, self.W))
        C, D = self.C @ c.T, c.scale * self.D
        return Vertex(E @ c.T, A @ c.T, c.scale * B, W, C, D)


def vertices_of(file):
    """The vertices and the numbers of inputs and disturbances."""
    plant, given = file["plant"], given_vertices(file["plant"])
    read = {"second order": second_order, "descriptor": descriptor}[plant["kind"]]
    vertices = [read(v, file) for v in given]
    sizes = {(len(d.E), len(v["B"][0]), len(v.get("F", v.get("B_w"))[0]))
             for d, v in zip(vertices, given)}  # fmt: skip
    need(len(sizes) == 1, "the vertices differ in size")
    return vertices, sizes.pop()[1:]


def given_vertices(plant):
    """The matrices of each vertex by name: as the file has them, or Bernstein's.

    With parameters p in [a, b] they are polynomials. In Bernstein's form of degree d
    p^e has for i = 0 .. d the coefficients

        c_i = sum_j C(i, j) C(d - i, e - j) b^j a^(e - j) / C(d, e)

    and p^e = sum_i w_i c_i with w_i = C(d, i) t^i (1 - t)^(d - i) >= 0 of sum 1, where
    t = (p - a) / (b - a). With several parameters the products of their w_i have the
    sum 1, too: so every plant is a mean of the vertices.
    """
    names = {"second order": "M D S B F", "descriptor": "E A B B_w C D_u"}[
        plant["kind"]
    ]
    if "parameters" not in plant:
        alike = " C D_u" if plant["kind"] == "descriptor" else ""
        keys(plant, "kind vertices" + alike)
        need(plant["vertices"], "the plant has no vertex")
        return plant["vertices"]
    keys(dict(plant, D_u=0) if "D_u" in names else plant, "kind parameters " + names)
    ends = {name: (single(a), single(b)) for name, a, b in plant["parameters"]}
    need(len(ends) == len(plant["parameters"]), "a parameter comes twice")
    for name, (a, b) in ends.items():
        need(re.fullmatch(NAME, name) and a < b, f"{name!r:.40} has no range")
    parts = {x: plant[x] for x in names.split() if plant.get(x) is not None}
    read = {x: [[polynomial(e, ends) for e in row] for row in rows]
            for x, rows in parts.items()}  # fmt: skip
    powers = {p for rows in read.values() for row in rows for e in row for p in e}
    degrees = [max((p[k] for p in powers), default=0) for k in range(len(ends))]
    need(
        prod(d + 1 for d in degrees) <= MOST_FAMILY, "the family has too many vertices"
    )

    @cache
    def coefficient(k, i, e):
        (a, b), d = list(ends.values())[k], degrees[k]
        return sum(Fraction(comb(i, j) * comb(d - i, e - j), comb(d, e)) * b**j
                   * a ** (e - j) for j in range(e + 1))  # fmt: skip

    def at(place):
        return {x: [[sum((c * prod(coefficient(k, i, e)
                                   for k, (i, e) in enumerate(zip(place, p)))
                          for p, c in entry.items()), Fraction(0))
                     for entry in row] for row in rows]
                for x, rows in read.items()}  # fmt: skip

    places = [()]
    for d in degrees:
        places = [(*place, i) for place in places for i in range(d + 1)]
    vertices = list(map(at, places))
    fixed = [[v.get(x) for x in ("C", "D_u")] for v in vertices]
    need(all(x == fixed[0] for x in fixed), "an output depends on a parameter")
    return vertices


def polynomial(text, ends):
    """Coefficients by powers of the parameters, of a sum of products."""
    need(isinstance(text, str) and text, f"{text!r:.40} is no polynomial")
    rest, terms = text.replace(" ", ""), {}
    while rest:
        found = re.match(rf"([-+]?)({FACTOR}(?:\*{FACTOR})*)", rest, re.ASCII)
        need(found and (found[1] or not terms), f"{text!r:.40} is no polynomial")
        c, powers = Fraction(-1 if found[1] == "-" else 1), dict.fromkeys(ends, 0)
        for factor in found[2].split("*"):
            name, _, power = factor.partition("^")
            if name[0].isdigit():
                need(not re.search("/0+$", factor), "a division by zero")
                c *= Fraction(factor)
            else:
                need(name in ends, f"{name:.40} has no range")
                powers[name] += int(power or 1)
        place = tuple(powers.values())
        terms[place], rest = terms.get(place, 0) + c, rest[found.end() :]
    terms = {place: c for place, c in terms.items() if c}
    need(text == in_words(terms, ends), f"{text!r:.40} isn't in its shortest form")
    return terms


def in_words(terms, names):
    """A polynomial as it is written: powers fall, coefficients are short decimals."""
    text = ""
    for powers, c in sorted(terms.items(), reverse=True):
        whole = abs(c) * 10**10  # more decimals than ten are a fraction
        value = str(abs(c)) if whole.denominator > 1 else decimal(abs(c))
        parts = [x if e == 1 else f"{x}^{e}" for x, e in zip(names, powers) if e]
        parts = [value] * (abs(c) != 1 or not parts) + parts
        sign = "-" if c < 0 else "+" if text else ""
        text += (f" {sign} " if text else sign) + "*".join(parts)
    return text or "0"


def single(text):
    return sum(polynomial(text, {}).values(), Fraction(0))


def every_plant(file, many):
    """Of which plants a proof says something."""
    ranges = [f"{x} in [{a}, {b}]" for x, a, b in file["plant"].get("parameters", ())]
    if ranges:
        *most, last = ranges
        return "every plant with " + (f"{', '.join(most)} and {last}" if most else last)
    return "every plant of the polytope" if many > 1 else "the plant"


def second_order(v, file):
    """M z'' + D z' + S z = B u + F w, x3' = U z, u = K x + K_A z''."""
    keys(v, "M D S B F")
    n, U = len(v["M"]), matrix(file["U"], len(file["U"]), len(v["M"]))
    M, D, S = (matrix(v[x], n, n) for x in "MDS")
    B, F = matrix(v["B"], n), matrix(v["F"], n)
    m, N = len(B[0]), 2 * n + len(U)
    if file["K_A"] is not None:
        M = M - B @ matrix(file["K_A"], m, n)
    E, A, C = eye(N), zeros(N, N), zeros(n, N)
    for i in range(n):
        A[i][n + i] = C[i][i] = Fraction(1)
        E[n + i][n : 2 * n] = M[i]
        A[n + i][: 2 * n] = (-1 * S)[i] + (-1 * D)[i]
    for i, row in enumerate(U):
        A[2 * n + i][:n] = row
    tall = (
        Matrix([[0] * len(x[0])] * n + x + [[0] * len(x[0])] * len(U)) for x in (B, F)
    )
    return Vertex(E, A, *tall, C)


def descriptor(v, file):
    v = dict({x: file["plant"].get(x) for x in ("C", "D_u")}, **v)
    keys(v, "E A B B_w C D_u")
    N, C = len(v["E"]), v["C"]
    need(file["U"] == [] and file["K_A"] is None, "this plant has no U, no K_A")
    E, A = matrix(v["E"], N, N), matrix(v["A"], N, N)
    B, D = matrix(v["B"], N), v["D_u"]
    D = None if D is None else matrix(D, len(C), len(B[0]))
    return Vertex(E, A, B, matrix(v["B_w"], N), matrix(C, len(C), N), D)


class Coordinates:
    """x = T xi and u = scale v; the plant's own where a file has none."""

    def __init__(self, N, file):
        self.left, self.T, self.back, self.scale = eye(N), eye(N), eye(N), Fraction(1)
        self.sizes = {}  # for requirements
        if "coordinates" in file:
            given = file["coordinates"]
            keys(given, "left T back scale sizes")
            self.left, self.T = matrix(given["left"], N, N), matrix(given["T"], N, N)
            self.back = matrix(given["back"], N, N)
            self.scale = positive(given["scale"])
            self.sizes = {k: positive(v) for k, v in given["sizes"].items()}
            for x in (self.left, self.T, self.back):
                solve(x, eye(N))  # it must be regular
        self.near = self.back @ self.T  # the identity, nearly; any matrix will do

    def times(self, c):
        """The coordinates x = T c xi."""
        scaled = copy(self)
        scaled.left, scaled.back = 1 / c * self.left, 1 / c * self.back
        scaled.T, scaled.scale = c * self.T, c * self.scale
        return scaled


# ---- 3. The regions of the poles (Theorem 2.2)

PI = Fraction(314159265358979323846264338327950288, 10**35)  # rounded down


@cache
def tangent(degrees):
    """A fraction just below the tangent of an angle in (0, 90] degrees."""
    x = PI * degrees / 180
    sine = sum((-1) ** k * x ** (2 * k + 1) / product(2 * k + 1) for k in range(16))
    cosine = sum((-1) ** k * x ** (2 * k) / product(2 * k) for k in range(17))
    return sine / cosine


TINY = Fraction(1, 10**9)


def near(wanted, written):
    """Whether a number is the one that is wanted, or a little more."""
    return 0 <= written - wanted <= TINY * abs(wanted)


def suffice(vertices):
    """Whether E^-1 [A B W] between the vertices is a mean of the vertices' ones.

    Up to a congruence the blocks of a design are affine in it, so that no pair of
    two vertices is needed then. With E + t u v' for E the inverse moves on a
    segment, and so does the quotient where A, B and W move along u, too; det E is
    affine in t. So it is enough that det E has one sign at all vertices and that
    their columns differ by multiples of one u; or that they are a box, all sums of
    some vertices with one E and any of some changes, each along a u of its own.
    """
    N = len(vertices[0].E)
    points = {tuple(e for x in (d.E, d.A, d.B, d.W) for row in x.T for e in row): d.E
              for d in vertices}  # fmt: skip
    first, *others = sorted(points)

    def change(point):
        return tuple(a - b for a, b in zip(point, first))

    def along_one(*changes):
        columns = [c[k : k + N] for c in changes for k in range(0, len(c), N)]
        u = next(filter(any, columns))
        k = next(k for k in range(N) if u[k])
        return all(c[r] * u[k] == u[r] * c[k] for c in columns for r in range(N))

    box = {p for p in points if p[: N * N] == first[: N * N]}
    if len(box) == len(points):
        return True
    if not along_one(*map(change, others)):
        for point in others:
            if point not in box:
                if not along_one(change(point)):
                    return False
                box |= {tuple(map(sum, zip(p, change(point)))) for p in box}
                if not box <= set(points):
                    return False
    dets = [determinant(E) for E in points.values()]
    return all(d > 0 for d in dets) or all(d < 0 for d in dets)


def product(n):
    return 1 if n < 2 else n * product(n - 1)


FORMS = {
    "half-plane": "sigma",
    "sector": "theta apex degrees",
    "disk": "rho centre",
    "strip": "left right",
    "horizontal strip": "omega",
    "ellipse": "centre a b",
}


def region(r):
    """alpha, beta, and the claim that alpha + beta s + beta' s* < 0 implies.

    They are those of the form that is claimed, but for roundings inwards: what
    excludes them excludes the form.
    """
    k, form = len(r["alpha"]), r["form"]
    keys(r, "kind name form alpha beta " + FORMS.get(form, ""))
    alpha, beta = matrix(r["alpha"], k, k), matrix(r["beta"], k, k)
    need(alpha == alpha.T and k, "alpha must be symmetric")
    if form == "half-plane":
        sigma = number(r["sigma"])
        good = beta == [[1]] and near(2 * sigma, alpha[0][0])
        minus = r["sigma"][1:] if sigma < 0 else "-" + r["sigma"]
        text = f"half-plane Re s < {minus if sigma else 0}"
    elif form == "disk":
        rho, centre = positive(r["rho"]), number(r["centre"])
        good = alpha == [[-rho, -centre], [-centre, -rho]] and beta == [[0, 1], [0, 0]]
        text = f"disk of radius {r['rho']} around {r['centre']}"
    elif form == "sector":
        sine, cosine = beta[0]
        degrees, apex = positive(r["degrees"]), number(r["apex"])
        theta = positive(r["theta"]) * 180 / PI
        good = beta == [[sine, cosine], [-cosine, sine]] and min(sine, cosine) > 0
        good = good and alpha == alpha[0][0] * eye(2) and max(degrees, theta) <= 90
        good = good and near(-2 * sine * apex, alpha[0][0])
        good = good and sine <= cosine * min(tangent(degrees), tangent(theta))
        good = good and sine >= cosine * tangent((1 - TINY) * theta)
        least = tangent(degrees - Fraction(1, 100))  # they are rounded up, to that
        good = good and sine >= cosine * least
        text = f"sector of half-angle {r['degrees']} degrees"
        text += f" with apex {r['apex']}" if apex else ""
    elif form == "strip":
        left, right = number(r["left"]), number(r["right"])
        good = beta == [[-1, 0], [0, 1]] and alpha[0][1] == 0
        good = good and near(2 * left, alpha[0][0]) and near(-2 * right, alpha[1][1])
        text = f"strip {r['left']} < Re s < {r['right']}"
    elif form == "horizontal strip":
        limit = -2 * positive(r["omega"])
        good = beta == [[0, 1], [-1, 0]] and alpha[0][1] == 0
        good = good and near(limit, alpha[0][0]) and near(limit, alpha[1][1])
        text = f"horizontal strip |Im s| < {r['omega']}"
    elif form == "ellipse":  # |g x - h + i k y| < radius
        a, b, centre = positive(r["a"]), positive(r["b"]), number(r["centre"])
        g, k = beta[0][1] + beta[1][0], beta[0][1] - beta[1][0]
        h, radius = -alpha[0][1], -alpha[0][0]
        good = beta[0][0] == beta[1][1] == 0 and alpha[0][0] == alpha[1][1]
        good = good and min(g, k) > 0 and (
            radius * max(1 / (g * a), 1 / (k * b)) + abs(h / g - centre) / a <= 1
            and radius * min(1 / (g * a), 1 / (k * b)) >= 1 - TINY
        )  # fmt: skip
        text = f"ellipse of half axes {r['a']} and {r['b']} around {r['centre']}"
    else:
        need(form == "matrices", f"the form {form!r} isn't known")
        return alpha, beta, in_matrices(r)
    need(good, f"alpha and beta don't belong to the {form} that is claimed")
    return alpha, beta, "its poles lie in the " + text


def in_matrices(r):
    return (
        "its poles lie in the region alpha + beta s + beta' s* < 0, with alpha = "
        + words_of(r["alpha"]) + " and beta = " + words_of(r["beta"])
    )  # fmt: skip


# ---- 4. Designs: the loop and its blocks, as in the thesis


class Design:
    """The blocks that must be positive definite, for values of the unknowns.

    Each requirement may have a P of its own size: it demands its blocks of
    P / s, V / s and Y / s, where s > 0 is one, a number or one more unknown.
    """

    def __init__(self, file):
        self.file, self.asked, self.Q = file, file["requirements"], {}
        need(isinstance(self.asked, list), "requirements must be a list")
        self.plain, (self.m, self.p) = vertices_of(file)
        self.many, self.N = len(self.plain), len(self.plain[0].E)
        self.c = Coordinates(self.N, file)
        need(file["coupling"] in ("pairs", "vertices", "slack"), "unknown coupling")
        self.slack = file["coupling"] == "slack"
        none = file["epsilon"] is None, file["E0"] is None
        need(none == (not self.slack,) * 2, "epsilon and E0 belong to a slack matrix")
        if self.slack:
            self.epsilon = positive(file["epsilon"])
            self.E0 = self.c.left @ matrix(file["E0"], self.N, self.N) @ self.c.T
        few = self.few = [  # without those that repeat an earlier one
            i for i, d in enumerate(self.plain)
            if all(vars(d) != vars(before) for before in self.plain[:i])
        ]  # fmt: skip
        between = [(i, j) for i in few for j in few
                   if i < j and self.plain[i].E != self.plain[j].E]  # fmt: skip
        if between and suffice(self.plain):
            between = []
        self.pairs = [(i, i) for i in few]
        self.pairs += between if file["coupling"] == "pairs" else []
        self.whole = not between or file["coupling"] != "vertices"
        self.K = None
        if file["K"] is not None:
            K = matrix(file["K"], self.m, self.N) or zeros(1, self.N)
            self.K = 1 / self.c.scale * (K @ self.c.T)
        for r in self.asked:
            if r["kind"] not in BLOCKS:
                raise Beyond(f"the theorem of a {r['kind']!r} isn't known here")
        names = [(r["kind"], sane(r["name"])) for r in self.asked]
        named = [NAMES.get(kind, name) == name for kind, name in names]
        need(all(named), "a requirement has another name than its kind")
        need(len(set(names)) == len(names), "a requirement comes twice")
        self.statements = list(self._statements())
        demanded = {(r["kind"], r["name"]): r for _, r in self.statements}
        self.demands = list(demanded.values())
        self._sizes()

    def _statements(self):
        """Each claim beside the requirement whose blocks prove it."""
        where = every_plant(self.file, self.many)
        if not self.whole:
            where = f"each of the {self.many} vertices (not the plants between)"
        under = ", under u = K x," if self.m else ""
        stable = next(filter(implies_stability, self.asked), STABILITY)
        owners = [next(o for o in self.asked if repeats(r, o)) for r in self.asked]
        yield f"{where}{under} is stable", stable
        yield from zip(map(claim, self.asked), owners)

    def _sizes(self):
        """Which requirements have an unknown size, and under which condition."""
        sized = [r for kind in SIZED for r in self.asked if r["kind"] == kind]
        need({*self.c.sizes} <= {*map(size_name, sized)}, "a size of nothing")
        tied = [r["mu"] for r in sized if r["kind"] == "gamma" and r["mu"] is not None]
        ties = [f"mu = {tied[0]}"] if tied and len(sized) > 1 else []
        self.sizes = {size_name(r): r for r in ([] if ties else sized[1:])}
        ties += [f"slack = {float(self.epsilon):g} s"] if self.slack else []
        self.condition = f" for {' and '.join(ties)}" if ties else ""
        if "unknowns" in self.file:  # where they are numbers, any may have one
            given = {size_name(r): r for r in sized}
            self.sizes = {k: r for k, r in given.items() if k in self.file["unknowns"]}

    def unknowns(self):
        """(rows, columns, whether symmetric) of each, by name."""
        N, unknowns = self.N, {"P": (self.N, self.N, True)}
        if self.slack:
            unknowns = {f"P {i + 1}": (N, N, True) for i in self.few}
            unknowns["V"] = N, N, False
        if self.K is None:
            unknowns["Y"] = self.m, N, False
        for r in self.asked:
            if r["kind"] == "cost":
                q = N if r["noise"] == "states" else self.p
                unknowns["J"] = q, q, True
        return dict(unknowns, **{name: (1, 1, True) for name in self.sizes})

    def blocks(self, x):
        """(key, matrix) of each; a size that x doesn't hold is one."""
        for i in self.few if self.slack else [0]:
            P = x[f"P {i + 1}"] if self.slack else x["P"]
            yield ("", "", "P", *((i,) if self.slack else ())), P
        for name, r in self.sizes.items():
            yield (r["kind"], r["name"], name), x.get(name, eye(1))
        known = {}
        for r in self.demands:
            s = x.get(size_name(r), eye(1))[0][0]
            unit = self.c.sizes.get(size_name(r), Fraction(1))
            if (s, unit) not in known:
                known[s, unit] = list(self._loops(x, s, unit))
            for c in known[s, unit]:
                for block, g in BLOCKS[r["kind"]](self, r, x, c):
                    places = c.places
                    if isinstance(block, tuple):
                        block, *places = block
                    yield (r["kind"], r["name"], block, *places), g

    def _loops(self, x, s, unit):
        """What is demanded once, and of each pair of vertices."""
        need(s > 0, "a size must be positive")
        c = self.c.times(unit)
        vertices = [d.changed(c) for d in self.plain]
        names = {i: f"P {i + 1}" if self.slack else "P" for i in self.few}
        P = {i: 1 / s * x[name] for i, name in names.items()}
        V = 1 / s * x["V"] if self.slack else P[0]
        Y = 1 / s * x["Y"] if self.K is None else self.K @ V.T
        loops = [] if self.slack else [Once(P[0], Y)]
        for i, j in self.pairs:
            if self.slack:
                loops.append(Slack(self, vertices[i], i, P[i], V, Y))
            else:
                loops.append(Pair(i, j, vertices, P[0], Y))
        for loop in loops:
            loop.c = c
        return loops

    def claims(self):
        return [words for words, _ in self.statements]


class Once:
    """What is demanded once for all vertices, with a common P."""

    def __init__(self, P, Y):
        self.P, self.Y, self.places = P, Y, ()


class Pair:
    """The symmetric parts of the theorems' matrices for two vertices."""

    def __init__(self, i, j, vertices, P, Y):
        self.places, half = ((i,) if i == j else (i, j)), Fraction(1, 2)
        i, j = vertices[i], vertices[j]
        theta = (i.A @ P + i.B @ Y) @ j.E.T + (j.A @ P + j.B @ Y) @ i.E.T
        self.Theta, self.EPE = half * theta, half * he(i.E @ P @ j.E.T)
        mean = half * (i.E + j.E)
        self.EP, self.EY, self.W = mean @ P, mean @ Y.T, half * (i.W + j.W)
        self.C, self.D = i.C, i.D


class Slack:
    """The same for a vertex i with the slack matrix V and its own P."""

    def __init__(self, design, d, i, P, V, Y):
        E0 = design.E0
        self.Theta = (d.A @ V.T + d.B @ Y) @ E0.T
        self.EPE, self.EVE = E0 @ P @ E0.T, d.E @ V.T @ E0.T
        self.EP, self.EY, self.W = E0 @ V, E0 @ Y.T, d.W
        self.C, self.D = d.C, d.D
        self.P, self.V, self.Y, self.places = P, V, Y, (i,)


def lifted(c, R11, R12, R22, L1, L2):
    """Finsler's lemma: the form R in (E x, E x') less he([L1; L2] (E x' - A x))."""
    return symmetric(
        kron(R11, c.EPE) + he(kron(L1, c.Theta)),
        kron(R22, c.EPE) - he(kron(L2, c.EVE)),
        b12=kron(R12, c.EPE) - kron(L1, c.EVE) + kron(L2, c.Theta).T,
    )


def poles(d, r, x, c):
    """Theorem 2.2 for the region alpha + beta s + beta' s* < 0."""
    a, b, _ = region(r)
    if isinstance(c, Once):
        return
    if isinstance(c, Pair):
        g = kron(a, c.EPE) + kron(b, c.Theta) + kron(b, c.Theta).T
    elif b == [[0, 1], [0, 0]]:  # |s - q| < rho
        q, one = -a[0][1], eye(1)
        g = lifted(c, (q * q - a[0][0] ** 2) * one, -q * one, one, -q * one, one)
    else:
        g = lifted(c, a, b, 0 * a, b, d.epsilon * eye(len(a)))
    yield ("stability" if r is STABILITY else ""), -1 * g


def gamma(d, r, x, c):
    """Theorem 2.1, the bounded real lemma."""
    keys(r, "kind name gamma mu")
    need(d.p, "the plant has no disturbance")
    if isinstance(c, Once):
        return
    mu, w = Fraction(1) if r["mu"] is None else positive(r["mu"]), len(c.W[0])
    form, push = he(c.Theta), c.W
    out = c.EP @ c.C.T + c.EY @ c.D.T
    if d.slack:
        one = eye(1)
        form = lifted(c, 0 * one, one, 0 * one, one, d.epsilon * one)
        out = Matrix([*out, *zeros(len(out), len(out[0]))])
        push = Matrix([*c.W, *(d.epsilon * c.W)])
    y = positive(r["gamma"]) ** 2 / mu * eye(len(c.C))
    yield "hinf", symmetric(-1 * form, y, mu * eye(w), b12=-1 * out, b13=-1 * push)


def peak(d, r, x, c):
    """Lemma 2.2: x0 lies in the ellipsoid x' P^-1 x < 1, and |K x| <= u_max there."""
    if isinstance(c, Pair):
        return
    keys(r, "kind name u_max x0 acceleration")
    x0 = c.c.back @ matrix([[e] for e in r["x0"]], d.N, 1)
    right, inner = (c.V, he(c.V) - c.P) if d.slack else (c.P, c.P)
    inner = c.c.near @ inner @ c.c.near.T
    yield "x0", symmetric(eye(1), inner, b12=x0.T)
    u = (positive(r["u_max"]) / c.c.scale) ** 2 * eye(len(c.Y))
    need(isinstance(r["acceleration"], bool), "acceleration must be true or false")
    if not r["acceleration"] or d.file["K_A"] is None:
        yield "u_max", symmetric(c.P, u, b12=c.Y.T)
        return
    n = len(given_vertices(d.file["plant"])[0]["M"])
    K_A, rows = matrix(d.file["K_A"], d.m, n), slice(n, 2 * n)
    need(all(v.E == d.plain[0].E for v in d.plain), "M - B K_A is uncertain")
    for i in c.places or range(d.many):  # z'' = inertia^-1 (A x + B K x)
        v = d.plain[i]
        z2 = solve(Matrix(row[rows] for row in v.E[rows]), Matrix(v.A[rows]))
        push = solve(Matrix(row[rows] for row in v.E[rows]), Matrix(v.B[rows]))
        G, H = 1 / c.c.scale * (K_A @ z2 @ c.c.T), K_A @ push + eye(d.m)
        yield ("u_max", i), symmetric(c.P, u, b12=(G @ right.T + H @ c.Y).T)


def cost(d, r, x, c):
    """Theorem 2.4: tr J bounds the cost of x'Qx + u'Ru."""
    J, states = x["J"], r["noise"] == "states"
    need(states or (r["noise"] == "F" and d.p), 'noise must be "states", or "F" with F')
    inner = None
    if isinstance(c, (Once, Slack)) and states:
        inner, noise = (he(c.V) - c.P if d.slack else c.P), c.c.back
        inner = c.c.near @ inner @ c.c.near.T
    elif not isinstance(c, Once) and not states:
        inner, noise = (he(c.EVE) - c.EPE if d.slack else c.EPE), c.W
    if inner:
        yield "cost", symmetric(J, inner, b12=noise.T)
    if c.places in ((), (0,)):
        trace = sum(J[k][k] for k in range(len(J)))
        if d.slack or not c.places:
            yield ("trace",), Matrix([[positive(r["bound"]) - trace]])
    if isinstance(c, Once):
        return
    L, W, R = weights(d, r, c.c)
    off = -1 * (c.EP @ L), -1 * (c.EY if d.m else Matrix([[]] * d.N))
    if isinstance(c, Pair):
        yield "lqr", symmetric(-1 * he(c.Theta), W, R, b12=off[0], b13=off[1])
    else:
        cross = c.EVE - c.EPE - d.epsilon * c.Theta.T
        last = d.epsilon * he(c.EVE)
        yield "lqr", symmetric(-1 * he(c.Theta), last, W, R,
                               b12=cross, b13=off[0], b14=off[1])  # fmt: skip


def weights(d, r, frame):
    """L, W, R^-1 with Q = L W^-1 L' and W diagonal, in the coordinates."""
    if not d.Q:
        R = matrix(r["R"], d.m, d.m)
        need(definite(R), "R must be positive definite")
        if "C" in r:  # Q = C'C
            keys(r, "kind name C R noise bound")
            C = matrix(r["C"], len(r["C"]), d.N)
            d.Q = C.T, eye(len(C)), solve(R, eye(d.m))
    if not d.Q:
        keys(r, "kind name Q R noise bound")
        rest, columns, sizes = matrix(r["Q"], d.N, d.N), [], []
        need(definite(rest, semi=True), "Q must be positive semidefinite")
        for k in range(d.N):
            if rest[k][k]:
                columns.append([row[k] / rest[k][k] for row in rest])
                sizes.append([1 / rest[k][k]])
                column = Matrix([columns[-1]])
                rest = rest - rest[k][k] * (column.T @ column)
        W = eye(len(sizes))
        W = Matrix([s * e for e in row] for (s,), row in zip(sizes, W))
        L = Matrix([c[i] for c in columns] for i in range(d.N))
        d.Q = L, W, solve(R, eye(d.m))
    L, W, R = d.Q
    return frame.T.T @ L, W, 1 / frame.scale**2 * R


def size_name(r):
    """The name of a requirement's size among the unknowns."""
    return " ".join(["size for", *dict.fromkeys((r["kind"], r["name"]))])


def repeats(r, other):
    """Whether they are the same, or one region by matrices of whatever size."""
    if r is other or not r["kind"] == other["kind"] == "region":
        return r is other
    (a, b, _), (c, d, _) = region(r), region(other)
    one, two = (next((abs(e) for row in x for e in row if e), 1) for x in (b, d))
    return two * a == one * c and two * b == one * d


def implies_stability(r):
    if r["kind"] != "region":
        return r["kind"] in ("gamma", "cost")
    alpha, beta, _ = region(r)
    return len(beta) == 1 and beta[0][0] > 0 <= alpha[0][0]


def claim(r):
    """What the blocks of a requirement prove."""
    if r["kind"] == "region":
        return region(r)[2]
    if r["kind"] == "gamma":
        return f"its H-infinity norm is below {r['gamma']}"
    if r["kind"] == "input":
        signal = "K x + K_A z''" if r["acceleration"] else "K x(t)"
        return f"|{signal}| <= {r['u_max']} from x0 (with r = 0, w = 0)"
    return f"its quadratic cost is below {r['bound']} times the largest noise intensity"


STABILITY = {"kind": "stability", "name": "stability", "form": "half-plane",
             "sigma": "0", "alpha": [["0"]], "beta": [["1"]]}  # fmt: skip
NAMES = {"gamma": "gamma", "cost": "cost", "input": "saturation"}  # regions have any
SIZED = ("gamma", "cost", "input")  # whose blocks aren't homogeneous in P
BLOCKS = {"region": poles, "gamma": gamma, "input": peak, "cost": cost,
          "stability": poles}  # fmt: skip


# ---- 5. A loop whose input comes late


class Delay:
    """E x' = A x + A_d x(t - d), d in [tau - mu, tau + mu], in units of tau.

    All methods but the first prove stability of e^(delta t) x(t).
    """

    def __init__(self, file):
        self.file, self.form = file, FORMS_OF_DELAY.get(file["method"])
        if self.form is None:
            raise Beyond(f"the theorem of method {file['method']!r} isn't known here")
        need(file["misprints"] == [], "the theorem as printed proves nothing")
        self.first = file["method"] in ("legendre", "interval")  # x' = A x + ..
        self.order = file["order"]
        good = type(self.order) is int and 0 <= self.order
        good = good and (file["method"] == "legendre" or self.order < 2)
        need(good if self.first else self.order is None, "an order that isn't one")
        tau, delta = positive(file["tau"]), number(file["delta"])
        mu = number(file["mu"])
        need(0 <= mu <= tau and delta >= 0, "mu or delta is out of range")
        plain = self._loop() if file["plant"]["kind"] == "loop" else self._plant()
        self.many, self.N = len(plain), len(plain[0].E)
        need(self.many == 1 or not self.first, "this method takes one plant")
        c = Coordinates(self.N, file)
        need(not c.sizes, "no requirement has a size")
        self.K = None
        if file["K"] is not None:
            self.K = 1 / c.scale * (matrix(file["K"], self.m, self.N) @ c.T)
        self.free = file["alpha"] is None  # F and G, else G = alpha F
        need(file["analysis"] is self.free, "alpha belongs to a design")
        self.alpha = None if self.free else positive(file["alpha"]) / tau
        self.mu, self.delta, shift = mu / tau, delta * tau, Fraction(0)
        ends, bounds = [("", Fraction(1))], [ratio(x) for x in file["exponentials"]]
        self.e1, self.e2 = Fraction(1), Fraction(1)
        if file["method"] == "functional":
            self.e1, self.e2 = bounds
            late = 2 * self.delta * (1 + self.mu)
            for e, x in ((self.e1, 2 * self.delta), (self.e2, late)):
                down = 0 < e and e * exponential(x)[1] <= 1
                need(down, "an exponential isn't rounded down")
        else:  # e^(delta t) x(t) has the input's factor e^(delta d)
            shift, self.delta = self.delta, 0
            need(len(bounds) == (2 if delta else 0), "there must be two factors")
            if delta:
                low, high = bounds
                need(low <= exponential(delta * (tau - mu))[0], "too large a factor")
                need(high >= exponential(delta * (tau + mu))[1], "too small a factor")
                ends = [(" shortest", low), (" longest", high)]
        self.loops = []
        for i, d in enumerate(plain):
            if any(vars(d) == vars(before) for before in plain[:i]):
                continue  # it repeats an earlier one
            d, index = d.changed(c), f" {i + 1}" if self.many > 1 else ""
            E, A, B = d.E, tau * d.A + shift * d.E, tau * d.B
            if self.first:
                E, A, B = eye(self.N), solve(E, A), solve(E, B)
            self.loops += [(index + tag, E, A, f * B) for tag, f in ends]

    def _loop(self):
        """x' = A x + A_d x(t - d) is read with B = A_d and K = 1."""
        loop, N = self.file["plant"], len(self.file["plant"]["A"])
        keys(loop, "kind A A_d")
        bare = self.file["U"] == [] and self.file["K_A"] is None
        need(bare, "a loop has no U, no K_A")
        need(matrix(self.file["K"], N, N) == eye(N), "the K of a loop is the identity")
        A, A_d = matrix(loop["A"], N, N), matrix(loop["A_d"], N, N)
        self.m = N
        return [Vertex(eye(N), A, A_d, zeros(N, 1), eye(N))]

    def _plant(self):
        need(self.file["K_A"] is None, "there is no K_A behind a delay")
        plain, (self.m, _) = vertices_of(self.file)
        return plain

    def unknowns(self):
        return self.form[0](self)

    def blocks(self, x):
        return self.form[1](self, x)

    def claims(self):
        tau, mu, delta = (number(self.file[k]) for k in ("tau", "mu", "delta"))
        who = every_plant(self.file, self.many)
        who += ", under u = K x(t - d),"
        if self.file["plant"]["kind"] == "loop":
            who = "the loop"
        how = "is exponentially stable"
        if delta:
            how = f"decays at least as fast as exp(-{self.file['delta']} t)"
        when = f"the constant delay {self.file['tau']} s"
        if mu:
            ends = f"[{decimal(tau - mu)}, {decimal(tau + mu)}]"
            when = f"every delay in {ends} s, however it varies"
        return [f"{who} {how} for {when}"]


def krasovskii_unknowns(d):
    N = d.N
    unknowns = {name: (N, N, True) for name in ("P", "S", "R1", "R3")}
    unknowns.update({name: (N, N, False) for name in ("Q", "R2", "F")})
    unknowns.update({"Z": (N, N, True)} if d.mu else {})
    unknowns.update({"G": (N, N, False)} if d.free else {})
    unknowns.update({} if d.K else {"X": (d.m, N, False)})
    return unknowns


def krasovskii(d, x):
    """Theorems A.3 (F and G free) and 2.3 (G = alpha F), corrected."""
    P, Q, S, R1, R2, R3, F = (x[k] for k in ("P", "Q", "S", "R1", "R2", "R3", "F"))
    e1, e2, mu, delta = d.e1, d.e2, d.mu, d.delta
    Z = x["Z"] if mu else zeros(d.N, d.N)
    yield "functional", symmetric(P, e1 * S, b12=Q)
    yield "R", symmetric(R1, R3, b12=R2.T)
    if mu:
        yield "Z", Z
    for name, E, A, B in d.loops:
        if d.free:
            A_d = B @ d.K
            FA, GA, FE, GE = F @ A, x["G"] @ A, F @ E, x["G"] @ E
            late, rate = F @ A_d, x["G"] @ A_d
        else:  # after a congruence with F^-1, which is called F then
            FA, FE = A @ F.T, E @ F.T
            late = B @ (d.K @ F.T if d.K else x["X"])
            GA, GE, rate = d.alpha * FA, d.alpha * FE, d.alpha * late
        parts = [
            2 * delta * P + he(Q) + R1 - e1 * R3 + S + e2 * he(FA),
            R3 + 2 * mu * Z - e2 * he(GE),
            -e1 * (R3 + S),
            -e1 * R1,
        ]
        off = dict(
            b12=(P + R2 + e2 * (GA - FE.T)).T,
            b13=e1 * R3 - Q + e2 * late,
            b14=2 * delta * Q - e1 * R2,
            b23=e2 * rate, b24=Q, b34=e1 * R2,
        )  # fmt: skip
        if mu:
            parts.append(-1 / (e2 * mu) * Z)
            off.update(b15=late, b25=rate)
        yield "decay" + name, -1 * symmetric(*parts, **off)


def form(X, v):
    return v.T @ X @ v


def pickers(N, parts):
    """Matrices that pick the parts of a long vector."""
    one = eye(N * parts)
    return [Matrix(one[k * N : (k + 1) * N]) for k in range(parts)]


def stack(*parts):
    return Matrix([row for x in parts for row in x])


def legendre_unknowns(d):
    unknowns = {"P": ((1 + d.order) * d.N,) * 2 + (True,)}
    names = ("S", "R", "Z") if d.mu else ("S", "R")
    return dict(unknowns, **{name: (d.N, d.N, True) for name in names})


def legendre(d, x):
    """Bessel's inequality of an order, of Seuret and Gouaisbaut (2015).

    X_k is the integral of L_k x over [t - 1, t], v that of x' from t - d
    to t - 1, divided by mu.
    """
    P, S, R, N, mu = x["P"], x["S"], x["R"], d.N, d.mu
    Z = x["Z"] if mu else zeros(N, N)
    weights = [(2 * k - 1) * S for k in range(1, d.order + 1)]
    yield "functional", P + symmetric(zeros(N, N), *weights)
    yield from ((name, x[name]) for name in ("S", "R", "Z") if name in x)
    for name, _, A, B in d.loops:
        now, late, *X = pickers(N, 2 + d.order + (1 if mu else 0))
        rate = A @ now + B @ d.K @ late
        if mu:
            v = X.pop()
            rate = rate - mu * (B @ d.K @ v)
        change = []  # the integrals of L_k x', by parts
        for k in range(d.order + 1):
            o = now - (-1) ** k * late
            for i in range(k):
                o = o - (2 * (2 * i + 1) * X[i] if (k + i) % 2 else 0 * now)
            change.append(o)
        flow = stack(rate, *change[:-1])
        total = he(stack(now, *X).T @ P @ flow) + form(S, now) - form(S, late)
        total = total + form(R + 2 * mu * Z, rate)
        for k, o in enumerate(change):
            total = total - (2 * k + 1) * form(R, o)
        yield "decay" + name, -1 * (total - mu * form(Z, v) if mu else total)


def interval_unknowns(d):
    before, within = d.mu < 1, d.mu > 0
    size = d.N * (1 + before + within) if d.order else d.N
    names = ("Q1", "R1") * before + ("Q2", "R2") * within
    unknowns = {name: (d.N, d.N, True) for name in names}
    unknowns.update({"T": ((1 + d.order) * d.N,) * 2 + (False,)} if within else {})
    return dict(unknowns, P=(size, size, True))


def interval(d, x):
    """The ends of the interval apart, with the reciprocally convex bound.

    Of Park, Ko and Jeong (2011), and Seuret and Gouaisbaut (2013).
    """
    P, N, h1, width = x["P"], d.N, 1 - d.mu, 2 * d.mu
    before, within = d.mu < 1, d.mu > 0
    parts = [zeros(N, N)]
    parts += [1 / h1 * x["Q1"]] if before else []
    parts += [1 / width * x["Q2"]] if within else []
    yield "functional", P + symmetric(*parts) if d.order else P
    yield from ((k, v) for k, v in x.items() if k[0] in "QR")
    if within:
        wide = symmetric(x["R2"], 3 * x["R2"]) if d.order else x["R2"]
        kernel = symmetric(wide, wide, b12=x["T"])
        yield "kernel", kernel
    ends = ((" early", 0), (" late", 1)) if d.order and within else (("", 0),)
    names = ["x"] + ["x1"] * before + ["xd", "x2"] * within
    names += (["m1"] * before + ["m2", "m3"] * within) if d.order else []
    at = dict(zip(names, pickers(N, len(names))))  # values, and means between them
    at.setdefault("x1", at["x"])
    at.setdefault("xd", at["x1"])

    def moments(new, old, mean):
        first = at[new] - at[old]
        return [first, at[new] + at[old] - 2 * at[mean]] if d.order else [first]

    for (name, _, A, B), (end, late) in ((a, b) for a in d.loops for b in ends):
        rate = A @ at["x"] + B @ d.K @ at["xd"]
        state, flow, total = [at["x"]], [rate], 0 * eye(N * len(names))
        if before:
            total = total + form(x["Q1"], at["x"]) - form(x["Q1"], at["x1"])
            total = total + h1 * h1 * form(x["R1"], rate)
            for k, m in enumerate(moments("x", "x1", "m1")):
                total = total - (2 * k + 1) * form(x["R1"], m)
            state += [h1 * at["m1"]] if d.order else []
            flow += [at["x"] - at["x1"]] if d.order else []
        if within:
            both = moments("x1", "xd", "m2") + moments("xd", "x2", "m3")
            total = total + form(x["Q2"], at["x1"]) - form(x["Q2"], at["x2"])
            total = total + width * width * form(x["R2"], rate)
            total = total - form(kernel, stack(*both))
            state += [width * at["m2" if late else "m3"]] if d.order else []
            flow += [at["x1"] - at["x2"]] if d.order else []
        total = total + he(stack(*state).T @ P @ stack(*flow))
        yield "decay" + name + end, -1 * total


FORMS_OF_DELAY = {
    "functional": (krasovskii_unknowns, krasovskii),
    "shift": (krasovskii_unknowns, krasovskii),
    "legendre": (legendre_unknowns, legendre),
    "interval": (interval_unknowns, interval),
}


def exponential(x, terms=80):
    """Bounds of e^x, for 0 <= x < 20."""
    if not 0 <= x < 20:
        raise Beyond("an exponential is out of this checker's range")
    total = term = Fraction(1)
    for k in range(1, terms):
        term = term * x / k
        total += term
    return total, total + term


def decimal(x):
    """A fraction with a finite decimal expansion, written out."""
    k = next(k for k in range(800) if (x * 10**k).denominator == 1)
    digits = str(abs(x * 10**k)).rjust(k + 1, "0")
    text = digits[: len(digits) - k] + ("." + digits[len(digits) - k :] if k else "")
    return "-" * (x < 0) + text


# ---- 6. Lemma 2.1, the observer, matrices, LMIs of one's own


class Mass:
    """The symmetric part of M - B K_A exceeds beta^2 at each vertex."""

    def __init__(self, file):
        vertices = given_vertices(file["plant"])
        need(file["plant"]["kind"] == "second order", "this plant has no mass")
        n, self.file = len(vertices[0]["M"]), file
        self.many, self.beta2 = len(vertices), positive(file["beta"]) ** 2
        self.data = [(matrix(v["M"], n, n), matrix(v["B"], n)) for v in vertices]
        for v in vertices:
            keys(v, "M D S B F")
            _ = matrix(v["D"], n, n), matrix(v["S"], n, n), matrix(v["F"], n)
        self.n, self.m = n, len(self.data[0][1][0])
        need(
            all(len(B[0]) == self.m for _, B in self.data),
            "the vertices differ in size",
        )
        self.K = None if file["K"] is None else matrix(file["K"], self.m, n)

    def unknowns(self):
        return {"K_A": (self.m, self.n, False)} if self.K is None else {}

    def blocks(self, x):
        for k, (M, B) in enumerate(self.data):
            if (M, B) in self.data[:k]:
                continue
            name = f"mass {k + 1}" if self.many > 1 else "mass"
            mass = M - B @ (x["K_A"] if self.K is None else self.K)
            yield name, Fraction(1, 2) * he(mass) - self.beta2 * eye(self.n)

    def claims(self):
        where = every_plant(self.file, self.many)
        least = "the eigenvalues of its symmetric part exceed beta^2 = "
        return [f"for {where}, M - B K_A is regular", least + decimal(self.beta2)]


class Observer:
    """Theorem 2.5 at each vertex: u = K x^, and x^ follows a model of the plant.

    L = P1^-1 Y'. The dual state is T xi.
    """

    def __init__(self, file):
        self.file, T = file, file["coordinates"]["T"]
        keys(file["coordinates"], "T left unit")
        need(len(T) == 2, "there are two parts of T")
        plant = dict(file, U=[], K_A=None)
        self.vertices, (m, _) = vertices_of(plant)
        N = self.N = len(self.vertices[0].E)
        self.T1, T2 = matrix(T[0], N, N), matrix(T[1], N, N)
        self.T = symmetric(self.T1, T2)
        self.back = solve(self.T, eye(2 * N)).T
        self.left = matrix(file["coordinates"]["left"], N, N)
        solve(self.left, eye(N))  # it must be regular
        self.unit = positive(file["coordinates"]["unit"])
        keys(file["model"], "E A Bu")
        E, A = matrix(file["model"]["E"], N, N), matrix(file["model"]["A"], N, N)
        self.model = E, A, matrix(file["model"]["Bu"], N, m)
        self.K, C = matrix(file["K"], m, N), matrix(file["C"], len(file["C"]), N)
        self.q, self.C = len(C), C @ solve(self.T1, eye(N)).T
        self.Q = self.T.T @ matrix(file["Q_F"], 2 * N)
        self.R = matrix(file["R_F"], self.q, self.q)
        need(len(file["noises"]) == len(self.vertices), "a vertex without noise")
        self.p = len(file["noises"][0][0])
        self.noises = [matrix(w, N, self.p) for w in file["noises"]]
        self.L = matrix(file["L"], N, self.q) if "L" in file else None

    def unknowns(self):
        N = self.N
        unknowns = {"P1": (N, N, True), "P2": (N, N, True), "J": (self.p, self.p, True)}
        return unknowns if self.L else dict(unknowns, Y=(self.q, N, False))

    def blocks(self, x):
        P1, P2, J, N = x["P1"], x["P2"], x["J"], self.N
        Y = self.L.T @ self.T1 @ P1 if self.L else x["Y"]
        yield "P1", P1
        yield "P2", P2
        if self.L:
            trace = sum(J[k][k] for k in range(self.p))
            yield (
                "trace",
                Matrix([[positive(self.file["bound"]) / self.unit**2 - trace]]),
            )
        P, (E0, A0, B0) = symmetric(P1, P2), self.model
        push = stack(Y.T @ self.R, zeros(N, self.q))
        for i, (d, w) in enumerate(zip(self.vertices, self.noises), 1):
            off = (B0 - d.B) @ self.K  # error and state, without L (2.40)
            E = quarters(E0, d.E - E0, zeros(N, N), d.E)
            BK = d.B @ self.K
            A = quarters(A0 + off, d.A - A0 - off, -1 * BK, d.A + BK)
            feed = quarters(self.C.T @ Y, zeros(N, N), zeros(N, N), zeros(N, N))
            flow = he((self.T.T @ solve(E, A) @ self.back).T @ P + feed)
            PQ = P @ self.Q
            yield (
                f"decay {i}",
                symmetric(
                    -1 * flow, eye(len(PQ[0])), eye(self.q), b12=-1 * PQ, b13=-1 * push
                ),
            )
            inner = self.left @ d.E @ self.T1
            noise = 1 / self.unit * (self.left @ w)
            yield f"cost {i}", symmetric(J, inner @ P1 @ inner.T, b12=noise.T)

    def claims(self):
        if not self.L:
            return ["no observer with this K is proven by these LMIs at the vertices"]
        loop = "at each vertex (not between them) the loop with the observer is stable"
        return [loop, f"tr J is at most {self.file['bound']} there"]


def quarters(a, b, c, d):
    return Matrix([r + s for r, s in zip(a, b)] + [r + s for r, s in zip(c, d)])


class Own:
    """LMIs that someone wrote: constants, and terms L X R in unknowns X."""

    def __init__(self, file):
        self.file, self.shapes, words = file, {}, file.get("statement", [])
        good = isinstance(words, list) and all(isinstance(w, str) for w in words)
        need(good, "the statement must be words")
        for name, rows, columns, even in file["shapes"]:
            good = type(rows) is type(columns) is int and min(rows, columns) > 0
            need(good, "an unknown has a name and a size")
            need(even is False or (even is True and rows == columns), "not symmetric")
            self.shapes[sane(name)] = rows, columns, even
        self.names = [sane(name) for name, *_ in file["expressions"]]
        for names, things in (
            (self.shapes, file["shapes"]),
            (set(self.names), self.names),
        ):
            need(len(names) == len(things) > 0, "a name comes twice, or none does")

    def unknowns(self):
        return self.shapes

    def blocks(self, x):
        for name, constant, terms in self.file["expressions"]:
            n = len(constant)
            need(n > 0, "a block is empty")
            total = matrix(constant, n, n, ratio)
            for unknown, transposed, left, right in terms:
                need(isinstance(transposed, bool), "transposed is true or false")
                X = x[unknown].T if transposed else x[unknown]
                left, right = (
                    matrix(left, n, len(X), ratio),
                    matrix(right, len(X[0]), n, ratio),
                )
                total = total + left @ X @ right
            yield name, total

    def claims(self):
        how = "these blocks are positive definite"
        if "multipliers" in self.file:
            how = "no point makes all these blocks positive definite"
        return [f"{how}: " + ", ".join(self.names)]


# ---- 7. A mode that no gain moves, a singular mass, a small input bound


def place_of(file, key, vertices):
    """Two vertices, from 0."""
    i, j = file[key]
    inside = type(i) is type(j) is int and 0 <= i < len(vertices) > j >= 0
    need(inside, f"{key} must be two vertices, from 0")
    return i, j


def singular_mass(file):
    """det E changes its sign between two vertices, or is zero halfway."""
    vertices, _ = vertices_of(file)
    i, j = place_of(file, "between", vertices)
    E, F = vertices[i].E, vertices[j].E
    signs = determinant(E) * determinant(F) <= 0 or determinant(E + F) == 0
    need(signs, "no mass is singular there")
    return ["no gain makes every plant of the polytope stable: a plant between the "
            f"vertices {i + 1} and {j + 1} has a singular matrix E"]  # fmt: skip


def unreached_response(file):
    """v (s E - A) = y C and v B + y D = 0: y z = v W w at s, whatever u is.

    A stable loop has a bounded transfer matrix T in Re s >= 0, with y T = v W,
    so its norm is at least |v W| / |y|.
    """
    vertices, (m, _) = vertices_of(file)
    k, gamma = file["vertex"], positive(file["bound"])
    inside = type(k) is int and 0 <= k < len(vertices)
    need(inside, "vertex must be one of the plant's, from 0")
    d = vertices[k]
    A, B, C, D = d.A, d.B, d.C, d.D
    if file["K"] is not None:
        K = matrix(file["K"], m, len(A)) or zeros(1, len(A))
        A, B, C, D = A + B @ K, 0 * B, C + D @ K, 0 * D
    sigma, omega = (row[0] for row in matrix(file["s"], 2, 1, ratio))
    v, y = matrix(file["v"], 2, len(A), ratio), matrix(file["y"], 2, len(C), ratio)
    turned = Matrix([[-e for e in v[1]], v[0]])  # j v
    left = sigma * (v @ d.E) + omega * (turned @ d.E) - v @ A - y @ C
    need(left == 0 * left, "v (s E - A) isn't y C")
    need(v @ B + y @ D == 0 * (v @ B), "an input reaches this response")
    reached = sum(e * e for row in v @ d.W for e in row)
    asked = gamma**2 * sum(e * e for row in y for e in row)
    need(sigma >= 0 and reached > 0 and reached >= asked, "it is below gamma")
    where = f"the vertex {k + 1}" if len(vertices) > 1 else "the plant"
    who = "no gain makes" if file["K"] is None else "the given gain doesn't make"
    return [f"{who} {where} stable with an H-infinity norm below {file['bound']}"]


def determinant(x):
    rows, product = [list(row) for row in x], Fraction(1)
    for k in range(len(rows)):
        top = next((r for r in range(k, len(rows)) if rows[r][k]), None)
        if top is None:
            return Fraction(0)
        rows[k], rows[top] = rows[top], rows[k]
        product *= rows[k][k] * (1 if top == k else -1)
        for r in range(k + 1, len(rows)):
            f = rows[r][k] / rows[k][k]
            rows[r] = [a - f * b for a, b in zip(rows[r], rows[k])]
    return product


def fixed_mode(file):
    """V A = L V E and V B = 0: the roots of h, L's polynomial, can't be moved.

    One of them lies outside of a region.
    """
    vertices, (m, _) = vertices_of(file)
    i, j = place_of(file, "place", vertices)
    one, other, half = vertices[i], vertices[j], Fraction(1, 2)
    E, A, B = (half * (getattr(one, x) + getattr(other, x)) for x in "EAB")
    where = f"the plant halfway between the vertices {i + 1} and {j + 1}"
    if i == j:
        where = f"the vertex {i + 1}" if len(vertices) > 1 else "the plant"
    if file["K"] is not None:
        A, B = A + B @ (matrix(file["K"], m, len(E)) or zeros(1, len(E))), 0 * B
    h = [ratio(x) for x in file["polynomial"]]
    k = len(h) - 1
    need(k > 0 and h[-1] == 1, "the polynomial must be monic")
    V = matrix(file["rows"], k, len(E), ratio)
    L = Matrix([*eye(k)[1:], [-a for a in h[:-1]]])
    need(determinant(E) != 0, "E is singular")
    need(definite(V @ V.T), "the rows aren't independent")
    need(V @ A == L @ V @ E and V @ B == 0 * (V @ B), "the rows aren't a fixed mode's")
    asked, text = file["requirement"], "its poles lie left of the imaginary axis"
    if asked is not None:
        if asked["kind"] != "region":
            raise Beyond(f"what a pole does to a {asked['kind']!r} isn't known here")
        sane(asked["name"])
        plain = asked["form"] == "disk"
        if asked["form"] == "half-plane":
            plain = 2 * number(asked["sigma"]) == number(asked["alpha"][0][0])
        text = region(asked)[2] if plain else in_matrices(asked)
    alpha, beta, _ = region(asked or STABILITY)
    x, y = map(ratio, file["point"])
    need(isinstance(file["witness"], list), "the witness must be a list")
    if file["witness"]:
        v = [(number(a), number(b)) for a, b in file["witness"]]
        need(len(v) == len(alpha), "the witness has a wrong length")
        need(outside(alpha, beta, h, x, y, v), "the mode keeps what is asked")
    else:
        need(mirrored(alpha, beta, h), "the modes don't come in pairs")
    s = f"{float(x):.6g}" + (f"{float(y):+.6g}j" if y else "")
    mode = f"no gain moves the mode near s = {s} of {where}"
    if file["K"] is not None:
        mode = f"{where} has {'under the given gain ' if m else ''}a mode near s = {s}"
    return [f"{mode}, which breaks: {text}"]


def outside(alpha, beta, h, x, y, v):
    """Whether a root of h near c = x + iy lies outside of a region.

    h'/h is the sum of 1 / (c - root): one root is within n |h(c) / h'(c)|.
    There v* (alpha + beta s + beta' conj(s)) v stays positive or zero.
    """
    a, b = [p for p, _ in v], [q for _, q in v]  # v = a + ib
    level = bilinear(a, alpha, a) + bilinear(b, alpha, b)
    re = bilinear(a, beta, a) + bilinear(b, beta, b)
    im = bilinear(a, beta, b) - bilinear(b, beta, a)
    level += 2 * (x * re - y * im)
    value = square_at(h, x, y)
    slope = square_at([k * a for k, a in enumerate(h)][1:], x, y)
    reach = 4 * (len(h) - 1) ** 2 * value * (re**2 + im**2)
    return any(map(any, v)) and level >= 0 and level**2 * slope >= reach


def bilinear(p, x, q):
    return sum(a * e * b for a, row in zip(p, x) for e, b in zip(row, q))


def square_at(h, x, y):
    """|h(x + iy)|^2"""
    re = im = Fraction(0)
    for a in reversed(h):
        re, im = re * x - im * y + a, re * y + im * x
    return re * re + im * im


def mirrored(alpha, beta, h):
    """Whether the roots of h are mirrored at the boundary of a half-plane or disk.

    Then they come in pairs, of which one isn't inside. Around a point of the line h
    is even or odd; around the centre of the circle it is its own image.
    """
    n = len(h) - 1
    if len(alpha) == 1 and beta[0][0]:
        return not any(moved(h, -alpha[0][0] / (2 * beta[0][0]))[n - 1 :: -2])
    if beta != [[0, 1], [0, 0]] or not alpha[0][0] == alpha[1][1] < 0:
        return False
    g = moved(h, -alpha[0][1])
    turned = [g[n - k] * alpha[0][0] ** (2 * n - 2 * k) for k in range(n + 1)]
    return g[0] != 0 and all(a * g[n] == b * g[0] for a, b in zip(turned, g))


def moved(h, a):
    """The coefficients of h(a + t)."""
    coefficients = []
    for x in reversed(h):
        up, down = [a * e for e in coefficients] + [0], [0] + coefficients
        coefficients = [p + q for p, q in zip(up, down)]
        coefficients[0] += x
    return coefficients


def small_input(file):
    """The LMIs of some modes' part of the plant exclude each other.

    If W A = L W E, the LMIs hold for p = V P V*, y = Y V*, V = W E, with L, W B and
    V x0. Here W = [1 X] T, and entry by entry |X| <= spread, |L - L0| <= blur.
    With K = T A R and J = T E R the equations for X and L, by blocks, are

        L = K11 + X K21 - L (J11 - 1) - L X J21,
        X K22 - L X J22 = L J12 - K12.

    Divided by the differences of the diagonals of K22 and K11 they map these
    bounds into themselves: a fixed point exists (Brouwer). Complex matrices c are
    real ones, [Re c, -Im c; Im c, Re c].
    """
    d = Design(dict(file, unknowns={}))
    need(file["K"] is None, "the gain must be free")
    need(not d.slack, "this proof is for a common P")
    (bound,) = [r for r in d.asked if r["kind"] == "input"]
    keys(bound, "kind name u_max x0 acceleration")
    need(bound["acceleration"] is False, "this proof is for a bound of K x")
    vertex, N, m = file["vertex"], d.N, d.m
    need(type(vertex) is int and 0 <= vertex < d.many, "there is no such vertex")
    v, k = d.plain[vertex], len(file["spread"])
    need(0 < k < N, "the part must be smaller than the plant")
    spread, blur = matrix(file["spread"], k, N - k), matrix(file["blur"], k, k)
    need(min(map(min, spread + blur)) >= 0, "a bound is negative")
    T, R = (complex_matrix(file[x], N) for x in ("rows", "columns"))
    one, start = eye(N), matrix([[e] for e in bound["x0"]], N, 1)
    E, A, B, x0 = (real_form(x, 0 * x) for x in (v.E, v.A, v.B, start))
    K, J, push, begin = T @ A @ R, T @ E @ R, T @ B, T @ E @ x0
    off = J - real_form(one, 0 * one)
    need(max(map(sum, sizes_of(off))) < 1, "the columns aren't near an inverse")
    top, rest = slice(0, k), slice(k, N)

    def cut(x, rows, columns):
        re, im = halves(x)
        return real_form(*(Matrix(r[columns] for r in y[rows]) for y in (re, im)))

    def size(x, rows, columns):
        return sizes_of(cut(x, rows, columns))

    def split(x):
        within = [
            [e if i == j else 0 for j, e in enumerate(r)] for i, r in enumerate(x)
        ]
        return Matrix(within), x - Matrix(within)

    L = cut(K, top, top)
    own, beside = split(sizes_of(L))
    _, beside_rest = split(size(K, rest, rest))
    error = sizes_of(L @ cut(J, top, rest) - cut(K, top, rest))
    far = sizes_of(L) + blur
    new_blur = spread @ size(K, rest, top) + far @ size(off, top, top)
    new_blur = new_blur + far @ spread @ size(off, rest, top)
    new_spread = error + blur @ size(J, top, rest) + spread @ beside_rest
    new_spread = new_spread + (beside + blur) @ spread @ size(J, rest, rest)
    new_spread = new_spread + own @ spread @ size(off, rest, rest)
    re, im = halves(K)
    for i in range(k):
        for j in range(N - k):
            h = k + j
            gap = max(abs(re[h][h] - re[i][i]), abs(im[h][h] - im[i][i]))
            need(new_spread[i][j] <= gap * spread[i][j], "the part isn't enclosed")
        need(
            all(a <= b for a, b in zip(new_blur[i], blur[i])), "the part isn't enclosed"
        )
    asked = {(r["kind"], r["name"]): r for r in d.asked if r["kind"] == "region"}
    asked["stability", "stability"] = STABILITY
    S = F = zeros(2 * k, 2 * k)
    for key, pair in file["multipliers"]:
        alpha, beta, _ = region(asked.pop(tuple(key)))
        z = complex_matrix(pair, len(alpha) * k)
        need(definite(z, semi=True), f"the multiplier of {key} isn't positive")
        for i, (a, b) in enumerate(zip(alpha, beta)):
            for j in range(len(a)):
                z_ji = cut(z, slice(j * k, j * k + k), slice(i * k, i * k + k))
                S, F = S + a[j] * z_ji, F + b[j] * z_ji
    # the sum of <G, z> over the regions is -tr(Q p) - 2 Re tr(f y)
    every = slice(None)
    Q, f = S + he(F @ L), F @ cut(push, top, every)
    Q_blur = he(sizes_of(F) @ blur)
    f_blur = sizes_of(F) @ spread @ size(push, rest, every)
    U, price = complex_matrix(file["share"], k), complex_matrix(file["price"], m)
    room = [sum(r) for r in f_blur] + [sum(c) for c in zip(*f_blur)]
    whole = [
        symmetric(a, b, b12=c) for a, b, c in zip(halves(U), halves(price), halves(f))
    ]
    whole[1] = Matrix(
        [*([*r, *s] for r, s in zip(halves(U)[1], halves(f)[1])),
         *([*r, *s] for r, s in zip(halves(f.T)[1], halves(price)[1]))]
    )  # fmt: skip
    need(
        definite(real_form(*whole) - diagonal(room * 2), semi=True),
        "the multiplier of u_max isn't positive",
    )
    D = Q - U - diagonal([sum(r) for r in Q_blur] * 2)
    need(definite(D, semi=True), "the multiplier of x0 isn't positive")
    h = Matrix([e[0]] for e in cut(begin, top, every))
    force, spill = D @ h, spread @ size(begin, rest, every)
    least = (h.T @ force)[0][0] - 2 * sum(
        (abs(force[i][0]) + abs(force[k + i][0])) * spill[i][0] for i in range(k)
    )
    paid = sum(price[i][i] for i in range(m))
    need(
        positive(bound["u_max"]) ** 2 * paid < least, "the multipliers exclude nothing"
    )
    which = "no gain and no matrices prove by these LMIs: "
    return [which + "; ".join(d.claims())]


def complex_matrix(pair, n):
    """A square matrix of n complex rows, from its real and its imaginary part."""
    re, im = pair
    return real_form(matrix(re, n, n), matrix(im, n, n))


def real_form(re, im):
    return Matrix([*([*a, *(-e for e in b)] for a, b in zip(re, im)),
                   *([*b, *a] for a, b in zip(re, im))])  # fmt: skip


def halves(x):
    """Real and imaginary part of a complex matrix in its real form."""
    rows, columns = len(x) // 2, len(x[0]) // 2
    return [Matrix(r[:columns] for r in y) for y in (x[:rows], x[rows:])]


def sizes_of(x):
    """A bound of the size of each complex entry."""
    re, im = halves(x)
    return Matrix([abs(a) + abs(b) for a, b in zip(r, s)] for r, s in zip(re, im))


def diagonal(entries):
    n = len(entries)
    return Matrix([e if i == j else Fraction(0) for j in range(n)]
                  for i, e in enumerate(entries))  # fmt: skip


# ---- 8. The verdict


def hold(problem, file):
    """Whether all blocks are positive definite at the file's unknowns."""
    shapes = problem.unknowns()
    given = file.get("unknowns", {})
    need(isinstance(given, dict) and set(given) == set(shapes), "other unknowns")
    x = {}
    for name, (rows, columns, even) in shapes.items():
        x[name] = matrix(given[name], rows, columns)
        need(not even or x[name] == x[name].T, f"{name} isn't symmetric")
    blocks = list(problem.blocks(x))
    for key, g in blocks:
        need(definite(g), f"the block {key} isn't positive definite")
    return [key for key, _ in blocks]


def exclude(problem, file):
    """Whether the multipliers show that the blocks can't all be positive.

    With Z_k >= 0, not all zero, sum <G_k(x), Z_k> would be positive. It must
    not depend on x, and be zero or negative. A requirement with an unknown
    size s demands s G(x / s) of x: what is constant in G is multiplied by s.
    """
    shapes, Z, owners = problem.unknowns(), {}, getattr(problem, "sizes", {})
    shapes = {name: shape for name, shape in shapes.items() if name not in owners}
    zero = {name: zeros(rows, columns) for name, (rows, columns, _) in shapes.items()}
    if isinstance(problem, Design):  # blocks without a multiplier add nothing
        named = [(key[3:] * 2)[:2] for key, _ in file["multipliers"]]
        problem.pairs = [pair for pair in problem.pairs if list(pair) in named]
    constant = dict(problem.blocks(zero))
    given = {json.dumps(key): z for key, z in file["multipliers"]}
    need(len(given) == len(file["multipliers"]), "two multipliers have one key")
    for key, g in constant.items():
        z = given.pop(json.dumps(key), None)
        if z is not None:
            Z[key] = matrix(z, len(g), len(g), ratio)
            need(definite(Z[key], semi=True), f"the multiplier of {key} isn't positive")
    need(not given, "a multiplier belongs to no block")
    need(any(any(map(any, z)) for z in Z.values()), "there is no multiplier")
    for name, (rows, columns, even) in shapes.items():
        for i in range(rows):
            for j in range(i + 1 if even else columns):
                x = dict(zero, **{name: zeros(rows, columns)})
                x[name][i][j] = Fraction(1)
                if even:
                    x[name][j][i] = Fraction(1)
                slope = sum(product_of(g, Z[k], constant[k])
                            for k, g in problem.blocks(x) if k in Z)  # fmt: skip
                need(slope == 0, f"the multipliers leave {name} a way out")
    parts = {k: product_of(constant[k], z) for k, z in Z.items()}
    for name, r in owners.items():
        slope = sum(v for k, v in parts.items() if k[:2] == (r["kind"], r["name"]))
        need(slope == 0, f"the multipliers leave the {name} a way out")
        parts = {k: v for k, v in parts.items() if k[:2] != (r["kind"], r["name"])}
    need(sum(parts.values()) <= 0, "the multipliers exclude nothing")
    return list(Z)


def product_of(g, z, less=None):
    """<g - less, z>"""
    g = g if less is None else g - less
    return sum(a * b for r, s in zip(g, z) for a, b in zip(r, s) if a)


LOOP, HEAD = "plant U K_A ", "format version kind checksum claims "
PROVEN, EXCLUDED = "unknowns blocks", "multipliers"
KINDS = {  # what reads it, and the keys of its file
    "design": (Design, LOOP + "K coupling epsilon E0 requirements " + PROVEN),
    "delay": (Delay, LOOP + "K tau mu delta alpha method order misprints analysis "
              "coordinates exponentials " + PROVEN),
    "regularization": (Mass, "plant K beta " + PROVEN),
    "observer": (Observer, "plant K C Q_F R_F noises model coordinates L bound "
                 + PROVEN),
    "lmi": (Own, "shapes expressions statement digits " + PROVEN),
    "fixed mode": (fixed_mode, LOOP + "K requirement place polynomial rows point "
                   "witness"),
    "singular mass": (singular_mass, LOOP + "between"),
    "unreached response": (unreached_response, LOOP + "K bound vertex s v y"),
    "small input": (small_input, LOOP + "K coupling epsilon E0 requirements vertex "
                    "rows columns spread blur multipliers share price"),
}  # fmt: skip
LESS = {"observer": "L bound", "lmi": "statement digits"}  # only with a point
BEYOND = {
    "sampled": "it encloses exponentials of matrices in balls",
    "infeasible delay modes": "it encloses irrational eigenvalues in balls",
}


def check(text):
    """The claims that the text of a proof file proves; else Refused or Beyond."""
    file = contents(text)
    good = isinstance(file, dict) and file.get("format") == "sosbook proof"
    need(good, "no proof file")
    need(type(file.get("version")) is int, "there is no version")
    if file["version"] != 1:
        raise Beyond("this checker reads version 1 of the format")
    rest = {key: value for key, value in file.items() if key != "checksum"}
    need(
        file.get("checksum") == digest(rest), "the checksum isn't that of the contents"
    )
    plant = file.get("plant")
    if isinstance(plant, dict) and len(plant.get("vertices", ())) > MOST_VERTICES:
        raise Beyond(f"the plant has more than {MOST_VERTICES} vertices")
    whole = str(file.get("kind"))
    if whole in BEYOND:
        raise Beyond(f"rationals can't redo this proof: {BEYOND[whole]}")
    *refused, kind = whole.rsplit("infeasible ", 1)
    if kind not in KINDS or refused not in ([], [""]):
        raise Beyond(f"a proof of the kind {whole!r} isn't known here")
    reader, names = KINDS[kind]
    if refused:
        need(names.endswith(PROVEN), "there is no such refusal")
        names = names.replace(PROVEN, EXCLUDED)
        names += " coordinates" if kind == "design" else ""
        names = " ".join(set(names.split()) - set(LESS.get(kind, "").split()))
    keys(file, HEAD + names)
    problem = reader(file)
    if isinstance(problem, list):  # of section 7
        claims = problem
    elif refused:
        exclude(problem, file)
        claims = problem.claims()
        if kind in ("design", "delay", "regularization"):
            how = "no matrices prove" if problem.K else "no gain and no matrices prove"
            how = "no gain proves" if kind == "regularization" else how
            which = "by these LMIs" + getattr(problem, "condition", "")
            claims = [f"{how} {which}: " + "; ".join(claims)]
    else:
        proven, claims = hold(problem, file), problem.claims()
        proven = sorted(map(json.dumps, proven))
        listed = sorted(map(json.dumps, file["blocks"]))
        need(proven == listed, "the blocks aren't those listed")
    other = "the file claims something else: " + "; ".join(claims)
    need(file["claims"] == claims, other)
    return claims


def contents(text):
    """What a text in JSON holds, within the limits."""
    value = json.loads(text, object_pairs_hook=unique, parse_constant=nothing,
                       parse_int=whole_number)  # fmt: skip
    level = [value]
    for _ in range(DEEPEST):
        longest = max((len(x) for x in level if isinstance(x, str)), default=0)
        if longest > 2 * MOST_DIGITS + 2:
            raise Beyond(f"a text has {longest} characters")
        level = [x for v in level if isinstance(v, (dict, list))
                 for x in (v.values() if isinstance(v, dict) else v)]  # fmt: skip
        if not level:
            return value
    raise Refused("its lists are nested too deeply")


def unique(pairs):
    need(len(dict(pairs)) == len(pairs), "a key comes twice")
    return dict(pairs)


def nothing(word):
    raise Refused(f"{word} is no number")


def whole_number(word):
    need(len(word) <= 400, "a whole number has too many digits")
    return int(word)


def digest(value):
    plain = json.dumps(value, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(plain.encode()).hexdigest()


MALFORMED = (LookupError, TypeError, AttributeError, ValueError, RecursionError,
             OverflowError)  # fmt: skip
