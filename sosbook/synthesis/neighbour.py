"""Beside a refusal: a design that asks for less, and what it truly does."""

from .bounds import bounds_of
from .feasibility import guarded
from .objectives import at_optimum
from .slack import with_slack
from .solution import Solution

SECONDS = 60.0  # for the design, and for what is true of it
BACKOFF = 0.01  # of the least bound, as everywhere


def neighbour(request, relaxed):
    """What a design does for which one of the ``relaxed`` requirements is eased.

    ``request``: what has no design; ``relaxed``: without any of these it has one. The
    first with a bound that can be minimised is taken. Returns a sentence, or nothing.
    """
    r = next((r for r in relaxed if _minimised(r)), None)
    if r is None or request.gain is not None:
        return ""
    key, objective = r.parameter.key, {r.parameter.key: 1.0}

    def work():
        settled = with_slack(request, objective)
        if settled is None:
            return Solution(request, "undecided")
        return at_optimum(settled, objective, BACKOFF)

    found = guarded(request, SECONDS, work)
    if found.status != "feasible":
        return ""
    table = bounds_of(found.request, found.K, SECONDS)
    one = next(b for b in table if b.requirement.key == r.key)
    text = f"With {key} = {one.asked:g} there is a design; of its loop {one.true:.4g} "
    text += "is true"
    if one.proven is None:
        return f"{text}."
    text += f", and {one.proven:.4g} proven with a P of its own"
    rest = [b for b in table if b is not one]
    if one.proven <= r.bound and all(b.proven is not None for b in rest):
        text += f": its gain keeps {key} = {r.bound:g}, as was asked"
    return f"{text}."


def _minimised(r):
    """Whether its bound can be minimised, and read again with a P of its own."""
    return r.parameter is not None and r.parameter.power and r.takes_multipliers
