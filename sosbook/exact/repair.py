"""Float multipliers made exact: their sums over all blocks vanish in rationals.

Where most unknowns are held by few blocks, as with a slack matrix, the blocks fall
into parts that share a border of unknowns only (see `leaves`). Each part cancels
what is left of the sums for its own unknowns, and its share of what is left for the
border: so the time grows with the number of parts, and the rationals of one part
have a common denominator of their own. Where a part can't, all blocks do together.
"""

from dataclasses import dataclass
from math import inf

import numpy as np
from scipy.linalg import qr

from ..runtime.time_limit import check_time
from ..solver.blocks import Blocks, refined
from ..solver.matrix import leaves
from .adjoint import adjoint, slopes_at
from .definite import definite, exact, in_floats
from .rational import _matrix, round_digits

MOST_NUMBERS = 2e8  # of the slopes by entries that are held at once: 1.6 GB
OF_ITS_ROOM = 1e-3  # that an entry gives at most: what stays positive is checked


def repair_multipliers(expressions, unknowns, Z, digits=15, free=None):
    """Exact Z_k near floats Z with sum <G_ka, Z_k> = 0 and sum <G_k0, Z_k> <= 0.

    The ``expressions`` G_k are exact, in ``unknowns``; Z is rounded to ``digits``
    first. On the slopes of the variables ``free`` those of all others depend linearly.
    In each part only as many entries change as there are equations: those that the
    smallest eigenvalues of the Z_k leave the most room. None if they prove nothing.
    """
    Z = refined(Blocks([in_floats(g) for g in expressions], unknowns), Z)
    Z = [exact(round_digits((z + z.T) / 2, digits)) for z in Z]
    try:
        stiff = [np.linalg.inv(z.astype(float)).diagonal() for z in Z]
    except np.linalg.LinAlgError:
        return None
    if min(s.min() for s in stiff) <= 0:
        return None
    residual = adjoint(expressions, unknowns, Z)
    ways = [[_Part(range(len(expressions)), range(len(unknowns)))]]
    if free is None:
        ways[:0] = _parts(expressions, unknowns)
    for parts in ways:
        repaired = _repaired(parts, expressions, unknowns, Z, stiff, residual, free)
        if repaired is not None and all(map(_stays_positive, Z, repaired)):
            value = sum((g.constant * z).sum() for g, z in zip(expressions, repaired))
            if value <= 0:
                return repaired, value
    return None


@dataclass(frozen=True)
class _Part:
    """Blocks, and all unknowns that they hold: their indices."""

    blocks: list
    unknowns: list


def _parts(expressions, unknowns):
    """The `_Part` of each leaf with its border, where that pays: a list of one."""
    index = {u: k for k, u in enumerate(unknowns)}
    held = [
        {index[t.unknown] for t in g.terms if t.unknown in index} for g in expressions
    ]
    sizes, best, least = np.array([u.size for u in unknowns]), [], inf
    for leaf in leaves(held, len(unknowns)):
        blocks = [[] for _ in range(max(leaf) + 1)]
        for k, some in enumerate(held):
            for own in {leaf[u] for u in some} - {-1}:
                blocks[own].append(k)
        parts = [
            _Part(some, sorted(set().union(*(held[k] for k in some))))
            for some in blocks
            if some  # else nothing holds that leaf
        ]
        work = sum(float(sizes[p.unknowns].sum()) ** 3 for p in parts)
        if len(parts) > 1 and work < least:
            best, least = [parts], work
    return best


def _repaired(parts, expressions, unknowns, Z, stiff, residual, free):
    """The multipliers, changed by each part; None where one can't."""
    sharing = [sum(k in p.unknowns for p in parts) for k in range(len(unknowns))]
    ends = np.cumsum([0, *(u.size for u in unknowns)])
    own = [residual[i:j] for i, j in zip(ends, ends[1:])]
    if any(not n and (r != 0).any() for n, r in zip(sharing, own)):
        return None
    repaired = [z.copy() for z in Z]
    for p in parts:
        change = _change(
            [expressions[k] for k in p.blocks],
            [unknowns[k] for k in p.unknowns],
            [stiff[k] for k in p.blocks],
            np.concatenate([own[k] / sharing[k] for k in p.unknowns]),
            slice(None) if free is None else free,
        )
        if change is None:
            return None
        for (k, i, j), c in change:
            z = repaired[p.blocks[k]]
            z[i, j] -= c
            z[j, i] = z[i, j]
    return repaired


