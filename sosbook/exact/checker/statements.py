"""What is asked of a plant, as a text for the kernel beside the words that it proves.

`law` is the only place that makes words, and each stands beside its blocks. What a
file asks is a dict of words and decimals; a text is written from that dict alone, so
a file may hold the text that is written here and no other.

 1. Reading    2. The text of a plant    3. Regions of the poles    4. Designs
 5. Observers, masses, matrices, LMIs of one's own
"""

import json
import re
from fractions import Fraction
from functools import cache

from . import kernel, payment
from .families import every_plant, given_vertices, keys
from .kernel import Beyond, Mat, need
from .outputs import Channel, ends

PI = Fraction(314159265358979323846264338327950288, 10**35)  # rounded down
TINY = Fraction(1, 10**9)


# ---- 1. Reading


def sane(name):
    """A name: one line, and no sentence."""
    sign = r"(?=[\w(])([\w (),#-]|[.](?! ))+(?<! )"
    good = isinstance(name, str) and re.fullmatch(sign, name)
    need(good, f"{name!r:.40} is no name: one line of letters, digits, spaces, hyphens")
    return name


def decimal_text(text):
    """The text of a number: a decimal in its shortest form, in a string."""
    good = isinstance(text, str) and re.fullmatch(r"[-+.e0-9]{1,30}", text, re.ASCII)
    shortest = repr(float(text) + 0.0) if good else ""
    shortest = shortest[:-2] if shortest.endswith(".0") else shortest
    need(good and text == shortest, f"{text!r:.40} isn't a decimal number in a string")
    return text


def number(text):
    """What a decimal says."""
    return Fraction(decimal_text(text))


def ratio(text):
    """A fraction in lowest terms, in a string."""
    good = isinstance(text, str) and re.fullmatch(r"-?\d+(/\d+)?", text, re.ASCII)
    need(good and str(kernel.number(text)) == text, f"{text!r:.40} isn't a fraction")
    return Fraction(text)


def positive(text):
    need(number(text) > 0, f"{text} must be positive")
    return number(text)


def mat(rows, r, c=None, entry=number):
    """A `Mat` with r rows, and c columns if they are told."""
    return kernel.gather(*entries(rows, r, c, entry))


def entries(rows, r, c, entry):
    """Each entry of a matrix as it is read, and how many columns there are."""
    good = isinstance(rows, list) and len(rows) == r
    good = good and all(isinstance(u, list) for u in rows)
    c = len(rows[0]) if good and rows and c is None else c or 0
    good = good and all(len(u) == c for u in rows)
    need(good, f"a matrix has a wrong shape: {r} x {c} is needed")
    return [[entry(e) for e in u] for u in rows], c


def words_of(rows):
    return "[" + ", ".join("[" + ", ".join(row) + "]" for row in rows) + "]"


class Text:
    """A file in the making: lines, data, sets, unknowns, and where data come from."""

    def __init__(self, asked):
        self.asked, self.lines, self.places = asked, [], {}
        self.data, self.sets, self.unknowns, self.found = {}, {}, {}, {}
        self.labels = {}  # from a block's key to its label
        self.each = ()  # names of outputs that each vertex has for itself

    def put(self, name, holder, key, width=0, entry=decimal_text, into=None):
        """A matrix of what is asked becomes data; without rows it has a width."""
        x, into = holder[key], self.data if into is None else into
        need(isinstance(x, list), f"{key!r:.40} must be a matrix")
        r, c = len(x), len(x[0]) if x else width
        entries(x, r, c, entry)
        self._keep(name, holder, key, into, x if r and c else {"zeros": [r, c]})

    def put_number(self, name, holder, key):
        """A number of what is asked becomes data."""
        number(holder[key])
        self._keep(name, holder, key, self.data, holder[key])

    def _keep(self, name, holder, key, into, value):
        need(name not in into, f"{name} comes twice")
        into[name] = value
        self.places[id(holder), key] = "=" + name

    def point(self, name, key, shape, *numbers):
        """An unknown, whose values are under ``key``."""
        self.unknowns[name] = shape
        values = self.asked.get("unknowns")
        if values is None:
            return
        need(key in values, f"the unknown {key} is missing")
        self.put(name, values, key, into=self.found)
        if shape == "number":
            ((self.found[name],),) = values[key]
            self.places[id(values), key] = "#" + name

    def write(self, *lines, loop=None):
        if loop and lines:
            self.lines.append(f"for {loop}:")
        self.lines += ["  " * bool(loop) + x for x in lines]

    def values(self):
        """What the lines so far define, by name."""
        data = {k: kernel.read(v) for k, v in self.data.items()}
        reader = kernel.Reader(data, sets=self.sets)
        for _ in reader.statements(kernel.parse("\n".join(self.lines))):
            pass
        return {k: x.v for k, x in reader.env.items()}

    def file(self):
        """What the kernel reads."""
        whole = dict(text=self.lines, data=self.data)
        whole |= dict(sets=self.sets, unknowns=self.unknowns)
        if "multipliers" not in self.asked:
            given = self.asked.get("unknowns", {})
            good = isinstance(given, dict) and len(given) == len(self.found)
            need(good, "other unknowns")
            return whole | {"point": self.found}
        Z = {}
        for key, z in self.asked["multipliers"]:
            label = self.label(key)
            need(label not in Z, "two multipliers have one key")
            good = isinstance(z, list) and all(isinstance(u, list) for u in z)
            need(good and [ratio(e) for u in z for e in u], "a multiplier is no matrix")
            Z[label] = z
        return whole | {"multipliers": Z}

    def label(self, key):
        key = key if isinstance(key, str) else tuple(key)
        need(key in self.labels, f"a multiplier of {key}, which is no block")
        return self.labels[key]


