"""A gain that is known: a Lyapunov matrix at each vertex, free multipliers, cells."""

import re
from itertools import product, takewhile

from .arithmetic import Beyond, need
from .families import CONSTANT, every_plant, keys, ranges, ticks, under
from .laws import put_law
from .outputs import Channel
from .plants import distinct, plant
from .requirements import (
    BLOCKS,
    INSIDE,
    is_disk,
    numbers_of,
    per_tick,
    start,
    stated,
    tag,
    weights,
)
from .text import Text

PARTS = "EL", "AL", "BL"  # of the loop E x' = A x + B w
MEAN = "{0}.k = ({0}.a + {0}.b)/2"
SIDE = "box.{0}.a.b: {0}.a - {0}.b == {0}.c - {0}.d"
# Of the cell c: the vertex i has the place j in it.
POLES = """-[kron({a}, P.c.j) + he(F.c {A}), \
kron({b}, P.c.j) - F.c {E} + {A}' G.c'; ., {d}-he(G.c {E})] > 0"""
NORM = """-[he(F.c AL.i), P.c.j - F.c EL.i + AL.i' G.c', F.c BL.i{S}, mu.c Cy.i'; \
., {d}-he(G.c EL.i), G.c BL.i{S}, {H}; ., ., -mu.c, {Z}; \
., ., ., -mu.c gamma{k}^2] > 0"""
PEAK = "u_max{k}.c.j: [P.c.j, mu.c {K}'; ., mu.c u_max{k}^2] > 0"
DECAY = """-[he(F.c AL.i) + mu.c {w}, P.c.j - F.c EL.i + AL.i' G.c'; \
., {d}-he(G.c EL.i)] > 0"""
NOISE = "[J.c, (H.c BL.i{S})'; ., he(H.c EL.i) - P.c.j] > 0"


PLAIN = "EL.i = E.i", "AL.i = A.i + Bu.i K", "BL.i = Bw.i"
# with a law's own states: y = of_sensors (rows x + noise w) + of_states x_c
LAW = """EL.i = [E.i, 0; 0, law.E]
push.i = [Bu.i, O({N}, {f}); O({c}, {m}), entry] K
AL.i = [A.i, O({N}, {c}); law.B law.rows, law.A] + push.i y
BL.i = [Bw.i; law.B law.noise] + push.i noise"""


