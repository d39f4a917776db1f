"""Vertices that are the corners of a box but for rounding, and that box."""

import numpy as np
from flint import fmpq

from ..exact.rational import exact
from .bernstein import Box
from .checks import as_in_a_file
from .descriptor_system import DescriptorSystem
from .polynomials import Polynomials
from .second_order import SecondOrderSystem
from .uncertain import MOST_VERTICES, ROWS, Uncertain

__all__ = ["as_a_box", "near_box"]

ROUNDING = 1e-14  # of an entry: sums and products of floats lose a few times 1e-16


def as_a_box(plant):
    """The family near vertices that are a box but for rounding; else the plant.

    There LMIs at the vertices say something of the plants between, and the last bit
    of a float, or the unit of force, would take it away. A plant in a proof file is
    what the file says.

    Parameters
    ----------
    plant : SecondOrderSystem, Polytope or DescriptorSystem
        With vertices that were given as floats.
    """
    if plant.family is not None or len(plant.vertices) < 2 or as_in_a_file():
        return plant
    known = vars(plant)  # a search asks again for each of its values
    if "_as_a_box" not in known:
        known["_as_a_box"] = _family(plant)
    return known["_as_a_box"] or plant


def _family(plant):
    """The polytope of that family, or None."""
    first, kind = plant.vertices[0], DescriptorSystem
    names: dict = {"B": "Bu", "B_w": "Bw"}
    if hasattr(first, "M"):
        kind, names = SecondOrderSystem, {}
    parts = [[getattr(v, names.get(x, x)) for x in ROWS[kind]] for v in plant.vertices]
    several = np.array([np.hstack(x) for x in parts])
    order = several.shape[1]
    if (several[:, :, :order] == several[0, :, :order]).all():  # a certain E
        return None
    if kind is DescriptorSystem and not plant.outputs:  # they are no part of that box
        return None
    near = near_box(several, order)
    if near is None:
        return None
    base, changes = near
    count = len(changes)
    box = Box.of(**{f"near_vertex_{k + 1}": (0, 1) for k in changes})
    powers = [tuple(int(i == k) for i in range(count)) for k in range(-1, count)]
    cuts = np.cumsum([x.shape[1] for x in parts[0]])[:-1]
    rest, found = {}, {}
    several = [np.split(x, cuts, axis=1) for x in (base, *changes.values())]
    for name, *summands in zip(ROWS[kind], *several):
        found[name] = _polynomials(summands, powers)
    if kind is SecondOrderSystem:
        rest["coordinates"] = first.coordinates
    else:
        for name, x in plant.outputs.items():
            found[name] = _polynomials([exact(x)], powers)
    return Uncertain.of(kind, box, found, **rest).polytope()


def _polynomials(summands, powers):
    """The sum of some matrices, each times its monomial."""
    entries = [
        {m: x for m, x in zip(powers, place) if x}
        for place in zip(*(x.ravel().tolist() for x in summands))
    ]
    return Polynomials.of(summands[0].shape, entries, len(powers[0]))


def near_box(vertices, order):
    """The exact box near some vertices, or None.

    Changes are taken from the first vertex to the others, the smallest first, unless
    it is a sum of those before. Each has multiples of one column only, or leaves E as
    it is. All their sums must be vertices, and all vertices such sums.

    Parameters
    ----------
    vertices : (k, rows, columns) array
        Of each vertex [E ...], in floats.
    order : int
        How many of the columns belong to E.

    Returns
    -------
    base : (rows, columns) Rational
        The first vertex, its floats read as decimals.
    changes : dict
        Matrices by the place of the vertex that the first one and the change are
        near to. All sums of the first and of some changes are near the vertices,
        within ``ROUNDING`` of the largest value that each entry has, in any units.

    Notes
    -----
    Where the sums are the vertices themselves, there is nothing to read: None.

    A verdict by floats is no proof: what is proven is proven of this box.

    Examples
    --------
    >>> corners = [np.eye(2) + m * np.outer([1, 0.7], [1, 0.7]) for m in (0, 1 / 3)]
    >>> base, changes = near_box(np.array(corners), 2)
    >>> change = changes[1]
    >>> bool(change[0, 0] * change[1, 1] == change[0, 1] * change[1, 0])
    True
    """
    if not 2 <= len(vertices) <= MOST_VERTICES:
        return None
    sizes = ROUNDING * np.abs(vertices).max(axis=0)
    steps = vertices - vertices[0]
    relative = (steps / np.where(sizes, sizes, 1.0)) ** 2
    found, sums = {}, np.zeros((1, *steps.shape[1:]))
    for k in np.argsort(relative.sum(axis=(1, 2)), kind="stable"):
        if _among(steps[k], sums, sizes).any():
            continue
        change = _one_column(vertices[[0, k]], sizes, order)
        if change is None:  # perhaps the sum of some that come
            continue
        if 2 * len(sums) > len(vertices):
            return None
        found[int(k)] = change
        sums = np.concatenate([sums, sums + change.astype(float)])
    all_there = all(_among(s, steps, sizes).any() for s in sums)
    if all_there and all(_among(s, sums, sizes).any() for s in steps):
        there = [exact(vertices[0])]
        for change in found.values():
            there += [s + change for s in there]
        if {tuple(s.ravel()) for s in there} != set(
            map(tuple, exact(vertices).reshape(len(vertices), -1).tolist())
        ):
            return there[0], found
    return None


def _among(step, others, sizes):
    """Which of some others are near a step."""
    return (np.abs(others - step) <= sizes).all(axis=(1, 2))


def _one_column(ends, sizes, order):
    """The change near that between two ends which has one column only, or None."""
    first, last = exact(ends)
    change, step = last - first, ends[1] - ends[0]
    change[np.abs(step) <= sizes] = fmpq(0)
    if not any(change[:, :order].ravel()):
        return change
    largest = np.abs(step) / np.where(sizes, sizes, 1.0)
    row, column = np.unravel_index(np.argmax(largest), step.shape)
    single = np.outer(change[:, column], change[row] / change[row, column])
    near = np.abs(single.astype(float) - step) <= sizes
    return single.view(type(change)) if near.all() else None
