r"""Rigorous bounds of the output for every plant: of noise, ramps and steps.

**Lemma.** If :math:`r^2 F^\top P F \le P - h^\top h` for some r > 1 then
:math:`\sum_k |h F^k g| \le \sqrt{g^\top P g / (1 - r^{-2})}` and each term is at most
:math:`\sqrt{g^\top P g}`.

*Proof.* x'Px - r^2 (Fx)'P(Fx) >= (h x)^2; weigh by r^(2k) along x_k = F^k g and add:
sum r^(2k) (h x_k)^2 <= g'Pg. By Cauchy and Schwarz with the weights r^-k. []

For one exponential it is sharp. The first terms are enclosed by themselves, near those
of the corners: see `sosbook.controllers.tube`.
"""

from contextlib import suppress
from decimal import Context

import numpy as np
from flint import arb, fmpq_mat
from scipy.linalg import matrix_balance

from ..exact.rational import exact, round_digits
from ..language import Unknown
from ..lmi.problem import LMIProblem
from ..lmi.text import LMIText
from ..runtime.time_limit import check_time
from ..sampled.balls import balls, middle
from ..sampled.cells import least_pivot
from ..sampled.lyapunov import discrete_lyapunov
from ..solver.loop import Unbounded
from .cells import Joined, work
from .tube import motions_of, tube_bound

SPREADS = tuple(np.linspace(0.1, 0.9, 9))  # of log r, from 1 to what the loop allows
HEADS = (0, 10, 25)  # terms that are enclosed by themselves
USED = 0.8  # of log r of the matrix P: the rest is room for other plants
ROOM = 1.1  # of P beyond its equation's: room for other plants, too
GAP = 1e-3  # to the least bound of P
ATTAINED = 1e-3  # of the weight, in every direction: so that there is a least P
MARGINS = (1e-3, 0.02, 0.1)  # of the room that r leaves in P: for the other plants
WHOLE = 0.05  # of what P says of the start, in every direction: room, too
GOOD = 1.2, 1.02  # of what is true of the corners, a sum or a peak: no more halving
MOST_TERMS = 30_000  # that floats add
MOST_CELLS = 32  # looked at; each has an LMI or three
LAST_CELLS = 1024  # where some have no bound at all


def four_digits(x, rounding):
    """A number ``x`` in words, which decimal's ``rounding`` keeps on the safe side."""
    return f"{float(Context(prec=4, rounding=rounding).create_decimal(float(x))):.4g}"


@work
def bounded_output(c, own, direct, k, start=None, peak=False):
    """A proven bound of output ``k`` (or of a row of the loop's state) of a controller
    c after impulses of several inputs, or None: the sum of |u_k| over all ticks and
    inputs.

    ``own``, ``direct``, (l, j) and (m, j): how inputs act on the memory and on u, as
    decimals; ``start``: the states (N, j) at the start, in rationals, else what the
    inputs leave; ``peak``: the largest |u_k| of one input instead. After ``MOST_CELLS``
    cells any bound of a cell is taken, and only what has none is halved, up to
    ``LAST_CELLS``, or until the time in force is over.
    """
    joined = Joined(c, own, direct)
    alone = Joined(c, own[:, :0], direct[:, :0])  # no input weighs on its loops
    output = not np.ndim(k)
    h, at_once = (outputs_of(c)[k], direct[k]) if output else (exact(k), 0 * direct[0])
    queue, worst, most, count = [joined.family.shape.whole()], 0.0, 0.0, 0
    while queue:
        check_time()
        weights = queue.pop()
        found, true = _cell(joined, alone, weights, h, at_once, start, peak)
        count, most = count + 1, max(most, true)
        if not np.isfinite(true):  # a corner's loop is unstable
            return None
        alone_here = len(weights) == 1
        last = alone_here or count + len(queue) >= MOST_CELLS
        if found <= GOOD[peak] * most or (last and np.isfinite(found)):
            worst = max(worst, found)
        elif alone_here or count + len(queue) >= LAST_CELLS:
            return None
        else:
            queue += joined.family.shape.halves(weights, longest_cut(joined, weights))
    return worst


