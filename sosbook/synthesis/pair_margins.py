"""The blocks of all pairs of vertices at a point, many in one numpy call."""

import numpy as np

from ..language.matrices import margins
from ..lmi.text import floats
from ..requirements.blocks import BlockName
from ..runtime.time_limit import check_time
from ..solver.loop import margin
from .pair_stacks import alone, read, stacked, together

LARGEST_STACK = 5e5  # entries of the blocks that are looked at together
BLOCK_ROWS = 4  # of a usual block, as a multiple of the states


def pair_margins(request, P, Y, frame=None, levels=(), own=(), below=np.inf):
    """The margins of the blocks of all pairs of vertices.

    ``request``: without a slack matrix; ``P``, ``Y``, ``frame``, ``levels``, ``own``:
    as for `Request.blocks`, in floats; ``below``: larger margins are reported as
    infinite, which is faster. Returns dict: from (requirement's key, block) to an array
    of one margin for each of the request's pairs: see
    `sosbook.language.matrices.margins`.

    The theorems are read with `Matrices`. A requirement that can't be read
    so, or reads otherwise for a single pair, is read pair by pair.
    """
    _, loops, _ = request.loops(P, Y, floats, frame, None, levels, own)
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
    """The margins of all blocks of a request, in the plant's own coordinates.

    ``request``: without a slack matrix; ``P``, ``Y``, ``own``: as for `Request.blocks`,
    in floats. Returns dict: from `BlockName` to the margin, in the order of
    `Request.blocks`.
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
