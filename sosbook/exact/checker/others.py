"""Texts and words of what is no design: delays, observers, masses, matrices, LMIs.

1. A loop whose input comes late    2. Lemma 2.1, the observer of Theorem 2.5
3. Matrices, LMIs of one's own
"""

import re
from fractions import Fraction

from .families import decimal, every_plant
from .kernel import Beyond, need
from .statements import Text, distinct, keys, mat, number, plant, positive, ratio, sane

# ---- 1. A loop whose input comes late: d in [tau - mu, tau + mu], in units of tau

LOOP = """E = left E.i T
A = {q}(tau left A.i T{shift})
B = factor.f tau scale {q}left Bu.i"""
FREE = """FA = F A
GA = G A
FE = F E
GE = G E
late = F B Kx
rate = G B Kx"""
TIED = """FA = A F'
GA = (alpha/tau) FA
FE = E F'
GE = (alpha/tau) FE
late = {late}
rate = (alpha/tau) late"""
DECAY = """decay.i.f: -[2 d P + he(Q) + R1 - e1 R3 + S + e2 he(FA), \
P + R2' + e2 (GA' - FE), e1 R3 - Q + e2 late, 2 d Q - e1 R2{Z1}; \
., R3 + {Z}he(0 - e2 GE), e2 rate, Q{Z2}; ., ., -e1 (R3 + S), e1 R2{Z0}; \
., ., ., -e1 R1{Z0}{Z5}] > 0"""


def exponential(x, terms=80):
    """Bounds of e^x, for 0 <= x < 20."""
    if not 0 <= x < 20:
        raise Beyond("an exponential is out of this checker's range")
    total = term = Fraction(1)
    for k in range(1, terms):
        term = term * x / k
        total += term
    return total, total + term


