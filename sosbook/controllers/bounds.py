"""Rigorous bounds of outputs for every plant: of noise, ramps and steps.

Each is a sum or the largest of what the tubes of all cells of plants say, tick by tick,
and by the norm from some tick on: see `sosbook.controllers.tube`.
"""

from contextlib import suppress
from decimal import Context, Decimal
from heapq import heappop, heappush
from itertools import count

import numpy as np
from flint import arb, fmpq_mat

from ..exact.rational import exact
from ..runtime.time_limit import OutOfTime, check_time
from ..sampled.balls import balls, middle
from ..sampled.cover import cover
from ..sampled.lyapunov import discrete_lyapunov
from ..sampled.proof_file import _leaves
from ..sampled.timing import TimeBox
from .cells import Joined, work
from .modes import by_modes
from .signals import known_index
from .tube import SAFE, Tube

RATES = ((0.6, 32), (0.3, 128), (0.1, 512))  # of log(radius) to prove, and cells for it
GOOD = 1.02  # of what is true of the corners: no more halving
HARDLY = 1e-3  # that falls from tick to tick: modes first, LMIs would end undecided
LEAST = 0.01  # radius that is asked for: of loops that are at rest after some ticks
MOST_TERMS = 60_000  # that floats add
MOST_CELLS = 128  # of tubes; then any bound is taken
ENDS = (
    "output ends elsewhere for each plant, where springs push back: take one that is "
    "integrated, or a plant without them; StepBounds.effort is what u asks"
)


def four_digits(x, rounding, times=1):
    """So many ``times`` a number ``x`` in words, which decimal's ``rounding`` keeps on
    the safe side.
    """
    four = Context(prec=4, rounding=rounding)
    return f"{float(four.multiply(Decimal(repr(float(x))), times)):.4g}"


@work
def bounded_output(c, own, direct, k, start=None, peak=False):
    """A proven bound of output ``k`` (or of a row of the loop's state) of a controller
    c after impulses of several inputs, or None: the sum of |u_k| over all ticks and
    inputs.

    ``own``, ``direct``, (l, j) and (m, j): how inputs act on the memory and on u, as
    decimals; ``start``: the state (N, 1) at the start, in rationals, else what the
    inputs leave; ``peak``: the largest |u_k| instead.
    """
    output = not np.ndim(k)
    h, at_once = (outputs_of(c)[k], direct[k]) if output else (exact(k), 0 * direct[0])
    now, columns = arb(0), None
    if start is None:
        now = sum((abs(e) for e in balls(at_once)), now)
        columns = [(None, 0.0, j) for j in range(len(at_once))]
    else:
        own, direct = own[:, :0], direct[:, :0]
    ticks = ticks_of(c.radius)

    def judged(tube):
        """The bound of a tube, and by how much it is above what is good."""
        check_time()
        most = true = 0.0
        several = [tube.rest(start)] if columns is None else columns
        for one in several:
            near, off, tail = tube.motion(*one, ticks=ticks).seen(h)
            sizes = abs(near)
            if peak:
                true = max(true, sizes.max())
                most = max(most, tail, (sizes.max(axis=1) + off).max())
            else:
                seen = sizes[:-1].sum(axis=0).max()
                true = true + seen
                most = most + seen + off[:-1].sum() + tail / (1 - tube.rho)
        other = float(now.mid())
        return most * SAFE, most + other - GOOD * (true + other)

    found = of_all_plants(c, Joined(c, own, direct), judged, MOST_CELLS)
    if found is None:
        return None
    return rounded(arb(max(found)) + now, np.inf)


def of_all_plants(c, joined, judged, most):
    """The answers that ``judged`` has of `Tube`s of ``joined`` loops, which hold all
    plants of a controller c; None where the loop isn't proven to fall.

    ``judged``: from a tube to (answer, excess); tubes of the largest excess above zero
    are halved first, until there are ``most``.
    """
    if c.falling is None:
        return None
    rho, leaves = c.falling
    done, queue, number = [], [], count()

    def keep(tube, answer, excess):
        if excess <= 0 or len(tube.weights) == 1:
            done.append(answer)
        else:
            heappush(queue, (-excess, next(number), tube, answer))

    for weights, L, P in leaves:
        check_time()
        tube = Tube(joined, weights, L, P, rho)
        keep(tube, *judged(tube))
    with suppress(OutOfTime):  # all plants have an answer: more cells are sharper
        while queue and len(done) + len(queue) < most:
            halves = [(half, *judged(half)) for half in queue[0][2].halves()]
            heappop(queue)
            for half in halves:
                keep(*half)
    return [*done, *(answer for *_, answer in queue)]


