"""Turn a proof file of sosbook into a file for Rocq: ``python gen.py proof.json``.

What it prints proves by its own run, with the theorems beside this file, that the
poles of the file's plants lie in the file's regions. Nothing here has to be believed:
a wrong matrix doesn't pass. Of a sampled loop it proves the last step, for the balls
that the stand-alone checker computes. It needs Python 3.9 or newer and nothing else.

Exit code: 0 written, 3 not covered, 1 nothing shows what the file says.
"""

import json
import re
import sys
from fractions import Fraction
from math import isqrt, lcm
from pathlib import Path

CHECKER = Path(__file__).resolve().parents[1] / "sosbook" / "exact"

#: Bits of the factors L; a block that none of these shows is near the boundary.
BITS = (24, 32, 48, 64, 96, 128, 192, 256, 384, 512)


class Refused(Exception):
    """The file isn't covered; the text says why."""


class Failed(Exception):
    """Nothing was found that shows what the file says."""


# ---- What a file says


def read(text):
    """The problem of a file's text: a `Problem`, or the boxes of a sampled loop."""
    file = json.loads(text)
    if file.get("format") != "sosbook proof" or file.get("version") != 2:
        raise Refused("it is no proof file of version 2")
    if file["kind"] == "sampled":
        return boxes(text)
    if file["kind"] != "design":
        raise Refused(f"a proof of the kind {file['kind']!r}")
    if "text" not in file:
        raise Refused("a proof without a text")
    file = looked_up(file["asks"], file["data"] | file["point"])
    if "parameters" in file["plant"] or file["plant"]["kind"] not in NAMES:
        raise Refused("a plant with parameters in ranges, or of another kind")
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


NAMES = {"second order": "MDSB", "descriptor": "EAB"}
STABLE = {"name": "stability", "form": "half-plane", "sigma": "0",
          "alpha": [["0"]], "beta": [["1"]]}  # fmt: skip


class Problem:
    """The numbers of a file, as it writes them, and P in integers."""

    def __init__(self, file):
        plant, self.P = file["plant"], integers(file["unknowns"]["P"])[1]
        self.K, self.U, self.K_A = file["K"], file["U"], file["K_A"] or []
        self.vertices, self.kind = plant["vertices"], plant["kind"]
        self.names = NAMES[self.kind]
        asked = [r for r in file["requirements"] if r["kind"] == "region"]
        self.regions = [STABLE, *asked]
        self.n, self.p = len(self.vertices[0][self.names[0]]), len(self.U)
        self.m = len(self.vertices[0]["B"][0])

    def pencils(self):
        """d, e and the pencils of the theorems: integers, the plant's times d e."""
        d = denominator(self.U, *(v[x] for v in self.vertices for x in self.names))
        e, n = denominator(self.K, self.K_A), self.n
        K, U, pencils = times(e, self.K), times(d, self.U), []
        K_A = times(e, self.K_A) or zeros(self.m, n)
        for v in self.vertices:
            B = times(d, v["B"])
            BK = product(B, K) if K else zeros(n, self.N)
            if self.kind == "descriptor":
                E, A = times(d * e, v["E"]), plus(times(d * e, v["A"]), BK)
            else:
                M, D, S = (times(d * e, v[x]) for x in "MDS")
                E, A = zeros(self.N, self.N), zeros(self.N, self.N)
                BK_A = product(B, K_A) if K else zeros(n, n)
                for i in range(n):
                    E[i][i] = A[i][n + i] = d * e
                    E[n + i][n : 2 * n] = [a - b for a, b in zip(M[i], BK_A[i])]
                    row = [-a for a in S[i] + D[i]] + [0] * self.p
                    A[n + i] = [a + b for a, b in zip(row, BK[i])]
                for i, row in enumerate(U):
                    E[2 * n + i][2 * n + i] = d * e
                    A[2 * n + i][:n] = [e * a for a in row]
            pencils.append((E, A))
        return d, e, pencils

    @property
    def N(self):
        return self.n if self.kind == "descriptor" else 2 * self.n + self.p


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


# ---- Matrices of integers


def denominator(*matrices):
    return lcm(*(Fraction(a).denominator for x in matrices for r in x for a in r))


def times(d, matrix):
    return [[int(d * Fraction(a)) for a in row] for row in matrix]


def integers(*matrices):
    d = denominator(*matrices)
    return (d, *(times(d, x) for x in matrices))


def zeros(rows, columns):
    return [[0] * columns for _ in range(rows)]


def plus(a, b):
    return [[x + y for x, y in zip(r, s)] for r, s in zip(a, b)]


def transposed(a):
    return [list(r) for r in zip(*a)]


def product(a, b):
    columns = transposed(b)
    return [[sum(x * y for x, y in zip(r, c)) for c in columns] for r in a]


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