# ---- 2. The text of a plant

SECOND = """E.i = [I(n), 0{z}; 0, {M}{z}{last}]
A.i = [0, I(n){U0}; -S.i, -D.i{z}{U}]
Bu.i = [O(n, cols(B.i)); B.i{push}]
Bw.i = [O(n, cols(F.i)); F.i{gust}]"""
OUTPUTS = {"C": "C", "D_u": "D", "D_w": "Z", "C_a": "H"}
OTHER = "E.i = Ed.i", "A.i = Ad.i", "Bu.i = Bd.i", "Bw.i = Wd.i"


def plant(t, d):
    """The lines of E x' = A x + B u + W w, y = C x + D u; (vertices, N, m, p)."""
    kind, vertices = d["plant"]["kind"], given_vertices(d["plant"])
    family = "parameters" in d["plant"] or "box" in d
    if "box" in d:
        vertices = payment.corners(d["box"], kind, len(vertices))
    entry, t.vertices = ratio if family else decimal_text, vertices
    t.sets["vertices"] = [[str(i + 1)] for i in range(len(vertices))]
    if kind == "second order":
        need(isinstance(d["U"], list), "U must be a matrix")
        names = dict(zip("MDSBF", "MDSBF"))
        n, U = len(vertices[0]["M"]), len(d["U"])
        N = 2 * n + U
    else:
        need(d["U"] == [] and d["K_A"] is None, "this plant has no U, no K_A")
        names, N = dict(E="Ed", A="Ad", B="Bd", B_w="Wd"), len(vertices[0]["E"])
    sizes, beside = set(), kind == "descriptor" and "C" in vertices[0]
    for i, v in enumerate(vertices, 1):
        none = dict.fromkeys(OUTPUTS) if beside else {}
        keys(none | v, " ".join([*names, *none]))
        for key, name in names.items():
            t.put(f"{name}.{i}", v, key, entry=entry)
        square, (B, W) = list(names)[:-2], (v[x] for x in list(names)[-2:])
        shapes = [(len(v[x]), len(v[x][0])) for x in square]
        sizes.add((*shapes, len(B), len(B[0]), len(W), len(W[0])))
    need(len(sizes) == 1, "the vertices differ in size")
    (*shapes, rows, m, high, p) = sizes.pop()
    need({*shapes} == {(rows, rows)} and high == rows, "a matrix has a wrong shape")
    if kind == "descriptor":
        outputs_of(t, d["plant"], vertices, dict(C=N, D_u=m, D_w=p, C_a=N), entry)
        t.write(*OTHER, loop="i in vertices")
        return vertices, N, m, p
    if U:
        t.put("U", d, "U")
    M = "M.i"
    if d["K_A"] is not None:
        t.put("K_A", d, "K_A")
        M = "M.i - B.i K_A"
    more = dict(z=", 0", last="; 0, 0, I(rows(U))", U0=", O(n, rows(U))",
                U="; U, O(rows(U), n), 0", push="; O(rows(U), cols(B.i))",
                gust="; O(rows(U), cols(F.i))")  # fmt: skip
    more = {k: v if U else "" for k, v in more.items()}
    t.write("n = rows(M.1)", f"C = [I(n), O(n, {'n + rows(U)' if U else 'n'})]")
    t.write(*SECOND.format(M=M, **more).split("\n"), loop="i in vertices")
    return vertices, N, m, p


def outputs_of(t, plant, vertices, widths, entry):
    """C, D, Z and H of a plant without z: one for all where they are C and D."""
    several = [(v.get("C"), v.get("D_u")) for v in vertices]
    alike = all(x == several[0] for x in several)
    alike = alike and not any(v.get(k) for v in vertices for k in ("D_w", "C_a"))
    t.each = () if "C" in plant and alike else tuple(OUTPUTS.values())
    if "C" in plant and alike:
        v = vertices[0] if "parameters" in plant else plant
        for key in ("C", "D_u"):
            if key == "C" or v.get(key) is not None:
                t.put(OUTPUTS[key], v, key, widths[key], entry)
        return
    for key, name in OUTPUTS.items():
        there = [v.get(key) is not None for v in vertices]
        need(all(there) or not any(there), "an output that one vertex hasn't")
        for i, v in enumerate(vertices, 1):
            if there[0]:
                t.put(f"{name}.{i}", v, key, widths[key], entry)
                rows, wide = len(v["C"]), widths[key]
                good = len(v[key]) == rows and all(len(u) == wide for u in v[key])
                need(good, "an output of another shape")
    need("C.1" in t.data, "there is no output")


