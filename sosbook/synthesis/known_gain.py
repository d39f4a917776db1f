"""A known gain: each requirement kept, with a proof, or broken, by a plant."""

import re
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np

from ..analysis.precise import floats_alone
from ..exact.definite import round_digits
from ..exact.refusal import Refusal
from ..plants.checks import SIZE_LIMITS
from ..runtime.read_only import ReadOnly
from ..runtime.time_limit import OutOfTime, check_time
from .counterexample import broken, itself
from .feasibility import answer
from .known_lmis import KnownLMIs, coordinates, with_means
from .ranges import family
from .solution import Solution

RANDOM = 60  # points at which the search for the worst plant looks, too
ROUNDS = 60  # of the search along the coordinates
SHORTEST = 1e-6  # step of it, of the family's size
DIGITS = 2, 3, 4, 6, 9  # of the plant that breaks a claim, in the order of trial
EASIER = 1.0, 1.05, 1.2, 2.0, 10.0  # times the least bound, in the order of trial
HALVINGS = 4  # of the way between two of them, as a ratio
MOST_CELLS = 128  # open or done; three parameters in squares took 60 to 65
FEW_CELLS = 16  # with which some bound is sought first, before a nearer one costs time
DEEP = 6  # cuts, after which a part that isn't proven is asked for its corners alone
CLEAR = 1e-9  # a margin of blocks that floats can tell from zero


@dataclass(frozen=True, eq=False)
class Worst(ReadOnly):
    """The worst plant that was found in floats.

    ``point``: where it is, as its family takes it; ``kept``: positive where it keeps
    the requirement: see `Requirement.kept`; ``truth``: the true value there;
    ``searched``: whether no worse one is near.
    """

    point: np.ndarray
    kept: float
    truth: float
    searched: bool = True


@dataclass(frozen=True, eq=False)
class Kept(ReadOnly):
    """The result of a requirement with a given gain.

    ``requirement``: what is asked; ``status``, {"feasible", "infeasible", "undecided"}:
    "feasible": every plant keeps it, ``blocks`` prove it. "infeasible": a plant breaks
    it, see ``infeasibility``; ``worst``: the worst plant that a search in floats has
    found; ``cuts``: of the cells that cover the family, each before its halves: the way
    in which it is cut, or None where the unknowns of it are known; ``values``: the
    unknowns of each cell that isn't cut, in that order: P of each of its corners, F, G,
    and the requirement's own, by name. In rationals the blocks at these decimals are
    positive definite; ``margin``: the smallest eigenvalue of the blocks in floats;
    ``infeasibility``: the proof of a plant that breaks it; ``reason``: which plant
    breaks it, or which part of the family is undecided.
    """

    requirement: Any
    status: str
    worst: Worst
    cuts: tuple = ()
    values: tuple = ()
    margin: float | None = None
    infeasibility: Refusal | None = None
    reason: str = ""

    @property
    def cells(self) -> int:
        """How many parts of the family have P, F and G of their own."""
        return len(self.values)


def worst(request, r, plants, enough=False):
    """The `Worst` plant for a requirement by a local search in floats, which a plant
    that breaks it ends, if it is ``enough``; ``request``, ``r`` and ``plants`` are as
    for `decided`.
    """
    K, K_A = request.state_gain, request.K_A

    def judged(point, d):
        check_time()
        if r.parameter is None:
            truth = r.truth([d], K, K_A)
            return Worst(point, r.kept(truth), truth)
        truth = r.reached([d], K, K_A)
        return Worst(point, _room(r, r.bound, truth), truth)

    def exactly(best):
        d = plants.at(plants.exactly(best.point)).plant_in_floats
        return judged(best.point, d)

    def quickly(point):
        with floats_alone():
            return judged(point, plants.near(point))

    def surely(point):
        return judged(point, plants.near(point))

    for best in _search(plants, quickly, surely):
        if enough and best.kept <= 0 and (found := exactly(best)).kept <= 0:
            return replace(found, searched=False)
    return exactly(best)