def witness(G):
    """u, t, L: the diagonal of u G - t L L' exceeds the rest of its row; or None."""
    top = max((row[i] for i, row in enumerate(G)), default=0).bit_length()
    for bits in BITS:
        up, down = max(0, 2 * bits - top), max(0, top - 2 * bits) // 2
        uG = [[a << up for a in row] for row in G]
        L = factor(uG, down, bits // 2)
        if L and dominant(less(uG, L, 2 * down)):
            return 1 << up, 1 << 2 * down, L
    return None


def less(G, L, shift):
    """G - 2^shift L L'"""
    return [
        [a - (sum(x * y for x, y in zip(r, s)) << shift) for a, s in zip(row, L)]
        for r, row in zip(L, G)
    ]


def factor(G, h, gap):
    """L up to the diagonal: L L' is near G / 4^h less 2^-gap of its diagonal."""
    L = []
    for i, row in enumerate(G):
        new = []
        for j in range(i + 1):
            a = row[j] - (row[j] >> gap if i == j else 0)
            rest = (a >> 2 * h) - sum(
                x * y for x, y in zip(new, L[j] if j < i else new)
            )
            if i == j and rest <= 0:
                return None
            new.append(isqrt(rest) if i == j else rest // L[j][j])
            if i == j and not new[-1]:
                return None
        L.append(new)
    return L


def dominant(R):
    return all(2 * row[i] > sum(map(abs, row)) for i, row in enumerate(R))


# ---- What Rocq reads

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
apply: (@{kind}_sound {plant} _ {less} alpha_{number} beta_{number} {scales} P wP
  w_{label}); last by vm_cast_no_check (eq_refl true).
{sound}
Qed.
"""

END = """
Definition proven := ({}).
Print Assumptions proven.
"""


def literal(matrix):
    """A list of lists, with the digits of the file."""
    rows = (
        "[:: " + "; ".join(map(str, row)) + "]" if row else "[::]" for row in matrix
    )
    return "[:: " + ";\n  ".join(rows) + "]" if matrix else "[::]"


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
        return f"in_matrices {len(beta)} alpha_{number} beta_{number}", "by []."
    name, *given = numbers[r["form"]]
    words = " ".join([f"in_{name}", *(f"({x})" if "-" in x else x for x in given)])
    sound = f"by move=> C s; apply: {name}_sound; vm_cast_no_check (eq_refl true)."
    return words, sound


def constant(name, kind, text):
    return f"Definition {name} : {kind} := {text}.\n"


def triple(witness):
    u, t, L = witness
    return f"({u}, {t}, {literal(L)})"


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


def ratio(x):
    return "({} # {})%Q".format(*Fraction(x).as_integer_ratio())


def rationals(x):
    return literal([[ratio(Fraction(a, x.d)) for a in row] for row in x.a])


def written(problem):
    """The whole file."""
    if isinstance(problem, list):
        return fallen(problem)
    d, e, pencils = problem.pencils()
    w = witness(problem.P)
    if w is None:
        raise Failed("nothing shows that P is positive definite")
    mechanical = problem.kind == "second order"
    kind = "mechanics" if mechanical else "descriptor"
    text, labels = [HEAD.format(kind)], []
    for i, v in enumerate(problem.vertices, 1):
        numbers = "\n ".join(literal(v[x]) for x in problem.names)
        text.append(constant(f"vertex_{i}", kind, f"({kind.title()} {numbers})%Q"))
    for x in ("U", "K_A", "K") if mechanical else ("K",):
        text.append(constant(x, "numbers", f"{literal(getattr(problem, x))}%Q"))
    text.append(constant("P", "seq (seq Z)", literal(problem.P)))
    text.append(constant("wP", "witness", triple(w)))
    size, law = f"{problem.n} {problem.m}", "K"
    if mechanical:
        size, law = f"{size} {problem.p}", "(Law U K_A K)"
    for number, r in enumerate(problem.regions):
        g, alpha, beta = integers(r["alpha"], r["beta"])
        where, sound = named(r, number)
        text.append(f"\n(* {number}: {r['name']} *)\n")
        for x in ("alpha", "beta"):
            text.append(constant(f"{x}_{number}", "numbers", f"{literal(r[x])}%Q"))
        for label, who, rows in witnesses(alpha, beta, problem.P, pencils):
            label = f"{number}{label}"
            labels.append(f"poles_{label}")
            pairs = ";\n ".join(f"[:: {';'.join(map(triple, row))}]" for row in rows)
            text.append(constant(f"w_{label}", "seq (seq witness)", f"[:: {pairs}]"))
            names = "; ".join(f"vertex_{i + 1}" for i in who)
            text.append(THEOREM.format(
                label=label, number=number, kind=kind, where=where, sound=sound,
                plant=f"{size} [:: {names}] {law}", less=len(alpha) - 1,
                scales=f"{d} {e} {g}",
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
