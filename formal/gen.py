"""Turn a proof file of sosbook into one for Rocq: ``python -m formal.gen proof.json``.

What it prints proves by its own run, with the theorems beside this file, that the
poles of the file's plants lie in the file's regions. Nothing here has to be believed:
a wrong matrix doesn't pass. Of a sampled loop it proves the last step, for the balls
that the stand-alone checker computes. It needs Python 3.9 or newer and nothing else.

Exit code: 0 written, 3 not covered, 1 nothing shows what the file says.
"""

import json
import re
import sys
from pathlib import Path

from formal import known
from formal.common import (
    Failed,
    Refused,
    constant,
    integers,
    literal,
    plus,
    product,
    ratio,
    rationals,
    transposed,
    triple,
    witness,
)
from formal.loops import NAMES, Loop

CHECKER = Path(__file__).resolve().parents[1] / "sosbook" / "exact"

# ---- What a file says


def read(text):
    """The problem of a file's text: a `Problem`, or the boxes of a sampled loop."""
    file = json.loads(text)
    if file.get("format") != "sosbook proof" or file.get("version") != 2:
        raise Refused("it is no proof file of version 2")
    if file["kind"] == "sampled":
        return boxes(text)
    kind = file["kind"]
    if kind not in ("design", "known gain"):
        raise Refused(f"a proof of the kind {file['kind']!r}")
    if "text" not in file:
        raise Refused("a proof without a text")
    file = looked_up(file["asks"], file["data"] | file["point"])
    if "parameters" in file["plant"] or file["plant"]["kind"] not in NAMES:
        raise Refused("a plant with parameters in ranges, or of another kind")
    if kind == "known gain":
        return known.Known(file)
    if set(file["unknowns"]) & {"V", "P 1"} or "P" not in file["unknowns"]:
        raise Refused("a design without a common P")
    return Problem(file)


def looked_up(asked, named):
    """What is asked, with the data for their names; matrices as lists."""
    if isinstance(asked, dict) and set(asked) == {"zeros"}:
        return [[] for _ in range(asked["zeros"][0])]
    if isinstance(asked, dict):
        return {key: looked_up(value, named) for key, value in asked.items()}
    if isinstance(asked, list):
        return [looked_up(value, named) for value in asked]
    if isinstance(asked, str) and asked.startswith("="):
        return looked_up(named[asked[1:]], {})
    return asked


class Problem:
    """A design: its loop, its regions, and P in integers; see region.v."""

    theory = ""

    def __init__(self, file):
        self.loop, self.P = Loop(file), integers(file["unknowns"]["P"])[1]
        asked = [r for r in file["requirements"] if r["kind"] == "region"]
        self.regions = [known.STABLE, *asked]

    def text(self):
        w = witness(self.P)
        if w is None:
            raise Failed("nothing shows that P is positive definite")
        P = constant("P", "seq (seq Z)", literal(self.P))
        return [P, constant("wP", "witness", triple(w))]

    def shown(self, number, pencils, c, sound):
        """Of a region label, vertices, a definition, the rule, and the last words."""
        r = self.regions[number]
        g, alpha, beta = integers(r["alpha"], r["beta"])
        rule = f"pairs_sound _ {len(alpha) - 1} alpha_{number} beta_{number} {g} P wP"
        for label, who, rows in witnesses(alpha, beta, self.P, pencils):
            w = f"w_{number}{label}"
            pairs = ";\n ".join(f"[:: {';'.join(map(triple, row))}]" for row in rows)
            text = constant(w, "seq (seq witness)", f"[:: {pairs}]")
            yield f"{number}{label}", who, text, f"{rule} {w}", sound


def boxes(text):
    """Of each box of a sampled proof: rate, share, G, and (P, ball) of its corners.

    A ball is the checker's, of the block that is decided; G and P are None where the
    block has none.
    """
    sys.path.insert(0, str(CHECKER))
    from checker import arithmetic, kernel, verdict

    found, names = (
        {},
        dict(P=r"^\[rate\^2 ([^ ,]+)", G=r"he\(([^)]+)", share=r"(share[.]\d+)"),
    )
    try:
        file = verdict.opened(text)[0]
        lines = dict(line.split(": ", 1) for line in file["text"] if ": " in line)
        program = kernel.parse("\n".join(file["text"]))
        data = {name: kernel.Reader.read(x) for name, x in file["data"].items()}
        reader = kernel.Reader(data, {}, file["sets"], True)
        for sign, label, left, right in reader.statements(program):
            kernel.holds(
                sign, label, left, right, lambda _, *x: arithmetic.definite(*x)
            )
            if label.startswith("tick."):
                said = (re.search(pattern, lines[label]) for pattern in names.values())
                P, G, share = (x and reader.env[x[1]].v for x in said)
                box = data["rate"], share or 0, G, []
                box = found.setdefault(label.split(".")[1], box)
                box[3].append((P, left.v if left.v.e else left.v.near()))
    except arithmetic.Beyond as limit:
        raise Refused(f"the checker doesn't decide it: {limit}") from None
    except arithmetic.Refused as fault:
        raise Failed(f"the checker refuses it: {fault}") from None
    return list(found.values())


# ---- What Rocq reads


def block(alpha, beta, P, one, other):
    """Minus twice the symmetric part of the theorem's matrix, for two vertices."""
    (E, A), (F, G) = one, other
    EP, AP, FP, GP = (product(x, P) for x in (E, A, F, G))
    E, A, F, G = map(transposed, (E, A, F, G))
    ee = plus(product(EP, F), product(FP, E))
    ae = plus(product(AP, F), product(GP, E))
    ea = plus(product(EP, G), product(FP, A))
    N, k = len(P), len(alpha)
    return [[-(alpha[a][b] * ee[r][c] + beta[a][b] * ae[r][c] + beta[b][a] * ea[r][c])
             for b in range(k) for c in range(N)]
            for a in range(k) for r in range(N)]  # fmt: skip