def _change(expressions, unknowns, stiff, residual, free):
    """Changes of few entries that make the sums equal a residual, or None.

    A list of ((block, row, column), rational). An entry that one sum alone has, as each
    of P's multiplier in P > 0, takes what is left of it: so only the other sums are
    solved together, and the rationals stay short. Floats choose the entries.
    """
    blocks = range(len(expressions))
    entries = [  # of the lower triangles, block by block
        (k, i, j) for k in blocks for i, j in zip(*np.tril_indices(len(stiff[k])))
    ]
    if len(entries) * len(residual) > MOST_NUMBERS:
        return None
    slopes = Blocks([in_floats(g) for g in expressions], unknowns).slopes
    room = np.stack(
        [
            slopes[k][:, i, j]
            / np.sqrt(stiff[k][i] * stiff[k][j])
            * (1 if i == j else 2)
            for k, i, j in entries
        ],
        axis=1,
    )[free]
    residual = residual[free]
    own = _own_entries(room, residual)
    held = (room != 0).any(axis=1)  # variables that occur in a block
    held[list(own)] = False
    lead, few = _solved_together(room, np.flatnonzero(held))
    chosen = np.sort([*few, *own.values()])
    some = [[entries[e][1:] for e in chosen if entries[e][0] == k] for k in blocks]
    exactly = np.vstack([slopes_at(g, unknowns, e) for g, e in zip(expressions, some)])[
        :, free
    ].T
    check_time()
    together, change = np.isin(chosen, few), np.empty(len(chosen), object)
    system, residual = exactly[np.ix_(lead, together)], residual[:, None]
    try:
        solved = _matrix(system).solve(_matrix(residual[lead]))
    except ZeroDivisionError:
        return None
    change[together] = solved.entries()
    left = _matrix(residual) - _matrix(exactly[:, together]) * solved
    for a, e in own.items():
        c = np.searchsorted(chosen, e)
        change[c] = left[a, 0] / exactly[a, c]
    if _matrix(exactly) * _matrix(change[:, None]) != _matrix(residual):
        return None  # floats lost a variable
    check_time()
    return [(entries[e], c) for e, c in zip(chosen, change)]


def _own_entries(room, residual):
    """From a sum's index to an entry that no other sum has, and that has the room."""
    found = {}
    alone = np.flatnonzero((room != 0).sum(axis=0) == 1)
    for a, left in enumerate(residual):
        mine = alone[room[a, alone] != 0]
        if len(mine):
            best = mine[np.abs(room[a, mine]).argmax()]
            if abs(float(left)) < OF_ITS_ROOM * abs(room[a, best]):
                found[a] = best
    return found


def _solved_together(room, sums):
    """Independent ones of the ``sums``, and as many entries with room for them."""
    if not len(sums):
        return sums, sums
    white = room[sums] / np.linalg.norm(room[sums], axis=1)[:, None]
    lengths, order = qr(white.T, mode="r", pivoting=True)
    lengths = np.abs(lengths.diagonal())
    order = order[: (lengths > 1e-10 * lengths[0]).sum()]
    lead = np.sort(sums[order])
    few = qr(white[order], mode="r", pivoting=True)[1][: len(lead)]
    return lead, np.sort(few)


def _stays_positive(near, far):
    """True if ``far`` is positive definite because ``near`` is.

    With c_i above the sum over j of |far - near|_ij w_j / w_i, near - diag(c) > 0
    implies far > 0 (Gershgorin, for any w > 0); near has short rationals.
    """
    lowered = near.copy()
    w = [2.0 ** -round(np.log2(float(e)) / 2) for e in near.diagonal()]
    for i, row in enumerate(far - near):
        change = sum(
            abs(float(e)) * w[j] / w[i] + 1e-300 for j, e in enumerate(row) if e != 0
        )
        lowered[i, i] -= exact(float(f"{1.01 * change:.2e}"))
    return definite(lowered)[0]
