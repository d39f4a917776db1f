"""The analytic centre of a request's LMIs, or the gain that comes nearest to one.

A centre may be so far away that its frame has no digits left: then it is sought in one
of its own. Where the solutions have no bound there is none; then P is kept below r I,
and r grows until the gain settles, unless nothing bounds the gains either.
"""

from dataclasses import replace

import numpy as np

from ..lmi.solution import CLEAR_MARGIN
from ..solver.barrier import CONVERGES_BELOW, Barrier
from ..solver.bounded import bounded, unpacked
from ..solver.loop import Unbounded, centre
from .cutting import CENTRE_UP_TO_PAIRS, Cuts, few_refuse, holds
from .scaled_lmis import ScaledLMIs
from .scaling import Frame
from .solution import Solution

LARGEST_UNKNOWN = 1e3  # beyond it unknowns are measured in a bad unit
MOST_FRAMES = 2  # one after the other, on the way to a centre
SMALL_BOUND = 16.0  # of P, where any other would change the gain as much
LARGE_BOUNDS = 16.0**4, 16.0**6  # floats lose larger ones
SETTLED = 1e-3  # of a gain: what a bound e times as large changes
AMID = 100.0  # times an optimum's accuracy: less leaves no room, more costs more
SMALLEST_GAIN = 0.1  # in a frame, where that of the Riccati equation is about one

NO_SIZE = (
    "Every multiple of a solution is one, so that none is their analytic centre: K is "
    "the centre of those below a bound. An input bound, a bound of gamma or one of a "
    "cost gives the solutions a size."
)
NO_GAIN_BOUND = (
    "Nothing that is asked bounds the gains, so that the solutions have no analytic "
    "centre: K is that of those below a bound, and depends on it. A disk (rho), an "
    "input bound or a bound of a cost would limit the gains."
)
NO_BOUND = (
    "The solutions have no bound, and no analytic centre within reach: K is what the "
    "centres of larger and larger parts {end}. A bound of a cost would limit them."
)
SETTLES = "settle to"
STILL_MOVES = "lead to, and still depends on the last part"


def too_many(request):
    """True if not all pairs of vertices of a request can be solved at once."""
    return len(request.pairs) > CENTRE_UP_TO_PAIRS


def centred(lmis, values):
    """The Solution of `finish` where the centre of ``lmis``, from ``values`` by name
    inside, needs no bounds, so that it doesn't depend on the frame; else None.
    """
    if too_many(lmis.request):
        return finish(lmis, values)
    found = analytic_centre(lmis, lmis.text.packed(values))
    return None if found is None else _solution(*found, True)


def finish(lmis, values):
    """The analytic centre of ``lmis`` as a Solution, from ``values`` by name inside;
    where they have none, that of a bounded part, as its ``central`` and ``reason``
    tell. With more than a thousand pairs of vertices it is the centre of some of their
    blocks: see `Cuts.centre`.
    """
    x, sizes = lmis.text.packed(values), lmis.request.sizes
    if np.abs(x).max() > LARGEST_UNKNOWN and sizes.followers(sizes.leader()):
        lmis, x = nearer(lmis, x)
    if too_many(lmis.request):
        cuts = Cuts(lmis)
        x = cuts.centre(x)
        _, decrement = cuts.some().barrier.step(x, np.zeros(len(x)))
        central = bool(decrement < CONVERGES_BELOW)
        reason = "" if central else NO_BOUND.format(end=STILL_MOVES)
        return _solution(lmis, x, central, reason)
    if not any(c.any() for c in lmis.compiled.constants):
        return _of_small_part(lmis, x, NO_SIZE)
    if lmis.compiled.barrier.recedes(x, [_gain_alone(lmis)]):
        return _of_small_part(lmis, x, NO_GAIN_BOUND)
    found = analytic_centre(lmis, x)
    return _of_part(lmis, x) if found is None else _solution(*found, True)


def _solution(lmis, x, central, reason=""):
    """The `Solution` at x; ``reason`` says why it isn't ``central``."""
    solution = lmis.solution(unpacked(lmis.unknowns, x))
    if lmis.request.gain is not None:
        return solution
    return replace(solution, central=central, reason=reason)


