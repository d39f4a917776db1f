"""What rests on more than definite matrices: modes, masses, responses, small inputs.

Each adds to its text what no text says: where a polynomial has a root, the sign of a
determinant, matrices that are known within bounds.
"""

from fractions import Fraction
from math import lcm

from .arithmetic import Beyond, Mat, definite, eye, need, zeros
from .designs import Design
from .outputs import explicit
from .plants import determinant, plant
from .regions import in_matrices, region
from .requirements import STABILITY
from .text import Text, mat, number, positive, ratio, sane

CLOSE = Fraction(1, 10**6)  # of |s|, of which six digits are said


def place_of(d, key, many):
    """Two vertices, from 0."""
    i, j = d[key]
    inside = type(i) is type(j) is int and 0 <= i < many > j >= 0
    need(inside, f"{key} must be two vertices, from 0")
    return i, j


class SingularMass:
    """det E changes its sign between two vertices, or is zero halfway."""

    def __init__(self, d):
        self.t = Text(d)
        vertices, *_ = plant(self.t, d)
        i, j = place_of(d, "between", len(vertices))
        env = self.t.values()
        E, F = env[f"E.{i + 1}"], env[f"E.{j + 1}"]
        signs = determinant(E) * determinant(F) <= 0 or determinant(E + F) == 0
        need(signs, "no mass is singular there")
        self.claims = ["no gain makes every plant of the polytope stable: a plant "
                       f"between the vertices {i + 1} and {j + 1} has a singular "
                       "matrix E"]  # fmt: skip


class UnreachedResponse:
    """v (s E - A) = y C and v B + y D = 0: y z = v W w at s, whatever u is.

    A stable loop has a bounded transfer matrix T in Re s >= 0, with y T = v W,
    so its norm is at least |v W| / |y|. Rows of v and y are real and imaginary parts.
    Where w is in the output, too, v W + y Z stands for v W.
    """

    def __init__(self, d):
        t = self.t = Text(d)
        vertices, N, m, _ = plant(t, d)
        k = d["vertex"]
        inside = type(k) is int and 0 <= k < len(vertices)
        need(inside, "vertex must be one of the plant's, from 0")
        t.put_number("gamma", d, "bound")
        for name, rows in (("s", [1, 1]), ("v", [N] * 2), ("y", [None] * 2)):
            t.put(name, d, name, entry=ratio)
            mat(d[name], 2, rows[0], ratio)
        k += 1
        A, W = f"A.{k}", f"v Bw.{k}"
        C, D, Z = (x.replace(".i", f".{k}") for x in explicit(t, d["plant"], k))
        if d["K"] is not None:
            t.put("K", d, "K", N)
            A, C = f"({A} + Bu.{k} K)", f"({C} + {D} K)" if D else C
        else:
            t.write(f"input: v Bu.{k}{D and ' + y ' + D} == O(2, {m})")
        t.write("sign.gamma: gamma > 0", "sign.s: at(s, 1, 1) >= 0")
        t.write("times = [at(s, 1, 1), -at(s, 2, 1); at(s, 2, 1), at(s, 1, 1)]")
        t.write(f"left: v {A} + y {C} == times v E.{k}")
        reached = f"{W} Bw.{k}' v'"
        if Z:
            t.write(f"push = {W} + y {Z}")
            reached = "push push'"
        t.write(f"reached = tr({reached})", "some: reached > 0")
        t.write("norm: reached - gamma^2 tr(y y') >= 0")
        where = f"the vertex {k}" if len(vertices) > 1 else "the plant"
        who = "no gain makes" if d["K"] is None else "the given gain doesn't make"
        self.claims = [f"{who} {where} stable with an H-infinity norm below "
                       f"{d['bound']}"]  # fmt: skip


class FixedMode:
    """V A = L V E and V B = 0: the roots of h, L's polynomial, can't be moved.

    One of them lies outside of a region.
    """

    def __init__(self, d):
        t = self.t = Text(d)
        vertices, N, m, _ = plant(t, d)
        i, j = place_of(d, "place", len(vertices))
        where = f"the plant halfway between the vertices {i + 1} and {j + 1}"
        if i == j:
            where = f"the vertex {i + 1}" if len(vertices) > 1 else "the plant"
        mean = "{0} = ({0}.{1} + {0}.{2})/2"
        t.write(*(mean.format(x, i + 1, j + 1) for x in ("E", "A", "Bu")))
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
        asked, text = d["requirement"], "its poles lie left of the imaginary axis"
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
        mode = f"no gain moves the mode near s = {s} of {where}"
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


