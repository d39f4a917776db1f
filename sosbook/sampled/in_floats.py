"""A sampled proof's text in floats: what its blocks are in some frame, about.

Each method has the numbers of a part of `sosbook.exact.checker.sampled`, whose theorem
they are of; the matrices are those that `Ticks` writes.
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

import numpy as np
from scipy.linalg import expm

from ..exact.checker.text import number
from ..exact.checker.ticks import Ticks
from .cells import most_room

__all__ = ["LONGEST", "Numbers", "norm"]

SHARES = np.array([float(f"{10 ** (k / 4):.3g}") for k in range(-24, 33)])
LONGEST = 30.0  # of an exponent: the text refuses 64


@dataclass(frozen=True, eq=False)
class _Frame:
    """Coordinates L of the loop, and R and scale of the plant, with their maps."""

    L: np.ndarray
    R: np.ndarray
    scale: float
    back: np.ndarray  # from [R x; scale u] to [x; u]
    inner: np.ndarray  # from L s to what acts, in the frame
    out: np.ndarray  # from R x(k+1) to L s(k+1)
    rest: np.ndarray  # what else L s(k+1) is made of


@dataclass(frozen=True, eq=False)
class _Cell:
    """A cell of plants in a frame: its middle, and how far its plants are from it."""

    corners: list
    frame: _Frame
    one: np.ndarray
    two: np.ndarray
    growth: float
    edges: list  # (V, D, where to cut) of each
    z: float = 0.0
    nu1: float = 0.0
    nu2: float = 0.0
    nu: float = 0.0

    @property
    def g(self):
        return norm(self.one)


def norm(x):
    """As large as the text's norm of ``x`` may be, which takes a 16th power."""
    size = np.linalg.svd(x, compute_uv=False).max(initial=0.0)  # faster than its norm
    return size * max(min(x.shape), 1) ** (1 / 32)


