"""Simple gains, which multipliers prove where no search finds one: K = 0, and that of
the mean plant.
"""

from dataclasses import replace

import numpy as np

from ..exact.definite import round_digits
from ..runtime.time_limit import LONGEST, OutOfTime
from .feasibility import answer, guarded

DIGITS = 6  # of the mean plant's gain
BY_ITSELF = (
    "No search found a gain, but {} keeps what is asked: each requirement is proven by "
    "itself, with multipliers."
)


def or_simple(first, request):
    """The ``first`` Solution of a ``request`` of several plants, or where it is
    undecided that of a simple gain, each requirement proven with multipliers.
    """
    if first.status != "undecided":
        return first
    try:
        for words, K in _gains(request):
            known = replace(request, gain=K, coupling="multipliers")
            if known.kept_by(K, known.demands):
                found = guarded(known, LONGEST, lambda known=known: _decided(known))
                if found.status == "feasible":
                    return replace(found, central=False, reason=BY_ITSELF.format(words))
    except OutOfTime:  # what is known stays
        pass
    return first


def _decided(known):
    from .known_gain import kept_or_broken

    return kept_or_broken(known, enough=True)


def _gains(request):
    """(What it is, the gain) of each simple gain; the mean plant's takes a search."""
    yield "K = 0", np.zeros((request.plant.m, request.order))
    mean = getattr(request.plant, "mean", None)
    if hasattr(mean, "vertices"):
        middle = replace(request, plant=mean, coupling="pairs")
        found = guarded(middle, LONGEST, lambda: answer(middle, refuse=False))
        if found.status == "feasible":
            yield "the gain of the mean plant", round_digits(found.K, DIGITS)
