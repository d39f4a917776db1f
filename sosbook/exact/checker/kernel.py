"""Check a proof that is a text with data: ``python kernel.py proof.json``.

It knows no control. The text says which matrices must be positive; the file holds data
and either a point at which all are positive definite, or multipliers by which they
can't all be. `arithmetic` is exact, `language` reads the text, and standard Python is
all that they need. What the matrices mean is said by whoever wrote the text.
"""

import json
import sys
from fractions import Fraction
from pathlib import Path

if not __package__:  # run by its path: its folder is the package
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    __package__ = Path(__file__).resolve().parent.name
from .arithmetic import Mat, Refused, definite, need, scalar, trace, zeros
from .language import Parser, Reader, parse, size

MOST_BYTES = 200_000_000


def shape_of(spec, reader):
    """(rows, columns, symmetric) of "symmetric n" or "n x m"; None of "number"."""
    if spec == "number":
        return None
    good = isinstance(spec, str) and spec.count(" x ") + spec.count("symmetric ") == 1
    need(good, f"{spec!r:.40} is no shape")
    even, n = spec.startswith("symmetric "), []
    for part in spec.removeprefix("symmetric ").split(" x "):
        p = Parser(part)
        n.append(size(reader.value(p.expression())))
        need(p.k == len(p.t), f"{spec!r:.40} is no shape")
    return n[0], n[-1], even


class Labels(list):
    """Of what is proven: at a point, or excluded by multipliers, with their sum."""

    value = None

    def __init__(self):
        super().__init__()
        self.known = set()

    def add(self, label):
        need(label not in self.known, f"{label} comes twice")
        self.known.add(label)
        self.append(label)


def check(file, decide=None, of=Reader):
    """The `Labels` that are proven; else Refused.

    ``decide(label, block, semi)`` may say faster than `definite` whether a block is
    positive definite, or semidefinite, and ``of`` may be a `Reader` of matrices that
    are multiplied faster: who believes these believes that.
    """
    decide = decide or (lambda label, x, semi: definite(x, semi))
    words = "the text isn't in the file: python -I checker writes it, and decides"
    lines = file.get("text") if isinstance(file, dict) else None
    good = isinstance(lines, (list, tuple)) and all(isinstance(x, str) for x in lines)
    need(good, words)
    for name in ("data", "sets", "unknowns", *({"point", "multipliers"} & {*file})):
        need(isinstance(file.get(name), dict), f"{name}: names with values are needed")
    for name, several in file["sets"].items():
        lists = isinstance(several, list) and all(isinstance(u, list) for u in several)
        good = lists and all(isinstance(w, str) for u in several for w in u)
        need(good, f"{name} is no set: a list of lists of words")
    data = {k: of.read(v) for k, v in file["data"].items()}
    program, plain = parse("\n".join(lines)), of(data)
    shapes = {k: shape_of(spec, plain) for k, spec in file["unknowns"].items()}
    need(("point" in file) != ("multipliers" in file), "a point, or multipliers")
    if "point" not in file:
        x = {k: zeros(*s[:2]) if s else Fraction(0) for k, s in shapes.items()}
        return exclude(program, of(data, x, file["sets"]), shapes, file, decide)
    need(set(file["point"]) == set(shapes), "other unknowns")
    x = {k: of.read(v) for k, v in file["point"].items()}
    for k, s in shapes.items():
        good = not scalar(x[k]) and s[:2] == (x[k].r, x[k].c) if s else scalar(x[k])
        need(good, f"{k} has another shape")
        need(not (s and s[2] and x[k] != x[k].T), f"{k} isn't symmetric")
    reader, proven = of(data, x, file["sets"], True), Labels()
    for sign, label, left, right in reader.statements(program):
        proven.add(label)
        holds(sign, label, left, right, decide)
    return proven


def holds(sign, label, x, y, decide):
    """Refuse a statement that isn't so."""
    if sign == "==":
        same = scalar(x.v) == scalar(y.v) and x.v == y.v
        need(same, f"{label} isn't an identity")
    else:
        v = x.v.below() if isinstance(x.v, Mat) else x.v
        good = scalar(y.v) and y.v == 0 and decide(label, v, sign == ">=")
        need(good, f"the block {label} isn't positive " + "semi" * (sign == ">=")
             + "definite")  # fmt: skip


def exclude(program, reader, shapes, file, decide):
    """With Z >= 0, not all zero, sum <G(x), Z> would be positive: it is not.

    It doesn't depend on x, and is zero or negative; each block is affine in x.
    """
    Z = {k: reader.read(v) for k, v in file["multipliers"].items()}
    proven, seeds, sum_ = Labels(), [], Fraction(0)
    for sign, label, x, y in reader.statements(program):
        proven.add(label)
        z = Z.pop(label, None)
        if z is None or sign != ">":
            need(z is None, f"{label} takes no multiplier")
            need(x.back is None or sign == ">", f"{label} holds for some x only")
            if x.back is None:
                holds(sign, label, x, y, decide)
            continue
        if scalar(x.v) and not scalar(z):
            z = trace(z)
        good = scalar(y.v) and y.v == 0 and (scalar(z) or (z.r, z.c) == (x.v.r, x.v.c))
        need(
            good and scalar(z) == scalar(x.v), f"the multiplier of {label} doesn't fit"
        )
        need(decide(label, z, True), f"the multiplier of {label} isn't positive")
        seeds.append((x, z))
        sum_ += z * x.v if scalar(z) else z.dot(x.v)
    need(not Z, "a multiplier belongs to no block")
    need(any(z if scalar(z) else z.any() for _, z in seeds), "none counts")
    for x, z in seeds:
        x.adj = z if x.adj is None else x.adj + z
    for x in reversed(reader.tape):
        for y, f in x.back if x.adj is not None else ():
            g = f(x.adj)
            y.adj = g if y.adj is None else y.adj + g
    for k, s in shapes.items():
        g = reader.env[k].adj
        if g is not None:
            g = g + g.T if s and s[2] else g
            gone = g == 0 if scalar(g) else not g.any()
            need(gone, f"the multipliers leave {k} a way out")
    need(sum_ <= 0, "the multipliers exclude nothing")
    proven.value = sum_
    return proven


def contents(text):
    """The content of a text in JSON; a key that comes twice is refused."""
    return json.loads(text, object_pairs_hook=unique, parse_constant=nothing,
                      parse_int=whole)  # fmt: skip


def unique(pairs):
    need(len(dict(pairs)) == len(pairs), "a key comes twice")
    return dict(pairs)


def whole(word):
    need(len(word) <= 400, "a whole number has too many digits")
    return int(word)


def nothing(word):
    raise Refused(f"{word} is no number")


MALFORMED = (LookupError, TypeError, AttributeError, ValueError, RecursionError,
             OverflowError, ZeroDivisionError)  # fmt: skip


def main(arguments):
    """Check the file that ``arguments`` name; return the exit code."""
    try:
        with open(arguments[0], "rb") as file:
            text = file.read(MOST_BYTES + 1)
        need(len(text) <= MOST_BYTES, "the file is too long")
        file = contents(text.decode("utf-8"))
        labels = check(file)
    except (Refused, *MALFORMED) as fault:
        print(f"refused: {fault!a:.200}")
        return 1
    except OSError as fault:
        print(f"not read: {fault}")
        return 2
    how = "positive definite" if "point" in file else "not all positive definite"
    print(f"{how}:", *labels)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
