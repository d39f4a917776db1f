"""Data of a law: its sensors, its states, and its free gains."""

import re

from .arithmetic import need
from .families import keys
from .text import ratio

PARTS_OF_LAW = "rows noise E A B of_sensors of_states"
SIGNAL = r"(?=[\w(-])(?:[\w ()'+#/-]|[.](?! )){1,99}(?<! )"


def put_law(t, law):
    """Write the matrices that a law joins to a plant as data."""
    keys(law, f"{PARTS_OF_LAW} states signals")
    for name in PARTS_OF_LAW.split():
        width = len(law["rows"]) if name == "B" else 0
        t.put(f"law.{name}", law, name, width, ratio)
    listed(law["states"], len(law["E"]))
    listed(law["signals"], len(law["of_sensors"]))


def listed(names, many):
    """The ``names`` of so ``many`` signals in words, [a, b]: none is a sentence."""
    good = isinstance(names, (list, tuple)) and len({*map(str, names)}) == many
    good = good and all(isinstance(x, str) and re.fullmatch(SIGNAL, x) for x in names)
    need(good and len(names) == many, "signals have names, each its own")
    return f"[{', '.join(names)}]"


def under(plant, law=None, free=0, late=""):
    """How u comes about, in the words of a claim about a ``plant`` of the file.

    With a ``law`` K multiplies its signals, and gives u and x_c' of ``free`` states.
    ``late`` says of which time x is, where it isn't now.
    """
    states = plant.get("states")
    x = "" if states is None else listed(states, len(states))
    if law is None:
        return f", under u = K x{late}" + f" with x = {x}" * bool(x) + ","
    y, own = law["signals"], law["states"]
    moved = "".join(f", {x}'" for x in own[len(own) - free :])
    memory = f" and the memory {listed(own, len(own))}" if own else ""
    given = f"[u{moved}]" if moved else "u"
    where = f", of the states {x}" * bool(x)
    return f", under {given} = K y with y = {listed(y, len(y))}{memory}{where},"


JOINED = """E = [{E}, 0; 0, law.E]
A = [{A}, O({N}, {c}); law.B law.rows, law.A]
Bu = [{Bu}, O({N}, {f}); O({c}, {m}), [O({k}, {f}); I({f})]]"""


def joined(t, law, size, mean, f):
    """E, A and Bu of a plant with a law's states, f of them free: how many of each."""
    put_law(t, law)
    (N, m), c = size, len(law["E"])
    need(type(f) is int and 0 <= f <= c, "a law has no such rows")
    parts = {x: mean.format(x) for x in ("E", "A", "Bu")}
    t.write(*JOINED.format(**parts, N=N, m=m, c=c, f=f, k=c - f).split("\n"))
    return N + c, m + f
