"""An input bound that is too small: matrices that are known within bounds.

Complex matrices c are real ones, [Re c, -Im c; Im c, Re c].
"""

from fractions import Fraction
from math import lcm

from .arithmetic import Mat, definite, eye, need, zeros
from .designs import Design
from .plants import plant, vertex_of
from .regions import region
from .requirements import STABILITY
from .text import Text, mat, positive


class SmallInput:
    """The LMIs of some modes' part of the plant exclude each other.

    If W A = L W E, the LMIs hold for p = V P V*, y = Y V*, V = W E, with L, W B and
    V x0. Here W = [1 X] T, and entry by entry |X| <= spread, |L - L0| <= blur.
    With K = T A R and J = T E R the equations for X and L, by blocks, are

        L = K11 + X K21 - L (J11 - 1) - L X J21,
        X K22 - L X J22 = L J12 - K12.

    Divided by the differences of the diagonals of K22 and K11 they map these
    bounds into themselves: a fixed point exists (Brouwer).
    """

    def __init__(self, d):
        """Enclose a part of the plant, and write the block of its multipliers."""
        design = Design(d)
        t = self.t = Text({k: x for k, x in d.items() if k != "multipliers"})
        _, N, m, _ = plant(t, d)
        need(d["K"] is None, "the gain must be free")
        need(not design.slack, "this proof is for a common P")
        bounds = [r for r in design.asked if r["kind"] == "input"]
        one = len(bounds) == 1 and "u" not in bounds[0]
        need(one, "requirements: this proof is for one bound of u")
        (bound,) = bounds
        need(bound["acceleration"] is False, "this proof is for a bound of K x")
        vertex, k = vertex_of(t, d["vertex"]), len(d["spread"])
        need(0 < k < N, "the part must be smaller than the plant")
        env, self.k, self.N = t.values(), k, N
        E, A, B = (env[f"{x}.{vertex}"] for x in ("E", "A", "Bu"))
        x0 = mat([[e] for e in bound["x0"]], N, 1, name="x0")
        L, F_of, blur, spread = self._enclosed(d, E, A, real(B), real(E @ x0))
        S, F = self._multiplied(d, design)
        push, begin = F_of
        # the sum of <G, z> over the regions is -tr(Q p) - 2 Re tr(f y)
        FL, f = F @ L, F @ part(push, 0, k, 0, m)
        Q = S + FL + FL.T
        Q_blur = sizes_of(F) @ blur
        Q_blur = Q_blur + Q_blur.T
        f_blur = sizes_of(F) @ spread @ sizes_of(part(push, k, N - k, 0, m))
        U, price = (complex_of(d[x], n, x) for x, n in (("share", k), ("price", m)))
        room = [*sums(f_blur), *sums(f_blur.T)]
        (a, b), (c, e), (f1, f2), (g1, g2) = map(halves, (U, price, f, f.T))
        whole = real_form(table([[a, f1], [g1, c]]), table([[b, f2], [g2, e]]))
        good = definite(whole + diagonal(room * 2).times(-1), semi=True)
        need(good, "the multiplier of u_max isn't positive")
        D = Q + U.times(-1) + diagonal(sums(Q_blur) * 2).times(-1)
        need(definite(D, semi=True), "the multiplier of x0 isn't positive")
        h = part(begin, 0, k, 0, 1).cut(0, 2 * k, 0, 1)
        force = D @ h
        spill = spread @ sizes_of(part(begin, k, N - k, 0, 1))
        least = h.dot(force) - 2 * sum(
            (abs(force.at(i, 0)) + abs(force.at(k + i, 0))) * spill.at(i, 0)
            for i in range(k)
        )
        paid = sum(price.at(i, i) for i in range(m))
        good = positive(bound["u_max"]) ** 2 * paid < least
        need(good, "the multipliers exclude nothing")
        which = f"no gain and no matrices prove by these LMIs{design.where}: "
        self.claims = [which + "; ".join(design.claims)]

    def _enclosed(self, d, E, A, B, start):
        """L0, T B and T E x0, and the bounds, which map into themselves."""
        k, N = self.k, self.N
        r = N - k
        spread = mat(d["spread"], k, r, name="spread")
        blur = mat(d["blur"], k, k, name="blur")
        need(min(map(min, spread.a + blur.a)) >= 0, "a bound is negative")
        T, R = (complex_of(d[x], N, x) for x in ("rows", "columns"))
        K, J = (between(T, x, R) for x in (A, E))
        off = J + eye(2 * N).times(-1)
        need(max(sums(sizes_of(off))) < 1, "the columns aren't near an inverse")
        L = part(K, 0, k, 0, k)
        own, beside = split(sizes_of(L))
        _, beside_rest = split(sizes_of(part(K, k, r, k, r)))
        error = L @ part(J, 0, k, k, r) + part(K, 0, k, k, r).times(-1)
        far = sizes_of(L) + blur
        low = sizes_of(part(off, k, r, 0, k))
        new_blur = spread @ sizes_of(part(K, k, r, 0, k)) + far @ spread @ low
        new_blur = new_blur + far @ sizes_of(part(off, 0, k, 0, k))
        new = sizes_of(error) + blur @ sizes_of(part(J, 0, k, k, r))
        new = new + spread @ beside_rest
        new = new + (beside + blur) @ spread @ sizes_of(part(J, k, r, k, r))
        new = new + own @ spread @ sizes_of(part(off, k, r, k, r))
        re, im = halves(K)
        for i in range(k):
            for j in range(r):
                gap = max(abs(x.at(k + j, k + j) - x.at(i, i)) for x in (re, im))
                good = new.at(i, j) <= gap * spread.at(i, j)
                need(good, "the part isn't enclosed")
            good = all(new_blur.at(i, j) <= blur.at(i, j) for j in range(k))
            need(good, "the part isn't enclosed")
        return L, (T @ B, T @ start), blur, spread

    def _multiplied(self, d, design):
        """The sums of alpha and of beta, weighted by the regions' multipliers z."""
        k = self.k
        asked = {(r["kind"], r["name"]): r for r in design.asked}
        asked = {key: r for key, r in asked.items() if key[0] == "region"}
        asked["stability", "stability"] = STABILITY | {"kind": "region"}
        S = F = zeros(2 * k, 2 * k)
        for key, pair in d["multipliers"]:
            name = key if isinstance(key, str) else tuple(key)
            need(
                name in asked, f"multipliers: nothing is asked of {key!r:.40}, or twice"
            )
            alpha, beta, _ = region(asked.pop(name))
            z = complex_of(pair, len(alpha) * k, "multipliers")
            need(definite(z, semi=True), f"the multiplier of {key} isn't positive")
            for i, (a, b) in enumerate(zip(alpha, beta)):
                for j in range(len(a)):
                    z_ji = part(z, j * k, k, i * k, k)
                    S, F = S + z_ji.times(a[j]), F + z_ji.times(b[j])
        return S, F