@work
def proven_decay(c):
    """(rho, leaves): all motions of the loop of c fall by rho a tick, in the norms of
    the leaves (weights, L, P), in rationals; None where no rate is proven.
    """
    if not c.radius < 1:
        return None
    family = Joined(c, c.B[:, :0], c.D[:, :0]).family
    clocks = TimeBox.only(c.timing)
    sizes = _moved(c.loops[0])
    for share, budget in RATES:
        rho = float(f"{max(c.radius, LEAST) ** share:.6g}")
        if not rho < 1:
            continue
        ways = [_covered, by_modes]
        for way in ways[:: -1 if 1 - rho < HARDLY else 1]:
            if found := way(family, clocks, rho, budget, sizes):
                return rho, found
    return None


def _covered(family, clocks, rho, budget, _):
    """As `by_modes`, by `cover`."""
    tree, _ = cover(family, clocks, rho, budget)
    if tree is None:
        return None
    return [
        (w, exact(L), exact(_each(P, len(w), len(L))))
        for w, L, _, P, _ in _leaves(tree, family.shape)
    ]


def _moved(loop):
    """(N,) sizes of a ``loop``'s states after impulses of set points and noise."""
    push = np.hstack([loop.set_point, loop.noise])
    found = np.sqrt(np.diag(discrete_lyapunov(loop.F.T, push @ push.T)))
    return (
        np.where(found > 0, found, 1.0) if np.isfinite(found).all() else 0 * found + 1
    )


def _each(P, count, N):
    return np.array([np.eye(N)] * count) if P is None else P


def rounded(x, way):
    """A float that is no nearer than a ball x on the ``way`` to zero or infinity, nor
    is the decimal that it prints.
    """
    up = bool(way > x)
    end = x.upper() if up else x.lower()
    found = float(end)
    if not np.isfinite(found):
        return found
    both = arb(found), arb(exact(found))
    beyond = all(v >= end if up else v <= end for v in both)
    return found if beyond else float(np.nextafter(found, way))


def stable(c, what):
    """A ValueError, which begins with ``what`` is asked, where a loop of c isn't."""
    if not c.radius < 1:
        raise ValueError(
            f"{what} are of a stable loop, and this one isn't: its spectral radius is "
            f"{c.radius:.4g}"
        )


def at_rest(c, set_point):
    """The state where a ``set_point`` of c rests: a ValueError if none exactly is."""
    known_index("set_point", set_point, c.set_points)
    x = rest(c, set_point)
    if x is None:
        raise ValueError(
            "set_point: where it rests the output isn't exactly zero for every "
            "plant (springs push back, or a memory without integrals has rounded "
            "numbers), so what a motion asks depends on where it ends; see "
            "static(r=...)"
        )
    return x


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


def fixed_end(c, j, x, row):
    """Where a ``row`` of the loop's state ends after a step of 1 of set point j of c,
    the same for every plant, as the controller's rest and what all plants have in
    common say; x: see `rest`, or None. None where plants differ.
    """
    if x is not None:
        return (row @ x)[0]
    n, l = c.readings.rows.shape[1], c.order
    plants = [d.map(exact) for d in c.vertices]
    still = [
        k
        for k in range(len(plants[0].A))
        if not plants[0].Bu[k].any() and all((d.A[k] == plants[0].A[k]).all()
                                             and not d.Bu[k].any() for d in plants)
    ]  # fmt: skip
    rests = np.hstack([plants[0].A[still], exact(np.zeros((len(still), l)))])
    seen = -(exact(c.B) @ exact(c.readings.rows))
    own = np.hstack([seen, exact(np.eye(l)) - exact(c.A)])  # times [x; xi] is B_r r
    known = np.vstack([rests, own]).T
    pushed = np.concatenate([exact(np.zeros(len(still))), exact(c.B_r)[:, j]])
    wanted = np.concatenate([row[:n], row[len(row) - l :]])[:, None]
    both, rank = fmpq_mat(np.hstack([known, wanted]).tolist()).rref()
    rows = np.array(both.tolist(), object)[:rank]
    first = [int(np.flatnonzero(r)[0]) for r in rows]
    if known.shape[1] in first:
        return None
    return sum((r[-1] * pushed[k] for r, k in zip(rows, first)), exact(0))


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


def root(P):
    """L with L'L near P, in floats; None where floats see no positive definite P."""
    with suppress(np.linalg.LinAlgError):
        return np.linalg.cholesky(P).T
    return None