def _search(plants, quickly, surely):
    """Ever worse plants: the worst vertex, given points, along coordinates, random
    ones. Only what seems the worst is asked twice, ``surely`` the second time.
    """
    at = surely

    def worse(points, best):
        for point in points:
            near = at(point)
            if near.kept < best.kept and at is not surely:
                near = surely(point)
            if near.kept < best.kept:
                best = near
        return best

    vertices, middles = plants.points()
    best = worse(vertices[1:], surely(vertices[0]))
    yield best
    if len(vertices) == 1:
        return
    if quickly(best.point).kept == best.kept:
        at = quickly
    for moved in _moved(plants, worse, worse(middles, best)):
        yield (best := moved)
    other = worse(plants.random(np.random.default_rng(0), RANDOM), best)
    if other is not best:
        yield from _moved(plants, worse, other)


def _moved(plants, worse, best):
    """The same along coordinates, from the ``best`` on."""
    step = 0.25
    yield best
    for _ in range(ROUNDS):
        before = best
        for k, way in product(range(plants.dimension), (step, -step)):
            moved = best.point.copy()
            moved[k] += way
            if ((moved := plants.inside(moved)) != best.point).any():
                best = worse([moved], best)
        yield best
        step /= 1 if best.kept < before.kept else 2
        if step < SHORTEST:
            return


def _room(r, bound, truth):
    """Positive where a requirement with this bound is kept by the true value."""
    return r.parameter.harder * (truth - bound)


def decided(request, r, plants, bad=None, most=MOST_CELLS, easier=()):
    """The `Kept` of ``r``, a demand of a ``request``, by at ``most`` so many cells of
    its ``plants`` (a `family`), ``bad`` the worst, if known. A claim that holds
    strictly is proven after finitely many halvings, for the LMIs lose nothing at one
    plant and hold around it; one that is broken strictly is broken by a rational plant.
    What an ``easier`` bound has cut is cut at once: those are its cuts. A corner that
    alone has no proof ends the search, for no part with it has one.
    """
    bad = bad or worst(request, r, plants)
    if bad.kept <= 0:
        for digits in DIGITS:
            point = plants.rounded(bad.point, digits)
            if digits < DIGITS[-1] and _room_at(request, r, plants.at(point)) > 0:
                continue
            found = _broken(request, r, plants, point, bad)
            if found is not None:
                return found
        if not bad.searched:
            return decided(request, r, plants, most=most)
        text = (
            f"In floats a plant breaks it: the true value is {bad.truth:.6g}. No exact "
            "proof of that was found."
        )
        return Kept(r, "undecided", bad, reason=text)
    open_cells, cuts, values, least = [(plants.whole, 0)], [], [], np.inf
    before, looked = iter(easier), False
    while open_cells:
        check_time()
        cell, depth = open_cells.pop()  # the depth below what is cut at once
        way = None if depth else next(before, None)
        if way is not None:
            cuts.append(way)
            open_cells += [(part, 0) for part in reversed(cell.cut(way))]
            continue
        room = [_room_at(request, r, loop) for loop in cell.loops]
        k = int(np.argmin(room))
        found = _proven(request, r, cell.loops, cell.means) if room[k] > 0 else None
        if found is not None:
            cuts.append(None)
            values.append(found[0])
            least = min(least, found[1])
            continue
        nearer = {} if room[k] > 0 else plants.nearer(cell.place, cell.loops, k)
        if not (room[k] > 0 or nearer):  # it is a plant of the family
            point = plants.point(cell.place, k)
            found = _broken(request, r, plants, point, bad)
            return found or _undecided(r, bad, values, "a plant that is at the edge")
        alone = [plants.at(plants.exactly(bad.point))]
        if not looked and _proven(request, r, alone) is None:
            return _undecided(r, bad, values, "the worst plant alone")
        looked = True
        if len(cell.loops) == 1 or len(values) + len(open_cells) >= most:
            return _undecided(r, bad, values, cell.words)
        if depth and depth % DEEP == 0:
            for point, loop in _corners(plants, cell):
                if _proven(request, r, [loop]) is None:  # so no part with it is, either
                    return _undecided(r, bad, values, plants.point_words(point))
        if nearer:
            best = {
                way: [_room_at(request, r, x) for x in nearer[way]] for way in nearer
            }
            way = max(best, key=lambda way: min(best[way]))
        else:
            T, _, rate = coordinates(cell.loops)
            way = cell.way(T, rate, r.needs_disturbance)
        cuts.append(way)
        open_cells += [(part, depth + 1) for part in reversed(cell.cut(way))]
    return Kept(r, "feasible", bad, tuple(cuts), tuple(values), float(least))


