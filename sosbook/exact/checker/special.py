"""What excludes every gain without multipliers: modes, masses, responses, sums.

Each adds to its text what no text says: where a polynomial has a root, the sign of a
determinant.
"""

from fractions import Fraction
from math import floor, log10

from .arithmetic import Beyond, definite, need
from .families import keys, vertex_words
from .known import put_law
from .outputs import at_vertex, ends
from .plants import determinant, plant, vertex_of
from .regions import in_matrices, region
from .requirements import STABILITY
from .text import Text, mat, number, ratio, sane

CLOSE = Fraction(1, 10**6)  # of |s|, of which six digits are said
STABLE = "its poles lie left of the imaginary axis"


class SingularMass:
    """det E changes its sign between two vertices, or is zero halfway."""

    def __init__(self, d):
        self.t = Text(d)
        plant(self.t, d)
        i, j = (vertex_of(self.t, k) for k in d["between"])
        env = self.t.values()
        E, F = env[f"E.{i}"], env[f"E.{j}"]
        signs = determinant(E) * determinant(F) <= 0 or determinant(E + F) == 0
        need(signs, "no mass is singular there")
        self.claims = ["no gain makes every plant of the polytope stable: a plant "
                       f"between the vertices {i} and {j} has a singular "
                       "matrix E"]  # fmt: skip


JOINED = """E = [{E}, 0; 0, law.E]
A = [{A}, O({N}, {c}); law.B law.rows, law.A]
Bu = [{Bu}, O({N}, {f}); O({c}, {m}), [O({k}, {f}); I({f})]]"""


def joined(t, law, size, mean, f):
    """E, A and Bu of a plant with a law's states, f of them free: how many of each."""
    put_law(t, law)
    (N, m), c = size, len(law["E"])
    need(type(f) is int and 0 <= f <= c, "a law has no such rows")
    parts = {x: mean.format(x) for x in ("E", "A", "Bu")}
    t.write(*JOINED.format(**parts, N=N, m=m, c=c, f=f, k=c - f).split("\n"))
    return N + c, m + f


class SumOfPoles:
    """The sum of the poles, tr E^-1 (A + B K C_y), is moved by no K of a law.

    K is a sum of the file's gains. Where these aren't all matrices, the words say how
    many numbers are free: another K of the same law may move the sum.

    Their mean isn't in the half-plane that is asked, or in the left one: nor are all.
    """

    def __init__(self, d):
        t = self.t = Text(d)
        vertices, *size, _ = plant(t, d)
        need(d["U"] == [] and d["gains"], "a law has gains, and no U")
        k, asked = vertex_of(t, d["vertex"]), d["requirement"]
        f = len(d["gains"][0]) - size[1]
        N, _ = joined(t, d["law"], size, f"{{}}.{k}", f)
        words, reach = STABLE, "mean"
        if asked is not None:
            need(asked["form"] == "half-plane", "a half-plane is needed")
            words, reach = region(asked)[2], "mean + sigma"
            t.put_number("sigma", asked, "sigma")
        t.sets["gains"] = [[str(i)] for i, _ in enumerate(d["gains"], 1)]
        for i, _ in enumerate(d["gains"]):
            t.put(f"G.{i + 1}", d["gains"], i, entry=ratio)
        t.write("y = [law.of_sensors law.rows, law.of_states]", "back = inv(E)")
        t.write("still.i: tr(back Bu G.i y) == 0", loop="i in gains")
        t.write(f"mean = tr(back A)/{N}", f"beyond: {reach} >= 0")
        where = vertex_words(d["plant"], k, len(vertices))
        shape, free = (len(d["gains"][0]), len(d["gains"][0][0])), len(d["gains"])
        rows = [[e for row in G for e in row] for G in d["gains"]]
        K = mat(rows, free, shape[0] * shape[1], ratio)
        need(definite(K @ K.T), "the gains depend on each other")
        some = "" if free == K.c else f" with {free} free number{'s' * (free > 1)}"
        least = downwards(t.values()["mean"])
        self.claims = [f"no gain of the law{some} moves the sum of the poles of "
                       f"{where}; one of them has a real part of at least {least}, so "
                       f"none keeps: {words}"]  # fmt: skip


