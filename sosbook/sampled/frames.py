"""The search for what a sampled proof's text needs beside L, P and G.

Floats only suggest it: which coordinates of the plant keep a tick's third order small,
how fast its motions grow there at most, and which share of a block is W's. Where cells
of the text must be smaller than those that were found, they are halved again. The
theorem is that of `sosbook.exact.checker.sampled`.
"""

from itertools import product
from math import sqrt

import numpy as np

from ..exact.checker.arithmetic import Beyond, Refused
from ..exact.definite import round_digits
from ..exact.rational import decimal, decimals
from ..runtime.time_limit import check_time
from .in_floats import LONGEST, Numbers, norm

__all__ = ["with_frames"]

WEIGHTS = 0, 0.03, 0.1, 0.3, 1, 3, 10, 100, 1e4  # of the motion, in a frame
SCALES = 1, 0.1, 10, 0.01, 100  # of the inputs, beside the plant's states
USUAL = 1, 0.03, 1  # plain, weight, share: where one box suffices, no more are tried
BALANCES, BALANCED = 60, 1e-2  # times that rows and columns are made alike; how far
MOST_BOXES, DEEPEST = 600, 10  # that are tried; then balls decide alone
ROOM = 1e-12  # that floats must see in a block which is proven
R_DIGITS = 12


class GaveUp(Exception):
    """No cells were found that are small enough."""


def with_frames(data, shape):
    """The ``data`` of a sampled proof with what its text needs; None where that is
    not found. ``shape`` is the `PlantShape` of its cells.
    """
    asked = {k: v for k, v in data.items() if k != "undecided"} | {"kind": "sampled"}
    asked |= {"corners": shape.order if shape.axes else None, "frames": []}
    try:
        writer = _Writer(asked)
        asked["cells"] = writer.tree(data["cells"], writer.corners, None, 0)
    except (GaveUp, Beyond, Refused, np.linalg.LinAlgError):
        return None
    asked.pop("kind")
    return asked


