"""A least bound that no minimisation finds, between what is kept and what is not."""

from dataclasses import replace
from functools import cache

import numpy as np

from ..runtime.time_limit import OutOfTime
from .feasibility import answer
from .scaling import Frame
from .solution import Solution

# times the bounds, where a point is too near the edge; of one that falls to zero even
# sixteen times is below what floats tell from zero
EASIER = 1.1, 2.0, 16.0, 1e3, 1e6
FALL = 0.1  # from one bound that is tried to the next
MOST_FALLS = 4
HALVINGS = 5  # of a fall, for either side
LARGE_GAIN = 1e3  # times one in the request's frame: smaller bounds need larger ones
# of the bounds that are tried in vain for a smaller gain: where gains are enormous
# roundings move them, and after three it was the processor that chose a bound
MOST_UPHILL = 6


def bracketed(request, bounds, best):
    """The Solution of a ``request`` with the smallest bounds that are kept, and what is
    known below: all ``bounds``, by the parameter's name, are moved by one factor.
    ``best`` is the Solution with these.
    """

    def at(factor):
        if factor == 1:
            return bounds
        return {name: rounded_up(b * factor) for name, b in bounds.items()}

    @cache
    def tried(factor):
        return _decided(request.with_bounds(at(factor)))

    def words(factor):
        return " and ".join(f"{name} = {b:g}" for name, b in at(factor).items())

    kept, smaller, excluded = 1.0, None, None
    try:
        for easier in EASIER:
            if best.status == "feasible":
                break
            kept, best = easier, tried(easier)
        if best.status != "feasible":
            return best
        below = [kept * FALL**k for k in range(1, MOST_FALLS + 1)]
        end = next((f for f in below if tried(f).status != "feasible"), None)
        if end is not None:
            kept, best = _edge(tried, "feasible", end / FALL, end, best)
            under = (f for f in below if f <= end and tried(f).status == "infeasible")
            excluded = next(under, None)
        else:
            smaller = below[-1]
        if excluded is not None:
            excluded, _ = _edge(tried, "infeasible", excluded, excluded / FALL)
        elif request.gain is None:
            gentle, solution = _gentler(request, tried, at, kept, best)
            if solution is not best:
                smaller, kept, best = smaller or kept, gentle, solution
    except OutOfTime:
        if best.status != "feasible":
            raise
    names = " and ".join(bounds)
    text = f"The search for the least {names} gave up: this design keeps {words(kept)}"
    if excluded is not None:
        text += "; whether a smaller one can be kept isn't known, but that "
        text += f"{words(excluded)} can't is proven for these LMIs"
        text = request.sizes.subject(text)
    elif smaller is None:
        text += "; whether a smaller one can be kept isn't known"
    else:
        text = f"No least {names} was found: this design keeps {words(kept)}, and "
        text += f"{words(smaller)} can be kept, too. The least one may be zero"
        if request.gain is None:
            text += (
                ", or reached by infinite gains only: limit them with saturation "
                "or a disk (rho)"
            )
    return replace(best, reason=f"{text}.")


def _decided(request, refuse=True):
    """The Solution of a ``request``, undecided where floats give up."""
    try:
        return answer(request, refuse)
    except (ArithmeticError, np.linalg.LinAlgError):
        text = "The numerics gave up."
        return Solution(request, "undecided", request.gain, reason=text)


def _gentler(request, tried, at, kept, best):
    """A factor and its Solution with a moderate gain, where that of ``best`` is
    enormous: bounds are eased until the gain is moderate, or nearly the least on the
    way up, and fall again to what this gain keeps.
    """
    frame, found = Frame.of(request), [(kept, best)]

    def gain(solution):
        return np.linalg.norm(solution.K @ frame.T, 2) / frame.scale

    least = gain(best)
    while min(gain(s) for _, s in found[-MOST_UPHILL:]) <= least > LARGE_GAIN:
        factor = found[-1][0] / FALL
        eased = tried(factor)
        if eased.status != "feasible":
            break
        found.append((factor, eased))
        least = min(least, gain(eased))
    factor, solution = next((f, s) for f, s in found if gain(s) <= 2 * least)
    given = replace(request, gain=solution.K)
    while factor * FALL > kept:
        lower = _decided(given.with_bounds(at(factor * FALL)), refuse=False)
        if lower.status != "feasible":
            break
        factor, solution = factor * FALL, lower
    return factor, solution


def _edge(tried, status, inside, outside, best=None):
    """The last factor of this status on the way from ``inside``, and its Solution."""
    for _ in range(HALVINGS):
        middle = float(np.sqrt(inside * outside))
        if tried(middle).status == status:
            inside, best = middle, tried(middle)
        else:
            outside = middle
    return inside, best


def rounded_up(value):
    """A positive ``value``, rounded up to three significant digits."""
    digits = 2 - int(np.floor(np.log10(value)))
    return float(np.round(np.ceil(value * 10.0**digits) / 10.0**digits, max(digits, 0)))
