"""Check a proof that is a text with data: ``python kernel.py proof.json``.

It knows no control. The text says which matrices must be positive; the file holds data
and either a point at which all are positive definite, or multipliers by which they
can't all be. Arithmetic is exact, and standard Python is all that it needs. What the
matrices mean is said by whoever wrote the text.

 1. Matrices: integers over one denominator    2. The language
 3. Values, and how a sum of them leads back   4. Positive    5. The verdict
"""

import json
import re
import sys
from fractions import Fraction
from math import gcd, lcm

MOST_DIGITS, MOST_BYTES, LARGEST = 100_000, 200_000_000, 2000


class Refused(Exception):
    """The file proves nothing; the text says why."""


class Beyond(Exception):
    """The file may be right, but it is too large to tell."""


def need(condition, words):
    if not condition:
        raise Refused(words)


# ---- 1. Matrices: integers over one denominator


class Mat:
    """r x c rationals: rows ``a`` of integers over ``d``."""

    __slots__ = "a", "c", "d", "r"

    def __init__(self, r, c, a, d=1):
        self.r, self.c, self.a, self.d = r, c, a, d

    def __add__(self, o):
        need((self.r, self.c) == (o.r, o.c), "a sum of two shapes")
        d = lcm(self.d, o.d)
        p, q = d // self.d, d // o.d
        rows = zip(self.a, o.a)
        a = [[p * x + q * y for x, y in zip(u, v)] for u, v in rows]
        return Mat(self.r, self.c, a, d)

    def times(self, f):
        n, d = f.numerator, f.denominator
        return Mat(self.r, self.c, [[n * x for x in u] for u in self.a], self.d * d)

    def __matmul__(self, o):
        need(self.c == o.r, "a product of shapes that don't fit")
        rows = []
        for u in self.a:
            total = [0] * o.c
            for x, v in zip(u, o.a):
                for j, y in enumerate(v if x else ()):
                    if y:
                        total[j] += x * y
            rows.append(total)
        return Mat(self.r, o.c, rows, self.d * o.d)

    @property
    def T(self):
        rows = (
            [list(v) for v in zip(*self.a)] if self.r else [[] for _ in range(self.c)]
        )
        return Mat(self.c, self.r, rows, self.d)

    def __eq__(self, o):
        rows = zip(self.a, o.a)
        same = (x * o.d == y * self.d for u, v in rows for x, y in zip(u, v))
        return (self.r, self.c) == (o.r, o.c) and all(same)

    def cut(self, i, r, j, c):
        return Mat(r, c, [u[j : j + c] for u in self.a[i : i + r]], self.d)

    def dot(self, o):
        rows = zip(self.a, o.a)
        return Fraction(sum(x * y for u, v in rows for x, y in zip(u, v)), self.d * o.d)

    def at(self, i, j):
        return Fraction(self.a[i][j], self.d)


def eye(n):
    return Mat(n, n, [[int(i == j) for j in range(n)] for i in range(n)])


def zeros(r, c):
    return Mat(r, c, [[0] * c for _ in range(r)])


def kron(p, q):
    need(p.r * q.r * p.c * q.c <= LARGEST**2, "a Kronecker product is too large")
    rows = [[x * y for x in u for y in v] for u in p.a for v in q.a]
    return Mat(p.r * q.r, p.c * q.c, rows, p.d * q.d)


def trace(x):
    need(x.r == x.c, "the trace of a matrix that isn't square")
    return Fraction(sum(x.a[i][i] for i in range(x.r)), x.d)


def inverse(x):
    """By Gauss and Jordan."""
    need(x.r == x.c, "the inverse of a matrix that isn't square")
    n = x.r
    rows = [[Fraction(e, x.d) for e in u] + [Fraction(i == j) for j in range(n)]
            for i, u in enumerate(x.a)]  # fmt: skip
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