class Delay:
    """All methods but the first prove stability of e^(delta t) x(t)."""

    def __init__(self, d):
        self.t, self.d = Text(d), d
        t, method = self.t, d["method"]
        if method not in LATE:
            raise Beyond(f"the theorem of method {method!r} isn't known here")
        need(d["misprints"] == [], "the theorem as printed proves nothing")
        first, order = method in ("legendre", "interval"), d["order"]
        good = type(order) is int and 0 <= order < 99
        good = good and (method == "legendre" or order < 2)
        need(good if first else order is None, "an order that isn't one")
        self.order, self.loop = order, d["plant"]["kind"] == "loop"
        self.mu = number(d["mu"])
        tau, delta = positive(d["tau"]), number(d["delta"])
        need(0 <= self.mu <= tau and delta >= 0, "mu or delta is out of range")
        few = self._loop() if self.loop else self._plant()
        need(self.many == 1 or not first, "this method takes one plant")
        for name in ("tau", "mu", "delta"):
            t.put_number(name, d, name)
        self._coordinates()
        self.known = d["K"] is not None
        if self.known:
            t.put("K", d, "K", self.N)
            t.write("Kx = K T/scale")
        self.free = d["alpha"] is None  # F and G, else G = alpha F
        need(d["analysis"] is self.free, "alpha belongs to a design")
        need(self.known or not self.free, "an analysis needs its gain")
        if not self.free:
            t.put_number("alpha", d, "alpha")
            t.write("sign.alpha: alpha > 0")
        t.write("sign.tau: tau > 0", "m = mu/tau", "sign.mu: mu >= 0",
                "shorter: tau - mu >= 0")  # fmt: skip
        ends, shift = self._exponentials(tau, delta), ""
        if method != "functional":
            shift = " + delta tau E" if delta else ""
        t.sets["loops"] = [[str(i + 1), f] for i in few for f in ends]
        q = "inv(E) " if first else ""
        self.lines = LOOP.format(shift=shift, q=q).split("\n")
        LATE[method](self)
        t.write(*self.lines, loop="i, f in loops")
        self.claims = [self._claim(tau, delta)]

    def block(self, label, key, text):
        """A block that is demanded once."""
        self.t.labels[key] = label
        self.t.write(f"{label}: {text} > 0")

    def decay(self, label="decay", tail=""):
        """The keys of the blocks of each loop."""
        for i, f in self.t.sets["loops"]:
            index = f" {i}" if self.many > 1 else ""
            end = "" if f == "one" else " " + f
            self.t.labels[f"decay{index}{end}{tail}"] = f"{label}.{i}.{f}"

    def unknowns(self, symmetric, full):
        for name in symmetric.split():
            self.t.point(name, name, f"symmetric {self.N}")
        for name in full.split():
            self.t.point(name, name, f"{self.N} x {self.N}")

    def _loop(self):
        """x' = A x + A_d x(t - d) is read with B = A_d and K = 1."""
        d, t = self.d, self.t
        loop, N = d["plant"], len(d["plant"]["A"])
        keys(loop, "kind A A_d")
        need(d["U"] == [] and d["K_A"] is None, "a loop has no U, no K_A")
        one = [["1" if i == j else "0" for j in range(N)] for i in range(N)]
        need(d["K"] == one, "the K of a loop is the identity")
        t.put("A_", loop, "A")
        t.put("Ad", loop, "A_d")
        t.write("E.1 = I(rows(A_))", "A.1 = A_", "Bu.1 = Ad")
        self.m = self.N = N
        self.many = 1
        return [0]

    def _plant(self):
        need(self.d["K_A"] is None, "there is no K_A behind a delay")
        vertices, self.N, self.m, _ = plant(self.t, self.d)
        self.many = len(vertices)
        return distinct(vertices)

    def _coordinates(self):
        t, c = self.t, self.d.get("coordinates", {})
        keys(c, "left T back scale sizes")
        need(c["sizes"] == {}, "there is no size")
        for name in ("left", "T", "back"):
            t.put(name, c, name)
            mat(c[name], self.N, self.N)
        t.put_number("scale", c, "scale")
        t.write(
            *(
                f"{x}.regular: inv({x}) {x} == I({self.N})"
                for x in ("left", "T", "back")
            )
        )
        t.write("sign.scale: scale > 0")

    def _exponentials(self, tau, delta):
        """The rational factors; of the functional they are rounded down."""
        t, mu, given = self.t, self.mu, self.d["exponentials"]
        bounds = [ratio(x) for x in given]
        t.write("factor.one = 1")
        if self.d["method"] == "functional":
            t.data.update(zip(("e1", "e2"), given))
            e1, e2 = bounds
            late = 2 * delta * (tau + mu)
            for e, x in ((e1, 2 * delta * tau), (e2, late)):
                down = 0 < e and e * exponential(x)[1] <= 1
                need(down, "an exponential isn't rounded down")
            t.write("d = delta tau")
            return ["one"]
        t.write("d = 0", "e1 = 1", "e2 = 1")
        need(len(bounds) == (2 if delta else 0), "there must be two factors")
        if not delta:
            return ["one"]
        t.data.update(zip(("factor.shortest", "factor.longest"), given))
        low, high = bounds
        need(low <= exponential(delta * (tau - mu))[0], "too large a factor")
        need(high >= exponential(delta * (tau + mu))[1], "too small a factor")
        return ["shortest", "longest"]

    def _claim(self, tau, delta):
        d, mu = self.d, self.mu
        who = every_plant(d["plant"], self.many)
        who += ", under u = K x(t - d),"
        who = "the loop" if self.loop else who
        how = "is exponentially stable"
        if delta:
            how = f"decays at least as fast as exp(-{d['delta']} t)"
        when = f"the constant delay {d['tau']} s"
        if mu:
            ends = f"[{decimal(tau - mu)}, {decimal(tau + mu)}]"
            when = f"every delay in {ends} s, however it varies"
        return f"{who} {how} for {when}"


def krasovskii(x):
    """Theorems A.3 (F and G free) and 2.3 (G = alpha F), corrected."""
    x.unknowns("P S R1 R3" + " Z" * (x.mu > 0), "Q R2 F" + " G" * x.free)
    if not x.known:
        x.t.point("X", "X", f"{x.m} x {x.N}")
    x.block("functional", "functional", "[P, Q; ., e1 S]")
    x.block("R", "R", "[R1, R2'; ., R3]")
    more = dict.fromkeys(("Z", "Z0", "Z1", "Z2", "Z5"), "")
    if x.mu:
        x.block("Z", "Z", "Z")
        more = dict(Z="2 m Z + ", Z0=", 0", Z1=", late", Z2=", rate",
                    Z5="; ., ., ., ., -Z/(e2 m)")  # fmt: skip
    late = "B Kx F'" if x.known else "B X"
    x.lines += (FREE if x.free else TIED.format(late=late)).split("\n")
    x.lines.append(DECAY.format(**more))
    x.decay()