class Known:
    """Free multipliers for u = K x, or for a law that sets u and x_c' by K y.

    In a block the loop is affine: what holds at a cell's corners holds in their hull. A
    cell is cut into two whose corners are means of its own: in the middle of an edge of
    a simplex, or of a parameter's range, where de Casteljau's means are Bernstein's
    coefficients on both halves. So no plant is lost, wherever cells were cut.
    """

    def __init__(self, d):
        """Write the text: cells of plants, and each requirement's blocks in them."""
        t, whole = Text(d), d["plant"]
        self.t, self.d, self.means, self.quiet = t, d, {}, ""
        if "parameters" in whole:  # their ranges are cut below
            whole = dict(whole, parameters=[x[:3] for x in whole["parameters"]])
        vertices, self.N, self.m, self.p = plant(t, dict(d, plant=whole), True)
        self.plain, self.integrals = self.N, len(d["U"])
        self.ticks = "dt" in whole
        self.rise = "dt P.c.j " * self.ticks  # by the square of the change
        self.slack = True  # rows on x' stay rows on x'
        self.vertices, self.few = vertices, distinct(vertices)
        self.pairs = [(0, 1)] if len(self.few) > 1 else []
        self.many, law = len(vertices), d["law"] is not None
        size = (None, len(d["law"]["signals"])) if law else (self.m, self.N)
        t.put("K", d, "K", size)
        if law:
            self._law(d["law"], self.m)
        else:
            t.write("Ku = K")
            t.write(*PLAIN, loop="i in vertices")
        stable = every_plant(d["plant"], self.many, CONSTANT)
        free = len(d["K"]) - self.m
        stable += (
            under(whole, d["law"], free) * bool(self.m) + " is stable" + ticks(whole)
        )
        signal = "u" if law else "K x"
        if any(r["kind"] not in BLOCKS for r in d["requirements"]):
            raise Beyond("an author's theorem with multipliers isn't a text")
        self.claims, asked = stated(stable, d, signal)
        self.ids = {id(r): k for k, r in enumerate(d["requirements"], 1)}
        for k, r in enumerate(d["requirements"], 1):
            numbers_of(t, d["requirements"], k, r, self.ticks)
        root, parts = self._root(whole, [i + 1 for i in distinct(vertices)]), []
        for q, (kind, name, cuts) in enumerate(d["cells"], 1):
            need((kind, name) in asked, f"nothing is asked of {name!r:.40}, or twice")
            parts.append((q, asked.pop((kind, name)), self._cells(root, cuts)))
        need(not asked, "something that is asked has no cells")
        t.sets["means"] = [[str(k), *map(str, ab)] for ab, k in self.means.items()]
        t.write(*map(MEAN.format, PARTS), loop="k, a, b in means")
        for q, r, cells in parts:
            self._write(q, r, cells)

    def _law(self, law, m):
        """The loop with the states of a law, of which the last ones follow K, too."""
        t = self.t
        put_law(t, law)
        N, c, f = self.N, len(law["E"]), len(self.d["K"]) - m
        need(0 <= f <= c, "K has another number of rows")
        rows, none = [*zip(law["E"], law["A"])], ["0"] * c
        own = (rows[i] == ([*none[:i], "1", *none[i + 1 :]], none)
               for i in range(c - f))  # fmt: skip
        self.integrals = sum(takewhile(bool, own))  # of what is measured, the first
        t.write("y = [law.of_sensors law.rows, law.of_states]",
                "noise = law.of_sensors law.noise",
                f"Ku = [I({m}), O({m}, {f})] K y",
                f"entry = [O({c - f}, {f}); I({f})]")  # fmt: skip
        t.write(*LAW.format(N=N, c=c, f=f, m=m).split("\n"), loop="i in vertices")
        self.N += c
        t.write(f"uw = [I({m}), O({m}, {f})] K noise")  # what of w is in u at once
        self.quiet = f"uw == O({m}, {self.p})"

    def _root(self, whole, numbers):
        """The cell of all plants: its corners by their places."""
        box = self.d["corners"]
        self.simplex = "parameters" not in whole and box is None
        if self.simplex:
            return {(place,): i for place, i in enumerate(numbers)}
        if box is None:  # Bernstein's coefficients
            places = product(*(range(k + 1) for k in ranges(whole)[2]))
            return dict(zip(places, range(1, self.many + 1)))
        axes = len(box).bit_length() - 1
        good = "parameters" not in whole and sorted(box) == numbers
        need(good and len(box) == 2**axes, "the box isn't made of the vertices")
        root = dict(zip(product((0, 1), repeat=axes), box))
        sides = []  # each corner moves by what the last of its ones moves the first
        for place in (x for x in root if sum(x) > 1):
            k = max(k for k in range(axes) if place[k])
            alone = (0,) * k + (1,) + (0,) * (axes - k - 1)
            corners = place, moved(place, k, 0), alone, (0,) * axes
            sides.append([str(root[x]) for x in corners])
        self.t.sets["sides"] = sides
        self.t.write(*map(SIDE.format, PARTS), loop="a, b, c, d in sides")
        return root

    def _cells(self, root, cuts):
        """The corners of each cell; a cell that is cut stands before its halves."""
        waiting, cells = [root], []
        for way in cuts:
            need(waiting, "there are more cells than were cut")
            cell = waiting.pop()
            if way is None:
                cells.append([cell[place] for place in sorted(cell)])
            else:
                waiting += self._halves(cell, way)[::-1]
        need(not waiting, "a cell is missing")
        return cells

    def _halves(self, cell, way):
        """The two halves of a ``cell``, cut across an edge or an axis, ``way``."""
        if self.simplex:
            good = isinstance(way, list) and {(i,) for i in way} <= cell.keys()
            need(good and way[0] != way[1], "an edge has two ends")
            i, j = way
            middle = self._mean(cell[i,], cell[j,])
            return [cell | {(i,): middle}, cell | {(j,): middle}]
        axes = len(next(iter(cell)))
        need(type(way) is int and 0 <= way < axes, "there is no such axis")
        last = max(place[way] for place in cell)
        first, second = {}, {}
        for place in cell if last else ():
            if place[way] == 0:
                line = [cell[moved(place, way, i)] for i in range(last + 1)]
                for i in range(last + 1):
                    first[moved(place, way, i)] = line[0]
                    second[moved(place, way, last - i)] = line[-1]
                    line = list(map(self._mean, line, line[1:]))
        return [first, second]

    def _mean(self, a, b):
        """The number of the loop halfway between two."""
        new = self.many + len(self.means) + 1
        return self.means.setdefault((min(a, b), max(a, b)), new)

    def _write(self, q, r, cells):
        """The unknowns and lines of a requirement in all its cells."""
        t, kind, N, once, k = self.t, r["kind"], self.N, ["mu.c: mu.c > 0"], 1
        own, each = {"mu": "number"}, []
        if kind in ("region", "stability"):
            own, once, (k, each) = {}, [], self._poles(q, r)
        elif kind == "gamma":
            need(r["mu"] is None, "mu is an unknown")
            S, H, Z = self._channel(r, "mu")
            text = NORM.format(
                d=self.rise, S=S, H=H, Z=Z, k=tag(r, self.d["requirements"])
            )
            each = [f"hinf.c.j: {text}".replace("Cy.i", f"Cy.{self.ids[id(r)]}.i")]
        elif kind == "h2":  # (C x)' (C x) is convex in C, which may move
            S, *_ = self._channel(r, "", rates=False)
            C, h2 = f"Cy.{self.ids[id(r)]}.i", "h2" + tag(r, self.d["requirements"])
            own |= {"J": f"symmetric {len(r.get('inputs', range(self.p)))}",
                    "H": f"{N} x {N}"}  # fmt: skip
            level = f"mu.c {h2}^2{per_tick(self, False)}"
            once.append(f"trace.c: {level} - tr(J.c) > 0")
            each = ["decay.c.j: " + DECAY.format(w=f"{C}' {C}", d=self.rise),
                    "noise.c.j: " + NOISE.format(S=S)]  # fmt: skip
        elif kind == "input":
            need(not (r["acceleration"] and self.d["K_A"]), "K_A z'' isn't K x")
            kth = tag(r, self.d["requirements"])
            points, some = start(t, r, N, self.m, kth)
            decay = POLES.format(a="[0]", b="[1]", d="", A="AL.i", E="EL.i")
            each = [f"decay.c.j: {decay}"]
            for _, label, x0 in points:
                each.append(f"{label}.c.j: mu.c - {x0} P.c.j ({x0})' > 0")
            K = f"({some} Ku)" if some else "Ku"
            each.append(PEAK.format(K=K, k=kth))
        else:
            states = weights(t, r, self)
            if self.quiet and not states:  # white noise in u would cost too much
                t.write(f"quiet.cost: {self.quiet}")
            mixed = "N" in r
            t.write("weight = " + ("Q" if "Q" in r else "Cq' Cq") + " + Ku' R Ku"
                    + " + he(Nq Ku)" * mixed)  # fmt: skip
            if "Q" in r:  # what is weighed isn't negative, whatever x and u are
                t.write("weights: " + ("[Q, Nq; ., R]" if mixed else "Q") + " >= 0")
            each = ["lqr.c.j: " + DECAY.format(w="weight", d=self.rise)]
            level = f"mu.c bound{per_tick(self, states)}"
            trace = f"trace.c{{0}}: {level} - tr({{1}}.c{{0}}) > 0"
            if states:
                each.append(trace.format(".j", "P"))
            else:
                own |= {"J": f"symmetric {self.p}", "H": f"{N} x {N}"}
                once.append(trace.format("", "J"))
                each.append("cost.c.j: " + NOISE.format(S=""))
        own |= dict.fromkeys("FG", f"{k * N} x {k * N}")
        names, corners = [[str(c)] for c, _ in enumerate(cells, 1)], []
        for (c,), cell in zip(names, cells):
            for name, shape in own.items():
                name = f"{name}.{q}.{c}"
                t.point(name, name, shape)
            for j, i in enumerate(cell, 1):
                corners.append([c, str(j), str(i)])
                t.point(f"P.{q}.{c}.{j}", f"P.{q}.{c}.{j}", f"symmetric {N}")
        t.sets |= {f"cells_{q}": names, f"corners_{q}": corners}
        once, each = ([re.sub(r"[.]c\b", f".{q}.c", x) for x in lines]
                      for lines in (once, ["P.c.j: P.c.j > 0", *each]))  # fmt: skip
        t.write(*once, loop=f"c in cells_{q}")
        t.write(*each, loop=f"c, j, i in corners_{q}")

    def _channel(self, r, more, rates=True):
        """S, H and Z of the outputs and disturbances of a norm, as its block has them.

        The lines of y = C x + H x' + Z w are written for all vertices and means.
        """
        own = [x for x in ("outputs", "inputs") if x in r]
        keys(r, " ".join(["kind name", r["kind"], more, *own]))
        need(self.p, "the plant has no disturbance")
        t, k, of_law = self.t, self.ids[id(r)], self.quiet and "outputs" in r
        channel = Channel(self, r, k, rates or of_law)
        C, H, D, Z = (channel.names[x] for x in "CHDZ")
        if self.quiet and D and not (rates or of_law):
            t.write(f"quiet.{k}: {self.quiet}")
        elif self.quiet and D:
            Z = f"{Z and Z + ' + '}{D} uw"
        if of_law and not rates:
            C, Z = self._solved(k, channel.S, C, H, Z)
        c = self.N - self.plain
        if c and not of_law:
            C, H = (x and f"[{x}, O(rows({x}), {c})]" for x in (C, H))
        Z = Z if rates else ""
        lines = {
            "Cy": C + f" + {D} Ku" * bool(D),
            "Hy": H,
            "Zy": Z and f"({Z}){channel.S}",
        }
        lines = {f"{x}.{k}": text for x, text in lines.items() if text}
        t.write(*(f"{x}.i = {text}" for x, text in lines.items()), loop="i in vertices")
        t.write(*map(MEAN.format, lines), loop="k, a, b in means")
        if "sides" in t.sets:
            t.write(*map(SIDE.format, lines), loop="a, b, c, d in sides")
        some = ((H, f"Hy.{k}"), (Z, f"Zy.{k}"))
        return channel.S, *(f"mu.c {x}.i'" if there else "0" for there, x in some)

    def _solved(self, k, S, C, H, Z):
        """Outputs of a law's loop whose x' is put in, and whose noise is none."""
        t, lines = self.t, []
        if H:
            x, w = (f" + {H} inv(EL.i) {of}.i" for of in ("AL", "BL"))
            C, Z = C + x, f"{Z}{w}" if Z else w[3:]
            lines.append(f"solved.{k}.i: {H} inv(EL.i) == {H} inv(EL.1)")
        if Z:
            lines.append(f"none.{k}.i: ({Z}){S} == 0 ({Z}){S}")
        t.write(*lines, loop="i in vertices")
        return C, Z

    def _poles(self, q, r):
        """The size of a region's matrices, and the block."""
        a, b, d, k, lines = "[0]", "[1]", "", 1, []
        E, A = "EL.i", "AL.i"
        if r["kind"] == "region" or r is INSIDE:
            name = self.ids.get(id(r), "stability")
            if r is INSIDE:
                inside = INSIDE | {"kind": "region"}
                numbers_of(self.t, [], name, inside, self.ticks)
            a, b = f"alpha.{name}", f"beta.{name}"
            k = len(r["alpha"])
            if is_disk(r):
                rho, hub = f"radius.{q}", f"hub.{q}"  # (|s - hub|^2 - rho^2)/rho < 0
                self.t.write(f"{rho} = -at({a}, 1, 1)", f"{hub} = -at({a}, 1, 2)")
                self.t.write(f"sign.{rho}: {rho} > 0")
                a, b = f"[{hub}^2/{rho} - {rho}]", f"[-{hub}/{rho}]"
                d, k = f"P.c.j/{rho} ", 1
        if k > 1:
            E, A = f"EE.{q}", f"AA.{q}"
            lines = [f"{E} = kron(I({k}), EL.i)", f"{A} = kron(I({k}), AL.i)"]
        text = POLES.format(a=a, b=b, d=d, A=A, E=E)
        return k, [*lines, f"poles.c.j: {text}"]


def moved(place, k, i):
    return (*place[:k], i, *place[k + 1 :])
