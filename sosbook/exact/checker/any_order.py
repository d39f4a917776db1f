"""Limits of every controller with some sensors: by motions, or the mean of poles."""

from fractions import Fraction
from math import floor, log10

from .arithmetic import definite, need
from .families import keys, vertex_words
from .laws import joined, put_law
from .outputs import at_vertex, ends
from .plants import plant, vertex_of
from .regions import STABLE, region
from .text import Text, mat, ratio

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
        """Write the text: each side's motions, and the two corners together."""
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
        t.put("T", units, "T", (N, N))
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
        wide, size = len(motions["push"][0]), len(motions["here"])
        for part in motions:
            k = size if part == "V" else wide
            t.put(f"{part}.{x}", motions, part, (None, k), ratio)
        if size:
            t.point(x, x, f"symmetric {size}")
        flow = f" - he(here.{x}' {x} rate.{x})" * bool(size)
        form = MOTIONS if size else "\n".join(MOTIONS.split("\n")[1:])
        parts = dict(zip("ABCDEF", letters.split()), x=x, name=name, flow=flow)
        t.write(*form.format(**parts).split("\n"))
        t.labels[key] = name
        return size > 0


class SumOfPoles:
    """The sum of the poles, tr E^-1 (A + B K C_y), is moved by no K of a law.

    K is a sum of the file's gains. Where these aren't all matrices, the words say how
    many numbers are free: another K of the same law may move the sum.

    Their mean isn't in the half-plane that is asked, or in the left one: nor are all.
    """

    def __init__(self, d):
        """Write the text: no gain moves the mean of the poles, and it is too large."""
        t = self.t = Text(d)
        vertices, *size, _ = plant(t, d)
        need(d["U"] == [] and d["gains"], "a law has gains, and no U")
        k, asked = vertex_of(t, d["vertex"]), d["requirement"]
        f = len(d["gains"][0]) - size[1]
        N, _ = joined(t, d["law"], size, f"{{}}.{k}", f)
        words, reach = STABLE, "mean"
        if asked is not None:
            half = asked["kind"] == "region" and asked["form"] == "half-plane"
            need(half, "a half-plane is needed")
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
        K = mat(rows, free, shape[0] * shape[1], ratio, "gains")
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