def analytic_centre(lmis, x):
    """The analytic centre of ``lmis`` from x inside, after the `ScaledLMIs` in whose
    coordinates it is; or None.
    """
    for _ in range(MOST_FRAMES):
        blocks = lmis.compiled
        try:
            return lmis, centre(blocks, x, **_hints(lmis))
        except np.linalg.LinAlgError:  # rounding puts x outside
            return None
        except Unbounded as end:
            if end.x is None:
                return None
            there, x = nearer(lmis, end.x)
        if there is lmis:
            return None
        lmis = there
    return None


def _of_part(lmis, x):
    """The Solution of a part that is so large that the gain settles, if one does."""
    found, reason = None, NO_BOUND.format(end=STILL_MOVES)
    for r in LARGE_BOUNDS:
        near = _below(lmis, x if found is None else found, r)
        if near is None:
            break
        margins = lmis.solution(unpacked(lmis.unknowns, near)).margins
        if min(margins.values()) <= CLEAR_MARGIN:
            break
        found = near
        if _settles(lmis, found, r):
            reason = NO_BOUND.format(end=SETTLES)
            break
    if found is None:
        return _of_small_part(lmis, x, reason)
    return _solution(lmis, found, False, reason)


def _of_small_part(lmis, x, reason):
    found = _below(lmis, x, SMALL_BOUND)  # without one: a degenerate set
    return _solution(lmis, x if found is None else found, False, reason)


def _below(lmis, x, r):
    """The centre of the part with P below r I, from x inside; None if it is lost."""
    try:
        part, inside = bounded(lmis.compiled, lmis.unknowns, x, r)
        return centre(part, inside)
    except (Unbounded, np.linalg.LinAlgError):
        return None


def _gain_alone(lmis):
    """The direction in which the gain grows against the input, and P stays."""
    request, frame = lmis.request, lmis.frame
    B = request.mean.change(frame.left, frame.T, frame.scale).state_space()[1]
    zero = {u.name: np.zeros(u.shape) for u in lmis.unknowns}
    return lmis.text.packed(zero | {"Y": -B.T} if "Y" in zero else zero)


def _settles(lmis, x, r):
    """True if a larger bound r of P hardly moves the gain at x, by one Newton step."""
    wider, _ = bounded(lmis.compiled, lmis.unknowns, x, 1.01 * r)
    try:
        moved, _ = Barrier(wider.newton).step(x, np.zeros(len(x)))
    except np.linalg.LinAlgError:
        return False
    there, here = (_gain_inside(lmis, y) for y in (moved, x))
    change, size = (np.abs(x).max(initial=0.0) for x in (there - here, here))
    return change <= 0.01 * SETTLED * max(size, SMALLEST_GAIN)


def _gain_inside(lmis, x):
    """The gain at x in the frame of ``lmis``."""
    return lmis.gain(unpacked(lmis.unknowns, x)) @ lmis.frame.T / lmis.frame.scale


def _hints(lmis):
    """Options of `centre`: the centres of a few vertices lead past slow ways."""

    def elsewhere(x):
        led = Cuts(lmis).find(unpacked(lmis.unknowns, x), refuse=False).values
        return None if led is None else lmis.text.packed(led)

    few = few_refuse(lmis.request)
    return dict(directions=lmis.free_directions, elsewhere=elsewhere if few else None)


def nearer(lmis, x):
    """The point ``x`` of blocks ``lmis`` in a frame in which P, sizes and levels are
    one: the guess of a size may be wrong by orders of magnitude, and what is far away
    looks as if the set had no bound.
    """
    values, levels = unpacked(lmis.unknowns, x), lmis.units
    request = lmis.request.with_bounds(lmis.bounds(values))
    point = Solution(request, "feasible", **lmis.in_plant_units(values))
    try:
        frame = Frame.of_solution(request, point, unit=True, levels=levels)
    except np.linalg.LinAlgError:
        return lmis, x
    units = {
        r.parameter.key: request.owner(r.parameter.key).bound ** r.parameter.power
        for r in lmis.free
    }
    there = ScaledLMIs(lmis.request, frame, lmis.free, units=units)
    moved = there.point(point)
    if moved is None or not holds(there, moved):
        return lmis, x
    return there, there.text.packed(moved)
