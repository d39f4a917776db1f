"""Observers, and that none is proven."""

from .arithmetic import need
from .families import keys
from .plants import plant
from .text import Text

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
        """Write the text: the blocks of [T Theorem 2.5] in the file's coordinates."""
        t = self.t = Text(d)
        c, model = d["coordinates"], d["model"]
        vertices, N, m, _ = plant(t, dict(d, U=[], K_A=None))
        keys(c, "T left unit")
        keys(model, "E A Bu")
        q = len(d["C"])
        for name, holder, key, *size in (
            ("T1", c["T"], 0, N, N), ("T2", c["T"], 1, N, N), ("left", c, "left", N, N),
            ("E0", model, "E", N, N), ("A0", model, "A", N, N), ("K", d, "K", m, N),
            ("B0", model, "Bu", N, m), ("C_", d, "C", q, N), ("R_F", d, "R_F", q, q),
            ("Q_F", d, "Q_F", 2 * N, None),
        ):  # fmt: skip
            t.put(name, holder, key, size)
        t.put_number("unit", c, "unit")
        need(len(d["noises"]) == len(vertices), "a vertex without noise")
        for i, _ in enumerate(vertices):
            t.put(f"noise.{i + 1}", d["noises"], i, (N, None))
        p = len(d["noises"][0][0])
        for name, shape in (("P1", N), ("P2", N), ("J", p)):
            t.point(name, name, f"symmetric {shape}")
        t.write(
            f"N = {N}", "sign.unit: unit > 0", "left.regular: inv(left) left == I(N)"
        )
        t.write("T = [T1, 0; 0, T2]", "back = inv(T)'", "T1C = C_ inv(T1)'")
        t.write("Q = T' Q_F", "P = [P1, 0; 0, P2]", "P1: P1 > 0", "P2: P2 > 0")
        named = ["P1", "P2", *["trace"] * ("L" in d)]
        if "L" in d:
            t.put("L", d, "L", (N, q))
            t.put_number("bound", d, "bound")
            t.write("Y = L' T1 P1", "sign.bound: bound > 0",
                    "trace: bound/unit^2 - tr(J) > 0")  # fmt: skip
            self.claims = ["at each vertex (not between them) the loop with the "
                           "observer is stable",
                           f"tr J is at most {d['bound']} there"]  # fmt: skip
        else:
            t.point("Y", "Y", f"{q} x {N}")
            self.claims = ["no observer with this K that follows the file's model is "
                           "proven by these LMIs at the vertices"]  # fmt: skip
        t.labels = {x: x for x in named}
        for i in range(1, len(vertices) + 1):
            for x in ("decay", "cost"):
                t.labels[f"{x} {i}"] = f"{x}.{i}"
        t.write(*OBSERVER.split("\n"), loop="i in vertices")
