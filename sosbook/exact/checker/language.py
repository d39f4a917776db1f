"""The language of a text, and what it says of matrices.

Unknowns lead back to themselves, so that a sum of blocks can be asked what it makes of
them: see `kernel.exclude`.

 1. From a text to steps    2. Values, and how a sum of them leads back
"""

import re
from fractions import Fraction
from functools import lru_cache

from .arithmetic import (
    LARGEST,
    MOST_DIGITS,
    Mat,
    exponential,
    eye,
    inverse,
    joined,
    kron,
    mul,
    need,
    norm,
    number,
    read,
    scalar,
    total,
    trace,
    turned,
    zeros,
)

# ---- 1. From a text to steps

TOKEN = re.compile(
    r"\s*(?:(\d+(?:\.\d+)?|[A-Za-z]\w*(?:\.\w+)*|>=|==|[-+/'^()\[\],;:=>.])|\S)",
    re.ASCII,
)
FACTOR = re.compile(r"[\w(\[]", re.ASCII)  # how one begins that can follow another
WORDS = {  # with how many arguments, at least
    **dict(he=1, inv=1, tr=1, I=1, rows=1, cols=1, exp=1, near=1, norm=1, most=1),
    **dict(kron=2, O=2, pick=3, at=3),
}


class Parser:
    """The tokens of a line, read from the left into nested tuples."""

    def __init__(self, text):
        self.t, self.k = TOKEN.findall(text.split("#")[0]), 0
        need("" not in self.t, f"not understood: {text!r:.60}")

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
            elif self.k < len(self.t) and FACTOR.match(self.t[self.k]):
                left = ("mul", left, self.factor())
            else:
                return left

    def factor(self):
        """A factor: a number, a name, a call, a block matrix or brackets."""
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
                good = len(x) - 1 == WORDS[token] or token == "most"
                need(good, f"{token} takes another number of arguments")
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
    for line in filter(step_of, text.split("\n")):
        step, inner = step_of(line), line[:1] == " "
        loop = step[0] == "for"
        good = not inner or (not loop and program and program[-1][0] == "for")
        need(good, "an odd indent")
        (program[-1][3] if inner else program).append((*step, []) if loop else step)
        if step[0] == "let":
            need(step[1] not in names, f"{step[1]} is defined twice")
            names.add(step[1])
    return program


@lru_cache(maxsize=4096)  # files of one kind have most lines in common
def step_of(line):
    """The step of a line, of a loop its head; None of an empty one."""
    p = Parser(line)
    if not p.t:
        return None
    if p.t[0] == "for":
        loop = line.split("#")[0].strip()
        m = re.fullmatch(r"for (\w+(?:, \w+)*) in (\w+):", loop, re.ASCII)
        need(m, "for i, j in pairs: is the only loop")
        return "for", m[1].split(", "), m[2]
    name, mark = p.next(), p.next(":", "=")
    need(name not in WORDS and name[:1].isalpha(), f"{name!r} can't be a name")
    need(mark, f"{line!r:.60} is neither a definition nor a statement")
    step = "let", name, p.expression()
    if mark == ":":
        sign = p.next(">", ">=", "==")
        need(sign, f"{name} states nothing")
        step = sign, name, step[2], p.expression()
    need(p.k == len(p.t), f"too much in {line!r:.60}")
    return step


# ---- 2. Values, and how a sum of them leads back


