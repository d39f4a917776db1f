"""Modes of a plant behind a late input, which no gain slows down enough.

**The part.** Let W A = L W E for rows W of full rank k. Multiplied by W and W' the LMIs
of Theorem 2.3 for the plant are those of x' = L x + W B u, with W E F' W' for F' and
X W' for X. So a plant has a solution only if its part has one.

**Near numbers.** Let D be blocks [a, -b; b, a], J = R E C with |J - 1| < 1, and eta
(1 - |J - 1|) at least |R A C - D J|. Then R, E and C are regular, and R A = (D + e) R E
with |e| <= eta. So W = [1, H] R is such a part, and L = D1 + e11 + H e21, if

    D1 H - H D2 = e12 + H e22 - e11 H - H e21 H.

As D is normal, the left side is at least gap |H| in the Frobenius norm, where gap is at
most the distance of D1's eigenvalues from D2's. If |H| <= h = (k + 3) eta/gap <= 1, the
right side is at most eta (sqrt(k) + 2 h + h^2) <= gap h: there is such an H (Brouwer).

**Their price.** Let t be the trace of functional, R, Z and a decay, which are positive
definite: each is at most t, and what is beside a diagonal at most t/2. With a skew K
and an even S let E F' = S - K. With kappa = alpha/tau and e1, e2 <= 1 the decay says

    2 e2 kappa |S| <= (2 + 2 m) t,    e2 |B X| <= 2 t,
    e2 |(S + K) T - S + K| <= 2 t,    T = kappa (A E^-1)',

so |K| <= |(1 + T)^-1| (2 t/e2 + |S| |T - 1|), and X is bounded where B's columns are
independent. So the numbers' decay differs from the part's by spill t at most, their t
by as much for each row, and their decay plus room t is positive definite, with their
own t. The multipliers exclude that it is.
"""

from itertools import product

from .arithmetic import need
from .delays import Delay
from .plants import vertex_of
from .text import number

PART = """whole = span E.{v} dual
off = norm(whole - I({N}))
regular: 1 - off > 0
eta = norm(span A.{v} dual - spectrum whole)/(1 - off)
sign.gap: gap > 0
h = ({k} + 3) eta/gap
small.h: 1 - h >= 0
first = [I({k}), O({k}, {r})]
rest = [O({r}, {k}), I({r})]
E.{s} = I({k})
A.{s} = first spectrum first'
Bu.{s} = push
far.A = (1 + h) eta
far.B = norm(first span Bu.{v} - push) + h norm(rest span Bu.{v})
kappa = alpha/tau"""
APART = "apart.{0}.{1}: ({2} - {4})^2 + ({3} - {5})^2 - gap^2 > 0"
MARGIN = """forward.i.f: factor.f > 0
off.A = tau far.A norm(left) norm(inv(left))
off.B = factor.f tau scale far.B norm(left)
turn = kappa (A inv(E))'
back.turn = norm(inv(I({k}) + turn))
turns.i.f: 1 - back.turn kappa off.A > 0
even = (1 + m)/(e2 kappa)
skew = back.turn/(1 - back.turn kappa off.A) \
(2/e2 + even (1 + norm(turn) + kappa off.A))
back.B = norm(inv(B' B) B')
moves.i.f: 1 - back.B off.B > 0
spill = (2 + kappa) e2 off.A (even + skew) \
+ ({late}) (1 + kappa) 2 back.B off.B/(e2 (1 - back.B off.B))
room.i.f: room (1 - rows(block) spill) - spill > 0
decay.i.f: block + room (tr(block) + tr(P) + e1 tr(S) + tr(R1) + tr(R3){Z}) > 0"""


class Modes(Delay):
    """Multipliers for a part of one vertex, which is an additional vertex here."""

    def _plant(self):
        """Write the plant, and the part beside it."""
        super()._plant()
        t, d = self.t, self.d
        design = d["K"] is None and d["method"] in ("functional", "shift")
        need(design and not self.printed, "modes are those of a design")
        v, N, s = vertex_of(t, d["vertex"]), self.N, self.many + 1
        self.N = k = len(d["push"])
        for name, key in (("span", "rows"), ("dual", "columns")):
            t.put(name, d, key, (N, N))
        t.put("push", d, "push", (k, self.m))
        for name in ("gap", "room"):
            t.put_number(name, d, name)
        t.data["spectrum"], ends = blocks(d["spectrum"], N)
        need(k in ends, "the part ends within a block")
        form = dict(v=v, N=N, k=k, r=N - k, s=s)
        t.write(*PART.format(**form).split("\n"))
        a, b = ("at(spectrum, {0}, {0})", "at(spectrum, {1}, {0})")
        places = list(zip([1, *(e + 1 for e in ends)], ends))
        sizes = [(a.format(i), b.format(i, j) if j > i else "0") for i, j in places]
        inside = ends.index(k) + 1
        for i, j in product(range(inside), range(inside, len(ends))):
            t.write(APART.format(i + 1, j + 1, *sizes[i], *sizes[j]))
        return [s - 1]

    def decay(self, label="decay", tail=""):
        """The block, made larger by what the part may differ by."""
        block = self.lines.pop().removeprefix("decay.i.f: ").removesuffix(" > 0")
        form = dict(k=self.N, late="e2 + 1" if self.mu else "e2")
        margin = MARGIN.format(**form, Z=" + tr(Z)" * (self.mu > 0))
        self.lines += [f"block = {block}", *margin.split("\n")]
        super().decay(label, tail)


def blocks(several, N):
    """The matrix of blocks [a, -b; b, a], or a where b is zero, and where each ends."""
    rows, ends = [["0"] * N for _ in range(N)], []
    for a, b in several:
        i = ends[-1] if ends else 0
        pair = number(b) != 0
        need(number(b) >= 0 and i + pair < N, "blocks that don't fit")
        rows[i][i] = a
        if pair:
            rows[i + 1][i + 1], rows[i + 1][i] = a, b
            rows[i][i + 1] = f"-{b}"
        ends.append(i + 1 + pair)
    need(ends and ends[-1] == N, "blocks that don't fit")
    return rows, ends