def gather(rows, c):
    d = lcm(*(e.denominator for u in rows for e in u))
    a = [[e.numerator * (d // e.denominator) for e in u] for u in rows]
    return Mat(len(rows), c, a, d)


NUMBER = re.compile(r"-?(\d+(\.\d+)?(e[-+]?\d{1,3})?|\d+/\d+)", re.ASCII)


def number(text):
    """A decimal, or a fraction, in a string."""
    good = isinstance(text, str) and NUMBER.fullmatch(text)
    need(good and not re.search("/0+$", text), f"{text!r:.40} isn't a number")
    need(max(map(len, text.split("/"))) <= MOST_DIGITS + 1, "a number is too long")
    try:
        return Fraction(text)
    except ValueError:  # Python's own limit, which a program may lift
        raise Beyond("a number has more digits than Python reads here") from None


def read(x):
    """A number, or a matrix; {"zeros": [r, c]} stands for one without entries."""
    if isinstance(x, dict):
        good = set(x) == {"zeros"} and len(x["zeros"]) == 2
        good = good and all(type(k) is int and 0 <= k < LARGEST for k in x["zeros"])
        need(good, "an odd matrix")
        return zeros(*x["zeros"])
    if not isinstance(x, list):
        return number(x)
    good = x and all(isinstance(u, list) and len(u) == len(x[0]) > 0 for u in x)
    need(good, "the rows of a matrix differ in length")
    return gather([[number(e) for e in u] for u in x], len(x[0]))


# ---- 2. The language

TOKEN = re.compile(
    r"\s*(\d+(?:\.\d+)?|[A-Za-z]\w*(?:\.\w+)*|>=|==|[-+/'^()\[\],;:=>.])", re.ASCII
)
WORDS = {"he", "kron", "inv", "tr", "I", "O", "rows", "cols", "pick", "at"}


class Parser:
    """The tokens of a line, read from the left into nested tuples."""

    def __init__(self, text):
        text = text.split("#")[0].rstrip()
        self.t, self.k, at = [], 0, 0
        while at < len(text):
            m = TOKEN.match(text, at)
            need(m, f"not understood: {text[at:]!r:.40}")
            self.t.append(m[1])
            at = m.end()

    def next(self, *wanted):
        token = self.t[self.k] if self.k < len(self.t) else ""
        if wanted and token not in wanted:
            return ""
        self.k += 1
        return token

    def must(self, token):
        need(self.next(token), f"{token} is missing in {' '.join(self.t)!r:.60}")

    def expression(self):
        left = ("neg", self.product()) if self.next("-") else self.product()
        while sign := self.next("+", "-"):
            right = self.product()
            left = ("add", left, right if sign == "+" else ("neg", right))
        return left

    def product(self):
        left = self.factor()
        while True:
            if self.next("/"):
                left = ("div", left, self.factor())
            elif self.k < len(self.t) and re.match(r"[\w(\[]", self.t[self.k]):
                left = ("mul", left, self.factor())
            else:
                return left

    def factor(self):
        token = self.next()
        if token == "(":
            x = self.expression()
            self.must(")")
        elif token == "[":
            x = ("block", self.table())
        elif token[:1].isdigit():
            x = ("number", token)
        else:
            need(token[:1].isalpha(), f"{token!r} where a matrix is wanted")
            x = ("name", token)
            if token in WORDS:
                self.must("(")
                x = (token, self.expression())
                while self.next(","):
                    x += (self.expression(),)
                self.must(")")
        while mark := self.next("'", "^"):
            x = ("T", x) if mark == "'" else ("pow", x, ("number", self.next()))
        return x

    def table(self):
        rows = [[]]
        while True:
            rows[-1].append(("mirror",) if self.next(".") else self.expression())
            end = self.next(",", ";", "]")
            need(end, "a block matrix that doesn't end")
            if end == "]":
                return rows
            if end == ";":
                rows.append([])


def parse(text):
    """The steps of a text: definitions, statements, and loops over them."""
    program, names = [], set()
    for line in text.split("\n"):
        p = Parser(line)
        if not p.t:
            continue
        inner = line[:1] == " "
        if p.t[0] == "for":
            loop = line.split("#")[0].strip()
            m = re.fullmatch(r"for (\w+(?:, \w+)*) in (\w+):", loop, re.ASCII)
            need(m and not inner, "for i, j in pairs: is the only loop")
            program.append(("for", m[1].split(", "), m[2], []))
            continue
        good = not inner or (program and program[-1][0] == "for")
        need(good, "an odd indent")
        body = program[-1][3] if inner else program
        name, mark = p.next(), p.next(":", "=")
        need(name not in WORDS and name[:1].isalpha(), f"{name!r} can't be a name")
        need(mark, f"{line!r:.60} is neither a definition nor a statement")
        x = p.expression()
        if mark == "=":
            need(name not in names, f"{name} is defined twice")
            names.add(name)
            body.append(("let", name, x))
        else:
            sign = p.next(">", ">=", "==")
            need(sign, f"{name} states nothing")
            body.append((sign, name, x, p.expression()))
        need(p.k == len(p.t), f"too much in {line!r:.60}")
    return program


# ---- 3. Values, and how a sum of them leads back


class Val:
    """A number or a matrix v; ``back`` holds (value, adjoint -> its share)."""

    __slots__ = "adj", "back", "v"

    def __init__(self, v, *back):
        self.v, self.adj = v, None
        self.back = [(x, f) for x, f in back if x.back is not None] or None


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


def share(z, x, other, left):
    """The share of a factor x in the adjoint z of a product."""
    if scalar(x):
        return z * other if scalar(other) else z.dot(other)
    if scalar(other):
        return z.times(other)
    return z @ other.T if left else other.T @ z


def summand(z, x):
    return trace(z) if scalar(x) and not scalar(z) else z


class Reader:
    """What the names of a text stand for; unknowns lead back to themselves."""

    def __init__(self, data, unknowns=(), sets=(), point=False):
        self.given, self.sets = {*data, *unknowns}, dict(sets)
        need(len(self.given) == len(data) + len(unknowns), "a name is given twice")
        self.env, self.tape, self.at = {k: Val(v) for k, v in data.items()}, [], {}
        for k, v in dict(unknowns).items():
            self.env[k] = x = Val(v)
            x.back = None if point else []

    def keep(self, v, *back):
        x = Val(v, *back)
        if x.back:
            self.tape.append(x)
        return x

    def name(self, text):
        head, *rest = text.split(".")
        return ".".join([head, *(self.at.get(k, k) for k in rest)])

    def value(self, x):
        op = x[0]
        if op == "number":
            return Val(number(x[1]))
        if op == "name":
            name = self.name(x[1])
            need(name in self.env, f"{name} isn't known")
            return self.env[name]
        if op == "block":
            return self.block(x[1])
        return getattr(self, "op_" + op)(*map(self.value, x[1:]))

    def op_neg(self, a):
        return self.keep(mul(Fraction(-1), a.v), (a, lambda z: mul(Fraction(-1), z)))

    def op_T(self, a):
        return self.keep(turned(a.v), (a, turned))

    def op_he(self, a):
        return self.keep(a.v + turned(a.v), (a, lambda z: z + turned(z)))

    def op_tr(self, a):
        return self.keep(trace(a.v), (a, lambda z: eye(a.v.r).times(z)))

    def op_rows(self, a):
        return Val(Fraction(a.v.r))

    def op_cols(self, a):
        return Val(Fraction(a.v.c))

    def op_add(self, a, b):
        v = total(a.v, b.v)
        return self.keep(v, *((x, lambda z, x=x: summand(z, x.v)) for x in (a, b)))

    def op_mul(self, a, b):
        need(a.back is None or b.back is None, "a product of two unknowns")
        ways = (
            (a, lambda z: share(z, a.v, b.v, True)),
            (b, lambda z: share(z, b.v, a.v, False)),
        )
        return self.keep(mul(a.v, b.v), *ways)

    def op_div(self, a, b):
        need(b.back is None and scalar(b.v) and b.v, "a division by no number")
        return self.keep(mul(1 / b.v, a.v), (a, lambda z: mul(1 / b.v, z)))

    def op_kron(self, a, b):
        need(a.back is None, "kron needs a certain first factor")
        return self.keep(kron(a.v, b.v), (b, lambda z: unkron(a.v, b.v, z)))

    def op_inv(self, a):
        need(a.back is None, "the inverse of an unknown")
        return Val(1 / a.v if scalar(a.v) else inverse(a.v))

    def op_pow(self, a, k):
        need(a.back is None and scalar(a.v) and k.v < 10, "no power of a number")
        long = max(map(int.bit_length, a.v.as_integer_ratio())) * size(k)
        need(long <= 4 * MOST_DIGITS, "a power has too many digits")
        return Val(a.v ** size(k))

    def op_at(self, a, i, j):
        i, j = int(i.v) - 1, int(j.v) - 1
        need(a.back is None and 0 <= i < a.v.r and 0 <= j < a.v.c, "no such entry")
        return Val(a.v.at(i, j))

    def op_I(self, n):
        return Val(eye(size(n)))

    def op_O(self, r, c):
        return Val(zeros(size(r), size(c)))

    def op_pick(self, k, parts, n):
        """The k-th of some parts of n rows."""
        row = [int(j + 1 == k.v) for j in range(size(parts))]
        return Val(kron(Mat(1, len(row), [row]), eye(size(n))))

    def block(self, table):
        n, m = len(table), len(table[0])
        need(all(len(r) == m for r in table), "the rows of a block matrix differ")
        e = [[None if x == ("mirror",) else self.value(x) for x in r] for r in table]
        nought = {}  # only the literal 0 fits everywhere
        for i, r in enumerate(table):
            for j, x in enumerate(r):
                if e[i][j] is None:
                    need(j < i < m and e[j][i], "a mirror image of nothing")
                    e[i][j] = self.op_T(e[j][i])
                    x = table[j][i]
                nought[i, j] = x == ("number", "0")
        high, wide = sizes(e, nought)
        top = [sum(high[:k]) for k in range(n)]
        left = [sum(wide[:k]) for k in range(m)]
        entries = [x.v for r in e for x in r]
        d = lcm(*(x.denominator if scalar(x) else x.d for x in entries))
        rows, back = [[0] * sum(wide) for _ in range(sum(high))], []
        for (i, j), zero in nought.items():
            x, place = e[i][j], (top[i], high[i], left[j], wide[j])
            if zero:
                continue
            v = x.v
            if scalar(v):
                need(high[i] == wide[j], "a number where a block isn't square")
                v = eye(high[i]).times(v)
            for k, u in enumerate(v.a):
                line = [d // v.d * y for y in u]
                rows[top[i] + k][left[j] : left[j] + wide[j]] = line
            back.append((x, lambda z, p=place, v=x.v: summand(z.cut(*p), v)))
        return self.keep(Mat(sum(high), sum(wide), rows, d), *back)

    def statements(self, program):
        """(sign, label, left, right) of each, in order."""
        for step in program:
            if step[0] == "let":
                name = self.name(step[1])
                need(name not in self.given, f"{name} is defined by the file")
                self.env[name] = self.value(step[2])
            elif step[0] == "for":
                need(step[2] in self.sets, f"there is no set {step[2]}")
                for words in self.sets[step[2]]:
                    need(len(words) == len(step[1]), "a set of another length")
                    good = all(re.fullmatch(r"\w+", w, re.ASCII) for w in words)
                    need(good, f"{words!r:.40} are no index words")
                    self.at = dict(zip(step[1], words))
                    yield from self.statements(step[3])
                self.at = {}
            else:
                left, right = map(self.value, step[2:])
                yield step[0], self.name(step[1]), left, right


def size(n):
    need(scalar(n.v) and n.v.denominator == 1 and 0 <= n.v < LARGEST, "no size")
    return int(n.v)


def sizes(e, nought):
    """Heights and widths of blocks; a number is as high as it is wide."""
    high, wide = [set() for _ in e], [set() for _ in e[0]]
    numbers = [k for k, z in nought.items() if not z and scalar(e[k[0]][k[1]].v)]
    for i, r in enumerate(e):
        for j, x in enumerate(r):
            if not scalar(x.v):
                high[i].add(x.v.r)
                wide[j].add(x.v.c)
    for _ in range(2):
        for i, j in numbers:
            high[i] = wide[j] = high[i] | wide[j]
    need(all(len(s) < 2 for s in high + wide), "blocks that don't fit")
    return ([next(iter(s), 1) for s in side] for side in (high, wide))


def unkron(p, q, z):
    """The sum over i, j of p_ij times the block i, j of z."""
    sum_ = zeros(q.r, q.c)
    for i, row in enumerate(p.a):
        for j, e in enumerate(row):
            if e:
                part = z.cut(i * q.r, q.r, j * q.c, q.c)
                sum_ += part.times(Fraction(e, p.d))
    return sum_


# ---- 4. Positive


def definite(x, semi=False):
    """By elimination in integers (Bareiss): the pivots are leading minors."""
    if scalar(x):
        return x >= 0 if semi else x > 0
    if x.r != x.c or x != x.T:
        return False
    common = gcd(*(e for u in x.a for e in u)) or 1
    rows, last = [[e // common for e in u[i:]] for i, u in enumerate(x.a)], 1
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


# ---- 5. The verdict


def shape_of(spec, reader):
    """(rows, columns, symmetric) of "symmetric n" or "n x m"; None of "number"."""
    if spec == "number":
        return None
    even = spec.startswith("symmetric ")
    parts = spec[10:] if even else spec
    n = [size(reader.value(Parser(p).expression())) for p in parts.split(" x ")]
    return n[0], n[-1], even


def check(file):
    """The labels that are proven: at a point, or excluded by multipliers."""
    data = {k: read(v) for k, v in file["data"].items()}
    program, plain = parse("\n".join(file["text"])), Reader(data)
    shapes = {k: shape_of(spec, plain) for k, spec in file["unknowns"].items()}
    need(("point" in file) != ("multipliers" in file), "a point, or multipliers")
    if "point" not in file:
        x = {k: zeros(*s[:2]) if s else Fraction(0) for k, s in shapes.items()}
        return exclude(program, Reader(data, x, file["sets"]), shapes, file)
    need(set(file["point"]) == set(shapes), "other unknowns")
    x = {k: read(v) for k, v in file["point"].items()}
    for k, s in shapes.items():
        good = not scalar(x[k]) and s[:2] == (x[k].r, x[k].c) if s else scalar(x[k])
        need(good and not (s and s[2] and x[k] != x[k].T), f"{k} has another shape")
    reader, proven = Reader(data, x, file["sets"], True), []
    for sign, label, left, right in reader.statements(program):
        need(label not in proven, f"{label} comes twice")
        holds(sign, label, left, right)
        proven.append(label)
    return proven


def holds(sign, label, x, y):
    """Refuse a statement that isn't so."""
    if sign == "==":
        need(x.v == y.v, f"{label} isn't an identity")
    else:
        good = y.v == 0 and definite(x.v, sign == ">=")
        need(good, f"the block {label} isn't positive " + "semi" * (sign == ">=")
             + "definite")  # fmt: skip


def exclude(program, reader, shapes, file):
    """With Z >= 0, not all zero, sum <G(x), Z> would be positive: it is not.

    It doesn't depend on x, and is zero or negative; each block is affine in x.
    """
    Z = {k: read(v) for k, v in file["multipliers"].items()}
    proven, seeds, sum_ = [], [], Fraction(0)
    for sign, label, x, y in reader.statements(program):
        need(label not in proven, f"{label} comes twice")
        proven.append(label)
        z = Z.pop(label, None)
        if z is None or sign != ">":
            need(z is None, f"{label} takes no multiplier")
            need(x.back is None or sign == ">", f"{label} holds for some x only")
            if x.back is None:
                holds(sign, label, x, y)
            continue
        if scalar(x.v) and not scalar(z):
            z = trace(z)
        good = y.v == 0 and (scalar(z) or (z.r, z.c) == (x.v.r, x.v.c))
        need(
            good and scalar(z) == scalar(x.v), f"the multiplier of {label} doesn't fit"
        )
        need(definite(z, True), f"the multiplier of {label} isn't positive")
        seeds.append((x, z))
        sum_ += z * x.v if scalar(z) else z.dot(x.v)
    need(not Z, "a multiplier belongs to no block")
    need(any(z if scalar(z) else any(map(any, z.a)) for _, z in seeds), "none counts")
    for x, z in seeds:
        x.adj = z if x.adj is None else x.adj + z
    for x in reversed(reader.tape):
        for y, f in x.back if x.adj is not None else ():
            g = f(x.adj)
            y.adj = g if y.adj is None else y.adj + g
    for k, s in shapes.items():
        g = reader.env[k].adj
        if g is not None:
            g = g + g.T if s and s[2] else g
            gone = g == 0 if scalar(g) else not any(map(any, g.a))
            need(gone, f"the multipliers leave {k} a way out")
    need(sum_ <= 0, "the multipliers exclude nothing")
    return proven


def contents(text):
    """What a text in JSON holds; a key that comes twice is refused."""
    return json.loads(text, object_pairs_hook=unique, parse_constant=nothing,
                      parse_int=whole)  # fmt: skip


def unique(pairs):
    need(len(dict(pairs)) == len(pairs), "a key comes twice")
    return dict(pairs)


def whole(word):
    need(len(word) <= 400, "a whole number has too many digits")
    return int(word)


def nothing(word):
    raise Refused(f"{word} is no number")


MALFORMED = (LookupError, TypeError, AttributeError, ValueError, RecursionError,
             OverflowError, ZeroDivisionError)  # fmt: skip


def main(arguments):
    getattr(sys, "set_int_max_str_digits", int)(0)  # fractions may be long
    try:
        with open(arguments[0], "rb") as file:
            text = file.read(MOST_BYTES + 1)
        need(len(text) <= MOST_BYTES, "the file is too long")
        file = contents(text.decode("utf-8"))
        labels = check(file)
    except (Refused, *MALFORMED) as fault:
        print(f"refused: {fault!a:.200}")
        return 1
    except OSError as fault:
        print(f"not read: {fault}")
        return 2
    how = "positive definite" if "point" in file else "not all positive definite"
    print(f"{how}:", *labels)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
