"""A sampled loop falls: every plant of cells, under every clock of boxes.

The theorem that all cells rest on is that of `sosbook.sampled.cells`; what is new is
its W. Where a plant is a mean of a cell's corners with weights w_i, and a clock one of
a box's with tau_j, the loop, which is `ticks`', is

    F = sum w_i tau_j F_ij + D.

**Second order.** Let q be the term of second order at the middle. A quadratic form of a
mean is the mean of its values less w_i w_j times its value at each difference of two,
and of a box less t (1 - t) times its value along each edge; what is a product of
different axes is none of it. So D holds - beta q(e) for each edge e, 0 <= beta <= 1/4.

**Third order.** In the coordinates R x and scale u let G be the generator, and a change
of G t have the norms nu_1, nu_2, .. by order, of the sum nu < 4. Duhamel's series has
for k changes, between e^(G t s), terms below e^(growth t) nu^k / k!, where he(G)/2 <
growth; for both spans of a tick nu is the sum. So what is of third order and above, at
the plant and at the corners, is below ``rest`` =

    nu^3/(6 - 3 nu/2) + (nu - nu_1 - nu_2) + (nu^2 - nu_1^2)/2

times e^(growth T). Of E^-1 [A B] = Y + (1 + Z)^-1 N the term of order k is at most
|Z|^(k-1) |N|, and where |Z| < 1 at the corners each E in the cell is regular.

**Both.** By Cauchy and Schwarz |D x|^2 <= (sum n) sum |H x|^2/n, for any n > 0.
"""

import re
from itertools import combinations, product

from .arithmetic import need
from .families import keys
from .text import number
from .ticks import Ticks, said

FRAME = """Li.f = near(inv(L.f))
Ri.f = near(inv(R.f))
back.f = [Ri.f, O({N}, {m}); O({m}, {N}), 1/scale.f I({m})]
in.f = [R.f, O({N}, 2 {m}); O(2 {m}, {N}), scale.f I(2 {m})] act Li.f
out.f = L.f [Ri.f; O({n} - {N}, {N})]
top.f = out.f [I({N}), O({N}, 2 {m})]
rest.f = L.f [O({N}, {n}); later] Li.f - centre
size.f = norm(out.f)
width.f = norm(in.f)"""
MIDDLE = """inv.q = near(inv(e.q))
Y.q = inv.q x.q
gen.q = R.f Y.q back.f
one.q = [gen.q first; O(2 {m}, {w})]
two.q = [gen.q second; O(2 {m}, {w})]
g.q = norm(one.q)
growth.q: limit.q - he(one.q)/2 > 0"""
AWAY = """Z.q.k = inv.q {e}
N.q.k = R.f (inv.q {x} - Z.q.k Y.q) back.f
z.q.k = norm(R.f Z.q.k Ri.f)
nu.q.k = norm(N.q.k)"""
SIMPLEX = """z.q = most({z})
nu1.q = most({nu})
nu2.q = z.q nu1.q
nu.q = nu1.q/(1 - z.q)"""
BOX = """z.q = {z}
nu1.q = {nu1}
nu2.q = {nu2} + ({z1}) nu1.q
nu.q = ({nu})/(1 - z.q)"""
EDGE = """V.q.j = R.f inv.q ({e}) Ri.f
D.q.j = R.f inv.q ({x} - ({e}) Y.q) back.f"""
JET = """d.{s}.q.j = [D.q.j {side}; O(2 {m}, {w})]
v.{s}.q.j = [-V.q.j D.q.j {side}; O(2 {m}, {w})]
jet.{s}.q.j = [{s}.q, d.{s}.q.j, v.{s}.q.j; 0, {s}.q, d.{s}.q.j; 0, 0, {s}.q]"""
SPANS = """wide.b = T.{T1} - T.{T0}
far.b = late.{l1} - late.{l0}
t1.b = (late.{l0} + late.{l1})/2
t2.b = (T.{T0} + T.{T1})/2 - t1.b
h1.b = exp(t1.b one.q)
h2.b = exp(t2.b two.q)"""
LEFT = """half.b = wide.b/2 + far.b
span.b = t1.b + {sign}t2.b
nu1.b{b} = half.b g.q + span.b nu1.q
nu2.b{b} = half.b nu1.q + span.b nu2.q
nu.b{b} = half.b g.q + (half.b + span.b) nu.q
small.b: 4 - nu.b{b} > 0
left.b = nu.b{b}^3/(6 - 3 nu.b{b}/2) + nu.b{b} - nu1.b{b} - nu2.b{b} \
+ (nu.b{b}^2 - nu1.b{b}^2)/2
rho.b = 2 size.f norm(exp({growth} span.b I(1))) left.b
W.b = ({sizes} + rho.b width.f) ({squares} + rho.b/width.f in.f' in.f)"""
LOOP = """gen.f.c.at = R.f near(inv(e.c)) x.c back.f
one.f.c.at = [gen.f.c.at first; O(2 {m}, {w})]
two.f.c.at = [gen.f.c.at second; O(2 {m}, {w})]"""
TICK = "F.f.c.{T}.{l} = top.f exp((T.{T} - late.{l}) two.f.c.at) " \
    "exp(late.{l} one.f.c.at) in.f + rest.f"  # fmt: skip