HEAD = """\
(* Made by formal/gen.py from a proof file of sosbook. *)
From Coq Require Import ZArith QArith.
From mathcomp Require Import ssreflect ssrbool seq.
From formal Require Import {} forms.
Local Open Scope Z_scope.
"""


THEOREM = """\
Theorem poles_{label} : {kind}_poles_in {plant} ({where}).
Proof.
apply: (@{kind}_sound {plant} _ {d} {e}); first by vm_cast_no_check (eq_refl true).
apply: (@{rule}); last by vm_cast_no_check (eq_refl true).
by move=> C s{sound}.
Qed.
"""

END = """
Definition proven := ({}).
Print Assumptions proven.
"""


def named(r, number):
    """Where a region's poles lie, and which theorem says so; see forms.v."""
    beta = r["beta"]
    numbers = {
        "half-plane": ("half_plane", r.get("sigma")),
        "strip": ("strip", r.get("left"), r.get("right")),
        "horizontal strip": ("horizontal_strip", r.get("omega")),
        "disk": ("disk", r.get("rho"), r.get("centre")),
        "sector": ("sector", *beta[0], r.get("apex")),
    }
    if r["form"] not in numbers:
        return f"in_matrices {len(beta)} alpha_{number} beta_{number}", ""
    name, *given = numbers[r["form"]]
    words = " ".join([f"in_{name}", *(f"({x})" if "-" in x else x for x in given)])
    sound = f"; apply: {name}_sound; vm_cast_no_check (eq_refl true)"
    return words, sound


FALLS = """\
Theorem falls_{k} : {kind}_contract {n} {numbers} {d} {what}_{k}.
Proof.
by apply: (@{kind}_sound {n} {numbers} {d} {what}_{k} w_{k});
  vm_cast_no_check (eq_refl true).
Qed.
"""


def fallen(found):
    """The file of the boxes of a sampled loop."""
    text = [HEAD.format("sampled")]
    for k, (rate, share, G, corners) in enumerate(found):
        shown = [witness(least(ball)) for _, ball in corners]
        if not all(shown):
            raise Failed("nothing shows that the ball of a block is positive definite")
        balls = [f"Ball {literal(ball.a)} {ball.e}" for _, ball in corners]
        numbers, n, what = f"{ratio(rate)} {ratio(share)}", corners[0][1].r, "balls"
        if G:
            numbers, n, what = f"{numbers} ({rationals(G)})", n // 2, "corners"
            balls = [f"Corner ({rationals(P)}) ({ball})"
                     for (P, _), ball in zip(corners, balls)]  # fmt: skip
        kind = "seq corner" if G else "seq ball"
        text.append(constant(f"{what}_{k}", kind, "[:: " + ";\n ".join(balls) + "]"))
        rows = ";\n ".join(map(triple, shown))
        text.append(constant(f"w_{k}", "seq witness", f"[:: {rows}]"))
        text.append(FALLS.format(k=k, kind="with_P" if G else "plain", n=n, what=what,
                                 numbers=numbers, d=corners[0][1].d))  # fmt: skip
    names = ", ".join(f"falls_{k}" for k in range(len(found)))
    return "".join(text) + END.format(names)


def least(ball):
    """What twice the form of each matrix in a ball exceeds."""
    return [[x + y - 2 * ball.e * (i == j) for j, (x, y) in enumerate(zip(u, v))]
            for i, (u, v) in enumerate(zip(ball.a, zip(*ball.a)))]  # fmt: skip


def written(problem):
    """The whole file."""
    if isinstance(problem, list):
        return fallen(problem)
    loop = problem.loop
    d, e, pencils = loop.pencils()
    text, labels = [HEAD.format(loop.head + problem.theory)], []
    text += loop.text() + problem.text()
    for number, r in enumerate(problem.regions):
        where, sound = named(r, number)
        text.append(f"\n(* {number}: {r['name']} *)\n")
        for x in ("alpha", "beta"):
            text.append(constant(f"{x}_{number}", "numbers", f"{literal(r[x])}%Q"))
        for label, who, more, rule, last in problem.shown(
            number, pencils, d * e, sound
        ):
            labels.append(f"poles_{label}")
            text.append(more + THEOREM.format(
                label=label, kind=loop.kind, plant=loop.stated(who), where=where, d=d,
                e=e, rule=rule, sound=last,
            ))  # fmt: skip
    return "".join(text) + END.format(", ".join(labels))


def witnesses(alpha, beta, P, pencils):
    """Those of all pairs, as [("", vertices, rows)]; else each vertex's own."""
    found, many = {}, range(len(pencils))
    for i in many:
        for j in many[i:]:
            found[i, j] = witness(block(alpha, beta, P, pencils[i], pencils[j]))
    if not all(found[i, i] for i in many):
        raise Failed("nothing shows that the block of a vertex is positive definite")
    if not all(found.values()):
        return [(f"_{i + 1}", [i], [[found[i, i]]]) for i in many]
    return [("", many, [[found[i, j] for j in many[i:]] for i in many])]


def main(arguments):
    if len(arguments) != 1:
        sys.exit(__doc__)
    try:
        with open(arguments[0], encoding="utf-8") as file:
            print(written(read(file.read())), end="")
    except (Refused, Failed) as fault:
        words = "not covered" if isinstance(fault, Refused) else "not shown"
        print(f"{arguments[0]}: {words}: {fault}", file=sys.stderr)
        return 3 if isinstance(fault, Refused) else 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
