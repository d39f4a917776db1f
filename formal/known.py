"""What Rocq reads of a proof of a known gain, by Theorem A: see multipliers.v.

The poles of each plant that is a mean of the vertices lie in the regions: multipliers
F and G of a cell, and P at each of its corners, show it. A proof of a norm or of a
cost has them, too, and so shows that the loop is stable.
"""

from fractions import Fraction
from itertools import count
from math import lcm

from formal.common import (
    Failed,
    Refused,
    constant,
    denominator,
    integers,
    literal,
    plus,
    product,
    ratio,
    times,
    transposed,
    triple,
    witness,
    zeros,
)
from formal.loops import Loop, WithLaw, exact, four

STABLE = {"name": "stability", "form": "half-plane", "sigma": "0",
          "alpha": [["0"]], "beta": [["1"]]}  # fmt: skip


class Known:
    """A known gain: its loop, its regions, and the cells of each."""

    theory = " multipliers"

    def __init__(self, file):
        plant, self.file = file["plant"], file
        box = file["corners"]
        if "dt" in plant:
            raise Refused("a known gain in a plant of ticks")
        if box and any(cuts != [None] for *_, cuts in file["cells"]):
            raise Refused("vertices that are a box and are cut as one")
        self.loop = (Loop if file["law"] is None else WithLaw)(file)
        vertices = plant["vertices"]
        self.who = [i for i, v in enumerate(vertices) if v not in vertices[:i]]
        self.who = [i - 1 for i in box] if box else self.who
        asked = {r["name"]: r for r in file["requirements"] if r["kind"] == "region"}
        asked["stability"] = STABLE
        parts = [(asked[name], q) for q, (kind, name, _) in enumerate(file["cells"])
                 if kind in ("region", "stability")] or [(STABLE, 0)]  # fmt: skip
        self.regions, self.parts = zip(*parts)
        if any(r["form"] != "disk" and is_disk(r) for r in self.regions):
            raise Refused("a disk of another name")

    def text(self):
        return []

    def shown(self, number, pencils, c, sound):
        """Of a region label, vertices, a definition, the rule, and the last words."""
        q, r = self.parts[number], self.regions[number]
        cells = Cells(self.file, q, r, c)
        tree = cells.text([(1, pencils[i]) for i in self.who])
        place = cells.place.format(number)
        text = constant(f"t_{number}", "cells", tree)
        rule = f"cells_sound _ {cells.k - 1} {place} {cells.g} t_{number}"
        if is_disk(r):
            sound = sound.replace(" disk_sound", " of_disk_sound")
        else:
            sound = " /square_sound" + sound
        yield f"{number}", self.who, text, rule, sound


def is_disk(r):
    """True if the checker takes a region for a disk, and k = 1."""
    alpha, beta = r["alpha"], r["beta"]
    return beta == [["0", "1"], ["0", "0"]] and alpha[0][0] == alpha[1][1]


class Cells:
    """The cells of one region: its W, and P and [F; G] in integers."""

    def __init__(self, file, q, r, c):
        """Of the cells q of a file, for the region r; c times the loops are whole."""
        self.unknowns, self.cuts = file["unknowns"], iter(file["cells"][q][2])
        self.here, self.c, self.over = (f"{q + 1}.{i}" for i in count(1)), c, 1
        if is_disk(r):  # the checker divides by rho
            rho, hub = Fraction(r["rho"]), Fraction(r["centre"])
            self.k, self.over = 1, rho
            W = [[hub * hub - rho * rho, -hub], [-hub, 1]]
            self.place = f"(of_disk {ratio(rho)} {ratio(hub)})"
        else:
            alpha, beta = (exact(r[x]) for x in ("alpha", "beta"))
            self.k = k = len(alpha)
            W = four(alpha, beta, transposed(beta), zeros(k, k))
            self.place = f"(square {k} alpha_{{0}} beta_{{0}} [::])"
        self.g, self.W = integers(W)

    def text(self, corners):
        """A tree of cells; a corner is a number t and t c times the loop's pencil."""
        way = next(self.cuts)
        if way is None:
            return self.cell(corners)
        (t, p), (u, q) = (corners[i] for i in way)
        x, y = lcm(t, u) // t, lcm(t, u) // u
        new = 2 * t * x, [plus(times(x, a), times(y, b)) for a, b in zip(p, q)]
        words = "(Cut {}%nat {}%nat {} {}".format(*way, x, y)
        for place in way:
            half = [new if a == place else old for a, old in enumerate(corners)]
            words += "\n" + self.text(half)
        return words + ")"

    def cell(self, corners):
        here, rows = next(self.here), []
        FG = self.unknowns[f"F.{here}"] + self.unknowns[f"G.{here}"]
        several = [exact(self.unknowns[f"P.{here}.{j + 1}"])
                   for j, _ in enumerate(corners)]  # fmt: skip
        d = denominator(FG, *several) * self.over.numerator
        FG = times(d * self.g, FG)
        for P, (t, pencil) in zip(several, corners):
            P = times(d * self.c * t / self.over, P)
            shown = witness(P), witness(multiplied(self.k, self.W, P, FG, *pencil))
            if not all(shown):
                raise Failed("nothing shows that a cell's matrix is positive definite")
            rows.append(f"({literal(P)}, {triple(shown[0])},\n {triple(shown[1])})")
        return f"(Cell {literal(FG)}\n [:: " + ";\n ".join(rows) + "])"


def multiplied(k, W, P, FG, E, A):
    """`multiplied` of multipliers.v."""
    N = len(P)
    R = [[A[r][j] if b == a else -E[r][j] if b == k + a else 0
          for b in range(2 * k) for j in range(N)]
         for a in range(k) for r in range(N)]  # fmt: skip
    L = product(FG, R)
    return [[-(W[i // N][j // N] * P[i % N][j % N] + L[i][j] + L[j][i])
             for j in range(2 * k * N)] for i in range(2 * k * N)]  # fmt: skip
