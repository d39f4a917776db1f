"""The theorems of the pages: the checker's texts, taken apart by requirement.

A page writes a proof file, designs and refuses by ``texts.json``, which is made of what
the checker writes for a plant of unlike sizes. To make it again:
``python -m sosbook.book.kernel.texts``.
"""

import json
import re
from pathlib import Path

from ...exact.checker.designs import Design
from ...exact.checker.plants import plant
from ...exact.checker.requirements import (
    BLOCKS,
    STABILITY,
    implies_stability,
    numbers_of,
    size_of,
)
from ...exact.checker.text import Text
from ...runtime.writing import write_file

FILE = Path(__file__).with_name("texts.json")
n, m, p, N = 3, 8, 5, 7  # of the plant below; no text has such numbers of its own
NAMES = {str(N): "{N}", str(m): "{m}", str(p): "{p}"}
LARGE = re.compile(r"\b[578]\b")
K_TH = "#"  # stands for the number of a requirement


def _zeros(rows, cols):
    return [["0"] * cols for _ in range(rows)]


def _one(rows):
    return [[str(int(i == j)) for j in range(rows)] for i in range(rows)]


VERTEX = {x: _one(n) for x in "MDS"} | {"B": _zeros(n, m), "F": _zeros(n, p)}
REGION = {"kind": "region", "name": "region", "alpha": [["0"]], "beta": [["1"]]}
COST = {"kind": "cost", "name": "cost", "Q": _one(N), "R": _one(m), "bound": "1"}
#: What a page can ask, each with the fields by which it has texts of its own.
ASKED = (
    (STABILITY, {"kind": "stability"}),
    (REGION | {"form": "half-plane", "sigma": "0"}, {"form": "half-plane"}),
    (REGION | {"form": "sector", "theta": "1", "apex": "0", "degrees": "1"},
     {"form": "sector"}),
    (REGION | {"form": "disk", "rho": "1", "centre": "0"}, {"form": "disk"}),
    ({"kind": "gamma", "name": "gamma", "gamma": "1", "mu": None},
     {"kind": "gamma", "mu": None}),
    ({"kind": "gamma", "name": "gamma", "gamma": "1", "mu": "1"}, {"kind": "gamma"}),
    (COST | {"noise": "states"}, {"kind": "cost", "noise": "states"}),
    (COST | {"noise": "F"}, {"kind": "cost", "noise": "F"}),
    ({"kind": "input", "name": "saturation", "u_max": "1", "x0": ["0"] * N,
      "acceleration": False}, {"kind": "input"}),
)  # fmt: skip


def _design(framed):
    """The text of a plant's stability: of a proof, or ``framed`` in coordinates."""
    d = {"plant": {"kind": "second order", "vertices": [VERTEX]}, "U": _zeros(1, n),
         "K_A": None, "coupling": "pairs", "epsilon": None, "E0": None,
         "requirements": []}  # fmt: skip
    if not framed:
        return Design(d | {"K": _zeros(m, N), "unknowns": {"P": _one(N)}})
    frame = {"left": _one(N), "T": _one(N), "back": _one(N), "scale": "1", "sizes": {}}
    return Design(d | {"K": None, "multipliers": [], "coordinates": frame})


def _part(r, framed, sized):
    """The lines of a requirement, their data, how blocks are called, and unknowns."""
    d, said = _design(framed), []
    d.t, d.asked, d.ids = Text({}), [r], {id(r): K_TH}
    d.t.data |= {"back": []} if framed else {}
    size = size_of(r, d.asked)
    d.sizes = {(r["kind"], r["name"]): size} if sized else {}
    blocks, lines, places = [], 0, 0
    for step in range(2):
        if step:
            blocks = [list(x) for x in BLOCKS[r["kind"]](d, r)]
        elif r is not STABILITY:
            numbers_of(d.t, d.asked, K_TH, r, False)
        given = [(key, x) for (_, key), x in d.t.places.items()]
        said.append({"lines": d.t.lines[lines:], "given": dict(given[places:])})
        lines, places = len(d.t.lines), len(given)
    return {"size": size, "positive": f"{size}: {size} > 0", "numbers": said[0],
            "more": said[1], "blocks": blocks, "unknowns": d.t.unknowns}  # fmt: skip


def _sure(r):
    return r["kind"] != "region" and implies_stability(r)


def _frame(framed):
    """The lines of every text, around those of requirements."""
    d = _design(framed)
    bare = Text(d.d)
    plant(bare, d.d)
    lines = d.t.lines[len(bare.lines) :]
    positive, pairs = lines.index("P: P > 0"), lines.index("for i, j in pairs:")
    shared = [x.strip() for x in lines[pairs + 1 :] if not x.startswith("  stability")]
    return {"first": lines[:positive], "then": lines[positive:pairs], "pairs": shared,
            "unknowns": d.t.unknowns}  # fmt: skip


def texts():
    """The contents of ``texts.json``: "plant", lines by what there is; "frames", those
    around all requirements, of a proof and in coordinates; "parts": what a page can
    ask, "of" the fields of a requirement, "sure" if it implies stability where its
    sigma isn't negative, and its "texts" for both frames, without and with a size of P.

    >>> texts()["plant"]["K_A"][3]
    '  E.i = [I(n), 0; 0, M.i - B.i K_A]'
    """
    plants = {}
    for U in ([], _zeros(1, n)):
        for K_A in (None, _zeros(m, n)):
            t, d = Text({}), _design(False).d | {"U": U, "K_A": K_A}
            plant(t, d)
            plants[" ".join(["U"] * bool(U) + ["K_A"] * bool(K_A))] = t.lines
    both = False, True
    parts = [{"of": of, "sure": r.get("form") == "half-plane" or _sure(r), "texts": [
        [_part(r, framed, sized) for sized in both] for framed in both
    ]} for r, of in ASKED]  # fmt: skip
    whole = {"plant": plants, "frames": [_frame(x) for x in both], "parts": parts}
    return _by_names(whole)


def _by_names(x):
    """The same with the letters of the sizes in the place of their numbers."""
    if isinstance(x, dict):
        return {_by_names(key): _by_names(value) for key, value in x.items()}
    if isinstance(x, (list, tuple)):
        return [_by_names(value) for value in x]
    return LARGE.sub(lambda size: NAMES[size[0]], x) if isinstance(x, str) else x


def stored():
    """`texts` as the file has it, one plant, frame or part a line."""
    lines = []
    for key, value in texts().items():
        named = isinstance(value, dict)
        some = value.items() if named else (("", x) for x in value)
        inner = ",\n".join(
            f"{json.dumps(k)}: " * named + json.dumps(x) for k, x in some
        )
        opened, closed = "{}" if named else "[]"
        lines.append(f'"{key}": {opened}\n{inner}\n{closed}')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def main():
    """Write the file."""
    write_file(FILE, stored())


if __name__ == "__main__":
    main()