def legendre(x):
    """Bessel's inequality of an order, of Seuret and Gouaisbaut (2015).

    X.k is the integral of L_k x over [t - 1, t], v that of x' from t - d to t - 1,
    divided by mu.
    """
    N, order, varies = x.N, x.order, x.mu > 0
    parts = 2 + order + varies
    x.t.point("P", "P", f"symmetric {(1 + order) * N}")
    x.unknowns("S R Z" if varies else "S R", "")
    weights = [f"{times(2 * k - 1)}S" for k in range(1, order + 1)]
    table = [[w if i == j else "0" for j in range(order + 1)]
             for i, w in enumerate([f"O({N}, {N})", *weights])]  # fmt: skip
    x.block("functional", "functional", "P + " + blocks(table))
    for name in ("S", "R", "Z") if varies else ("S", "R"):
        x.block(name, name, name)
    pick = [f"pick({k + 1}, {parts}, {N})" for k in range(parts)]
    names = ["now", "late", *(f"X.{k}" for k in range(order)), "v"][:parts]
    x.lines += [f"{a} = {b}" for a, b in zip(names, pick)]
    x.lines.append("flow.0 = A now + B Kx " + ("(late - m v)" if varies else "late"))
    total = ["he(state' P flow)", "now' S now", "-late' S late"]
    total.append("flow.0' (R + 2 m Z) flow.0" if varies else "flow.0' R flow.0")
    for k in range(order + 1):  # the integrals of L_k x', by parts
        parts = [f"{2 * (2 * i + 1)} X.{i}" for i in range(k) if (k + i) % 2]
        change = " - ".join([f"now {'+' if k % 2 else '-'} late", *parts])
        x.lines.append(f"flow.{k + 1} = {change}")
        total.append(f"-{times(2 * k + 1)}flow.{k + 1}' R flow.{k + 1}")
    state = ["now", *(f"X.{k}" for k in range(order))]
    x.lines.append("state = " + blocks([[s] for s in state]))
    x.lines.append("flow = " + blocks([[f"flow.{k}"] for k in range(order + 1)]))
    total += ["-m v' Z v"] if varies else []
    x.lines.append(f"decay.i.f: -({summed(total)}) > 0")
    x.decay()


def times(k):
    return f"{k} " if k > 1 else ""


def blocks(table):
    return "[" + "; ".join(", ".join(row) for row in table) + "]"


def summed(terms):
    return " + ".join(terms).replace("+ -", "- ")


def interval(x):
    """The ends of the interval apart, with the reciprocally convex bound.

    Of Park, Ko and Jeong (2011), and Seuret and Gouaisbaut (2013).
    """
    N, order, within, before = x.N, x.order, x.mu > 0, x.mu < number(x.d["tau"])
    size = N * (1 + before + within) if order else N
    x.unknowns("Q1 R1 " * before + "Q2 R2" * within, "")
    if within:
        x.t.point("T_", "T", f"{(1 + order) * N} x {(1 + order) * N}")
    x.t.point("P", "P", f"symmetric {size}")
    x.t.write("h1 = 1 - m", "width = 2 m")
    parts = [f"O({N}, {N})", *["Q1/h1"] * before, *["Q2/width"] * within]
    table = [[w if i == j else "0" for j in range(len(parts))]
             for i, w in enumerate(parts)]  # fmt: skip
    x.block("functional", "functional", "P + " + blocks(table) if order else "P")
    for name in ["Q1", "R1"] * before + ["Q2", "R2"] * within:
        x.block(name, name, name)
    if within:
        wide = "kron([1, 0; 0, 3], R2)" if order else "R2"
        x.t.write(f"wide = {wide}", "bound = [wide, T_; ., wide]")
        x.block("kernel", "kernel", "bound")
    names = ["x"] + ["x1"] * before + ["xd", "x2"] * within
    names += (["m1"] * before + ["m2", "m3"] * within) if order else []
    x.lines += [f"{a} = pick({k}, {len(names)}, {N})" for k, a in enumerate(names, 1)]
    x1 = "x1" if before else "x"  # values, and means between them
    xd = "xd" if within else x1

    def moments(new, old, mean):
        return [f"{new} - {old}"] + [f"{new} + {old} - 2 {mean}"] * order

    x.lines.append(f"rate = A x + B Kx {xd}")
    state, flow, total = ["x"], ["rate"], []
    if before:
        total += ["x' Q1 x", "-x1' Q1 x1", "h1^2 rate' R1 rate"]
        for k, moment in enumerate(moments("x", "x1", "m1")):
            x.lines.append(f"before.{k} = {moment}")
            total.append(f"-{times(2 * k + 1)}before.{k}' R1 before.{k}")
        state, flow = state + ["h1 m1"] * order, flow + ["x - x1"] * order
    if within:
        both = moments(x1, "xd", "m2") + moments("xd", "x2", "m3")
        x.lines.append("both = " + blocks([[e] for e in both]))
        total += [f"{x1}' Q2 {x1}", "-x2' Q2 x2", "width^2 rate' R2 rate"]
        total.append("-both' bound both")
        flow += [f"{x1} - x2"] * order
    x.lines.append("flow = " + blocks([[e] for e in flow]))
    ends = (("early", "m3"), ("late", "m2")) if order and within else (("decay", ""),)
    for end, mean in ends:
        whole = state + ([f"width {mean}"] if mean else [])
        name = "state" + (f".{end}" if mean else "")
        x.lines.append(f"{name} = " + blocks([[e] for e in whole]))
        text = summed([*total, f"he({name}' P flow)"])
        x.lines.append(f"{end}.i.f: -({text}) > 0")
        x.decay(end, f" {end}" if mean else "")