def rounded(x, way):
    """A float that is no nearer than a ball x on the ``way`` to zero or infinity."""
    end = x.upper() if way > x else x.lower()
    found = float(end)
    return found if arb(found) == end else float(np.nextafter(found, way))


def rest(c, j):
    """The state of the loop of c at rest at one unit of set point j, of every plant: in
    rationals (N, 1), proven that no plant is pushed there and the controller asks
    nothing. None where springs push back, or rounded numbers leave a rest that isn't
    exactly so.
    """
    seen, n = exact(c.readings.rows), c.readings.rows.shape[1]
    A, B, C, D = (exact(m) for m in (c.A, c.B, c.C, c.D))
    still = np.vstack([d.map(exact).A for d in c.vertices])
    left = np.block(
        [
            [still, exact(np.zeros((len(still), len(A))))],
            [-(B @ seen), exact(np.eye(len(A))) - A],
            [D @ seen, C],
        ]
    )
    pushed = exact(np.vstack([c.B_r, -c.D_r])[:, [j]])
    found = _solved(left, np.vstack([exact(np.zeros((len(still), 1))), pushed]))
    if found is None:
        return None
    x, xi = found[:n], found[n:]
    older = exact(np.zeros((len(c.loops[0].F) - len(x) - len(xi), 1)))
    return np.vstack([x, older, xi])


def _solved(left, right):
    """A rational solution of left x = right with more rows than columns, or None."""
    both = fmpq_mat(np.hstack([left, right]).tolist())
    reduced, rank = both.rref()
    n = left.shape[1]
    rows = np.array(reduced.tolist(), object)[:rank]
    if rank != n or any(rows[k, k] != 1 for k in range(n)):
        return None
    return rows[:, n:]


def settled(loop):
    """After how many ticks a ``loop`` has a millionth left of an impulse."""
    return ticks_of(loop.radius)


def ticks_of(radius):
    """After how many ticks loops of a spectral ``radius`` have a millionth left."""
    return min(MOST_TERMS, int(np.log(1e-6) / np.log(min(radius, 0.999999))) + 2)


def sizes_of(loop, G, direct, output):
    """(ticks, k) sizes of an ``output`` of a ``loop`` after impulses by G and
    ``direct`` (see `Loop.impulses`); infinite if unstable.
    """
    if loop.radius >= 1:
        return np.full((1, G.shape[1]), np.inf)
    return abs(loop.impulses(G, direct, settled(loop)))[:, output]


def outputs_of(c):
    """The rows, rationals, that pick c's outputs from the state of its loop."""
    seen, C = exact(c.D) @ exact(c.readings.rows), exact(c.C)
    older = c.timing.n_past_inputs * len(C)
    return np.hstack([seen, exact(np.zeros((len(C), older))), C])


def longest_cut(joined, weights):
    """The longest edge of a cell of ``joined`` loops, by its corners' ``weights``."""
    F = [middle(joined.family.loop(w, joined.controller.timing)) for w in weights]
    shape = joined.family.shape
    if shape.axes:
        stack = np.array(F)
        ends = [shape.along(stack, axis) for axis in range(shape.axes)]
        return int(np.argmax([abs(high - low).max() for low, high in ends]))
    far = np.array([[np.linalg.norm(a - b) for a in F] for b in F])
    if not far.any():
        w = weights.astype(float)
        far = np.linalg.norm(w[:, None] - w[None], axis=2)
    return tuple(int(x) for x in np.unravel_index(far.argmax(), far.shape))