class _Writer:
    """The writer of one proof's cells; names of matrices are those of `Ticks`."""

    def __init__(self, asked):
        self.asked, self.numbers = asked, Numbers(asked)
        self.ticks, self.corners = self.numbers.ticks, self.numbers.corners
        self.T, self.late = tuple(self.ticks.T), tuple(self.ticks.late)
        self.frames, self.style, self.tried = {}, None, 0
        self.searched = {}

    # ---- the tree of plants

    def tree(self, node, corners, above, depth):
        """The text's cells for those of a ``node``, whose L and P are ``above`` it."""
        check_time()
        own = above
        if own is None and ("L" in node or "halve" not in node):
            own = np.array(node["L"], float), node.get("P") and _arrays(node["P"])
        if "halve" not in node:
            multipliers = [None, *_multipliers(node.get("times", {}))]
            return self._leaf(corners, *own, multipliers, depth)
        halves, cut = self._halves(corners, node["halve"]), node["halve"]
        several = [own, own]
        if own is not None:
            several = [(own[0], P) for P in self._halves_of_P(own[1], cut)]
        found = [self.tree(*x, depth) for x in zip(node["halves"], halves, several)]
        return {"halve": cut, "halves": found}

    def _leaf(self, corners, L, P, multipliers, depth):
        """A leaf of the text, or halves of it."""
        times = cut = None
        styles = [self.style or USUAL] if L.tobytes() not in self.frames else []
        for style in (*styles, None):
            framed = self._frame(L, style)
            if framed is None:  # motions grow too fast in it
                continue
            frame, index = framed
            cell = self.numbers.cell(corners, frame)
            whole = style is not None and self.style is None
            times, cut = self._times(cell, P, multipliers, whole)
            if times is not None:
                break
        if times is not None:
            index = self._kept(L, frame, index)
            leaf = {"frame": index, "growth": decimal(cell.growth), "times": times}
            return leaf | ({} if P is None else {"P": decimals(P)})
        if cut is None or depth == DEEPEST:
            raise GaveUp
        several = [P, P] if P is None else self._halves_of_P(P, cut)
        halves = [self._leaf(c, L, x, multipliers, depth + 1)
                  for c, x in zip(self._halves(corners, cut), several)]  # fmt: skip
        return {"halve": cut, "halves": halves}

    def _pairs(self, many, cut):
        """Which corners a cut lies between."""
        if not self.ticks.axes:
            return [tuple(cut)]
        step = 1 << self.ticks.axes - 1 - cut
        return [(k | step, k) for k in range(many) if not k & step]

    def _halves(self, corners, cut):
        first, second = list(corners), list(corners)
        for i, j in self._pairs(len(corners), cut):
            both = sorted((corners[i], corners[j]))
            name = first[i] = second[j] = f"({'+'.join(both)})"
            for matrices in (self.numbers.e, self.numbers.x):
                if name not in matrices:
                    matrices[name] = sum(matrices[c] for c in both) / 2
        return first, second

    def _halves_of_P(self, P, cut):
        first, second = P.copy(), P.copy()
        for i, j in self._pairs(len(P), cut):
            first[i] = second[j] = round_digits((P[i] + P[j]) / 2, 17)
        return first, second

    # ---- frames

    def _kept(self, L, frame, style):
        """The number of a frame in the file."""
        key = L.tobytes()
        if key not in self.frames:
            self.frames[key] = len(self.asked["frames"]), frame
            self.style = style
            parts = {"L": decimals(L), "R": decimals(frame.R)}
            self.asked["frames"].append(parts | {"scale": decimal(frame.scale)})
        return self.frames[key][0]

    def _frame(self, L, style):
        """The frame for L, and its style, or None: see `_searched`."""
        if L.tobytes() in self.frames:
            return self.frames[L.tobytes()][1], None
        key = L.tobytes(), style
        if key not in self.searched:
            self.searched[key] = self._searched(L, style)
        return self.searched[key]

    def _searched(self, L, style):
        """The frame, of some, in which a tick's third order is smallest, and its
        style; None where it is infinite in each.

        The axes are chosen first, then the inputs' share beside them.
        """

        def tried(one, share):
            R, scale = axes[one]
            frame = self.numbers.frame(L, R, float(f"{share * scale:.3g}"))
            strain = self._strain(self.numbers.cell(self.corners, frame))
            return strain, frame, (*one, share)

        ones = product((0, 1), WEIGHTS) if style is None else [style[:2]]
        axes = {one: self._balanced(L, *one) for one in ones}
        best = np.inf, None, None
        for share in SCALES if style is None else style[2:]:
            several = [best[2][:2]] if np.isfinite(best[0]) else axes
            found = [tried(one, share) for one in several]
            best = min(best, *found, key=lambda x: x[0])
        strain, frame, style = best
        return (frame, style) if np.isfinite(strain) else None

    def _balanced(self, L, plain, weight):
        """R and scale: of L's own axes or the plant's, with rows as long as columns.

        What acts and what is reached count a thousandth, the motion its ``weight``.
        """
        N, m, T = self.ticks.N, self.ticks.m, float(self.T[1])
        base = np.eye(N) if plain else np.linalg.qr(L[:, :N])[1]
        Ri, acting = np.linalg.inv(base), self.numbers.act @ np.linalg.inv(L)
        both = self.numbers.e, self.numbers.x
        E, x = (sum(y[c] for c in self.corners) for y in both)
        X = base @ np.linalg.solve(E, x)
        G = np.vstack([np.hstack([X[:, :N] @ Ri, X[:, N:]]), np.zeros((m, N + m))])
        into = np.vstack([base @ acting[:N], acting[N : N + m] + acting[N + m :]])
        out = np.hstack([L[:, :N] @ Ri, np.zeros((len(L), m))])
        into, out = np.linalg.norm(into, axis=1), np.linalg.norm(out, axis=0)
        small = 1e-3 if weight else 1.0
        moves = (weight * T * G) ** 2
        np.fill_diagonal(moves, 0.0)
        into, out = (small * into) ** 2, (small * out) ** 2
        d, shares = np.ones(N + m), np.ones(N + m)  # squares of the units, and inverses
        moved = list(zip(moves, moves.T, into.tolist(), out.tolist()))
        for _ in range(BALANCES):
            before = d.copy()
            for i, (along, down, acts, seen) in enumerate(moved):
                row, column = float(along @ shares) + acts, float(down @ d) + seen
                if row > 0 and column > 0:
                    d[i] = sqrt(column / row)
                elif i >= N and row > 0:
                    d[i] = 1 / max(acts / small**2, 1e-60)
                shares[i] = 1 / d[i]
            if abs(d / before - 1).max() < BALANCED:
                break
        d = np.sqrt(d)
        R = round_digits(np.diag(d[:N]) @ base, R_DIGITS)
        return R, np.exp(np.log(d[N:]).mean())

    def _strain(self, cell):
        """The logarithm of the third order in cells as small as they must be."""
        T, spread = float(self.T[1]), cell.nu1 * float(self.T[1])
        plants = min(1, 0.1 / max(cell.z, spread, 1e-9)) if len(cell.corners) > 1 else 1
        half = float(self.T[1] - self.T[0]) / 2 + float(self.late[1] - self.late[0])
        clocks = min(1, 0.1 / max(half * cell.g, 1e-12))
        nu, z = spread * plants + half * cell.g * clocks, cell.z * plants
        left = nu**3 / 6 + nu * z * (nu + z) + 1e-30
        around = norm(cell.frame.out) * norm(cell.frame.inner)
        growth = cell.growth * T + np.log(around)
        if cell.growth * T > LONGEST:
            return np.inf
        return np.log(left) - 3 * np.log(plants * clocks) + growth

    # ---- clocks

    def _times(self, cell, P, multipliers, whole=False):
        """The tree of a cell's clocks, or None and where the cell of plants is cut;
        None, too, where the clocks had to be cut and a ``whole`` box is asked for.
        """

        numbers = self.numbers

        def half(T, late):
            """The tree of a box of clocks, and where it is cut if it has none."""
            if self.ticks.varies and late[0] >= T[1]:
                return {}, None
            check_time()
            self.tried += 1
            if self.tried > MOST_BOXES:
                raise GaveUp
            spans = [float(x) for x in T], [float(x) for x in late]
            ends = product(*(sorted(set(x)) for x in spans))
            at = product(ends, cell.corners)
            loops = [numbers.loop(cell.frame, c, *e) for e, c in at]
            bends, left, W = [], 0.0, None
            if cell.edges or T[0] < T[1] or late[0] < late[1]:
                bends, left, W = self.numbers.bends(cell, *spans)
            if W is not None or not bends:
                for G in multipliers if P is not None else [None]:
                    mean = None if P is None else P.mean(axis=0)
                    multiplier = mean if G is None else G
                    share, room = numbers.room(loops, W, P, multiplier)
                    if room > ROOM:
                        found = {"share": decimal(share)} if bends else {}
                        return found | ({} if G is None else {"G": decimals(G)}), None
            if whole or not bends:
                return None, None
            cut = self._cut(cell, spans, bends, left)
            if cut not in ("T", "delay"):
                return None, cut
            low, high = T if cut == "T" else late
            mid, halves = (low + high) / 2, []
            for e in ((low, mid), (mid, high)):
                found, trouble = half(*((e, late) if cut == "T" else (T, e)))
                if found is None:
                    return None, trouble
                halves.append(found)
            return {"halve": cut, "halves": halves}, None

        return half(self.T, self.late)

    def _cut(self, cell, spans, bends, left):
        """The range that is halved: T, the delay, or the plants by their cut."""
        sizes = [(np.linalg.norm(H, 2) / 4, cut) for cut, H in bends]
        plants = [x for x in sizes if x[1] not in ("T", "delay")]
        largest = max(sizes, key=lambda x: x[0])
        if left <= largest[0]:
            return largest[1]
        wide, far = (high - low for low, high in spans)
        clocks = (wide / 2 + far) * cell.g
        if plants and sum(spans[0]) / 2 * max(cell.nu, cell.z) > clocks:
            return max(plants, key=lambda x: x[0])[1]
        return "T" if wide >= far else "delay"


def _arrays(several):
    return np.array([[[float(e) for e in u] for u in x] for x in several])


def _multipliers(node):
    """The different G of a tree of clocks."""
    waiting, found = [node], []
    while waiting:
        node = waiting.pop()
        waiting += node.get("halves", [])
        if "G" in node and node["G"] not in found:
            found.append(node["G"])
    return list(_arrays(found)) if found else []
