r"""Motions of all plants of a cell: those of its corners, and how far others are off.

**Theorem.** Let :math:`F = \sum w_i F_i + D` with weights :math:`w_i \ge 0` of sum one
and :math:`D^\top D \le W` be the loop of a plant, and :math:`|F d| \le |d| / s` for
every d in the norm used here. For any sequences :math:`p_k^i`, the motion
:math:`x_{k+1} = F x_k` differs from :math:`p_k = \sum w_i p_k^i` by at most
:math:`e_k`, where :math:`|x_0 - p_0| \le e_0` and :math:`e_{k+1} = e_k / s + \delta_k`
with

.. math::

    \delta_k = \max_i |p_{k+1}^i - F_i p_k^i|
    + \max \sum_{i < j} w_i w_j |(F_i - F_j)(p_k^i - p_k^j)|
    + \max_i \sqrt{(p_k^i)^\top W p_k^i} .

*Proof.* x - p moves by F and is pushed by F p_k - p_{k+1}, which is the sum of
w_i (F_i p_k^i - p_{k+1}^i), of D p_k and, since sum_ij w_i w_j F_i (p^j - p^i) counts
each pair twice, of -w_i w_j (F_i - F_j)(p^i - p^j). []

So an output is, at each tick, at most the largest of the corners' own plus what e_k is
worth; e_k is of second order in the size of the cell, and zero but for roundings of one
plant. The p_k^i are the corners' motions in floats; what they leave is in balls.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..sampled.balls import balls, balls_of, middle, product, solve

SAFE = 1 + 1e-9  # more than what sums of 1e6 positive floats lose
TINY = 1e-150  # whose square is still a float
NEAR = 1.005  # of the least bound: then no more ticks are looked at


@dataclass(frozen=True, eq=False)
class Sizes:
    """The sizes of motions, as floats: see `Sizes.of` and `Sizes.bounds`.

    ``seen``, (corners, ticks): |h p|; ``lengths``, (corners, ticks): |p|; ``left``,
    (ticks,): delta of the theorem; ``gain``: the largest |h d| for |d| = 1.
    """

    seen: np.ndarray
    lengths: np.ndarray
    left: np.ndarray
    gain: float

    @classmethod
    def of(cls, motions, L, loops, bent, row, norms, times):
        """Those of ``motions``, (corners, ticks + 1, N, k), in the coordinates L x.

        ``loops``, ``bent``, ``row``: F_i, W (or None) and h in these coordinates;
        ``norms``: lengths of the columns of a matrix; ``times``: a product.
        """
        corners, _, N, k = motions.shape
        flat = [p.transpose(1, 0, 2).reshape(N, -1) for p in motions]
        p = [times(L, x) for x in flat]
        now, then = [x[:, :-k] for x in p], [x[:, k:] for x in p]

        def each(x):  # the columns of a tick count together
            return x.reshape(-1, k).sum(axis=1)

        pairs = list(combinations(range(corners), 2))
        own = [norms(x - times(F, y)) for F, x, y in zip(loops, then, now)]
        found = np.max(own, axis=0)
        if pairs:
            across = [
                norms(times(loops[i] - loops[j], now[i] - now[j])) for i, j in pairs
            ]
            share = (1 - 1 / corners) / 2
            found = found + np.minimum(
                np.sum(across, axis=0) / 4, share * np.max(across, axis=0)
            )
        if bent is not None:
            squares = [norms((times(bent, x) * x).sum(axis=0)[None]) for x in now]
            found = found + np.sqrt(np.max(squares, axis=0))
        return cls(
            np.array([each(norms(times(row, x))) for x in p]),
            np.array([each(norms(x)) for x in p]),
            each(found),
            float(norms(row.T)[0]),
        )

    def bounds(self, pace, first, peak):
        """(ticks + 1,) bounds of the sum of |h x_k|, or of the largest (``peak``).

        Entry n takes the first n ticks one by one and the others by the norm, in which
        x falls by ``pace`` a tick; ``first`` is e_0.
        """
        e = np.empty(len(self.left) + 1)
        e[0] = first
        for k, delta in enumerate(self.left):
            e[k + 1] = e[k] / pace + delta
        tail, off = self.lengths.max(axis=0) + e, self.gain * e
        if peak:
            most = np.maximum.accumulate(self.seen.max(axis=0) + off)
            most = np.concatenate([[0.0], most[:-1]])
            return np.maximum(most, self.gain * tail) * SAFE
        sums = (np.cumsum(self.seen, axis=1) - self.seen).max(axis=0)
        return (sums + np.cumsum(off) - off + tail / np.sqrt(1 - pace**-2.0)) * SAFE


def motions_of(loops, start, ticks):
    """(corners, ticks + 1, N, k) motions of several ``loops``, (corners, N, N), from
    one ``start``, (N, k), in floats.
    """
    F, x = np.array(loops), np.array([start] * len(loops), float)
    found = np.empty((len(F), ticks + 1, *x.shape[1:]))
    for k in range(ticks + 1):
        found[:, k] = x
        x = F @ x
    return found


def tube_bound(cell, motions, start, row, pace, peak):
    """A bound of the sum of |row x_k| over ticks k >= 0, or of the largest (``peak``),
    of every plant of a `JoinedCell`, proven in balls; infinite where none is known.

    ``motions``: the corners' in floats (see `motions_of`); ``start``, (N, k): where
    they start, in rationals; ``row``, (N,), rationals; ``pace``: by which the cell's
    norm is proven to fall a tick, from the second one on; P > h'h, too.
    """
    try:
        L, loops, bent = cell.parts
        h = solve(L.T, balls(row[:, None])).T
    except ZeroDivisionError:
        return np.inf
    known = (
        middle(L),
        list(map(middle, loops)),
        None if bent is None else middle(bent),
        middle(h),
    )
    guess = Sizes.of(motions, *known, _norms, np.matmul)
    bounds = guess.bounds(pace, 0.0, peak)[1:]
    if not np.isfinite(bounds).any():
        return np.inf
    n = 1 + int(np.argmax(bounds <= NEAR * np.nanmin(bounds)))
    first = balls(start) - balls_of(motions[0, 0])
    e_0 = float(_sure(product(L, first)).sum())
    sizes = Sizes.of(balls_of(motions[:, : n + 1]), L, loops, bent, h, _sure, product)
    found = float(sizes.bounds(pace, e_0, peak)[n])
    return found if np.isfinite(found) else np.inf


def _norms(x):
    """Lengths of the columns of floats."""
    return np.linalg.norm(x, axis=0)


def _sure(x):
    """Upper bounds of the lengths of the columns of balls, but for a few roundings."""
    most = np.array([float(e.abs_upper()) + TINY for e in x.flat])
    return np.linalg.norm(most.reshape(x.shape), axis=0)