def _corners(plants, cell):
    """The corners of a cell that are plants of the family: where, and their loops."""
    for k, loop in enumerate(cell.loops):
        if not plants.nearer(cell.place, cell.loops, k):
            yield plants.point(cell.place, k), loop


def _broken(request, r, plants, point, bad):
    """The `Kept` of a requirement that a plant provably breaks; None without proof."""
    found = broken(request, r, plants, point)
    if found is None:
        return None
    return Kept(r, "infeasible", bad, infeasibility=found[0], reason=found[1])


def _undecided(r, bad, values, where):
    where = re.sub(r"-?\d+/\d+", lambda x: f"{float(Fraction(x[0])):.6g}", where)
    text = (
        f"Neither a proof nor a plant that breaks it was found for {where}; the worst "
        f"plant that was found has the true value {bad.truth:.6g}."
    )
    return Kept(r, "undecided", bad, values=tuple(values), reason=text)


def _room_at(request, r, loop):
    """Positive where a loop keeps a requirement: no LMI holds if a vertex doesn't."""
    return r.kept(r.truth([loop.plant_in_floats], request.state_gain, request.K_A))


def _proven(request, r, loops, means=()):
    """(values, margin) of the hull of loops that keep it; None if none are found. Of
    one loop the LMIs without multipliers tell in which coordinates P is I. Where a loop
    is one of the ``means`` of others, a mean of their P does; the blocks are checked.
    """
    found = _found(KnownLMIs(r, [x for k, x in enumerate(loops) if k not in means]))
    if means and found:
        values = with_means(r, loops, found[0], means)
        return values and (values, found[1])
    if found is None and len(loops) == 1:
        one = itself(request, r, loops[0])
        P = one and answer(one, refuse=False).P
        if P is not None:
            found = _found(KnownLMIs(r, loops, np.linalg.cholesky(P)))
    return found


def _found(lmis):
    even = lmis.even()
    if even and (size := lmis.margin(even)) > CLEAR and (values := lmis.rounded(even)):
        return values, size
    first = lmis.find(refuse=False)
    if first.values is None or not (size := lmis.margin(first.values)) > CLEAR:
        return None
    values = lmis.rounded(first.values)
    return values and (values, size)


