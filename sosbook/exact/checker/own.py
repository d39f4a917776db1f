"""LMIs of somebody's own."""

import re

from .arithmetic import need
from .text import Text, ratio, sane


class Own:
    """LMIs that someone wrote: constants, and terms L X R in unknowns X."""

    def __init__(self, d):
        """Write the text: each block as a sum of a constant and terms L X R."""
        t, names = Text(d), {}
        self.t = t
        for k, (name, r, c, even) in enumerate(d["shapes"], 1):
            need(min(r, c) > 0, f"shapes: {name!r:.40} has no size")
            need(not even or r == c, f"shapes: {name!r:.40} isn't symmetric")
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
                need(name in names, f"expressions: there is no unknown {name!r:.40}")
                t.put(f"L.{i}.{j}", term, 2, entry=ratio)
                t.put(f"R.{i}.{j}", term, 3, entry=ratio)
                parts.append(f"L.{i}.{j} {names[name]}{chr(39) * turned} R.{i}.{j}")
            t.labels[row[0]] = f"block.{i}"
            t.write(f"block.{i}: {' + '.join(parts)} > 0")
        for e in (e for x in d.get("unknowns", {}).values() for u in x for e in u):
            count = len(re.sub("e.*|[-.]", "", e).strip("0"))
            need(count <= d["digits"], "the point has more digits")
        how = "these blocks are positive definite"
        if "multipliers" in d:
            how = "no point makes all these blocks positive definite"
        self.claims = [f"{how}: " + ", ".join(said)]