def downwards(x):
    """A fraction in six digits, not above it."""
    words = f"{float(x):.6g}"
    if Fraction(words) <= x:
        return words
    return f"{float(x) - 10.0 ** (floor(log10(abs(float(x)))) - 5):.6g}"


class UnreachedResponse:
    """v (s E - A) = y C and v B + y D = 0: y z = v W w at s, whatever u is.

    A stable loop has a bounded transfer matrix T in Re s >= 0, with y T = v W,
    so its norm is at least |v W| / |y|. Rows of v and y are real and imaginary parts.
    Where w is in the output, too, v W + y Z stands for v W.
    """

    def __init__(self, d):
        t = self.t = Text(d)
        r, at = d.get("requirement", {}), (d, "bound")
        if r:  # with outputs or inputs of its own
            more = [x for x in ("outputs", "inputs") if x in r]
            keys(r, " ".join(["kind name gamma mu", *more]))
            at = r, "gamma"
        vertices, N, m, _ = sizes = plant(t, d)
        k = vertex_of(t, d["vertex"])
        t.put_number("gamma", *at)
        for name, rows in (("s", [1, 1]), ("v", [N] * 2), ("y", [None] * 2)):
            t.put(name, d, name, entry=ratio)
            mat(d[name], 2, rows[0], ratio)
        A, (C, D, Z, S, _) = f"A.{k}", at_vertex(t, d, sizes, r, k)
        if d["K"] is not None:
            t.put("K", d, "K", N)
            A, C = f"({A} + Bu.{k} K)", f"({C} + {D} K)" if D else C
        else:
            t.write(f"input: v Bu.{k}{D and ' + y ' + D} == O(2, {m})")
        t.write("sign.gamma: gamma > 0", "sign.s: at(s, 1, 1) >= 0")
        t.write("times = [at(s, 1, 1), -at(s, 2, 1); at(s, 2, 1), at(s, 1, 1)]")
        t.write(f"left: v {A} + y {C} == times v E.{k}")
        t.write(f"push = v Bw.{k}{S}" + (f" + y {Z}{S}" if Z else ""))
        t.write("reached = tr(push push')", "some: reached > 0")
        t.write("norm: reached - gamma^2 tr(y y') >= 0")
        where = vertex_words(d["plant"], k, len(vertices))
        who = "no gain makes" if d["K"] is None else "the given gain doesn't make"
        self.claims = [f"{who} {where} stable with an H-infinity norm{ends(r)} below "
                       f"{at[0][at[1]]}"]  # fmt: skip


