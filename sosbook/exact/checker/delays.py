"""A loop whose input comes late: d in [tau - mu, tau + mu], in units of tau."""

from fractions import Fraction

from .arithmetic import Beyond, need
from .families import CHANGING, decimal, every_plant, keys, under
from .plants import coordinates, distinct, plant
from .text import Text, number, positive, ratio

MISPRINTS = "sign", "transpose", "alpha"
MOST_EXPONENT, FINE = 10_000, 10**80  # 4343 digits, and some behind the point
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
DECAY = """decay.i.f: -[2 d P + he(Q) + R1 - e1 R3 + S + e2 {first}, \
P + R2' + e2 (GA' - FE), e1 R3 - Q + e2 late, 2 d Q - e1 R2{Z1}; \
., R3 + {Z}he(0 - e2 GE), e2 rate, Q{Z2}; ., ., -e1 (R3 + S), e1 R2{Z0}; \
., ., ., -e1 R1{Z0}{Z5}] > 0"""


def exponential(x):
    """Bounds of e^x, for x >= 0."""
    if x >= 20:
        need(x < MOST_EXPONENT, "an exponential of a very large number")
        low, high = (y * y * FINE for y in exponential(x / 2))
        return Fraction(int(low), FINE), Fraction(int(high) + 1, FINE)
    total = term = Fraction(1)
    for k in range(1, 80):
        term = term * x / k
        total += term
    return total, total + term


class Delay:
    """All methods but the first prove stability of e^(delta t) x(t)."""

    def __init__(self, d):
        """Write the text: the functional, and the decay of each vertex."""
        self.t, self.d = Text(d), d
        t, method = self.t, d["method"]
        if method not in LATE:
            raise Beyond(f"the theorem of method {method!r} isn't known here")
        self.printed = d["misprints"]
        good = {*self.printed} <= {*MISPRINTS}
        good = good and (method == "functional" or not self.printed)
        need(good, "an unknown misprint")
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
        coordinates(t, d["coordinates"], self.N)
        need(d["coordinates"]["sizes"] == {}, "there is no size")
        self.known = d["K"] is not None
        if self.known:
            t.put("K", d, "K", (self.m, self.N))
            t.write("Kx = K T/scale")
        self.free = d["analysis"]  # F and G, else G = alpha F
        none = d["alpha"] is None
        good = none == self.free or (self.free and "alpha" in self.printed)
        need(good, "alpha belongs to a design")
        need(self.known or not self.free, "an analysis needs its gain")
        if not none:
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
            index = f" {i}" if int(i) <= self.many > 1 else ""
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
        t.put("A_", loop, "A", (N, N))
        t.put("Ad", loop, "A_d", (N, N))
        t.write("E.1 = I(rows(A_))", "A.1 = A_", "Bu.1 = Ad")
        self.m = self.N = N
        self.many = 1
        return [0]

    def _plant(self):
        need(self.d["K_A"] is None, "there is no K_A behind a delay")
        vertices, self.N, self.m, _ = plant(self.t, self.d)
        self.many = len(vertices)
        return distinct(vertices)

    def _exponentials(self, tau, delta):
        """The rational factors; of the functional they are rounded down."""
        t, mu, given = self.t, self.mu, self.d["exponentials"]
        bounds = [ratio(x) for x in given]
        both = self.d["method"] == "functional" or delta
        need(len(bounds) == (2 if both else 0), "exponentials: there are two factors")
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
        if not delta:
            return ["one"]
        t.data.update(zip(("factor.shortest", "factor.longest"), given))
        low, high = bounds
        need(low <= exponential(delta * (tau - mu))[0], "too large a factor")
        need(high >= exponential(delta * (tau + mu))[1], "too small a factor")
        return ["shortest", "longest"]

    def _claim(self, tau, delta):
        """The claim, in words, for the delay ``tau`` and the decay ``delta``."""
        d, mu = self.d, self.mu
        if self.printed:
            return "the LMIs as printed hold: that proves nothing about the loop"
        who = every_plant(d["plant"], self.many, CHANGING)
        who += under(d["plant"], late="(t - d)")
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
    """Theorems A.3 (F and G free) and 2.3 (G = alpha F), corrected or as printed."""
    sign, first, last = "-", "he(FA)", "rate"
    if "sign" in x.printed:
        sign = ""
    if "transpose" in x.printed and x.free:
        first = "he(A F')"
    if "alpha" in x.printed and x.free and x.d["alpha"] is not None:
        last = "(alpha/tau) rate"
    x.unknowns("P S R1 R3" + " Z" * (x.mu > 0), "Q R2 F" + " G" * x.free)
    if not x.known:
        x.t.point("X", "X", f"{x.m} x {x.N}")
    x.block("functional", "functional", "[P, Q; ., e1 S]")
    x.block("R", "R", "[R1, R2'; ., R3]")
    more = dict.fromkeys(("Z", "Z0", "Z1", "Z2", "Z5"), "")
    if x.mu:
        if sign:
            x.block("Z", "Z", "Z")
        more = dict(Z="2 m Z + ", Z0=", 0", Z1=", late", Z2=f", {last}",
                    Z5=f"; ., ., ., ., {sign}Z/(e2 m)")  # fmt: skip
    late = "B Kx F'" if x.known else "B X"
    x.lines += (FREE if x.free else TIED.format(late=late)).split("\n")
    x.lines.append(DECAY.format(**more, first=first))
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
