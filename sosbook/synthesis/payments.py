"""Margins at the corners of a box that cover vertices which are only near them."""

from dataclasses import replace

import numpy as np

from ..language.matrices import Reaches
from ..lmi.text import floats
from ..plants.coupled import Coupled

ROUNDED = 1.01  # a sum of products of positive floats is wrong by far less
NOT_PAID = (
    "The corners aren't a box within what the margin pays for: give the parameters "
    "(sosbook.Uncertain)."
)


def pays(r):
    """True if the plant enters the blocks of ``r`` by the quotient alone."""
    others = (getattr(r, x, None) for x in ("acceleration", "outputs", "inputs"))
    return r.of_package and r.affine_in_quotient and not any(others)


def paid(request, blocks, P, Y, own=()):
    r"""The ``blocks`` of a ``request`` in the plant's units, by `BlockName` in floats,
    less what the vertices' distance from a `NearBox` costs: what all plants of the
    polytope keep where these are definite. ``P``, ``Y`` and ``own`` are as for
    `Request.blocks`.

    Each block is T G T' with G affine in X = E^-1 [A B_u B_w] and a regular T that
    depends on E alone. Every plant has X = sum b_i (X_i + D) with the corners' X_i,
    weights b_i and abs(D) <= the `reach`: so G > 0 there if at each corner the block of
    E_i and E_i (X_i + D) is positive for all such D. Its entries move by H_kl at most,
    which the theorem itself says when it is read with `Reaches`, and for any d > 0 sum
    H_kl |x_k| |x_l| <= sum H_kl (d_k / d_l) x_k^2, so a diagonal is subtracted. With d
    the root of the block's diagonal the share that is paid doesn't depend on units.
    """
    if request.ground.near is None:
        return blocks
    _, far = request.ground.near.ground(request.vertices, request.described)
    loops, _ = request.loops(P, Y, floats, None, None, {}, own)
    owners, less = {r.key: r for r in request.demands}, dict(blocks)
    moved = {i: _moving(request.ground.vertices[i], far) for i, _ in request.pairs}
    for i, d in moved.items():
        found = {}
        for key, r in owners.items():
            loop = loops[key]
            for block, g in r.pair(loop, Coupled(d, d, loop.P, loop.Y)):
                found[key, block] = g
        for name, g in blocks.items():
            moving = found.get((name.requirement, name.block))
            if name.vertices == (i,) and hasattr(moving, "array"):
                # a block without an entry that moves has nothing to pay for
                less[name] = g - np.diag(_price(moving.array[1], g))
    return less


def _moving(d, far):
    """A corner whose A, B_u and B_w may move."""
    steps = ROUNDED * np.abs(d.E) @ far
    cuts = np.cumsum([d.A.shape[1], d.Bu.shape[1]])
    parts = (
        Reaches(np.array([np.abs(x), step]))
        for x, step in zip((d.A, d.Bu, d.Bw), np.split(steps, cuts, axis=1))
    )
    return replace(d, **dict(zip(("A", "Bu", "Bw"), parts)))


def _price(reaches, g):
    """The diagonal for a block g, in its arithmetic."""
    sizes = np.sqrt(np.abs(np.diagonal(g).astype(float)))
    sizes[sizes == 0] = 1.0  # this block isn't positive
    return ROUNDED * sizes * (reaches @ (1 / sizes))
