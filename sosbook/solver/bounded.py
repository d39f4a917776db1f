"""Centres where the set of points is unbounded: bound the unknowns first."""

import numpy as np

from ..language.expression import eye
from ..language.layout import block
from .loop import NO_LEAST, Unbounded, centre, minimize, phase_one

MINIMUM_BOUNDS = 1e5, 1e7  # of the unknowns, between which a minimum has to be the same


def unpacked(unknowns, x):
    """Values by name of some ``unknowns``, from a vector x of variables."""
    values, start = {}, 0
    for u in unknowns:
        end = start + u.size
        values[u.name] = u.unpack(x[start:end])
        start = end
    return values


def any_centre(blocks, unknowns, x, enough=None, **hints):
    """The analytic centre from x, of a bounded part if there is no other.

    ``blocks`` are affine in ``unknowns``; ``enough`` and ``hints`` as for `centre`.
    """
    if any(c.any() for c in blocks.constants):  # else a cone, which has none
        try:
            return centre(blocks, x, enough=enough, **hints)
        except Unbounded:
            pass
    try:
        joined, near = bounded(blocks, unknowns, x)
        return centre(joined, near, enough=enough)
    except Unbounded:
        return x  # a degenerate set: keep the feasible point


def any_minimum(blocks, unknowns, cost, x, gap):
    """A point of ``blocks`` where cost.x is nearly least, to the accuracy ``gap``, with
    bounded ``unknowns`` where directions ``cost`` nothing; raises Unbounded, with the
    best point, if none is found. ``x`` lies inside.
    """
    try:
        return minimize(blocks, cost, x, gap)[0]
    except Unbounded as missed:  # perhaps in a direction that costs nothing
        best = missed.x
    try:
        near, far = (
            minimize(joined, cost, inside, gap)[0]
            for joined, inside in (
                bounded(blocks, unknowns, x, r) for r in MINIMUM_BOUNDS
            )
        )
    except Unbounded as missed:
        points = [p for p in (x, best, missed.x) if p is not None]
        raise Unbounded(NO_LEAST, min(points, key=lambda p: cost @ p)) from None
    if cost @ far < 0.99 * (cost @ near):
        raise Unbounded(NO_LEAST, near)
    return near


def bounded(blocks, unknowns, x, r=16.0, size=None):
    """The blocks, joined by blocks "scale" that bound the unknowns.

    P is joined with Y in [[r I - P, Y'], [Y, r I]] > 0. Where every block is
    homogeneous the gain doesn't depend on r, and a multiple of x lies inside: that of a
    ``size`` below r, if one is asked for. Else r grows until there is a point inside,
    which is returned too: x or a multiple if that will do.
    """
    while r < 1e16:
        joined = blocks.joined(lambda values: _bounds(values, unknowns, r))  # noqa: B023
        newton, near = joined.newton, x
        reach = _reach(newton, len(blocks.constants), x)
        if size is not None or reach >= r:  # else x keeps this bound
            near = x * ((size or r / 2) / reach)
        if newton.least(near).min() > 0:
            return joined, near
        inside = phase_one(joined, start=near).x
        if inside is not None:
            return joined, inside
        r *= 16
    raise Unbounded("no bound of the unknowns holds a feasible point")


def _reach(newton, first, x):
    """The least r for which x lies inside all blocks r I + .. from the ``first`` on."""
    reach = 0.0
    for s, changes in zip(newton.stacks, newton.along(x)):
        some = [g for g, index in zip(changes, s.indices) if index >= first]
        if some:
            reach = max(reach, -np.linalg.eigvalsh(some).min())
    return reach


def _bounds(values, unknowns, r):
    """The blocks "scale" of r, for the values of some unknowns."""
    P = [p for p, u in zip(values, unknowns) if u.symmetric]
    others = [Y for Y, u in zip(values, unknowns) if not u.symmetric]
    blocks = [-p for p in P]
    wide = [Y for Y in others if len(P) == 1 and Y.shape[1] == P[0].shape[0]]
    if wide:
        Y = wide[0]
        others = [X for X in others if X is not Y]
        blocks = [block([[-P[0], Y.T], [Y, 0 * eye(Y.shape[0])]])]
    for X in others:
        rows, cols = X.shape
        blocks.append(block([[0 * eye(cols), X.T], [X, 0 * eye(rows)]]))
    return [g + r * eye(g.shape[0]) for g in blocks]
