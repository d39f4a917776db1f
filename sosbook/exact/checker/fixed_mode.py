"""Modes that no gain moves.

The text says that they are roots of a polynomial; where these lie is decided here.
"""

from fractions import Fraction

from .arithmetic import Beyond, need
from .families import vertex_words
from .laws import joined, put_law
from .plants import plant, vertex_of
from .regions import STABLE, at_ticks, in_matrices, region
from .requirements import STABILITY, stability
from .text import Text, number, ratio, sane

CLOSE = Fraction(1, 10**6)  # of |s|, of which six digits are said


class FixedMode:
    """V A = L V E and V B = 0: the roots of h, L's polynomial, can't be moved.

    One of them lies outside of a region. With a law the plant is transposed, and has
    the sensors in the place of B; or it has the law's states, of which some are free.
    """

    def __init__(self, d):
        """Write the text: rows that no input moves, and their root outside."""
        t = self.t = Text(d)
        vertices, N, m, _ = plant(t, d, ticks=True)
        where, mean = place(t, d, len(vertices))
        who = "no gain"
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
            t.put("K", d, "K", (m, N))
            A = "(A + Bu K)"
        h = [ratio(x) for x in d["polynomial"]]
        k = len(h) - 1
        need(k > 0 and h[-1] == 1, "the polynomial must be monic")
        t.put("V", d, "rows", (k, N), ratio)
        t.data["L"] = [["1" if b == a + 1 else "0" for b in range(k)]
                       for a in range(k - 1)]  # fmt: skip
        minus = (x[1:] if x[0] == "-" else f"-{x}" for x in d["polynomial"][:-1])
        t.data["L"].append([x.replace("-0", "0") for x in minus])
        t.write(f"E.regular: inv(E) E == I({N})", "independent: V V' > 0",
                f"mode: V {A} == L V E")  # fmt: skip
        if d["K"] is None:
            t.write(f"still: V Bu == O({k}, {m})")
        alpha, beta, text = broken(d["requirement"], d)
        x, y = map(ratio, d["point"])
        value, slope = steps(h, x, y)
        good = value <= CLOSE**2 * (x * x + y * y) * slope
        need(good, "no mode is near the point")
        if d["witness"]:
            v = [(number(a), number(b)) for a, b in d["witness"]]
            need(len(v) == len(alpha), "the witness has a wrong length")
            need(outside(alpha, beta, h, x, y, v), "the mode keeps what is asked")
        else:
            need(mirrored(alpha, beta, h), "the modes don't come in pairs")
            need(kept_out(alpha, beta, x, y), "the mode keeps what is asked")
        letter = "s"
        if "dt" in d["plant"]:
            dt, letter = number(d["plant"]["dt"]), "z"
            x, y = 1 + dt * x, dt * y
        s = f"{float(x):.6g}" + (f"{float(y):+.6g}j" if y else "")
        mode = f"{who} moves the mode near {letter} = {s} of {where}"
        if d["K"] is not None:
            mode = f"{where} has {'under the given gain ' if m else ''}a mode near "
            mode += f"{letter} = {s}"
        self.claims = [f"{mode}, which breaks: {text}"]


def place(t, d, count):
    """A plant's place among so many vertices, in words, and how it is made of them."""
    i, j = (vertex_of(t, k) for k in d["place"])
    where = f"the plant halfway between the vertices {i} and {j}"
    if i == j:
        where = vertex_words(d["plant"], i, count)
    return where, f"({{0}}.{i} + {{0}}.{j})/2"


def broken(asked, d):
    """alpha and beta of the region that is asked of the poles, and its claim; of ticks
    those of s = (z - 1)/dt.
    """
    stable = stability(d)
    if asked is not None and asked["kind"] != "region":
        raise Beyond(f"what a pole does to a {asked['kind']!r} isn't known here")
    alpha, beta, text = region(asked or stable | {"kind": "region"})
    if asked is not None:
        sane(asked["name"])
        plain = asked["form"] == "disk"
        if asked["form"] == "half-plane":
            plain = 2 * number(asked["sigma"]) == alpha[0][0]
        text = text if plain else in_matrices(asked)
    elif stable is STABILITY:
        text = STABLE
    return at_ticks(d["plant"], alpha, beta, text)


def outside(alpha, beta, h, x, y, v):
    """True if a root of h near c = x + iy lies outside of a region.

    One root is within n |h(c) / h'(c)|. There v* (alpha + beta s + beta' conj(s)) v
    stays positive or zero.
    """
    a, b = [p for p, _ in v], [q for _, q in v]  # v = a + ib
    level, re, im = half_plane(alpha, beta, a, b)
    level += 2 * (x * re - y * im)
    value, slope = steps(h, x, y)
    reach = 4 * value * (re**2 + im**2)
    return any(map(any, v)) and level >= 0 and level**2 * slope >= reach


def half_plane(alpha, beta, a, b):
    """v* (alpha + beta s + beta' conj(s)) v = level + 2 Re((re + i im) s), v = a + ib:
    the half-plane where that is negative holds the region.
    """
    level = bilinear(a, alpha, a) + bilinear(b, alpha, b)
    re = bilinear(a, beta, a) + bilinear(b, beta, b)
    return level, re, bilinear(a, beta, b) - bilinear(b, beta, a)


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
    """True if the roots of h are mirrored at the boundary of a half-plane or disk.

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
    """True if x + iy isn't inside of a half-plane or disk, but for `CLOSE`."""
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
