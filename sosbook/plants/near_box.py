"""Vertices that are the corners of a box but for rounding, and that box.

What it buys: where the vertices are a box, no pair of them is asked. In coordinates
that are turned, or in other units, rounding moves the vertices off their box by a last
bit, and the pairs would be asked again. The car seat of Example 2 for drivers of 70 to
400 kg has a design in the thesis's coordinates and, by this module, in coordinates
turned by 0.3 rad; without it these are refused (`tests/test_near_box.py` has both). The
polytope that was given is proven: the blocks' margins pay for the distance.
"""

from dataclasses import dataclass

import numpy as np
from flint import fmpq

from ..exact.rational import Rational, exact, inverse
from ..runtime.read_only import ReadOnly
from .checks import as_in_a_file, as_written
from .descriptor_system import DescriptorSystem
from .hull import quotient_in_hull
from .second_order import SecondOrderSystem
from .uncertain import MOST_VERTICES, ROWS, Uncertain

ROUNDING = 1e-9  # of an entry: what sums and products of floats may lose by far


@dataclass(frozen=True, eq=False)
class NearBox(ReadOnly):
    """An exact box near the vertices of a plant: LMIs at its corners say something of
    the plants between where the last bit of a float, or the unit of force, takes that
    from the vertices. Their distance from the ``corners``, one for each vertex, the
    blocks' margins pay for (see `reach`); ``family`` has parameters like near_vertex_2,
    0 at the first vertex and 1 near the second.
    """

    family: Uncertain
    corners: tuple

    @classmethod
    def of(cls, plant):
        """That of a ``plant`` in floats, or None; in a file only the one it names."""
        known = vars(plant)  # a search asks again for each of its values
        if "_near_box" not in known:
            if plant.family is not None or len(plant.vertices) < 2 or as_in_a_file():
                return None
            known["_near_box"] = _found(plant)
        return known["_near_box"]

    def data(self):
        """The data of the box in a proof file."""
        return {**self.family.data(), "corners": list(self.corners)}

    @classmethod
    def read(cls, plant, data):
        """Let a plant know the box of the ``data`` that `data` writes."""
        rest = {name: x for name, x in data.items() if name != "corners"}
        kind = type(plant)
        if kind is not DescriptorSystem:
            kind = SecondOrderSystem
        family, corners = Uncertain.read(kind, rest), data["corners"]
        good = all(type(k) is int and 0 <= k < len(family.vertices) for k in corners)
        if not good or len(corners) != len(plant.vertices):
            raise ValueError("each vertex has a corner of the box")
        vars(plant)["_near_box"] = cls(family, tuple(corners))

    def ground(self, given, describe):
        """The corners near the ``given`` vertices, in rationals, and their `reach`, or
        None; ``describe``: from a plant to its `Descriptor`s.
        """
        kept = vars(self).get("_ground")  # a search asks for the same at each value
        if kept is None or any(a is not b for a, b in zip(kept[0], given)):
            with as_written():
                there = describe(self.family.polytope())
            found = _ground(given, tuple(there[k] for k in self.corners))
            vars(self)["_ground"] = kept = given, found
        return kept[1]


def _ground(given, corners):
    exactly = [d.map(exact) for d in corners]
    if not quotient_in_hull(exactly):
        return None
    far = reach([d.map(exact) for d in given], exactly)
    return None if far is None else (corners, far)