def distinct(vertices, names=None):
    """Indices of the vertices without those that repeat an earlier one."""
    data = [v if names is None else [v[x] for x in names] for v in vertices]
    return [i for i, v in enumerate(data) if v not in data[:i]]


def suffice(E, points):
    """Whether E^-1 [A B W] between the vertices is a mean of the vertices' ones.

    Up to a congruence the blocks of a design are affine in it, so that no pair of
    two vertices is needed then. With E + t u v' for E the inverse moves on a
    segment, and so does the quotient where A, B and W move along u, too; det E is
    affine in t. So it is enough that det E has one sign at all vertices and that
    their columns differ by multiples of one u; or that they are a box, all sums of
    some vertices with one E and any of some changes, each along a u of its own.
    ``points`` are the entries of [E A B W] by columns.
    """
    N = E[0].r
    points = dict(zip(points, E))
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


def determinant(x):
    rows, product = [list(u) for u in x.a], Fraction(1, x.d**x.r)
    for k in range(len(rows)):
        top = next((r for r in range(k, len(rows)) if rows[r][k]), None)
        if top is None:
            return Fraction(0)
        rows[k], rows[top] = rows[top], rows[k]
        product *= rows[k][k] * (1 if top == k else -1)
        for r in range(k + 1, len(rows)):
            f = Fraction(rows[r][k]) / rows[k][k]
            rows[r] = [a - f * b for a, b in zip(rows[r], rows[k])]
    return product


# ---- 3. Regions of the poles: alpha + beta s + beta' conj(s) < 0


