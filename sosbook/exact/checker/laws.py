"""Data of a law: its sensors, its states, and its free gains."""

from .arithmetic import need
from .families import keys, listed
from .text import ratio

PARTS_OF_LAW = "rows noise E A B of_sensors of_states"


def put_law(t, law):
    """Write the matrices that a law joins to a plant as data."""
    keys(law, f"{PARTS_OF_LAW} states signals")
    for name in PARTS_OF_LAW.split():
        width = len(law["rows"]) if name == "B" else None
        t.put(f"law.{name}", law, name, (None, width), ratio)
    listed(law["states"], len(law["E"]))
    listed(law["signals"], len(law["of_sensors"]))


JOINED = """E = [{E}, 0; 0, law.E]
A = [{A}, O({N}, {c}); law.B law.rows, law.A]
Bu = [{Bu}, O({N}, {f}); O({c}, {m}), [O({k}, {f}); I({f})]]"""


def joined(t, law, size, mean, f):
    """E, A and Bu of a plant with a law's states, f of them free: how many of each."""
    put_law(t, law)
    (N, m), c = size, len(law["E"])
    need(0 <= f <= c, "a law has no such rows")
    parts = {x: mean.format(x) for x in ("E", "A", "Bu")}
    t.write(*JOINED.format(**parts, N=N, m=m, c=c, f=f, k=c - f).split("\n"))
    return N + c, m + f