def reach(given, corners):
    r"""How far the quotients of a polytope lie from the hull of those of a box.

    ``given``, ``corners``: the vertices, and the corner that each is near to, in
    rationals. Returns a bound for each entry of E^-1 [A B_u B_w], or None.

    Let Gamma bound the entries of all W_i - C_i for the vertices W = [E R] and their
    corners C, Q those of the corners' E^-1 and Xi those of their quotients E^-1 R. A
    plant of the polytope is W(a) = C(t) + G with C(t) in the box and abs(G) <= Gamma.
    The quotient of C(t), and E^-1 of C(t), are means of the corners' ones. With M = Q
    Gamma_E and (I - M)^-1 >= 0 the spectral radius of M is below one, so that E =
    C_E(t) (I + C_E(t)^-1 G_E) is regular with abs(E^-1) <= (I - M)^-1 Q, and

    .. math::  X - X(t) = E^{-1} (G_R - G_E X(t)), \quad
        |X - X(t)| \le (I - M)^{-1} Q (\Gamma_R + \Gamma_E \Xi).
    """
    N, several = len(corners[0].E), (given, corners)
    given, corners = ([np.hstack([d.E, d.A, d.Bu, d.Bw]) for d in x] for x in several)
    gap = _largest(v - c for v, c in zip(given, corners))
    inverses = [inverse(c[:, :N]) for c in corners]
    Q = _largest(inverses)
    Xi = _largest(i @ c[:, N:] for i, c in zip(inverses, corners))
    try:
        near = inverse(exact(np.eye(N)) - Q @ gap[:, :N])
    except ZeroDivisionError:
        return None
    if (near < 0).any():
        return None
    return (near @ (Q @ (gap[:, N:] + gap[:, :N] @ Xi))).astype(float)


def _largest(several):
    """The largest absolute value of each entry."""
    return np.maximum.reduce([np.abs(x) for x in several]).view(Rational)


def _found(plant):
    """The `NearBox` of a plant, or None."""
    from .bernstein import Box

    first, kind = plant.vertices[0], DescriptorSystem
    names: dict = {"B": "Bu", "B_w": "Bw"}
    if hasattr(first, "M"):
        kind, names = SecondOrderSystem, {}
    parts = [[getattr(v, names.get(x, x)) for x in ROWS[kind]] for v in plant.vertices]
    several = np.array([np.hstack(x) for x in parts])
    order = several.shape[1]
    if (several[:, :, :order] == several[0, :, :order]).all():  # a certain E
        return None
    fixed = {} if kind is SecondOrderSystem else plant.outputs
    if kind is DescriptorSystem and (not fixed or "C_a" in fixed):  # it would move, too
        return None
    near = near_box(several, order)
    if near is None:
        return None
    base, changes, corners = near
    changes, count = dict(reversed(changes.items())), len(changes)
    box = Box.of(**{f"near_vertex_{k + 1}": (0, 1) for k in changes})
    powers = [tuple(int(i == k) for i in range(count)) for k in range(-1, count)]
    cuts = np.cumsum([x.shape[1] for x in parts[0]])[:-1]
    rest, found = {}, {}
    several = [np.split(x, cuts, axis=1) for x in (base, *changes.values())]
    for name, *summands in zip(ROWS[kind], *several):
        found[name] = _polynomials(summands, powers)
    if kind is SecondOrderSystem:
        rest |= dict(coordinates=first.coordinates, reduction=first.reduction)
    else:
        for name, x in fixed.items():
            found[name] = _polynomials([exact(x)], powers)
    return NearBox(Uncertain.made(kind, box, found, **rest), corners)


def _polynomials(summands, powers):
    """The sum of some matrices, each times its monomial."""
    from .polynomials import Polynomials

    entries = [
        {m: x for m, x in zip(powers, place) if x}
        for place in zip(*(x.ravel().tolist() for x in summands))
    ]
    return Polynomials.of(summands[0].shape, entries, len(powers[0]))


def near_box(vertices, order):
    """The exact box near some ``vertices`` [E ...] in floats, ``order`` columns of them
    E.

    Changes are taken from the first vertex to the others, the smallest first, unless it
    is a sum of those before. Each has multiples of one column only, or leaves E as it
    is. All their sums must be near vertices, within ``ROUNDING`` of each entry's
    largest value in any units, and all vertices near such sums.

    Returns the first vertex in rationals; the changes by the place of the vertex that
    they lead to; and for each vertex the sum near it: 1 the first change, 2 the second,
    3 both. None where there is no such box, the sums are the vertices themselves, or
    none is far from the first. A verdict by floats is no proof: `reach` and the blocks
    are.
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
    if found and all_there and all(_among(s, sums, sizes).any() for s in steps):
        there = [exact(vertices[0])]
        for change in found.values():
            there += [s + change for s in there]
        given = exact(vertices).reshape(len(vertices), -1).tolist()
        if {tuple(s.ravel()) for s in there} != {*map(tuple, given)}:
            places = [int(np.argmax(_among(s, sums, sizes))) for s in steps]
            return there[0], found, tuple(places)
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
