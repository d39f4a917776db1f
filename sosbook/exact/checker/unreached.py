"""A response that no gain, or not the given one, makes as small as is asked."""

from .families import keys, ticks, vertex_words
from .outputs import at_vertex, ends
from .plants import plant, vertex_of
from .text import Text, ratio


class UnreachedResponse:
    """v (s E - A) = y C and v B + y D = 0: y z = v W w at s, whatever u is.

    A stable loop has a bounded transfer matrix T in Re s >= 0, with y T = v W,
    so its norm is at least |v W| / |y|. Rows of v and y are real and imaginary parts.
    Where w is in the output, too, v W + y Z stands for v W.
    """

    def __init__(self, d):
        """Write the text: v and y, which no input reaches, at s."""
        t = self.t = Text(d)
        r, at = d.get("requirement", {}), (d, "bound")
        if r:  # with outputs or inputs of its own
            more = [x for x in ("outputs", "inputs") if x in r]
            keys(r, " ".join(["kind name gamma mu", *more]))
            at = r, "gamma"
        vertices, N, m, _ = sizes = plant(t, d, ticks=True)
        k = vertex_of(t, d["vertex"])
        t.put_number("gamma", *at)
        for name, rows in (("s", [1, 1]), ("v", [N] * 2), ("y", [None] * 2)):
            t.put(name, d, name, (2, rows[0]), ratio)
        A, (C, D, Z, S, _) = f"A.{k}", at_vertex(t, d, sizes, r, k)
        if d["K"] is not None:
            t.put("K", d, "K", (m, N))
            A, C = f"({A} + Bu.{k} K)", f"({C} + {D} K)" if D else C
        else:
            t.write(f"input: v Bu.{k}{D and ' + y ' + D} == O(2, {m})")
        t.write("sign.gamma: gamma > 0", "sign.s: at(s, 1, 1) >= 0")
        t.write("times = [at(s, 1, 1), -at(s, 2, 1); at(s, 2, 1), at(s, 1, 1)]")
        t.write(f"left: v {A} + y {C} == times v E.{k}")
        t.write(f"push = v Bw.{k}{S}" + (f" + y {Z}{S}" if Z else ""))
        t.write("reached = tr(push push')", "some: reached > 0")
        t.write("loud: reached - gamma^2 tr(y y') >= 0")
        where = vertex_words(d["plant"], k, len(vertices))
        who = "no gain makes" if d["K"] is None else "the given gain doesn't make"
        self.claims = [f"{who} {where} stable with an H-infinity norm{ends(r)} below "
                       f"{at[0][at[1]]}{ticks(d['plant'])}"]  # fmt: skip