class FixedMode:
    """V A = L V E and V B = 0: the roots of h, L's polynomial, can't be moved.

    One of them lies outside of a region. With a law the plant is transposed, and has
    the sensors in the place of B; or it has the law's states, of which some are free.
    """

    def __init__(self, d):
        t = self.t = Text(d)
        vertices, N, m, _ = plant(t, d)
        i, j = (vertex_of(t, k) for k in d["place"])
        where = f"the plant halfway between the vertices {i} and {j}"
        if i == j:
            where = vertex_words(d["plant"], i, len(vertices))
        mean, who = f"({{0}}.{i} + {{0}}.{j})/2", "no gain"
        if "law" not in d:
            t.write(*(f"{x} = {mean.format(x)}" for x in ("E", "A", "Bu")))
        elif d["free"] is None:
            put_law(t, d["law"])
            lines = (f"{x} = ({mean.format(x)})'" for x in "EA")
            t.write(*lines, "Bu = law.rows'")
            m, who = len(d["law"]["rows"]), "no controller with these sensors"
        else:
            N, m = joined(t, d["law"], (N, m), mean, d["free"])
            who = "no gain of the law"
        need("law" not in d or d["K"] is None, "a law's gain is free")
        A = "A"
        if d["K"] is not None:
            t.put("K", d, "K", N)
            A = "(A + Bu K)"
        h = [ratio(x) for x in d["polynomial"]]
        k = len(h) - 1
        need(k > 0 and h[-1] == 1, "the polynomial must be monic")
        t.put("V", d, "rows", entry=ratio)
        t.data["L"] = [["1" if b == a + 1 else "0" for b in range(k)]
                       for a in range(k - 1)]  # fmt: skip
        minus = (x[1:] if x[0] == "-" else f"-{x}" for x in d["polynomial"][:-1])
        t.data["L"].append([x.replace("-0", "0") for x in minus])
        t.write(f"E.regular: inv(E) E == I({N})", "independent: V V' > 0",
                f"mode: V {A} == L V E")  # fmt: skip
        if d["K"] is None:
            t.write(f"still: V Bu == O({k}, {m})")
        asked, text = d["requirement"], STABLE
        if asked is not None:
            if asked["kind"] != "region":
                raise Beyond(
                    f"what a pole does to a {asked['kind']!r} isn't known here"
                )
            sane(asked["name"])
            plain = asked["form"] == "disk"
            if asked["form"] == "half-plane":
                plain = 2 * number(asked["sigma"]) == number(asked["alpha"][0][0])
            text = region(asked)[2] if plain else in_matrices(asked)
        alpha, beta, _ = region(asked or STABILITY | {"kind": "region"})
        x, y = map(ratio, d["point"])
        value, slope = steps(h, x, y)
        good = value <= CLOSE**2 * (x * x + y * y) * slope
        need(good, "no mode is near the point")
        need(isinstance(d["witness"], list), "the witness must be a list")
        if d["witness"]:
            v = [(number(a), number(b)) for a, b in d["witness"]]
            need(len(v) == len(alpha), "the witness has a wrong length")
            need(outside(alpha, beta, h, x, y, v), "the mode keeps what is asked")
        else:
            need(mirrored(alpha, beta, h), "the modes don't come in pairs")
            need(kept_out(alpha, beta, x, y), "the mode keeps what is asked")
        s = f"{float(x):.6g}" + (f"{float(y):+.6g}j" if y else "")
        mode = f"{who} moves the mode near s = {s} of {where}"
        if d["K"] is not None:
            mode = f"{where} has {'under the given gain ' if m else ''}a mode near "
            mode += f"s = {s}"
        self.claims = [f"{mode}, which breaks: {text}"]


def outside(alpha, beta, h, x, y, v):
    """Whether a root of h near c = x + iy lies outside of a region.

    One root is within n |h(c) / h'(c)|. There v* (alpha + beta s + beta' conj(s)) v
    stays positive or zero.
    """
    a, b = [p for p, _ in v], [q for _, q in v]  # v = a + ib
    level = bilinear(a, alpha, a) + bilinear(b, alpha, b)
    re = bilinear(a, beta, a) + bilinear(b, beta, b)
    im = bilinear(a, beta, b) - bilinear(b, beta, a)
    level += 2 * (x * re - y * im)
    value, slope = steps(h, x, y)
    reach = 4 * value * (re**2 + im**2)
    return any(map(any, v)) and level >= 0 and level**2 * slope >= reach


def steps(h, x, y):
    """|n h(c)|^2 and |h'(c)|^2: h'/h is the sum of 1 / (c - root) at c = x + iy."""
    slope = square_at([k * a for k, a in enumerate(h)][1:], x, y)
    return (len(h) - 1) ** 2 * square_at(h, x, y), slope


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


def kept_out(alpha, beta, x, y):
    """Whether x + iy isn't inside of a half-plane or disk, but for `CLOSE`."""
    size, depth = 2 * beta[0][0], -alpha[0][0] - 2 * beta[0][0] * x
    if len(alpha) > 1:
        size = alpha[0][0]
        depth = size**2 - (x + alpha[0][1]) ** 2 - y**2
    return depth <= 0 or depth**2 <= (CLOSE * size) ** 2 * (x * x + y * y)


def moved(h, a):
    """The coefficients of h(a + t)."""
    coefficients = []
    for x in reversed(h):
        up, down = [a * e for e in coefficients] + [0], [0, *coefficients]
        coefficients = [p + q for p, q in zip(up, down)]
        coefficients[0] += x
    return coefficients
