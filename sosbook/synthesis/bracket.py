"""A least bound that no minimisation finds, between what is kept and what is not."""

from dataclasses import replace
from functools import cache

import numpy as np

from ..lmi.time_limit import OutOfTime
from .feasibility import answer
from .solution import Solution

__all__ = ["bracketed", "rounded_up"]

EASIER = 1.1, 2.0, 16.0  # times the bounds, where a point is too near the edge
FALL = 0.1  # from one bound that is tried to the next
MOST_FALLS = 4
HALVINGS = 5  # of a fall, for either side


def bracketed(request, bounds, best):
    """The Solution of the smallest bounds that are kept, and what is known below.

    All bounds are moved by one factor.

    Parameters
    ----------
    request : Request
        What is asked of the plant; numbers stand in for the bounds.
    bounds : dict
        From a parameter's name to its bound, at the best point that is known.
    best : Solution
        Of the request with these bounds.
    """

    def at(factor):
        if factor == 1:
            return bounds
        return {name: rounded_up(b * factor) for name, b in bounds.items()}

    @cache
    def tried(factor):
        asked = request.with_bounds(at(factor))
        try:
            return answer(asked)
        except (ArithmeticError, np.linalg.LinAlgError):
            text = "The numerics gave up."
            return Solution(asked, "undecided", request.gain, reason=text)

    def words(factor):
        return " and ".join(f"{name} = {b:g}" for name, b in at(factor).items())

    kept, excluded, ends = 1.0, None, False
    try:
        for easier in EASIER:
            if best.status == "feasible":
                break
            kept, best = easier, tried(easier)
        if best.status != "feasible":
            return best
        below = [kept * FALL**k for k in range(1, MOST_FALLS + 1)]
        end = next((f for f in below if tried(f).status != "feasible"), None)
        ends = end is not None
        if ends:
            kept, best = _edge(tried, "feasible", end / FALL, end, best)
            under = (f for f in below if f <= end and tried(f).status == "infeasible")
            excluded = next(under, None)
        if excluded is not None:
            excluded, _ = _edge(tried, "infeasible", excluded, excluded / FALL)
    except OutOfTime:
        if best.status != "feasible":
            raise
    names = " and ".join(bounds)
    if ends:
        text = f"The search for the least {names} gave up: this design keeps "
        text += f"{words(kept)}; "
        text += "whether a smaller one can be kept isn't known"
        if excluded is not None:
            text += f", but that {words(excluded)} can't is proven for these LMIs"
            text = " ".join(filter(None, (text, request.condition)))
    else:
        text = f"No least {names} was found: this design keeps {words(kept)}, and "
        text += f"{words(below[-1])} can be kept, too. The least one may be zero"
        if request.gain is None:
            text += (
                ", or reached by infinite gains only: limit them with saturation "
                "or a disk (rho)"
            )
    return replace(best, reason=f"{text}.")


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
    """A positive number to three significant digits."""
    digits = 2 - int(np.floor(np.log10(value)))
    return float(np.round(np.ceil(value * 10.0**digits) / 10.0**digits, max(digits, 0)))