# ---- A small input. Complex matrices c are real ones, [Re c, -Im c; Im c, Re c]


class SmallInput:
    """The LMIs of some modes' part of the plant exclude each other.

    If W A = L W E, the LMIs hold for p = V P V*, y = Y V*, V = W E, with L, W B and
    V x0. Here W = [1 X] T, and entry by entry |X| <= spread, |L - L0| <= blur.
    With K = T A R and J = T E R the equations for X and L, by blocks, are

        L = K11 + X K21 - L (J11 - 1) - L X J21,
        X K22 - L X J22 = L J12 - K12.

    Divided by the differences of the diagonals of K22 and K11 they map these
    bounds into themselves: a fixed point exists (Brouwer).
    """

    def __init__(self, d):
        design = Design(d)
        t = self.t = Text({k: x for k, x in d.items() if k != "multipliers"})
        _, N, m, _ = plant(t, d)
        need(d["K"] is None, "the gain must be free")
        need(not design.slack, "this proof is for a common P")
        (bound,) = [r for r in design.asked if r["kind"] == "input"]
        need(bound["acceleration"] is False, "this proof is for a bound of K x")
        vertex, k = d["vertex"], len(d["spread"])
        inside = type(vertex) is int and 0 <= vertex < design.many
        need(inside, "there is no such vertex")
        need(0 < k < N, "the part must be smaller than the plant")
        env, self.k, self.N = t.values(), k, N
        E, A, B = (env[f"{x}.{vertex + 1}"] for x in ("E", "A", "Bu"))
        x0 = mat([[e] for e in bound["x0"]], N, 1)
        L, F_of, blur, spread = self._enclosed(d, *map(real, (E, A, B, E @ x0)))
        S, F = self._multiplied(d, design)
        push, begin = F_of
        # the sum of <G, z> over the regions is -tr(Q p) - 2 Re tr(f y)
        FL, f = F @ L, F @ part(push, 0, k, 0, m)
        Q = S + FL + FL.T
        Q_blur = sizes_of(F) @ blur
        Q_blur = Q_blur + Q_blur.T
        f_blur = sizes_of(F) @ spread @ sizes_of(part(push, k, N - k, 0, m))
        U, price = complex_of(d["share"], k), complex_of(d["price"], m)
        room = [*sums(f_blur), *sums(f_blur.T)]
        (a, b), (c, e), (f1, f2), (g1, g2) = map(halves, (U, price, f, f.T))
        whole = real_form(table([[a, f1], [g1, c]]), table([[b, f2], [g2, e]]))
        good = definite(whole + diagonal(room * 2).times(-1), semi=True)
        need(good, "the multiplier of u_max isn't positive")
        D = Q + U.times(-1) + diagonal(sums(Q_blur) * 2).times(-1)
        need(definite(D, semi=True), "the multiplier of x0 isn't positive")
        h = part(begin, 0, k, 0, 1).cut(0, 2 * k, 0, 1)
        force = D @ h
        spill = spread @ sizes_of(part(begin, k, N - k, 0, 1))
        least = h.dot(force) - 2 * sum(
            (abs(force.at(i, 0)) + abs(force.at(k + i, 0))) * spill.at(i, 0)
            for i in range(k)
        )
        paid = sum(price.at(i, i) for i in range(m))
        good = positive(bound["u_max"]) ** 2 * paid < least
        need(good, "the multipliers exclude nothing")
        which = "no gain and no matrices prove by these LMIs: "
        self.claims = [which + "; ".join(design.claims)]

    def _enclosed(self, d, E, A, B, start):
        """L0, T B and T E x0, and the bounds, which map into themselves."""
        k, N = self.k, self.N
        r = N - k
        spread, blur = mat(d["spread"], k, r), mat(d["blur"], k, k)
        need(min(map(min, spread.a + blur.a)) >= 0, "a bound is negative")
        T, R = (complex_of(d[x], N) for x in ("rows", "columns"))
        K, J = T @ A @ R, T @ E @ R
        off = J + eye(2 * N).times(-1)
        need(max(sums(sizes_of(off))) < 1, "the columns aren't near an inverse")
        L = part(K, 0, k, 0, k)
        own, beside = split(sizes_of(L))
        _, beside_rest = split(sizes_of(part(K, k, r, k, r)))
        error = L @ part(J, 0, k, k, r) + part(K, 0, k, k, r).times(-1)
        far = sizes_of(L) + blur
        low = sizes_of(part(off, k, r, 0, k))
        new_blur = spread @ sizes_of(part(K, k, r, 0, k)) + far @ spread @ low
        new_blur = new_blur + far @ sizes_of(part(off, 0, k, 0, k))
        new = sizes_of(error) + blur @ sizes_of(part(J, 0, k, k, r))
        new = new + spread @ beside_rest
        new = new + (beside + blur) @ spread @ sizes_of(part(J, k, r, k, r))
        new = new + own @ spread @ sizes_of(part(off, k, r, k, r))
        re, im = halves(K)
        for i in range(k):
            for j in range(r):
                gap = max(abs(x.at(k + j, k + j) - x.at(i, i)) for x in (re, im))
                good = new.at(i, j) <= gap * spread.at(i, j)
                need(good, "the part isn't enclosed")
            good = all(new_blur.at(i, j) <= blur.at(i, j) for j in range(k))
            need(good, "the part isn't enclosed")
        return L, (T @ B, T @ start), blur, spread

    def _multiplied(self, d, design):
        """What the multipliers z of the regions make of alpha and of beta."""
        k = self.k
        asked = {(r["kind"], r["name"]): r for r in design.asked}
        asked = {key: r for key, r in asked.items() if key[0] == "region"}
        asked["stability", "stability"] = STABILITY | {"kind": "region"}
        S = F = zeros(2 * k, 2 * k)
        for key, pair in d["multipliers"]:
            alpha, beta, _ = region(asked.pop(tuple(key)))
            z = complex_of(pair, len(alpha) * k)
            need(definite(z, semi=True), f"the multiplier of {key} isn't positive")
            for i, (a, b) in enumerate(zip(alpha, beta)):
                for j in range(len(a)):
                    z_ji = part(z, j * k, k, i * k, k)
                    S, F = S + z_ji.times(a[j]), F + z_ji.times(b[j])
        return S, F


