"""The blocks of many pairs of vertices from one reading of the theorems."""

import numpy as np

from ..language import Affine
from ..language.matrices import Matrices, array_of, margins
from ..lmi.text import floats
from ..plants.coupled import Coupled
from ..plants.descriptor import MATRICES, Descriptor
from ..requirements.blocks import BlockName
from ..runtime.time_limit import check_time
from ..solver.loop import margin
from ..solver.structure import some_matrix

ROUNDING = 1e-9  # relative, by which a block that is read alone may differ
UNREADABLE = (TypeError, AttributeError, ValueError, IndexError)
FEWEST = 4  # pairs that are read at once


def stacked(vertices):
    """The matrices of all ``vertices``, by name: arrays (vertices, rows, columns), or
    (1, rows, columns) where all are equal.
    """
    stack = {}
    for name in MATRICES:
        some = [getattr(d, name) for d in vertices]
        if some[0] is None:
            stack[name] = None
            continue
        array = np.array(some, float)
        stack[name] = array[:1] if (array[1:] == array[0]).all() else array
    return stack


def together(loop, stack, i, j):
    """The `Coupled` of `Matrices` of many pairs of vertices, with the indices ``i`` and
    ``j``, equal in all pairs or in none; ``stack`` are the vertices of a ``loop`` in
    floats, `stacked`.
    """
    first = _at(stack, i)
    second = first if np.array_equal(i, j) else _at(stack, j)
    return Coupled(first, second, loop.P, loop.Y)


def _at(stack, indices):
    """The `Descriptor` of `Matrices` of some vertices; what all share is plain."""

    def at(some):
        if some is None or len(some) == 1:
            return None if some is None else some[0]
        return Matrices(some[indices])

    return Descriptor(**{name: at(some) for name, some in stack.items()})


def read(r, loop, coupled, i, j):
    """The blocks of ``r`` for many pairs, by name: an array, or a list of `Affine` in
    unknowns; None where a theorem can't be read so, or reads otherwise for a single
    pair. ``loop``, ``coupled``, ``i`` and ``j`` are as `together` takes and gives them.
    """
    try:
        blocks = {block: _each(g, len(i)) for block, g in r.pair(loop, coupled)}
        for k in (0, -1):
            one = alone(r, loop, i[k], j[k])
            if blocks.keys() != one.keys() or not all(
                _agree(some[k], one[block]) for block, some in blocks.items()
            ):
                return None
    except UNREADABLE:
        return None
    return blocks


def alone(r, loop, i, j):
    """The blocks of ``r`` for one pair of a ``loop``'s vertices, ``i`` and ``j``, by
    name.
    """
    pair = Coupled(loop.vertices[i], loop.vertices[j], loop.P, loop.Y)
    return dict(r.pair(loop, pair))


def _each(g, count):
    if isinstance(g, Affine):
        return g.each(count)
    return np.broadcast_to(array_of(g), (count, *g.shape))


def _agree(one, other):
    """True if two matrices are the same, at some values of their unknowns."""
    if isinstance(one, Affine) != isinstance(other, Affine) or one.shape != other.shape:
        return False
    if isinstance(one, Affine):
        unknowns = {t.unknown for g in (one, other) for t in g.terms}
        values = {
            u: some_matrix(k, *u.shape, u.symmetric)
            for k, u in enumerate(sorted(unknowns, key=lambda u: u.name))
        }
        one, other = one.value(values), other.value(values)
    return np.abs(one - other).max() <= ROUNDING * np.abs(other).max()


def blocks_of_pairs(requirements, loops, pairs):
    """The blocks of ``requirements`` at many ``pairs`` in unknowns, as far as they can
    be read at once: from (key, pair) to a dict by name. ``loops`` has, by key, the loop
    that each requirement sees, in floats.
    """
    found, stacks = {}, {loop: stacked(loop.vertices) for loop in set(loops.values())}
    for single in (True, False):
        some = [pair for pair in pairs if (pair[0] == pair[1]) == single]
        if len(some) < FEWEST:
            continue
        i, j = np.array(some).T
        coupled = {loop: together(loop, stack, i, j) for loop, stack in stacks.items()}
        for r in requirements:
            loop = loops[r.key]
            blocks = read(r, loop, coupled[loop], i, j)
            if blocks is not None:
                for k, pair in enumerate(some):
                    found[r.key, pair] = {name: g[k] for name, g in blocks.items()}
    return found


LARGEST_STACK = 5e5  # entries of the blocks that are looked at together
BLOCK_ROWS = 4  # of a usual block, as a multiple of the states


def pair_margins(request, P, Y, frame=None, levels=(), own=(), below=np.inf):
    """The margins of the blocks of all pairs of a ``request`` without a slack matrix,
    from (key, block) to an array, see `sosbook.language.matrices.margins`; above
    ``below`` they may be infinite, which is faster. ``P``, ``Y``, ``frame``, ``levels``
    and ``own`` are as for `Request.blocks`, in floats. A requirement that can't be read
    with `Matrices`, or reads otherwise for a single pair, is read pair by pair.
    """
    loops, _ = request.loops(P, Y, floats, frame, None, levels, own)
    stacks = {loop: stacked(loop.vertices) for loop in set(loops.values())}
    pairs, found = np.array(request.pairs), {}
    step = max(1, int(LARGEST_STACK / (BLOCK_ROWS * request.order) ** 2))
    for start in range(0, len(pairs), step):
        check_time()
        part = slice(start, start + step)
        i, j = pairs[part].T
        coupled = {loop: together(loop, stack, i, j) for loop, stack in stacks.items()}
        for r in request.demands:
            loop = loops[r.key]
            for block, least in _margins(r, loop, coupled[loop], i, j, below).items():
                whole = found.setdefault((r.key, block), np.empty(len(pairs)))
                whole[part] = least
    return found


def _margins(r, loop, coupled, i, j, below):
    """Those of a requirement's blocks, of the pairs with the indices i and j."""
    stacks = read(r, loop, coupled, i, j)
    if stacks is not None:
        return {block: margins(stack, below) for block, stack in stacks.items()}
    least = {}
    for k, pair in enumerate(zip(i, j)):
        for block, g in alone(r, loop, *pair).items():
            least.setdefault(block, np.full(len(i), np.inf))[k] = margin(g)
    return least


def named_margins(request, P, Y, own=()):
    """The margins of all blocks of a ``request`` without a slack matrix, in the plant's
    own coordinates, from `BlockName` in the order of `Request.blocks`; ``P``, ``Y`` and
    ``own`` are as there, in floats.
    """
    first = request.pairs[0]
    found = pair_margins(request, P, Y, own=own)
    once = request.blocks(P, Y, own=own, pairs=[first])
    coupled = [n for n in once if (n.requirement, n.block) in found]
    named = {}
    for name, g in once.items():
        if name not in coupled:
            named[name] = margin(g)
        elif name == coupled[0]:  # those of the pairs follow each other
            kinds = [
                (n.removesuffix(_numbers(first)), n.requirement, n.block)
                for n in coupled
            ]
            least = np.array([found[kind[1:]] for kind in kinds]).T.tolist()
            for pair, values in zip(request.pairs, least):
                numbers, vertices = _numbers(pair), tuple(dict.fromkeys(pair))
                for (label, *key), value in zip(kinds, values):
                    named[BlockName(label + numbers, *key, vertices)] = value
    return named


def _numbers(pair):
    i, j = pair
    return f" {i + 1}" if i == j else f" {i + 1},{j + 1}"