class Val:
    """A number or a matrix v; ``back`` holds (value, adjoint -> its share)."""

    __slots__ = "adj", "back", "v"

    def __init__(self, v, *back):
        self.v, self.adj = v, None
        self.back = [(x, f) for x, f in back if x.back is not None] or None


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
    """The values of a text's names; unknowns stand for themselves."""

    read, joined = staticmethod(read), staticmethod(joined)
    kron, inverse = staticmethod(kron), staticmethod(inverse)

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
        head, *rest = text.split(".") if self.at else [text]
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

    def defined(self, name, x):
        return self.value(x)

    def op_neg(self, a):
        return self.keep(mul(Fraction(-1), a.v), (a, lambda z: mul(Fraction(-1), z)))

    def op_T(self, a):
        return self.keep(turned(a.v), (a, turned))

    def op_he(self, a):
        return self.keep(a.v + turned(a.v), (a, lambda z: z + turned(z)))

    def op_tr(self, a):
        return self.keep(trace(matrix(a)), (a, lambda z: eye(a.v.r).times(z)))

    def op_rows(self, a):
        return Val(Fraction(matrix(a).r))

    def op_cols(self, a):
        return Val(Fraction(matrix(a).c))

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
        kron = self.kron(matrix(a), matrix(b))
        return self.keep(kron, (b, lambda z: unkron(a.v, b.v, z)))

    def op_inv(self, a):
        need(a.back is None, "the inverse of an unknown")
        return Val(1 / a.v if scalar(a.v) else self.inverse(a.v))

    def op_pow(self, a, k):
        need(a.back is None and scalar(a.v) and k.v < 10, "no power of a number")
        long = max(map(int.bit_length, a.v.as_integer_ratio())) * size(k)
        need(long <= 4 * MOST_DIGITS, "a power has too many digits")
        return Val(a.v ** size(k))

    def op_at(self, a, i, j):
        i, j = size(i) - 1, size(j) - 1
        inside = 0 <= i < matrix(a).r and 0 <= j < a.v.c
        need(a.back is None and inside, "no such entry")
        return Val(a.v.at(i, j))

    def op_exp(self, a):
        return Val(exponential(certain(a)))

    def op_near(self, a):
        x = certain(a)
        return Val(x.near(x.e))

    def op_norm(self, a):
        return Val(norm(certain(a)))

    def op_most(self, *several):
        """The largest of some numbers."""
        good = all(x.back is None and scalar(x.v) for x in several)
        need(good, "the largest of what isn't a number")
        return Val(max(x.v for x in several))

    def op_I(self, n):
        return Val(eye(size(n)))

    def op_O(self, r, c):
        return Val(zeros(size(r), size(c)))

    def op_pick(self, k, parts, n):
        """The k-th of some parts of n rows."""
        row = [int(j + 1 == size(k)) for j in range(size(parts))]
        need(any(row), "no such part")
        return Val(self.kron(Mat(1, len(row), [row]), eye(size(n))))

    def block(self, table):
        """The matrix of a ``table`` of blocks; 0 fits everywhere."""
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
        parts, back = [], []
        for (i, j), zero in nought.items():
            x, place = e[i][j], (top[i], high[i], left[j], wide[j])
            if zero:
                continue
            v = x.v
            if scalar(v):
                need(high[i] == wide[j], "a number where a block isn't square")
                v = eye(high[i]).times(v)
            parts.append((top[i], left[j], v))
            back.append((x, lambda z, p=place, v=x.v: summand(z.cut(*p), v)))
        return self.keep(self.joined(sum(high), sum(wide), parts), *back)

    def statements(self, program):
        """(sign, label, left, right) of each, in order."""
        for step in program:
            if step[0] == "let":
                name = self.name(step[1])
                need(name not in self.given, f"{name} is defined by the file")
                self.env[name] = self.defined(name, step[2])
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
                need(right.back is None, f"an unknown on the right of {step[1]}")
                self.form = step[1]
                yield step[0], self.name(step[1]), left, right


def matrix(x):
    """The matrix x."""
    need(not scalar(x.v), "a matrix is needed, no number")
    return x.v


def certain(x):
    """The matrix x, which holds no unknown."""
    need(x.back is None, "a matrix without unknowns is needed")
    return matrix(x)


def size(n):
    good = n.back is None and scalar(n.v)
    need(good and n.v.denominator == 1 and 0 <= n.v < LARGEST, "no size")
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