FALLS = {  # with P and without, with a D and without
    (False, False): "rate^2 - {F}' {F} > 0",
    (False, True): "rate^2 - (1 + share.b) {F}' {F} - (1 + 1/share.b) W.b > 0",
    (True, False): "[rate^2 {P}, ({G} {F})'; ., he({G}) - {P}] > 0",
    (True, True): "[rate^2 {P} - share.b W.b, ({G} {F})'; "
                  "., he({G}) - {P} - 1/share.b {G} {G}'] > 0",
}  # fmt: skip


class Sampled:
    """The blocks of all cells, and of all boxes of clocks in each.

    ``frames`` have L, the coordinates of the loop in which P is given, and R and scale,
    those of the plant and its inputs, which may be any: see `sosbook.sampled.frames`.
    """

    def __init__(self, d):
        """Write the loop, each frame of P, and the blocks of each cell."""
        loop = self.loop = Ticks(d)
        t, self.t, self.d = loop.t, loop.t, d
        for name in ("rate", "centre"):
            t.put_number(name, d, name)
        rate, centre = number(d["rate"]), abs(number(d["centre"]))
        need(
            0 < rate and centre + rate <= 1,
            "rate and centre: the disk lies in the unit disk",
        )
        need(not (centre and loop.varies), "a disk is of one clock")
        self.sizes = dict(N=loop.N, m=loop.m, n=loop.n, w=loop.N + 2 * loop.m)
        self.done, self.cells, self.boxes = {}, 0, 0
        for f, frame in enumerate(d["frames"]):
            self._frame(f, frame)
        self._cells(loop.corners, d["cells"])
        self.claims = said(d, loop.many)

    def _write(self, lines, **names):
        """Write lines with the parts .q, .f and so on of names replaced."""
        parts = "|".join(names)
        lines = lines.format(**self.sizes) if "{" in lines else lines
        self.t.write(*re.sub(rf"\.({parts})\b", lambda m: f".{names[m[1]]}", lines)
                     .split("\n"))  # fmt: skip

    def _once(self, lines, **names):
        """Write lines unless they have been written."""
        key = lines, tuple(names.items())
        if key not in self.done:
            self.done[key] = True
            self._write(lines, **names)

    def _frame(self, f, frame):
        """Coordinates; those of w and z stay as they are."""
        t = self.t
        keys(frame, "L R scale")
        t.put(f"L.f{f}", frame, "L", [self.loop.n] * 2)
        t.put(f"R.f{f}", frame, "R", [self.loop.N] * 2)
        t.put_number(f"scale.f{f}", frame, "scale")
        self._weigh(f"L.f{f}")
        self._write(FRAME, f=f"f{f}")

    def _weigh(self, x):
        """The channel of a norm has the weight one, beside all else."""
        if self.loop.k:
            self.t.write(f"weigh.{x}: {x} w == w", f"weighs.{x}: w' {x} == w'")

    def _cells(self, corners, node):
        """The leaves of a tree of halves, which leave out no plant."""
        if "halve" not in node:
            self._leaf(corners, node)
            return
        keys(node, "halve halves")
        first, second, cut = list(corners), list(corners), node["halve"]
        if self.loop.axes:
            good = isinstance(cut, int) and 0 <= cut < self.loop.axes
            need(good, "there is no such axis")
            step = 1 << self.loop.axes - 1 - cut
            pairs = [(k | step, k) for k in range(len(corners)) if not k & step]
        else:
            good = isinstance(cut, list) and len({*cut}) == 2
            good = good and all(0 <= k < len(corners) for k in cut)
            need(good, "there is no such edge")
            pairs = [cut]
        for i, j in pairs:
            first[i] = second[j] = self._mean(corners[i], corners[j])
        one, other = node["halves"]
        self._cells(first, one)
        self._cells(second, other)

    def _mean(self, a, b):
        """The name of the plant halfway between two."""
        key = "mean", frozenset((a, b))
        if key not in self.done:
            k = self.done[key] = f"m{len(self.t.lines)}"
            self.t.write(*(f"{y}.{k} = ({y}.{a} + {y}.{b})/2" for y in "ex"))
        return self.done[key]

    def _leaf(self, corners, node):
        """A cell's middle, how far its plants are from it, and its boxes of clocks."""
        t, n, f = self.t, len(corners), node["frame"]
        keys(node, "frame growth times" + " P" * ("P" in node))
        need(0 <= f < len(self.d["frames"]), "there is no such frame")
        self.cells += 1
        at = dict(q=f"q{self.cells}", f=f"f{f}")
        q = at["q"]
        t.put_number(f"limit.{q}", node, "growth")
        P = []
        if "P" in node:
            need(len(node["P"]) == n, "there is a P for each corner")
            P = [f"P.{q}.{k}" for k in range(n)]
            for k, name in enumerate(P):
                t.put(name, node["P"], k, [self.loop.n] * 2)
                t.write(f"even.{name}: {name} == {name}'")
                self._weigh(name)
            t.write(f"P.{q} = ({' + '.join(P)})/{n}")
        t.write(*(f"{y}.{q} = ({' + '.join(f'{y}.{c}' for c in corners)})/{n}"
                  for y in "ex"))  # fmt: skip
        self._write(MIDDLE, **at)
        edges = []
        if n > 1:
            edges = (self._box_around if self.loop.axes else self._around)(corners, at)
            t.write(f"regular.{q}: 1 - z.{q} > 0")
        else:
            t.write(*(f"{x}.{q} = 0" for x in ("nu", "nu1", "nu2")))
        for j, (e, x) in enumerate(edges):
            self._write(EDGE.replace("{e}", e).replace("{x}", x), j=f"j{j}", **at)
        boxes = [(self.loop.T, self.loop.late, node["times"])]
        while boxes:
            T, late, times = boxes.pop()
            if self.loop.varies and late[0] >= T[1]:  # no delay is within an interval
                continue
            if "halve" not in times:
                self._times(corners, P, len(edges), T, late, times, at)
                continue
            keys(times, "halve halves")
            which, (a, b) = times["halve"], times["halves"]
            need(which in ("T", "delay"), "clocks are halved by T or delay")
            ends = self._halves(*("T", T) if which == "T" else ("late", late))
            boxes += [(e, late, x) if which == "T" else (T, e, x)
                      for e, x in zip(ends, (a, b))]  # fmt: skip

    def _halves(self, kind, ends):
        """The two halves of a range, and the name of its middle in the text."""
        low, high = ends
        mid = (low + high) / 2
        if (kind, mid) not in self.loop.times:
            k = self.loop.times[kind, mid] = f"h{len(self.loop.times)}"
            a, b = (self.loop.times[kind, x] for x in ends)
            self.t.write(f"{kind}.{k} = ({kind}.{a} + {kind}.{b})/2")
        return (low, mid), (mid, high)

    def _around(self, corners, at):
        """Of means of the corners: E and [A B] along each edge."""
        q, every = at["q"], range(len(corners))
        for k, c in enumerate(corners):
            parts = {y: f"({y}.{c} - {y}.{q})" for y in "ex"}
            self._away(parts, k, at)
        form = {x: ", ".join(f"{x}.{q}.k{k}" for k in every) for x in ("z", "nu")}
        self._write(SIMPLEX.format(**form), **at)
        return [tuple(f"{y}.{corners[b]} - {y}.{corners[a]}" for y in "ex")
                for a, b in combinations(every, 2)]  # fmt: skip

    def _box_around(self, corners, at):
        """The same of a box: its terms are products of some of the axes."""
        q, n = at["q"], len(corners)
        for k in range(1, n):
            for y in "ex":
                signed = "".join(f" {'+-'[(k & ~i).bit_count() % 2]} {y}.{c}"
                                 for i, c in enumerate(corners))  # fmt: skip
                signed = signed.removeprefix(" +").strip()
                self.t.write(f"{y}.{q}.b{k} = ({signed})/{n}")
            self._away({y: f"{y}.{q}.b{k}" for y in "ex"}, k, at)

        def total(x, *orders):
            some = [k for k in range(1, n) if not orders or k.bit_count() in orders]
            return " + ".join(f"{x}.{q}.k{k}" for k in some)

        form = dict(z=total("z"), z1=total("z", 1), nu1=total("nu", 1))
        self._write(BOX.format(**form, nu2=total("nu", 2), nu=total("nu")), **at)
        axes = (1 << self.loop.axes - 1 - a for a in range(self.loop.axes))
        return [tuple(f"2 {y}.{q}.b{k}" for y in "ex") for k in axes]

    def _away(self, parts, k, at):
        lines = AWAY.replace("{e}", parts["e"]).replace("{x}", parts["x"])
        self._write(lines, k=f"k{k}", **at)

    def _times(self, corners, P, edges, T, late, times, at):
        """The blocks of one box of clocks, at all corners of plants and clocks."""
        self.boxes += 1
        t, b = self.t, self.boxes
        at = at | dict(b=b)
        bends = edges or T[0] < T[1] or late[0] < late[1]
        own = ["share"] * bool(bends) + ["G"] * ("G" in times)
        keys(times, " ".join(own), " of times")
        need(P or "G" not in times, "G needs P")
        backward = sum(T) < sum(late)  # at the middle the delay is the longer one
        T = [self.loop.times["T", x] for x in T]
        late = [self.loop.times["late", x] for x in late]
        if bends:
            t.put_number(f"share.{b}", times, "share")
            t.write(f"sign.share.{b}: share.{b} > 0")
            self._bends(edges, T, late, backward, at)
        G = f"P.{at['q']}"
        if "G" in times:
            G = f"G.{b}"
            t.put(G, times, "G", [self.loop.n] * 2)
        line = FALLS[bool(P), bool(bends)]
        places = product(dict.fromkeys(T), dict.fromkeys(late), enumerate(corners))
        for place, (x, y, (k, c)) in enumerate(places):
            self._once(LOOP, f=at["f"], c=c)
            self._once(TICK.format(T=x, l=y), f=at["f"], c=c)
            form = dict(F=f"F.{at['f']}.{c}.{x}.{y}", G=G, P=P[k] if P else "")
            label = f"tick.{b}.{place}"
            t.labels[self._name(corners, place)] = label
            self._write(f"{label}: " + line.format(**form), b=b)

    def _name(self, corners, place):
        """The name of a block beside a proof."""
        cell = f"cell {self.cells}" if self.loop.many > 1 else "plant"
        clock = f", clocks {self.boxes}" if self.loop.varies else ""
        several = len(corners) > 1 or self.loop.varies
        return cell + clock + f", corner {place + 1}" * several

    def _bends(self, edges, T, late, backward, at):
        """W of a box: above D'D for each plant of the cell at each of its clocks."""
        b, q = at["b"], at["q"]
        (T0, T1), (l0, l1) = T, late
        self._write(SPANS.format(T0=T0, T1=T1, l0=l0, l1=l1), **at)
        bends = []
        if T0 != T1:
            bends.append("(wide.b^2/2) two.q two.q h2.b h1.b")
        if l0 != l1:
            turn = "(one.q - two.q) one.q - two.q (one.q - two.q)"
            bends.append(f"(far.b^2/2) h2.b ({turn}) h1.b")
        w = self.sizes["w"]
        for j in range(edges):
            both = []
            for span, s, side in (("t2", "two", "second"), ("t1", "one", "first")):
                jet = JET.replace("{s}", s).replace("{side}", side)
                self._once(jet, j=f"j{j}", q=q)
                both.append(f"exp({span}.b jet.{s}.{q}.j{j})")
            bends.append(f"pick(1, 3, {w}) {' '.join(both)} pick(3, 3, {w})'")
        for j, text in enumerate(bends):
            self._write(f"H.b.j = top.f {text} in.f\nn.b.j = norm(H.b.j)/4", j=j, **at)
        every = range(len(bends))
        sizes = " + ".join(f"n.{b}.{j}" for j in every)
        squares = " + ".join(f"1/(16 n.{b}.{j}) H.{b}.{j}' H.{b}.{j}" for j in every)
        growth = f"g.{q}" if backward else f"limit.{q}"
        form = dict(b=b, sign="-" * backward, growth=growth, sizes=sizes)
        self._write(LEFT.format(**form, squares=squares), **at)