def kept_or_broken(request, objective=(), backoff=0.01, common=None, enough=False):
    """The Solution of a ``request`` with a given gain and ``coupling="multipliers"``,
    each demand by itself. The least bounds of an ``objective`` are sought, the fraction
    ``backoff`` above the worst true value. ``common`` is the same with a common P:
    where the vertices keep everything and one is found that is the answer, and no plant
    between is searched for; ``enough`` is as in `worst`.
    """
    if common is not None and common.kept_by(request.gain, request.demands):
        solution = answer(common, refuse=False)
        if solution.status == "feasible":
            return solution
    plants, parts = family(request), []
    bad = [
        worst(request, r, plants, enough and not _sought(r, objective))
        for r in request.demands
    ]
    for r, known in zip(request.demands, bad, strict=True):
        if _sought(r, objective):
            part = least(request, r, plants, backoff, bad=known)
            request = request.with_bounds({r.parameter.key: part.requirement.bound})
        else:
            part = decided(request, r, plants, known)
        parts.append(part)
    solution = Solution(request, "feasible", request.gain, parts=tuple(parts))
    missing = [part for part in parts if part.status != "feasible"]
    if not missing:
        margins = {part.requirement.name: part.margin for part in parts}
        return replace(solution, margins=margins)
    broken = next((p for p in missing if p.status == "infeasible"), None)
    reason = " ".join(f"{p.requirement.words}: {p.reason}" for p in missing)
    return replace(
        solution,
        status="undecided" if broken is None else "infeasible",
        reason=reason[0].upper() + reason[1:],
        infeasibility=broken and broken.infeasibility,
    )


def _sought(r, objective):
    return r.parameter is not None and r.parameter.key in objective


def least(request, r, plants, backoff, digits=3, bad=None):
    """The `Kept` of ``r`` with the best bound, of so many ``digits``, for which a proof
    is found: the fraction ``backoff`` easier than the worst true value, if it can be.
    ``request``, ``plants`` and ``bad`` are as for `decided`; the bound of r is
    anything.
    """
    bad, harder = bad or worst(request, r, plants), r.parameter.harder

    def at(easier, most=MOST_CELLS):
        bound = _rounded(
            bad.truth * (easier * (1 + backoff)) ** -harder, harder, digits
        )
        known = replace(bad, kept=_room(r, bound, bad.truth))
        moved = request.with_bounds({r.parameter.key: bound})
        kept = [x for x, part in tries.items() if part.status == "feasible"]
        cuts = tries[min(kept)].cuts if kept else ()
        return decided(moved, r.with_bound(bound), plants, known, most, cuts)

    (small, large), reach = SIZE_LIMITS, 2 * max(EASIER)
    inside = small * reach < bad.truth < large / reach  # a bound is so near the truth
    few = FEW_CELLS if len(plants.whole.loops) > 1 else MOST_CELLS
    tries, looked = {}, {}

    def proven(easier, most):
        undecided = easier not in tries or tries[easier].status == "undecided"
        if undecided and most > looked.get(easier, 0):
            tries[easier], looked[easier] = at(easier, most), most
        return tries[easier].status == "feasible"

    def first(most):
        """The first factor with a proof, or None."""
        return next((x for x in EASIER if inside and proven(x, most)), None)

    def nearest(easier, most):
        """Halve the way to a factor from the one before it."""
        low = max(x for x in EASIER if x < easier)
        for _ in range(HALVINGS):
            middle = float(np.sqrt(low * easier))
            low, easier = (low, middle) if proven(middle, most) else (middle, easier)

    try:
        some = first(few)
        if some != EASIER[0] and first(MOST_CELLS) != EASIER[0]:
            for most in (few, MOST_CELLS):
                known = [x for x in EASIER if x in tries and proven(x, 0)]
                if known:
                    nearest(min(known), most)
    except OutOfTime:  # what is proven stays: a nearer bound takes longer
        if not any(part.status == "feasible" for part in tries.values()):
            raise
    found = [easier for easier, part in tries.items() if part.status == "feasible"]
    if found:
        return tries[min(found)]
    weakest = r.with_bound(0.0) if harder > 0 else r
    # no proof of the last bound; or no bound: is every loop stable, then?
    return tries[max(tries)] if tries else decided(request, weakest, plants, bad)


def _rounded(bound, harder, digits):
    """A positive bound, rounded to so many digits to the easier side."""
    size = 10.0 ** (int(np.floor(np.log10(bound))) + 1 - digits)
    whole = np.floor(bound / size) if harder > 0 else np.ceil(bound / size)
    return float(round_digits(whole * size, digits))
