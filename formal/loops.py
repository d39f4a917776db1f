"""A plant with a gain or a law: its numbers, its pencils, and what Rocq reads."""

from fractions import Fraction

from formal.common import constant, denominator, literal, plus, product, times, zeros

NAMES = {"second order": "MDSB", "descriptor": "EAB"}


class Loop:
    """A loop of u = K x, with K_A z'' in u, in the numbers that a file has."""

    def __init__(self, file):
        plant = file["plant"]
        self.K, self.U, self.K_A = file["K"], file["U"], file["K_A"] or []
        self.vertices, self.plant = plant["vertices"], plant["kind"]
        self.names = NAMES[self.plant]
        self.n, self.p = len(self.vertices[0][self.names[0]]), len(self.U)
        self.m = len(self.vertices[0]["B"][0])
        self.mechanical = self.plant == "second order"
        self.own = "mechanics" if self.mechanical else "descriptor"
        self.head = self.kind = self.own  # the theory, and the theorem's name
        self.gains = ("U", "K_A", "K") if self.mechanical else ("K",)

    @property
    def N(self):
        return 2 * self.n + self.p if self.mechanical else self.n

    def pencils(self):
        """d, e and the pencils of the theorems: integers, the plant's times d e."""
        d = denominator(self.U, *(v[x] for v in self.vertices for x in self.names))
        e, n = denominator(self.K, self.K_A), self.n
        K, U, pencils = times(e, self.K), times(d, self.U), []
        K_A = times(e, self.K_A) or zeros(self.m, n)
        for v in self.vertices:
            B = times(d, v["B"])
            BK = product(B, K) if K else zeros(n, self.N)
            if not self.mechanical:
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

    def text(self):
        """The definitions of the plant's matrices and of the gains."""
        text = []
        for i, v in enumerate(self.vertices, 1):
            numbers = "\n ".join(literal(v[x]) for x in self.names)
            words = f"({self.own.title()} {numbers})%Q"
            text.append(constant(f"vertex_{i}", f"{self.own}.{self.own}", words))
        for x in self.gains:
            text.append(constant(x, "numbers", f"{literal(getattr(self, x))}%Q"))
        return text

    def stated(self, who):
        """The arguments of `mechanics_poles_in` or `descriptor_poles_in`."""
        if self.mechanical:
            return f"{self.n} {self.m} {self.p} {vertices(who)} (Law U K_A K)"
        return f"{self.n} {self.m} {vertices(who)} K"


def vertices(who):
    return "[:: " + "; ".join(f"vertex_{i + 1}" for i in who) + "]"


class WithLaw(Loop):
    """The same with a law's own states, as `with_law` of laws.v joins them."""

    PARTS = "rows", "E", "A", "B", "of_sensors", "of_states"

    def __init__(self, file):
        super().__init__(file)
        law = self.law = file["law"]
        self.kind, self.head = "descriptor", "mechanics laws"
        self.c, self.q, self.y = len(law["E"]), len(law["rows"]), len(law["signals"])
        self.f, self.gains = len(self.K) - self.m, self.gains[:-1]

    def pencils(self):
        N, c, f, law, zero = self.N, self.c, self.f, self.law, zeros
        form = Loop(dict(plant=self.first_order(), K=[], U=[], K_A=None))
        rows = exact(law["rows"])
        seen = [
            product(exact(law[x]), rows) if law[x] else [] for x in ("B", "of_sensors")
        ]
        joined = [dict(
            E=four(exact(v["E"]), zero(N, c), zero(c, N), exact(law["E"])),
            A=four(exact(v["A"]), zero(N, c), seen[0], exact(law["A"])),
            B=four(exact(v["B"]), zero(N, f), zero(c, self.m),
                   zero(c - f, f) + unit(f)),
        ) for v in form.vertices]  # fmt: skip
        form.vertices, form.n = joined, N + c
        form.K = product(exact(self.K), four(seen[1], exact(law["of_states"])))
        return form.pencils()

    def first_order(self):
        """The plant in descriptor form, as `first_order` of laws.v computes it."""
        n, p, m, zero = self.n, self.p, self.m, zeros
        if not self.mechanical:
            return {"kind": "descriptor", "vertices": self.vertices}
        form = []
        for v in self.vertices:
            M, D, S, B = (exact(v[x]) for x in "MDSB")
            if self.K_A:
                M = plus(M, product(B, [[-a for a in row] for row in exact(self.K_A)]))
            D, S = ([[-a for a in row] for row in x] for x in (D, S))
            E = four(unit(n), zero(n, n), zero(n, n), M)
            A = four(zero(n, n), unit(n), S, D)
            form.append(dict(
                E=four(E, zero(2 * n, p), zero(p, 2 * n), unit(p)),
                A=four(A, zero(2 * n, p), four(exact(self.U), zero(p, n)), zero(p, p)),
                B=zero(n, m) + B + zero(p, m),
            ))  # fmt: skip
        return {"kind": "descriptor", "vertices": form}

    def text(self):
        parts = " ".join(f"\n {literal(self.law[x])}" for x in self.PARTS)
        words = f"(Controller {parts}\n {literal(self.K)})%Q"
        return [*super().text(), constant("own", "controller", words)]

    def stated(self, who):
        size = f"{self.N} {self.m} {self.c} {self.f} {self.q}"
        plant = f"(first_order {self.n} {self.m} {self.p} U K_A v)"
        form = f"with_law {size} own {plant if self.mechanical else 'v'}"
        gain = f"(law_gain {size} {self.y} own)"
        every = f"[seq {form} | v <- {vertices(who)}]"
        return f"{self.N + self.c} {self.m + self.f} {every} {gain}"


def exact(matrix):
    return [list(map(Fraction, row)) for row in matrix]


def unit(n):
    return [[int(i == j) for j in range(n)] for i in range(n)]


def four(a, b, c=(), d=()):
    """[a, b; c, d]"""
    return [r + s for x, y in ((a, b), (c, d)) for r, s in zip(x, y)]
