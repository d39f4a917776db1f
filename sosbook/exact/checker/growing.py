"""A pole outside, of a loop too large for its polynomial: something grows."""

from .arithmetic import need
from .fixed_mode import broken, half_plane, place
from .plants import plant
from .text import Text, number


class Growing:
    """E' P F + F' P E + level E' P E > 0, and x' E' P E x > 0: a pole lies outside.

    If all poles lie in a region, they lie in its half-plane level + 2 Re(b s) < 0, and
    all y with y' = (level / 2 + b E^-1 A) y end at zero. But y' E' P E y grows, and
    begins above zero. A complex b makes two rows of each.
    """

    def __init__(self, d):
        """Write the text: a form that grows, and where it is positive."""
        t = self.t = Text(d)
        vertices, N, m, _ = plant(t, d)
        where, mean = place(t, d, len(vertices))
        t.write(*(f"{x} = {mean.format(x)}" for x in ("E", "A", "Bu")))
        t.put("K", d, "K", (m, N))
        alpha, beta, text = broken(d["requirement"], d)
        a, b = ([number(e[k]) for e in d["witness"]] for k in (0, 1))
        need(len(a) == len(alpha), "the witness has a wrong length")
        level, re, im = half_plane(alpha, beta, a, b)
        need(number(d["level"]) <= level, "the level is above what is asked")
        t.put_number("level", d, "level")
        t.data["re"], t.data["im"] = str(re), str(im)
        t.write("L = A + Bu K")
        if im:
            N *= 2
            t.write("F = [re L, -im L; im L, re L]", "H = [E, 0 E; 0 E, E]")
        else:
            t.write("F = re L", "H = E")
        t.put("P", d, "form", (N, N))
        t.put("x", d, "start", (N, 1))
        t.write("even: P == P'",
                "grows: H' P F + F' P H + level H' P H > 0",
                "begins: x' H' P H x > 0")  # fmt: skip
        loop = "under the given gain " if m else ""
        self.claims = [f"{where} has {loop}a pole outside, which breaks: {text}"]