LATE = {
    "functional": krasovskii,
    "shift": krasovskii,
    "legendre": legendre,
    "interval": interval,
}


# ---- 2. Lemma 2.1, the observer of Theorem 2.5


class Mass:
    """The symmetric part of M - B K_A exceeds beta^2 at each vertex."""

    def __init__(self, d):
        t = self.t = Text(d)
        need(d["plant"]["kind"] == "second order", "this plant has no mass")
        vertices, N, m, _ = plant(t, dict(d, U=[], K_A=None))
        t.put_number("beta", d, "beta")
        t.write("sign.beta: beta > 0")
        if d["K"] is None:
            t.point("K_A", "K_A", f"{m} x {N // 2}")
        else:
            t.put("K_A", d, "K", N // 2)
        few, many = distinct(vertices, "MB"), len(vertices)
        t.sets["vertices"] = [[str(i + 1)] for i in few]
        for i in few:
            t.labels[f"mass {i + 1}" if many > 1 else "mass"] = f"mass.{i + 1}"
        t.write("mass.i: he(M.i - B.i K_A)/2 - beta^2 > 0", loop="i in vertices")
        where = every_plant(d["plant"], many)
        least = "the eigenvalues of its symmetric part exceed beta^2 = "
        least += decimal(positive(d["beta"]) ** 2)
        self.claims = [f"for {where}, M - B K_A is regular", least]


OBSERVER = """off = (B0 - Bu.i) K
E = [E0, E.i - E0; 0, E.i]
A = [A0 + off, A.i - A0 - off; -Bu.i K, A.i + Bu.i K]
flow = he(back' A' inv(E)' T P + [T1C' Y, 0; 0, O(N, N)])
decay.i: -[flow, P Q, [Y' R_F; O(N, cols(R_F))]; ., -1, 0; ., 0, -1] > 0
inner = left E.i T1
cost.i: [J, (left noise.i)'/unit; ., inner P1 inner'] > 0"""


class Observer:
    """Theorem 2.5 at each vertex: u = K x^, and x^ follows a model of the plant.

    L = P1^-1 Y'. The dual state is T xi.
    """

    def __init__(self, d):
        t = self.t = Text(d)
        c, model = d["coordinates"], d["model"]
        vertices, N, *_ = plant(t, dict(d, U=[], K_A=None))
        keys(c, "T left unit")
        keys(model, "E A Bu")
        for name, holder, key in (
            ("T1", c["T"], 0), ("T2", c["T"], 1), ("left", c, "left"),
 ("E0", model, "E"), ("A0", model, "A"),
            ("B0", model, "Bu"), ("K", d, "K"), ("C_", d, "C"), ("Q_F", d, "Q_F"),
            ("R_F", d, "R_F"),
        ):  # fmt: skip
            t.put(name, holder, key, N)
        t.put_number("unit", c, "unit")
        need(len(c["T"]) == 2, "there are two parts of T")
        need(len(d["noises"]) == len(vertices), "a vertex without noise")
        for i, _ in enumerate(vertices):
            t.put(f"noise.{i + 1}", d["noises"], i)
        q, p = len(d["C"]), len(d["noises"][0][0])
        for name, shape in (("P1", N), ("P2", N), ("J", p)):
            t.point(name, name, f"symmetric {shape}")
        t.write(
            f"N = {N}", "sign.unit: unit > 0", "left.regular: inv(left) left == I(N)"
        )
        t.write("T = [T1, 0; 0, T2]", "back = inv(T)'", "T1C = C_ inv(T1)'")
        t.write("Q = T' Q_F", "P = [P1, 0; 0, P2]", "P1: P1 > 0", "P2: P2 > 0")
        named = ["P1", "P2", *["trace"] * ("L" in d)]
        if "L" in d:
            t.put("L", d, "L")
            t.put_number("bound", d, "bound")
            t.write("Y = L' T1 P1", "sign.bound: bound > 0",
                    "trace: bound/unit^2 - tr(J) > 0")  # fmt: skip
            self.claims = ["at each vertex (not between them) the loop with the "
                           "observer is stable",
                           f"tr J is at most {d['bound']} there"]  # fmt: skip
        else:
            t.point("Y", "Y", f"{q} x {N}")
            self.claims = ["no observer with this K is proven by these LMIs at the "
                           "vertices"]  # fmt: skip
        t.labels = {x: x for x in named}
        for i in range(1, len(vertices) + 1):
            for x in ("decay", "cost"):
                t.labels[f"{x} {i}"] = f"{x}.{i}"
        t.write(*OBSERVER.split("\n"), loop="i in vertices")


# ---- 3. Matrices, LMIs of one's own


class Schur:
    """|L x| decays in each of some matrices F: rate^2 L'L - F' L'L F > 0."""

    def __init__(self, d):
        t = self.t = Text(d)
        if any(isinstance(e, list) for F in d["matrices"] for r in F for e in r):
            raise Beyond("matrices of balls rest on more than rationals")
        need(d["note"] == "", "there is nothing to note")
        need(d["cells"] is not None and d["undecided"] == [], "nothing is proven")
        many = len(d["matrices"])
        need(len(d["cells"]) == many > 0, "a matrix without an L")
        t.put_number("rate", d, "rate")
        for i, F in enumerate(d["matrices"]):
            t.put(f"F.{i + 1}", d["matrices"], i)
            t.put(f"L.{i + 1}", d["cells"], i)
            _ = mat(F, len(F), len(F)), mat(d["cells"][i], len(F), len(F))
        t.sets["matrices"] = [[str(i + 1)] for i in range(many)]
        t.write("sign.rate: rate > 0", "one: 1 - rate >= 0")
        lines = "P = L.i' L.i", "metric.i: P > 0", "matrix.i: rate^2 P - F.i' P F.i > 0"
        t.write(*lines, loop="i in matrices")
        pace = f": every motion decays at least as {float(number(d['rate']))!r}^k"
        pace = pace if number(d["rate"]) != 1 else ""
        self.claims = [f"matrix {k + 1} is stable{pace}" for k in range(many)]


class Own:
    """LMIs that someone wrote: constants, and terms L X R in unknowns X."""

    def __init__(self, d):
        t, names = Text(d), {}
        self.t, words = t, d.get("statement", [])
        good = isinstance(words, list) and all(isinstance(w, str) for w in words)
        need(good, "the statement must be words")
        for k, (name, r, c, even) in enumerate(d["shapes"], 1):
            good = type(r) is type(c) is int and min(r, c) > 0
            need(good, "an unknown has a name and a size")
            need(even is False or (even is True and r == c), "not symmetric")
            need(sane(name) not in names, "a name comes twice")
            names[name] = f"X.{k}"
            t.point(f"X.{k}", name, f"symmetric {r}" if even else f"{r} x {c}")
        said = [sane(name) for name, _, _ in d["expressions"]]
        need(len(set(said)) == len(said) > 0 < len(names), "a name comes twice")
        for i, row in enumerate(d["expressions"], 1):
            t.put(f"C.{i}", row, 1, entry=ratio)
            parts = [f"C.{i}"]
            for j, term in enumerate(row[2], 1):
                name, turned, _, _ = term
                need(isinstance(turned, bool), "transposed is true or false")
                t.put(f"L.{i}.{j}", term, 2, entry=ratio)
                t.put(f"R.{i}.{j}", term, 3, entry=ratio)
                parts.append(f"L.{i}.{j} {names[name]}{chr(39) * turned} R.{i}.{j}")
            t.labels[row[0]] = f"block.{i}"
            t.write(f"block.{i}: {' + '.join(parts)} > 0")
        for e in (e for x in d.get("unknowns", {}).values() for u in x for e in u):
            count = len(re.sub("e.*|[-.]", "", e).strip("0"))
            good = type(d["digits"]) is int and count <= d["digits"]
            need(good, "the point has more digits")
        how = "these blocks are positive definite"
        if "multipliers" in d:
            how = "no point makes all these blocks positive definite"
        self.claims = [f"{how}: " + ", ".join(said)]
