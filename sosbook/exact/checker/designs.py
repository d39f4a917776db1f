"""Designs, with pairs of vertices or a slack matrix."""

import re
from fractions import Fraction

from . import payment
from .arithmetic import Beyond, need, read
from .families import CHANGING, CONSTANT, every_plant, keys, ticks, under
from .language import Reader, parse
from .plants import OUTPUTS, coordinates, corners_suffice, distinct, plant, suffice
from .requirements import (
    BLOCKS,
    SIZED,
    key_of,
    numbers_of,
    own,
    size_name,
    size_of,
    stated,
    tag,
)
from .text import Text, positive

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


class Design:
    """Blocks of P; a requirement of size s has them of P / s, all multiplied by s."""

    def __init__(self, d):
        """Write the text: P, the gain, the blocks of each requirement and pair."""
        self.d, self.t, self.asked = d, Text(d), d["requirements"]
        self.refuted, self.ids, t = "multipliers" in d, {}, self.t
        self.vertices, self.N, self.m, self.p = plant(t, d, ticks=True)
        self.plain, self.integrals = self.N, len(d["U"])
        self.many, self.few = len(self.vertices), distinct(self.vertices)
        need(d["coupling"] in ("pairs", "vertices", "slack"), "unknown coupling")
        self.slack, self.ticks = d["coupling"] == "slack", "dt" in d["plant"]
        self.far = self._far() if "box" in d else None
        none = d["epsilon"] is None, d["E0"] is None
        need(none == (not self.slack,) * 2, "epsilon and E0 belong to a slack matrix")
        self._pairs()
        for r in self.asked:
            if r["kind"] not in ("region", *SIZED) and "theorem" not in r:
                raise Beyond(f"the theorem of a {r['kind']!r} isn't known here")
            if r["kind"] not in BLOCKS and self.refuted:
                raise Beyond("a refusal by an author's theorem isn't a text")
        scope = CONSTANT if self.slack else CHANGING
        where = every_plant(d["plant"], self.many, scope)
        if not self.whole:
            where = f"each of the {self.many} vertices (not the plants between)"
        where += under(d["plant"]) if self.m else ""
        self.claims, demands = stated(f"{where} is stable{ticks(d['plant'])}", d)
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
        plant(given, {k: x for k, x in self.d.items() if k != "box"}, ticks=True)
        env, near, several = given.values(), self.t.values(), []
        rows = OUTPUTS.values() if self.d["plant"]["kind"] == "descriptor" else "C"
        for name in (x for x in env.keys() | near if x.split(".")[0] in rows):
            need(env.get(name) == near.get(name), "the box has another output")
        if self.refuted:  # nothing pays: what is refused are the vertices themselves
            good = payment.close(given.vertices, self.vertices)
            need(good, "the box is far from the vertices")
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
        values = {k: read(x) for k, x in (t.data | t.found).items()}
        reader, program = Reader(values, sets=t.sets), parse("\n".join(t.lines))
        forms = set()
        for form, label, price in payment.prices(reader, known, program):
            forms.add(form)
            t.data[f"pay.{label}"] = price
        for k, line in enumerate(t.lines):
            form = line.strip().partition(":")[0]
            if form in forms:
                t.lines[k] = line.removesuffix(" > 0") + f" - pay.{form} > 0"

    def _pairs(self):
        """The pairs of vertices that have blocks, and whether they are enough."""
        env = self.t.values() if len(self.few) > 1 else {}
        E = {i: env[f"E.{i + 1}"] for i in self.few if env}
        first = {}  # the first vertex with the same E
        kind = {i: first.setdefault(x.shortest, i) for i, x in E.items()}
        between = [(i, j) for i in E for j in E if i < j and kind[i] != kind[j]]
        first_one, *others = self.t.vertices
        alike = all(v.get(x) == first_one.get(x) for v in others for x in OUTPUTS)
        if between and alike:
            points = {i: self._point(env, i) for i in E}
            ranges = self.d["plant"].get("parameters", ())
            several = len(self.t.vertices)  # of no powers above one as many as corners
            corners = ranges and 2 ** len(ranges) == several == len(E)
            known = list(E.values()), list(points.values())
            if suffice(*known) or (corners and corners_suffice(*known)):
                between = []
        need(not between or self.far is None, "the box doesn't speak for its inside")
        self.certain = len(first) < 2
        self.whole = not between or self.d["coupling"] != "vertices"
        pairs = [(i, i) for i in self.few]
        pairs += between if self.d["coupling"] == "pairs" else []
        if self.refuted:  # those without a multiplier add nothing
            named = [tuple(k[3:] * 2)[:2] for k, _ in self.d["multipliers"]]
            pairs = [p for p in pairs if p in set(named)]
        self.pairs = pairs

    def _point(self, env, i):
        """The entries of [E A B W] of a vertex, by columns."""
        whole = [env[f"{x}.{i + 1}"].T for x in ("E", "A", "Bu", "Bw")]
        return tuple(Fraction(e, x.d) for x in whole for u in x.a for e in u)

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
        self.where = "" if self.far is None else payment.AT_CORNERS
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
            t.put("E0", d, "E0", (self.N, self.N))
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
                numbers_of(t, self.asked, k, r, self.ticks)
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
            self.t.put("K", self.d, "K", (self.m, self.N))
            T, over = ("T ", "/scale") if coordinates else ("", "")
            P = "V'" if self.slack else "P"
            self.t.write(f"Y = K {T}{P}{over}")
        if coordinates:
            self.t.write("Yx = scale Y T'")

    def _coordinates(self, c):
        """x = T xi, u = scale v, and rows times ``left``; lengths of sizes."""
        t = self.t
        coordinates(t, c, self.N)
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
