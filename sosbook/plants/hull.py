"""Polytopes whose vertices speak for the plants between, an exact test."""

import numpy as np
from flint import fmpq_mat

from ..exact.rational import exact


def quotient_in_hull(vertices, corners=False):
    """True if E^-1 [A B_u B_w] of every plant is a mean of the vertices' ones.

    Then LMIs that are affine in it hold for every plant of the polytope if they hold at
    the ``vertices`` (floats are read as decimals). It is so where

    - all vertices have the same E, or, with one output at all of them,
    - the differences of [E A B_u B_w] have multiples of one column only, as
      where one row alone is uncertain, or
    - the vertices are a box: all sums of some plants with the same E and of
      any of some changes, each of which has multiples of one column only. A
      mass does that, and whatever else stands in its row of the equations; or
    - they are ``corners`` of a box of parameters, the last of which changes first,
      [E A B_u B_w] is affine in each, and each parameter of E changes multiples of
      one column, whatever the others are: the column and the multiples may depend
      on them. Then it is proven of the parameters' ranges, not of all means,

    and where det E has one sign at all vertices. True is proven; a polytope that has
    the property for another reason may get False.

    Source: the chapter on vertices of the book. With E + t u v' for E the inverse moves
    on a segment (Sherman and Morrison), and so does the quotient where A, B_u and B_w
    move along u, too. det E is affine in each t. From a plant between corners go along
    one parameter after the other: its quotient is a mean of two with that parameter at
    the ends, and at last of corners.
    """
    wide = np.array([np.hstack([d.E, d.A, d.Bu, d.Bw]) for d in vertices])
    rows, columns = np.nonzero((wide != wide[0]).any(axis=0))
    order = np.argsort(columns, kind="stable")  # those of E come first
    rows, columns = rows[order], columns[order]
    of_E = int(np.sum(columns < wide.shape[1]))
    if not of_E:
        return True
    if any(_outputs(d) != _outputs(vertices[0]) for d in vertices[1:]):
        return False  # the mean of the quotients may have other weights
    places = list(zip(rows.tolist(), columns.tolist()))
    entries = wide[:, rows, columns]
    points = sorted(set(map(tuple, entries.tolist())))
    corners = corners and len(points) == len(wide)
    if corners and _ranks_of_one(_rationals(entries), places, of_E):
        return _one_sign(wide[:, :, : wide.shape[1]])
    other = next(p for p in points if p[:of_E] != points[0][:of_E])
    ends = _rationals(np.array([points[0], other]))
    if not _one_column([_difference(*ends)], places):  # most are told by this one
        return False
    points = list(map(tuple, _rationals(np.array(points))))
    return _spanned(points, places, of_E) and _one_sign(wide[:, :, : wide.shape[1]])


def _outputs(d):
    parts = (getattr(d, name) for name in ("C", "Du", "Dw", "Ca"))
    return [None if x is None else x.tolist() for x in parts]


def _ranks_of_one(corners, places, of_E):
    """True if each parameter of E changes the rest by a rank of one: minors of two rows
    have degree two in each other parameter, so three places show that they are zero.
    """
    grid = np.array(corners, dtype=object)
    axes = len(grid).bit_length() - 1
    grid = grid.reshape(*(2,) * axes, -1)
    for axis in range(axes):
        low, high = np.moveaxis(grid, axis, 0)
        changes = high - low
        if not any(changes[..., :of_E].flat):
            continue
        for other in range(axes - 1):
            first, last = np.moveaxis(changes, other, 0)
            changes = np.stack([first, (first + last) / 2, last], other)
        for change in changes.reshape(-1, len(places)).tolist():
            if any(change) and not _one_column([change], places):
                return False
    return True


def _spanned(points, places, of_E):
    """True if changes of one column each make the ``points`` from some of one E;
    sorted, the first point that isn't reached yet ends a change.
    """
    changes = [_difference(p, points[0]) for p in points[1:]]
    if _one_column(changes, places):
        return True
    reached = {p for p in points if p[:of_E] == points[0][:of_E]}
    for point in points:
        if point in reached:
            continue
        change = _difference(point, points[0])
        if not _one_column([change], places):
            return False
        reached |= {tuple(a + b for a, b in zip(p, change)) for p in reached}
        if len(reached) > len(points):
            return False
    return reached == set(points)


def _difference(point, first):
    return [a - b for a, b in zip(point, first)]


def _one_column(changes, places):
    """True if all columns of all ``changes`` are multiples of one of them."""
    columns = {}
    for k, change in enumerate(changes):
        for (row, column), x in zip(places, change):
            if x:
                columns.setdefault((k, column), {})[row] = x
    one, *others = columns.values()
    lead = next(iter(one))
    return all(
        c.keys() == one.keys() and all(c[r] * one[lead] == one[r] * c[lead] for r in c)
        for c in others
    )


def _one_sign(E):
    """True if det E has the same sign at all vertices, and is never zero."""
    plain = E == np.eye(E.shape[1], dtype=int)
    inner = ~(plain.all(axis=(0, 1)) & plain.all(axis=(0, 2)))
    distinct = set(map(tuple, _rationals(E[:, inner][:, :, inner].reshape(len(E), -1))))
    k = int(inner.sum())
    dets = [fmpq_mat(k, k, list(entries)).det() for entries in distinct]
    return all(d > 0 for d in dets) or all(d < 0 for d in dets)


def _rationals(rows):
    """A matrix of floats or rationals as lists of rationals."""
    if rows.dtype == object:
        return rows.tolist()
    values, places = np.unique(rows, return_inverse=True)  # most are read once
    return exact(values)[places].reshape(rows.shape).tolist()