@cache
def tangent(degrees):
    """A fraction just below the tangent of an angle in (0, 90] degrees."""
    x, term, sums = PI * degrees / 180, Fraction(1), [Fraction(0), Fraction(0)]
    for k in range(33):
        sums[k % 2] += term * (-1) ** (k // 2)
        term = term * x / (k + 1)
    return sums[1] / sums[0]


def near(wanted, written):
    """Whether a number is the one that is wanted, or a little more."""
    return 0 <= written - wanted <= TINY * abs(wanted)


FORMS = {
    "half-plane": "sigma",
    "sector": "theta apex degrees",
    "disk": "rho centre",
    "strip": "left right",
    "horizontal strip": "omega",
    "ellipse": "centre a b",
    "matrices": "",
}


def region(r):
    """alpha, beta, and the claim that the region implies.

    They are those of the form that is claimed, but for roundings inwards: what
    excludes them excludes the form.
    """
    form = r["form"]
    need(form in FORMS, f"the form {form!r} isn't known")
    keys(r, "kind name form alpha beta " + FORMS[form])
    k = len(r["alpha"])
    A, B = mat(r["alpha"], k, k), mat(r["beta"], k, k)
    need(A == A.T and k, "alpha must be symmetric")
    alpha, beta = ([[x.at(i, j) for j in range(k)] for i in range(k)] for x in (A, B))
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
        good = good and alpha[0][0] == alpha[1][1] and max(degrees, theta) <= 90
        good = good and alpha[0][1] == 0 and near(-2 * sine * apex, alpha[0][0])
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
        return alpha, beta, in_matrices(r)
    need(good, f"alpha and beta don't belong to the {form} that is claimed")
    return alpha, beta, "its poles lie in the " + text


def in_matrices(r):
    return (
        "its poles lie in the region alpha + beta s + beta' s* < 0, with alpha = "
        + words_of(r["alpha"]) + " and beta = " + words_of(r["beta"])
    )  # fmt: skip


# ---- 4. Designs: Theorems 2.1, 2.2, 2.4, Lemma 2.2, with pairs or a slack matrix

PAIR = """Theta = {left}((A.i {X} + Bu.i {Y}) E.j' + (A.j {X} + Bu.j {Y}) E.i'){right}/2
EPE = {left}he(E.i {X} E.j'){right}/2
EP = {left}(E.i + E.j) {X}/2
EY = {left}(E.i + E.j) {Y}'/2
W = {left}(Bw.i + Bw.j)/2"""
SLACK = """Theta = {left}(A.i {V}' + Bu.i {Y}) E0'{right}
EPE = {left}E0 {X}.i E0'{right}
EVE = {left}E.i {V}' E0'{right}
EP = {left}E0 {V}
EY = {left}E0 {Y}'
W = {left}Bw.i"""
SLACK_CROSS = "EPE - EVE + epsilon Theta', "
REGION = "-(kron({a}, EPE) + he(kron({b}, Theta))) > 0"
REGION_SLACK = """-[kron({a}, EPE) + he(kron({b}, Theta)), \
kron({b}, EPE - EVE) + epsilon kron(I({k}), Theta'); ., \
-epsilon he(kron(I({k}), EVE))] > 0"""
DISK_SLACK = """-[({q}^2 - {rho}^2) EPE - {q} he(Theta), \
-{q} EPE + {q} EVE + Theta'; ., EPE - he(EVE)] > 0"""
HINF = "-[he(Theta), {y}, {w}; ., -{s}gamma{k}^2/mu{k}, {z}; ., {h}, -{s}mu{k}] > 0"
HINF_SLACK = """-[he(Theta), EPE - EVE + epsilon Theta', {y}, {w}; \
., -epsilon he(EVE), {a}, epsilon {w}; \
., ., -{s}gamma{k}^2/mu{k}, {z}; ., ., ., -{s}mu{k}] > 0"""
LQR = "-[he(Theta), EP {u}L, {y}; ., -{s}Wq, 0; ., 0, -{s}inv(R){r2}] > 0"
LQR_SLACK = """-[he(Theta), EPE - EVE + epsilon Theta', EP {u}L, {y}; \
., -epsilon he(EVE), 0, 0; ., ., -{s}Wq, 0; ., ., ., -{s}inv(R){r2}] > 0"""

STABILITY = {"kind": "stability", "name": "stability", "form": "half-plane",
             "sigma": "0", "alpha": [["0"]], "beta": [["1"]]}  # fmt: skip
NAMES = {
    "gamma": "gamma",
    "h2": "h2",
    "cost": "cost",
    "input": "saturation",
}  # regions have any
SEVERAL = ("gamma", "h2")  # of which a request may have more than one, by name
SIZED = ("gamma", "h2", "cost", "input")  # whose blocks aren't homogeneous in P
NUMBERS = {"gamma": "gamma mu", "h2": "h2", "input": "u_max", "cost": "bound"}


class Design:
    """Blocks of P; a requirement of size s has them of P / s, all multiplied by s."""

    def __init__(self, d):
        self.d, self.t, self.asked = d, Text(d), d["requirements"]
        self.refuted, self.ids, t = "multipliers" in d, {}, self.t
        self.vertices, self.N, self.m, self.p = plant(t, d)
        self.many, self.few = len(self.vertices), distinct(self.vertices)
        need(d["coupling"] in ("pairs", "vertices", "slack"), "unknown coupling")
        self.slack = d["coupling"] == "slack"
        self.far = self._far() if "box" in d else None
        none = d["epsilon"] is None, d["E0"] is None
        need(none == (not self.slack,) * 2, "epsilon and E0 belong to a slack matrix")
        self._pairs()
        for r in self.asked:
            if r["kind"] not in ("region", *SIZED) and "theorem" not in r:
                raise Beyond(f"the theorem of a {r['kind']!r} isn't known here")
            if r["kind"] not in BLOCKS and self.refuted:
                raise Beyond("a refusal by an author's theorem isn't a text")
        where = every_plant(d["plant"], self.many)
        if not self.whole:
            where = f"each of the {self.many} vertices (not the plants between)"
        under = ", under u = K x," if self.m else ""
        self.claims, demands = stated(f"{where}{under} is stable", self.asked)
        self.demands = list(demands.values())
        self._sizes()
        self._write()
        if self.far is not None and not self.refuted:
            kinds = ("region", *SIZED)
            free = all(r["kind"] in kinds and not r.get("acceleration")
                       for r in self.asked)  # fmt: skip
            need(free, "what is asked doesn't pay for a box")
            self._pay()

    def _far(self):
        """How far the plants are from those of the box that is near them."""
        need(not self.slack and "parameters" not in self.d["plant"], "a box of nothing")
        given = Text(self.d)
        plant(given, {k: x for k, x in self.d.items() if k != "box"})
        env, near, several = given.values(), self.t.values(), []
        for name in ("C", "D"):
            need(env.get(name) == near.get(name), "the box has another output")
        for values in (env, near):
            several.append([])
            for i in range(1, self.many + 1):
                E, *rest = (values[f"{x}.{i}"] for x in ("E", "A", "Bu", "Bw"))
                several[-1].append((E, payment.joined(*rest)))
        self.bases = [E for E, _ in several[1]]
        return payment.reach(*several)

    def _pay(self):
        """Each block that the plants move is less a diagonal: see `payment`."""
        t, known, N = self.t, {}, self.N
        for i in self.few:
            steps = payment.absolute(self.bases[i]) @ self.far
            for name, at, wide in (("A", 0, N), ("Bu", N, self.m),
                                   ("Bw", N + self.m, self.p)):  # fmt: skip
                known[f"{name}.{i + 1}"] = steps.cut(0, N, at, wide)
        values = {k: kernel.read(x) for k, x in (t.data | t.found).items()}
        moves = payment.Moves(kernel.Reader(values, sets=t.sets), known)
        forms = set()
        for form, label, price in moves.prices(kernel.parse("\n".join(t.lines))):
            forms.add(form)
            t.data[f"pay.{label}"] = price
        for k, line in enumerate(t.lines):
            form = line.strip().partition(":")[0]
            if form in forms:
                need(line.endswith(" > 0"), "a block that pays has another form")
                t.lines[k] = line.removesuffix(" > 0") + f" - pay.{form} > 0"

    def _pairs(self):
        """The pairs of vertices that have blocks, and whether they are enough."""
        env = self.t.values() if len(self.few) > 1 else {}
        E = {i: env[f"E.{i + 1}"] for i in self.few if env}
        between = [(i, j) for i in E for j in E if i < j and E[i] != E[j]]
        alike = all(env.get(f"{x}.{i + 1}") == env.get(f"{x}.1")
                    for x in self.t.each for i in E)  # fmt: skip
        if between and alike:
            points = []
            for i in E:
                whole = [env[f"{x}.{i + 1}"].T for x in ("E", "A", "Bu", "Bw")]
                parts = (Fraction(e, x.d) for x in whole for u in x.a for e in u)
                points.append(tuple(parts))
            between = [] if suffice(list(E.values()), points) else between
        need(not between or self.far is None, "the box doesn't speak for its inside")
        self.certain = all(E[i] == x for x in E.values() for i in E)
        self.whole = not between or self.d["coupling"] != "vertices"
        pairs = [(i, i) for i in self.few]
        pairs += between if self.d["coupling"] == "pairs" else []
        if self.refuted:  # those without a multiplier add nothing
            named = [tuple(k[3:] * 2)[:2] for k, _ in self.d["multipliers"]]
            pairs = [p for p in pairs if p in set(named)]
        self.pairs = pairs

    def _sizes(self):
        """Which requirements have an unknown size, and under which condition."""
        sized = [r for kind in SIZED for r in self.asked if r["kind"] == kind]
        sized.sort(key=lambda r: (SIZED.index(r["kind"]), r["name"]))
        tied = [r["mu"] for r in self.asked if r["kind"] == "gamma" and r["mu"]]
        ties = [f"mu = {mu}" for mu in tied] if len(sized) > 1 else []
        own = [] if ties else sized[1:]
        if self.slack:
            ties += [f"slack = {float(positive(self.d['epsilon'])):g} s"]
        self.condition = f" for {' and '.join(ties)}" if ties else ""
        if not self.refuted:  # where they are numbers, any may have one
            sized += [r for r in self.asked if r["kind"] not in BLOCKS]
            own = [r for r in sized if size_name(r) in self.d["unknowns"]]
        self.sizes = {key_of(r): size_of(r, self.asked) for r in own}

    def _write(self):
        """All lines but those of the plant."""
        d, t, coordinates = self.d, self.t, "coordinates" in self.d
        self.frame = {"left": "", "right": "", "X": "P", "Y": "Y", "V": "V"}
        if coordinates:
            self._coordinates(d["coordinates"])
        N = f"symmetric {self.N}"
        for (kind, name), s in self.sizes.items():
            size = size_name({"kind": kind, "name": name})
            t.point(s, size, "number")
            t.labels[kind, name, size] = s
            t.write(f"{s}: {s} > 0")
        if self.slack:
            t.put_number("epsilon", d, "epsilon")
            t.put("E0", d, "E0")
            t.sets["distinct"] = [[str(i + 1)] for i in self.few]
            t.write("sign.epsilon: epsilon > 0")
            t.write("P.i: P.i > 0", loop="i in distinct")
            for i in self.few:
                t.point(f"P.{i + 1}", f"P {i + 1}", N)
                t.labels["", "", "P", i] = f"P.{i + 1}"
            t.point("V", "V", f"{self.N} x {self.N}")
        else:
            t.sets["pairs"] = [[str(i + 1), str(j + 1)] for i, j in self.pairs]
            t.write("P: P > 0")
            t.point("P", "P", N)
            t.labels["", "", "P"] = "P"
        self._gain(coordinates)
        once, each = [], []
        for k, r in enumerate(self.asked, 1):
            self.ids[id(r)] = k
            if r["kind"] in BLOCKS:
                numbers_of(t, self.asked, k, r)
            else:
                self._of_author(k, r["theorem"])
        for r in self.demands:
            for where, block, line in BLOCKS.get(r["kind"], own)(self, r):
                label = line.partition(":")[0]
                key = r["kind"], r["name"], block
                for places, at in self._places(where):
                    t.labels[(*key, *places)] = label.split(".i")[0] + at
                (once if where in ("once", "all") else each).append((where, line))
        t.write(*(x for where, x in once if where == "once"))
        t.write(*(x for where, x in once if where == "all"), loop="i in vertices")
        lines = (SLACK if self.slack else PAIR).format(**self.frame).split("\n")
        lines[:0] = ["X.i = T P.i T'"] if self.slack and coordinates else []
        loop = "i in distinct" if self.slack else "i, j in pairs"
        t.write(*lines, *(x for _, x in each), loop=loop)

    def _places(self, where):
        """The vertices in the keys of blocks, and those in their labels."""
        if where == "once":
            return [((), "")]
        if where == "all" or self.slack:
            some = range(self.many) if where == "all" else self.few
            return [((i,), f".{i + 1}") for i in some]
        return [
            ((i,) if i == j else (i, j), f".{i + 1}.{j + 1}") for i, j in self.pairs
        ]

    def _gain(self, coordinates):
        """Y, or what a given K makes of P or V."""
        if self.d["K"] is None:
            self.t.point("Y", "Y", f"{self.m} x {self.N}")
            need(self.refuted, "a gain must be given")
        else:
            self.t.put("K", self.d, "K", self.N)
            T, over = ("T ", "/scale") if coordinates else ("", "")
            P = "V'" if self.slack else "P"
            self.t.write(f"Y = K {T}{P}{over}")
        if coordinates:
            self.t.write("Yx = scale Y T'")

    def _coordinates(self, c):
        """x = T xi, u = scale v, and rows times ``left``; lengths of sizes."""
        t = self.t
        keys(c, "left T back scale sizes")
        for name in ("left", "T", "back"):
            t.put(name, c, name)
            mat(c[name], self.N, self.N)
            t.write(f"{name}.regular: inv({name}) {name} == I({self.N})")
        t.put_number("scale", c, "scale")
        t.write("sign.scale: scale > 0")
        known = {size_name(r): r["kind"] + tag(r, self.asked)
                 for r in self.asked if r["kind"] in SIZED}  # fmt: skip
        for name in c["sizes"]:
            need(name in known, "a size of nothing")
            t.put_number(f"unit.{known[name]}", c["sizes"], name)
            t.write(f"sign.unit.{known[name]}: unit.{known[name]} > 0")
        X, V = ("X", "Vx") if self.slack else ("X", "V")
        self.frame = {"left": "left ", "right": " left'", "X": X, "Y": "Yx", "V": V}
        t.write("Vx = T V T'" if self.slack else "X = T P T'")

    def _of_author(self, k, theorem):
        """The numbers and unknowns of somebody's theorem, under names of their own."""
        keys(theorem, "numbers unknowns blocks")
        need(theorem["blocks"], "an author's claim rests on no block")
        for name in (*theorem["numbers"], *theorem["unknowns"]):
            good = re.fullmatch(rf"own\.{k}\.\w+", name, re.ASCII)
            need(good, f"{name!r:.40} isn't called own.{k}. and a word")
        for name in theorem["numbers"]:
            self.t.put_number(name, theorem["numbers"], name)
        for name, (key, shape) in theorem["unknowns"].items():
            self.t.point(name, key, shape)

    def size(self, r):
        """s, unit, and its inverse, as factors in a text."""
        unit = f"unit.{r['kind']}" + tag(r, self.asked)
        unit = unit if unit in self.t.data else ""
        s = self.sizes.get(key_of(r), "")
        return s and s + " ", unit and unit + " ", unit and "/" + unit


def poles(d, r):
    """Theorem 2.2 for the region alpha + beta s + beta' s* < 0."""
    label, block, a, b, k = "stability", "stability", "[0]", "[1]", 1
    if r is not STABILITY:
        name, block, k = d.ids[id(r)], "", len(r["alpha"])
        label, a, b = f"region.{name}", f"alpha.{name}", f"beta.{name}"
    if not d.slack:
        yield "pair", block, f"{label}.i.j: " + REGION.format(a=a, b=b)
    elif is_disk(r):  # |s - q| < rho
        q, rho = (f"(0 - at({a}, 1, {j}))" for j in (2, 1))
        d.t.write(f"sign.{label}: {rho} > 0")
        yield "pair", block, f"{label}.i: " + DISK_SLACK.format(q=q, rho=rho)
    else:
        yield "pair", block, f"{label}.i: " + REGION_SLACK.format(a=a, b=b, k=k)


def is_disk(r):
    """Whether its matrices are those of a disk, if they are those of any region."""
    (a, *_), *_ = alpha = r["alpha"]
    return r["beta"] == [["0", "1"], ["0", "0"]] and a == alpha[1][1]


def gamma(d, r):
    """Theorem 2.1, the bounded real lemma."""
    more = [x for x in ("outputs", "inputs") if x in r]
    keys(r, " ".join(["kind name gamma mu", *more]))
    need(d.p, "the plant has no disturbance")
    (s, u, over), k = d.size(r), tag(r, d.asked)
    c = Channel(d, r, d.ids[id(r)])
    z, label = c.through(s), f"hinf{k}"
    form = dict(s=s, y=c.y(u), w=f"{s}W{c.S}{over}", a=c.rates(u), z=z, k=k)
    form["h"] = "0" if z == "0" else "."
    if d.slack:
        yield "pair", "hinf", f"{label}.i: " + HINF_SLACK.format(**form)
    else:
        yield "pair", "hinf", f"{label}.i.j: " + HINF.format(**form)


def noise(d, r):
    """The H2 norm: P lies above the Gramian of what w reaches, J above that of y."""
    more = [x for x in ("outputs", "inputs") if x in r]
    keys(r, " ".join(["kind name h2", *more]))
    need(d.p, "the plant has no disturbance")
    t, (s, u, over), k = d.t, d.size(r), tag(r, d.asked)
    c = Channel(d, r, d.ids[id(r)], rates=False)
    y, w, one = c.y(u), f"{s}W{c.S}{over}", s.strip() or "1"
    t.point(f"J_h2{k}", f"J {r['name']}", f"symmetric {c.height}")
    J = f"J_h2{k}" if d.refuted or not s else f"{s}J_h2{k}"  # there it stands for s J
    i, cross = (".i", SLACK_CROSS) if d.slack else (".i.j", "")
    last = " ., -epsilon he(EVE), epsilon " + w + ";" if d.slack else ""
    yield "once", "trace", f"h2{k}.trace: {s}h2{k}^2 - tr({J}) > 0"
    dots = "., ., " if d.slack else "., "
    line = f"-[he(Theta), {cross}{w};{last} {dots}-{one}] > 0"
    yield "pair", "noise", f"h2{k}.noise{i}: {line}"
    yield "pair", "output", f"h2{k}.output{i}: [{J}, ({y})'; ., EPE] > 0"


def peak(d, r):
    """Lemma 2.2: x0 lies in the ellipsoid x' P^-1 x < 1, and |K x| <= u_max there."""
    t, (s, u, over) = d.t, d.size(r)
    start(t, r, d.N)
    back, to = ("back ", " back'") if "back" in t.data else ("", "")
    X, i, one = d.frame["X"], ".i" if d.slack else "", s.strip() or "1"
    where = "pair" if d.slack else "once"
    inner = f"{back}(he({d.frame['V']}) - {X}.i){to}" if d.slack else f"{back}{X}{to}"
    yield where, "x0", f"x0{i}: [{one}, {s}x0'{to}{over}; ., {inner}] > 0"
    lower = f"{s}u_max^2" + (f"/({u}scale)^2" if back else "")
    if not r["acceleration"] or d.d["K_A"] is None:
        yield where, "u_max", f"u_max{i}: [P{i}, Y'; ., {lower}] > 0"
        return
    need(d.certain, "M - B K_A is uncertain")
    rest = ", O(n, rows(U))" if "U" in t.data else ""  # z'' = inertia^-1 (A x + B K x)
    P, T = "V'" if d.slack else "P", "T " if back else ""
    force = f"K_A inv(M.i - B.i K_A) ([-S.i, -D.i{rest}] {T}{P}{'/scale' * bool(back)}"
    force += " + B.i Y) + Y"
    where = "pair" if d.slack else "all"
    yield where, "u_max", f"u_max.i: [P{i}, ({force})'; ., {lower}] > 0"


def start(t, r, N):
    """The x0 of a bound of the input becomes data."""
    keys(r, "kind name u_max x0 acceleration")
    need(isinstance(r["acceleration"], bool), "acceleration must be true or false")
    t.data["x0"] = [[e] for e in r["x0"]]
    mat(t.data["x0"], N, 1)
    t.places[id(r), "x0"] = "|x0"


def cost(d, r):
    """Theorem 2.4: tr J bounds the cost of x'Qx + u'Ru."""
    t, (s, u, over) = d.t, d.size(r)
    states = weights(t, r, d)
    if "C" in r:  # Q = C'C
        t.write("L = Cq'", "Wq = I(rows(Cq))")
    else:
        Q, whole = mat(r["Q"], d.N, d.N), "Q"
        if "N" in r:  # 2 x'N u: a square of u + R^-1 N'x, and the rest
            N, R = mat(r["N"], d.N, d.m), mat(r["R"], d.m, d.m)
            need(kernel.definite(R), "R must be positive definite")
            Q = Q + (N @ kernel.inverse(R) @ N.T).times(Fraction(-1))
            whole = "Q - Nq inv(R) Nq'"
        t.data["L"], t.data["Wq"] = factors(Q)
        t.write("Wq: Wq > 0", f"Q: L inv(Wq) L' == {whole}")
    t.point("J", "J", f"symmetric {d.N if states else d.p}")
    J = "J" if d.refuted or not s else f"{s}J"  # there it stands for s J
    X, i, framed = d.frame["X"], ".i" if d.slack else "", "back" in t.data
    back, to = ("back ", " back'") if framed else ("", "")
    yield "once", "trace", f"trace: {s}bound - tr({J}) > 0"
    if states:
        inner = f"(he({d.frame['V']}) - {X}.i)" if d.slack else X
        noise = f"{s}back'{over}" if framed else s.strip() or "1"
        line = f"cost{i}: [{J}, {noise}; ., {back}{inner}{to}] > 0"
        yield "pair" if d.slack else "once", "cost", line
    else:
        inner, i = ("he(EVE) - EPE", ".i") if d.slack else ("EPE", ".i.j")
        yield "pair", "cost", f"cost{i}: [{J}, {s}W'{over}; ., {inner}] > 0"
    more = {"y": "EY/scale" if framed else "EY"}
    more["r2"] = f"/({u}scale)^2" if framed else ""
    if "N" in r:
        more["y"] += " + EP Nq inv(R)" + "/scale" * framed
    form, i = (LQR_SLACK, ".i") if d.slack else (LQR, ".i.j")
    yield "pair", "lqr", f"lqr{i}: " + form.format(s=s, u=u, **more)


def weights(t, r, d):
    """The weights of a cost become data; whether the noise is on the states."""
    good = r["noise"] == "states" or (r["noise"] == "F" and d.p)
    need(good, 'noise must be "states", or "F" with F')
    mine = {"C": "Cq"} if "C" in r else {"Q": "Q", **({"N": "Nq"} if "N" in r else {})}
    keys(r, " ".join(["kind name R noise bound", *mine]))
    t.put("R", r, "R")
    for key, name in mine.items():
        t.put(name, r, key)
    t.write("R: R > 0")
    return r["noise"] == "states"


def own(d, r):
    """Blocks of somebody's theorem: what they mean is the author's word."""
    k = d.ids[id(r)]
    for where, block, text in r["theorem"]["blocks"]:
        need(where in ("once", "pair"), "a block is written once, or for each pair")
        tokens = kernel.Parser(text)
        tokens.expression()
        good = tokens.k == len(tokens.t) and not re.search(r"[\n#]", text)
        need(good, f"a block of an author is one matrix, not {text!r:.60}")
        label = f"own.{k}." + re.sub(
            r"\W", "_", sane(block or r["name"]), flags=re.ASCII
        )
        at = "" if where == "once" else ".i" if d.slack else ".i.j"
        yield where, block, f"{label}{at}: {text} > 0"


def stated(stable, asked, signal="K x"):
    """What is claimed, `stable` first, and by name the requirements that prove it."""
    need(isinstance(asked, list), "requirements must be a list")
    names = [(r["kind"], sane(r["name"])) for r in asked]
    named = [NAMES.get(kind, name) == name for kind, name in names
             if kind not in SEVERAL]  # fmt: skip
    need(all(named), "a requirement has another name than its kind")
    need(len(set(names)) == len(names), "a requirement comes twice")
    owners = [next(filter(implies_stability, asked), STABILITY)]
    owners += [next(o for o in asked if repeats(r, o)) for r in asked]
    words = [stable, *(claim(r, signal) for r in asked)]
    return words, {key_of(r): r for r in owners}


def numbers_of(t, asked, k, r):
    """The numbers of the k-th requirement become data; words need their signs."""
    if r["kind"] == "region":
        for name in ("alpha", "beta"):
            t.put(f"{name}.{k}", r, name)
        for name in FORMS[r["form"]].split():
            t.put_number(f"{name}.{k}", r, name)
        return
    for name in NUMBERS[r["kind"]].split():
        if r[name] is not None:
            full = name + tag(r, asked)
            t.put_number(full, r, name)
            t.write(f"sign.{full}: {full} > 0")
    if r["kind"] == "gamma" and r["mu"] is None:
        t.write(f"mu{tag(r, asked)} = 1")


def key_of(r):
    return r["kind"], r["name"]


def size_of(r, asked):
    """What a text calls the size of a requirement."""
    if r["kind"] in BLOCKS:
        return "s_" + r["kind"] + tag(r, asked)
    return f"own.{1 + next(k for k, q in enumerate(asked) if q is r)}.size"


def tag(r, asked):
    """What tells the names of a requirement from those of others of its kind."""
    plain = r["name"] == NAMES.get(r["kind"], r["name"])
    return "" if plain else f".{1 + next(k for k, q in enumerate(asked) if q is r)}"


def factors(rest):
    """L and W with Q = L W^-1 L' and W diagonal."""
    columns, sizes, N = [], [], rest.r
    need(kernel.definite(rest, semi=True), "Q must be positive semidefinite")
    for k in range(N):
        pivot = rest.at(k, k)
        if pivot:
            column = Mat(N, 1, [[u[k]] for u in rest.a], rest.d).times(1 / pivot)
            columns.append([column.at(i, 0) for i in range(N)])
            sizes.append(1 / pivot)
            rest = rest + (column @ column.T).times(-pivot)
    n = len(sizes)
    L = [[str(c[i]) for c in columns] for i in range(N)] if n else {"zeros": [N, 0]}
    W = [[str(e) if i == j else "0" for j in range(n)] for i, e in enumerate(sizes)]
    return L, W or {"zeros": [0, 0]}


def size_name(r):
    """The name of a requirement's size among the unknowns."""
    return " ".join(["size for", *dict.fromkeys((r["kind"], r["name"]))])


def repeats(r, other):
    """Whether they are the same, or one region by matrices of whatever size."""
    if r is other or not r["kind"] == other["kind"] == "region":
        return r is other
    (a, b, _), (c, d, _) = region(r), region(other)
    one, two = (next((abs(e) for row in x for e in row if e), 1) for x in (b, d))
    return [[[two * e for e in u] for u in x] for x in (a, b)] == [
        [[one * e for e in u] for u in x] for x in (c, d)]  # fmt: skip


def implies_stability(r):
    if r["kind"] != "region":
        return r["kind"] in ("gamma", "h2", "cost")
    alpha, beta, _ = region(r)
    return len(beta) == 1 and beta[0][0] > 0 <= alpha[0][0]


def claim(r, signal):
    """What the blocks of a requirement prove."""
    if r["kind"] == "region":
        return region(r)[2]
    if r["kind"] not in BLOCKS:
        need(isinstance(r["claim"], str), "an author's claim must be words")
        return f"{r['name']}, by its author's theorem: {json.dumps(r['claim'])}"
    if r["kind"] in SEVERAL:
        whose = "its" if r["name"] == r["kind"] else f"{r['name']}: its"
        norm = {"gamma": "H-infinity", "h2": "H2"}[r["kind"]]
        return f"{whose} {norm} norm{ends(r)} is below {r[r['kind']]}"
    if r["kind"] == "input":
        signal += " + K_A z''" if r["acceleration"] else "(t)"
        return f"|{signal}| <= {r['u_max']} from x0 (with r = 0, w = 0)"
    return f"its quadratic cost is below {r['bound']} times the largest noise intensity"


BLOCKS = {"region": poles, "gamma": gamma, "h2": noise, "input": peak, "cost": cost,
          "stability": poles}  # fmt: skip