def table(blocks):
    """The matrix of blocks, over one denominator."""
    d = lcm(*(x.d for row in blocks for x in row))
    rows = [[d // x.d * e for x in row for e in x.a[i]]
            for row in blocks for i in range(row[0].r)]  # fmt: skip
    return Mat(len(rows), sum(x.c for x in blocks[0]), rows, d)


def real_form(re, im):
    return table([[re, im.times(-1)], [im, re]])


def real(x):
    return real_form(x, zeros(x.r, x.c))


def complex_of(pair, n):
    """A square matrix of n complex rows, from its real and its imaginary part."""
    re, im = pair
    return real_form(mat(re, n, n), mat(im, n, n))


def halves(x):
    """Real and imaginary part of a complex matrix in its real form."""
    r, c = x.r // 2, x.c // 2
    return x.cut(0, r, 0, c), x.cut(r, r, 0, c)


def part(x, i, r, j, c):
    """A block of a complex matrix."""
    return real_form(*(y.cut(i, r, j, c) for y in halves(x)))


def sizes_of(x):
    """A bound of the size of each complex entry."""
    re, im = (Mat(y.r, y.c, [[abs(e) for e in u] for u in y.a], y.d) for y in halves(x))
    return re + im


def split(x):
    """The diagonal, and what is beside it."""
    own = [[e if i == j else 0 for j, e in enumerate(u)] for i, u in enumerate(x.a)]
    own = Mat(x.r, x.c, own, x.d)
    return own, x + own.times(-1)


def sums(x):
    return [Fraction(sum(u), x.d) for u in x.a]


def diagonal(entries):
    d = lcm(*(e.denominator for e in entries))
    n, numbers = len(entries), [int(e * d) for e in entries]
    return Mat(n, n, [[e if i == j else 0 for j in range(n)]
                      for i, e in enumerate(numbers)], d)  # fmt: skip