def _cell(joined, alone, weights, h, at_once, start, peak):
    """(bound, what is true of the corners in floats) of one cell."""
    j, timing = joined.inputs, joined.controller.timing
    wholes = [middle(joined.family.loop(w, timing)) for w in weights]
    loops = [F[:-j, :-j] for F in wholes]
    radii = [abs(np.linalg.eigvals(F)).max() for F in loops]
    slow, radius = int(np.argmax(radii)), max(radii)
    if not radius < 1:
        return np.inf, np.inf
    now = arb(0)
    if start is None:
        start, first = exact(np.eye(len(wholes[0]))[:, -j:]), wholes[slow][:-j, -j:]
        now = sum((abs(e) for e in balls(at_once)), now)
    else:
        start = np.vstack([start, exact(np.zeros((j, start.shape[1])))])
        first = start[:-j].astype(float)
    row = np.concatenate([h, exact(np.zeros(j))])
    motions = motions_of(wholes, start, ticks_of(radius) if radius else 1)
    seen = abs(row.astype(float) @ motions).sum(axis=2)
    true = float(seen.max() if peak else seen.sum(axis=1).max() + float(now.mid()))
    P, r, head = _best(loops[slow], first, row[:-j].astype(float), float(now.mid()))
    if P is None:
        return np.inf, true
    used, head = (1.0, 0) if peak else (r**USED, head)
    G = np.linalg.matrix_power(loops[slow], head) @ first
    for margin in MARGINS:
        L = _common(P, loops, h.astype(float), margin * (1 - r**-2), used, G, peak)
        if L is None:
            continue
        Lx, H = balls(L), balls(h[None])
        left = Lx.T @ Lx - H.T @ H
        R = Lx.T @ Lx if peak else left / arb(float(used)) ** 2
        if not least_pivot(left) > 0 or not alone.cell(weights, L).least(R) > 0:
            continue
        wide = np.eye(len(L) + j)
        wide[:-j, :-j] = L
        found = tube_bound(joined.cell(weights, wide), motions, start, row, used, peak)
        return rounded(arb(found) + now, np.inf), true
    return np.inf, true


def _common(P, loops, h, margin, used, G, peak):
    """L, of 12 digits, whose L'L is a P of the lemma for some loops at once, with room;
    None where none is found.
    """
    L = root(P)
    if L is None:
        return None
    back = np.linalg.inv(L)
    inside, row = [L @ F @ back for F in loops], h @ back

    def write(values, number):
        X, seen = values["X"], number(np.outer(row, row))
        falls = {
            f"loop {k}": (X if peak else X - seen) * number(used**-2)
            - number(F.T) @ X @ number(F)
            - number(margin * np.eye(len(P)))
            for k, F in enumerate(inside)
        }
        return {"X": X - seen if peak else X} | falls

    X = Unknown("X", len(P), symmetric=True)
    problem = LMIProblem(LMIText(write, [X]))
    W = L @ G @ G.T @ L.T
    W = W / np.trace(W) + ATTAINED * np.eye(len(P))
    found = problem.find(refuse=False).values
    if found is not None:
        with suppress(Unbounded):
            found = problem.minimize(W @ X, GAP, found).values
    inner = None if found is None else root(found["X"])
    return None if inner is None else round_digits(inner @ L, 12)


def root(P):
    """L with L'L near P, in floats; None where floats see no positive definite P."""
    with suppress(np.linalg.LinAlgError):
        return np.linalg.cholesky(P).T
    return None


def _best(F, G, h, direct):
    """P, r and the number of first terms for which the sum is least, in floats; None
    for each where no P is finite.
    """
    radius = abs(np.linalg.eigvals(F)).max()
    units = matrix_balance(F, permute=False, separate=True)[1][0] ** -2.0
    best, least = (None,) * 3, np.inf
    for share in SPREADS:
        r = radius**-share
        P = discrete_lyapunov(r * F, np.outer(h, h))
        rest = discrete_lyapunov(r * F, np.diag(units))
        if not (np.isfinite(P).all() and np.isfinite(rest).all()):
            continue
        x, total = G, direct
        for head in range(max(HEADS) + 1):
            if head in HEADS:
                sizes, others = (np.trace(x.T @ X @ x) for X in (P, rest))
                whole = ROOM * P + (WHOLE * sizes / others) * rest
                tails = np.sqrt(np.einsum("ij,ik,kj->j", x, whole, x).clip(0))
                bound = total + tails.sum() / np.sqrt(1 - r ** (-2 * USED))
                if bound < least:
                    best, least = (whole, r, head), bound
            total += abs(h @ x).sum()
            x = F @ x
    return best