class Numbers:
    """The matrices of a text that is asked for, and what blocks are made of them.

    ``e`` and ``x`` have E and [A B] of plants by name: corners, and means of them.
    """

    def __init__(self, asked):
        ticks, self.loops = Ticks(asked), {}
        self.ticks = ticks
        self.corners = ticks.corners
        self.rate, self.centre = (float(number(asked[x])) for x in ("rate", "centre"))
        values = ticks.t.values()
        names = ("act", "later", "first", "second")
        self.act, self.later, self.first, self.second = (
            _floats(values[x]) for x in names
        )
        self.e, self.x = (
            {i: _floats(values[f"{y}.{i}"]) for i in self.corners} for y in "ex"
        )

    def frame(self, L, R, scale):
        """The coordinates L, R and scale with their maps."""
        N, m, n = self.ticks.N, self.ticks.m, self.ticks.n
        Ri, Li = np.linalg.inv(R), np.linalg.inv(L)
        o = np.zeros((N, m))
        back = np.block([[Ri, o], [o.T, np.eye(m) / scale]])
        inner = self.act @ Li
        inner = np.vstack([R @ inner[:N], scale * inner[N:]])
        later = np.vstack([np.zeros((N, n)), self.later])
        rest = L @ later @ Li - self.centre * np.eye(n)
        return _Frame(L, R, scale, back, inner, L[:, :N] @ Ri, rest)

    def _generator(self, G, side):
        return np.vstack([G @ side, np.zeros((2 * self.ticks.m, side.shape[1]))])

    def cell(self, corners, frame):
        """The numbers of the cell between some ``corners``, in a ``frame``."""
        R, back, many = frame.R, frame.back, len(corners)
        Ri = back[: len(R), : len(R)]
        es, xs = ([y[c] for c in corners] for y in (self.e, self.x))
        E, X = sum(es) / many, sum(xs) / many
        inv = np.linalg.inv(E)
        Y = inv @ X
        one, two = (self._generator(R @ Y @ back, s) for s in (self.first, self.second))
        least = np.linalg.eigvalsh(one + one.T)[-1] / 2
        growth = float(f"{least + abs(least) * 2e-3 + 1e-6:.4g}")
        plain = _Cell(corners, frame, one, two, growth, [])
        if many == 1:
            return plain

        def away(e, x):
            Z = inv @ e
            return norm(R @ Z @ Ri), norm(R @ (inv @ x - Z @ Y) @ back)

        if self.ticks.axes:
            signs = [[(-1) ** (k & ~i).bit_count() for i in range(many)]
                     for k in range(many)]  # fmt: skip
            es, xs = ([sum(s * y for s, y in zip(row, several)) / many for row in signs]
                      for several in (es, xs))  # fmt: skip
            parts = [(k.bit_count(), *away(es[k], xs[k])) for k in range(1, many)]
            z, nu = (sum(p[i] for p in parts) for i in (1, 2))
            z1, nu1 = (sum(p[i] for p in parts if p[0] == 1) for i in (1, 2))
            nu2 = sum(p[2] for p in parts if p[0] == 2) + z1 * nu1
            steps = [1 << self.ticks.axes - 1 - a for a in range(self.ticks.axes)]
            edges = [(2 * es[k], 2 * xs[k], a) for a, k in enumerate(steps)]
        else:
            parts = [away(e - E, x - X) for e, x in zip(es, xs)]
            z, nu1 = (max(p[i] for p in parts) for i in (0, 1))
            nu, nu2 = nu1, z * nu1
            edges = [(es[b] - es[a], xs[b] - xs[a], [a, b])
                     for a, b in combinations(range(many), 2)]  # fmt: skip
        nu = nu / (1 - z) if z < 1 else np.inf
        edges = [(R @ inv @ e @ Ri, R @ inv @ (x - e @ Y) @ back, cut)
                 for e, x, cut in edges]  # fmt: skip
        return _Cell(corners, frame, one, two, growth, edges, z, nu1, nu2, nu)

    def loop(self, frame, corner, T, late):
        """F of the plant at a ``corner`` for T and ``late``, in the ``frame``."""
        key = frame, corner, T, late  # neighbouring boxes share ends
        if key not in self.loops:
            self.loops[key] = self._loop(*key)
        return self.loops[key]

    def _loop(self, frame, corner, T, late):
        X = np.linalg.solve(self.e[corner], self.x[corner])
        G = frame.R @ X @ frame.back
        flow = expm((T - late) * self._generator(G, self.second))
        if late:
            flow = flow @ expm(late * self._generator(G, self.first))
        return frame.out @ flow[: self.ticks.N] @ frame.inner + frame.rest

    def bends(self, cell, T, late):
        """The bends of a ``cell`` in the clocks between the ends ``T`` and ``late``.

        (each H and where it is cut, the third order's size, W), see the text.
        """
        frame, one, two = cell.frame, cell.one, cell.two
        t1 = (late[0] + late[1]) / 2
        t2, wide, far = (T[0] + T[1]) / 2 - t1, T[1] - T[0], late[1] - late[0]
        h1, h2, w = expm(t1 * one), expm(t2 * two), len(one)
        bends = []
        if wide:
            bends.append(("T", wide**2 / 2 * two @ two @ h2 @ h1))
        if far:
            turn = one - two
            turn = h2 @ (turn @ one - two @ turn) @ h1
            bends.append(("delay", far**2 / 2 * turn))
        for V, D, cut in cell.edges:
            flow = np.eye(3 * w)
            for span, G, side in ((t2, two, self.second), (t1, one, self.first)):
                d, v = self._generator(D, side), self._generator(-V @ D, side)
                o = 0 * G
                flow = flow @ expm(span * np.block([[G, d, v], [o, G, d], [o, o, G]]))
            bends.append((cut, flow[:w, 2 * w :]))
        N, inner = self.ticks.N, frame.inner
        bends = [(cut, frame.out @ H[:N] @ inner) for cut, H in bends]
        half, span, g = wide / 2 + far, t1 + abs(t2), cell.g
        nu1, nu2 = (half * g + span * cell.nu1, half * cell.nu1 + span * cell.nu2)
        nu = half * g + ((half + span) * cell.nu if cell.edges else 0.0)
        growth = (g if t2 < 0 else cell.growth) * span
        if not nu < 4 or growth > LONGEST:
            return bends, np.inf, None
        left = nu**3 / (6 - 1.5 * nu) + nu - nu1 - nu2 + (nu**2 - nu1**2) / 2
        rho, width = 2 * norm(frame.out) * np.exp(growth) * left, norm(inner)
        sizes = [max(norm(H) / 4, 1e-30) for _, H in bends]
        squares = sum(H.T @ H / (16 * n) for n, (_, H) in zip(sizes, bends))
        W = squares + rho / width * (inner.T @ inner)
        return bends, rho * width, (sum(sizes) + rho * width) * W

    def room(self, loops, W, P, G):
        """(the share that leaves the most room in the blocks, that room).

        The ``loops`` are at the corners, with W, P and G.
        """
        F, (n, _), r2 = np.array(loops), loops[0].shape, self.rate**2
        bent, o = W is not None and W.any(), np.zeros((n, n))
        if P is None:
            first, second = F.mT @ F, W if bent else o
            blocks = r2 * np.eye(n) - first - second
            first = first * bent
        else:
            x, GF = P[np.arange(len(F)) % len(P)], G @ F
            top = np.concatenate([r2 * x, GF.mT], axis=2)
            rest = np.concatenate([GF, G + G.T - x], axis=2)
            blocks = np.concatenate([top, rest], axis=1)
            first = np.block([[W if bent else o, o], [o, o]])[None]
            second = np.block([[o, o], [o, G @ G.T * bent]])
        return most_room(blocks, first, second, np.ones(1) if W is None else SHARES)


def _floats(x):
    rows = [[float(Fraction(e, x.d)) for e in u] for u in x.a]
    return np.array(rows, float).reshape(x.r, x.c)