def table(blocks):
    """The matrix of blocks, over one denominator."""
    d = lcm(*(x.d for row in blocks for x in row))
    rows = [[d // x.d * e for x in row for e in x.a[i]]
            for row in blocks for i in range(row[0].r)]  # fmt: skip
    return Mat(len(rows), sum(x.c for x in blocks[0]), rows, d)


def real_form(re, im):
    return table([[re, im.times(-1)], [im, re]])


def real(x):
    return real_form(x, zeros(x.r, x.c))


def between(T, x, R):
    """T x R of a real x: a quarter of what its real form would ask."""
    (a, b), (c, e) = halves(T), halves(R)
    a, b = a @ x, b @ x
    return real_form(a @ c + (b @ e).times(-1), a @ e + b @ c)


def complex_of(pair, n, name):
    """A square matrix of n complex rows, from its real and its imaginary part."""
    return real_form(*(mat(x, n, n, name=name) for x in pair))


def halves(x):
    """Real and imaginary part of a complex matrix in its real form."""
    r, c = x.r // 2, x.c // 2
    return x.cut(0, r, 0, c), x.cut(r, r, 0, c)


def part(x, i, r, j, c):
    """A block of a complex matrix."""
    return real_form(*(y.cut(i, r, j, c) for y in halves(x)))


def sizes_of(x):
    """A bound of the size of each complex entry."""
    re, im = (Mat(y.r, y.c, [[abs(e) for e in u] for u in y.a], y.d) for y in halves(x))
    return re + im


def split(x):
    """The diagonal, and what is beside it."""
    own = diagonal([x.at(i, i) for i in range(x.r)])
    return own, x + own.times(-1)


def sums(x):
    return [Fraction(sum(u), x.d) for u in x.a]


def diagonal(entries):
    d = lcm(*(e.denominator for e in entries))
    n, numbers = len(entries), [int(e * d) for e in entries]
    return Mat(n, n, [[e if i == j else 0 for j in range(n)]
                      for i, e in enumerate(numbers)], d)  # fmt: skip
