"""The blocks of all pairs of vertices at a point, many in one numpy call."""

from dataclasses import fields

import numpy as np

from ..lmi.centre import margin
from ..lmi.matrices import Matrices, array_of, margins
from ..lmi.time_limit import check_time
from ..plants.descriptor import Coupled, Descriptor
from ..requirements.base import BlockName

__all__ = ["named_margins", "pair_margins"]

LARGEST_STACK = 5e5  # entries of the blocks that are looked at together
BLOCK_ROWS = 4  # of a usual block, as a multiple of the states
ROUNDING = 1e-9  # relative, by which a block that is read alone may differ
UNREADABLE = (TypeError, AttributeError, ValueError, IndexError)


def pair_margins(request, P, Y, frame=None, levels=(), own=(), below=np.inf):
    """The margins of the blocks of all pairs of vertices.

    Parameters
    ----------
    request : Request
        Without a slack matrix.
    P, Y, frame, levels, own
        As for `Request.blocks`, in floats.
    below : float
        Larger margins are reported as infinite, which is faster.

    Returns
    -------
    dict
        From (requirement's key, block) to an array of one margin for each of
        the request's pairs: see `sosbook.lmi.matrices.margins`.

    Notes
    -----
    The theorems are read with `Matrices`. A requirement that can't be read
    so, or reads otherwise for a single pair, is read pair by pair.
    """
    _, loops, _ = request.loops(P, Y, _floats, frame, None, levels, own)
    stacks = {loop: _stacked(loop.vertices) for loop in set(loops.values())}
    pairs, found = np.array(request.pairs), {}
    step = max(1, int(LARGEST_STACK / (BLOCK_ROWS * request.order) ** 2))
    for start in range(0, len(pairs), step):
        check_time()
        part = slice(start, start + step)
        i, j = pairs[part].T
        coupled = {
            loop: Coupled(_at(stack, i), _at(stack, j), loop.P, loop.Y)
            for loop, stack in stacks.items()
        }
        for r in request.demands:
            loop = loops[r.key]
            for block, least in _margins(r, loop, coupled[loop], i, j, below).items():
                whole = found.setdefault((r.key, block), np.empty(len(pairs)))
                whole[part] = least
    return found


def _floats(x):
    return x


def _margins(r, loop, coupled, i, j, below):
    """Those of a requirement's blocks, of the pairs with the indices i and j."""
    try:
        stacks = {
            block: np.broadcast_to(array_of(g), (len(i), *g.shape))
            for block, g in r.pair(loop, coupled)
        }
    except UNREADABLE:
        stacks = None
    if stacks is not None and all(
        _same(stacks, k, _alone(r, loop, i[k], j[k])) for k in (0, -1)
    ):
        return {block: margins(stack, below) for block, stack in stacks.items()}
    least = {}
    for k, pair in enumerate(zip(i, j)):
        for block, g in _alone(r, loop, *pair).items():
            least.setdefault(block, np.full(len(i), np.inf))[k] = margin(g)
    return least


def _alone(r, loop, i, j):
    """The blocks of a requirement for one pair, by name."""
    pair = Coupled(loop.vertices[i], loop.vertices[j], loop.P, loop.Y)
    return dict(r.pair(loop, pair))


def _same(stacks, k, blocks):
    return stacks.keys() == blocks.keys() and all(
        stacks[block][k].shape == g.shape
        and np.abs(stacks[block][k] - g).max() <= ROUNDING * np.abs(g).max()
        for block, g in blocks.items()
    )


def _stacked(vertices):
    """The matrices of all vertices, by name, as arrays (vertices, rows, columns)."""
    parts = {f.name: [getattr(d, f.name) for d in vertices] for f in fields(Descriptor)}
    return {
        name: None if some[0] is None else np.array(some, float)
        for name, some in parts.items()
    }


def _at(stack, indices):
    """The `Descriptor` of `Matrices` of some vertices."""
    return Descriptor(
        **{
            name: None if some is None else Matrices(some[indices])
            for name, some in stack.items()
        }
    )


def named_margins(request, P, Y, own=()):
    """The margins of all blocks of a request, in the plant's own coordinates.

    Parameters
    ----------
    request : Request
        Without a slack matrix.
    P, Y, own
        As for `Request.blocks`, in floats.

    Returns
    -------
    dict
        From `BlockName` to the margin, in the order of `Request.blocks`.
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
