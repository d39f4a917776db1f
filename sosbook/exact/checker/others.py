"""Texts and words of the rest: masses, observers, any controller, LMIs of one's own."""

import re

from .arithmetic import need
from .families import decimal, every_plant, keys, vertex_words
from .known import put_law
from .outputs import at_vertex, ends
from .plants import distinct, plant, vertex_of
from .text import Text, positive, ratio, sane


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
        need([len(row) for row in d["R_F"]] == [q] * q, "R_F isn't square")
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


UNITS = """back = slow inv(T) inv(E.{k})
in.A = back A.{k} T
in.B = back Bu.{k}
in.W = of_w back Bw.{k}{S}
in.C = of_z {C} T
in.D = of_z {D}
in.Z = of_z of_w {Z}
in.Y = law.rows T
in.N = of_w law.noise{S}
level = of_z of_w gamma"""
MOTIONS = """independent.{x}: V.{x}' V.{x} > 0
different.{x}: here.{x}' here.{x} + push.{x}' push.{x} > 0
rate.{x}: {A} V.{x} here.{x} + {B} push.{x} == V.{x} rate.{x}
still.{x}: {C} V.{x} here.{x} + {D} push.{x} == O(rows({C}), cols(push.{x}))
out.{x} = {E} V.{x} here.{x} + {F} push.{x}
{name}: [level push.{x}' push.{x}{flow}, out.{x}'; ., level I(rows(out.{x}))] > 0"""
SIDES = {  # what isn't moved of the transposed plant, and what isn't seen
    "X": ("unmoved", "not moved", "in.A' in.C' in.B' in.D' in.W' in.Z'"),
    "Y": ("unseen", "not seen", "in.A in.W in.Y in.N in.C in.Z"),
}


class AnyOrder:
    """No controller of any order: motions that its sensors don't see or u doesn't move.

    Where y = 0 a controller at rest stays at rest, so the bounded real lemma of the
    loop is about the plant's corners X of L^-1 and Y of L alone, [X I; I Y] >= 0.
    """

    def __init__(self, d):
        t, r, units = Text(d), d["requirement"], d["units"]
        self.t = t
        vertices, N, m, p = sizes = plant(t, d)
        need(d["U"] == [] and "multipliers" in d, "multipliers exclude, and no U")
        need(r["kind"] == "gamma", "a bound of an H-infinity norm is needed")
        keys(r, " ".join(["kind name gamma mu", *({*r} & {"outputs", "inputs"})]))
        k = vertex_of(t, d["vertex"])
        put_law(t, d["law"])
        t.put_number("gamma", r, "gamma")
        keys(units, "slow of_w of_z T")
        t.put("T", units, "T", N)
        for name in ("slow", "of_w", "of_z"):
            t.put_number(name, units, name)
        t.write(*(f"sign.{x}: {x} > 0" for x in ("gamma", "slow", "of_w", "of_z")))
        C, D, Z, S, q = at_vertex(t, d, sizes, r, k)
        Z = f"{Z}{S}" if Z else f"O({q}, {len(r['inputs']) if S else p})"
        t.write(*UNITS.format(k=k, S=S, C=C, D=D or f"O({q}, {m})", Z=Z).split("\n"))
        need(d["sides"] and d["sides"].keys() <= SIDES.keys(), "there are two sides")
        known = [x for x in d["sides"] if self._side(x, d["sides"][x])]
        P = "[X, V.X' V.Y; ., Y]" if len(known) == 2 else "".join(known)
        if known:
            t.write(f"together: {P} > 0")
            t.labels["together"] = "together"
        where = vertex_words(d["plant"], k, len(vertices))
        self.claims = ["no linear controller of any order with these sensors makes "
                       f"{where} stable with an H-infinity norm{ends(r)} below "
                       f"{r['gamma']}"]  # fmt: skip

    def _side(self, x, motions):
        """The block of one side; whether it has an unknown."""
        t, (name, key, letters) = self.t, SIDES[x]
        keys(motions, "V here rate push")
        wide = len(motions["push"][0])
        for part in motions:
            t.put(f"{part}.{x}", motions, part, wide, ratio)
        size = len(motions["here"])
        if size:
            t.point(x, x, f"symmetric {size}")
        flow = f" - he(here.{x}' {x} rate.{x})" * bool(size)
        form = MOTIONS if size else "\n".join(MOTIONS.split("\n")[1:])
        parts = dict(zip("ABCDEF", letters.split()), x=x, name=name, flow=flow)
        t.write(*form.format(**parts).split("\n"))
        t.labels[key] = name
        return size > 0


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
