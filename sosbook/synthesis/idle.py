"""Requests that a plant meets without any input: nothing is left to minimise."""

from dataclasses import replace

import numpy as np

from ..runtime.time_limit import check_time_of_eigenvalues
from .bracket import rounded_up
from .feasibility import answer
from .scaled_lmis import ScaledLMIs
from .scaling import Frame
from .slack import with_slack

NEAR_ZERO = 1e-6  # of the unit in which a bound is sought


def without_input(request, objective):
    """The Solution with K = 0 whose minimised bounds are zero; else None.

    Where a gain is given it is looked at instead of K = 0.

    ``request``: what is asked of the plant; numbers stand in for the bounds;
    ``objective``: the names of the parameters that are minimised, with weights.

    A bound is positive, so what the request says is a millionth of the unit in
    which the bound would be sought. Any other positive number will do as well.
    """
    K = request.gain
    if K is None:
        K = np.zeros((request.plant.m, request.order))
    free = tuple(request.owner(name) for name in objective)
    if not _meets(request, K, free):
        return None
    lmis = ScaledLMIs(request, Frame.of(request, tuple(objective)), free)
    bounds = {
        r.parameter.key: rounded_up(
            NEAR_ZERO * r.parameter.bound(lmis.units[r.parameter.key] or 1.0)
        )
        for r in free
    }
    given = with_slack(replace(request.with_bounds(bounds), gain=K))
    solution = given and answer(given, refuse=False)
    if solution is None or solution.status != "feasible":
        return None
    names = " and ".join(bounds)
    text = f"The least {names} is zero, any positive number will do"
    if request.gain is None:
        text = f"K = 0 keeps everything that is asked: {text[0].lower()}{text[1:]}"
    asked = replace(solution.request, gain=request.gain)
    return replace(solution, request=asked, reason=f"{text}.")


def _meets(request, K, free):
    """Whether the true values are zero where they are free, and good elsewhere."""
    loops = request.vertices
    for d in loops:
        check_time_of_eigenvalues(len(d.E))
        poles = np.linalg.eigvals(np.linalg.solve(d.E, d.A + d.Bu @ K))
        if not poles.real.max() < 0:
            return False
    if any(r.truth(loops, K, request.K_A) != 0 for r in free):
        return False
    rest = [r for r in request.demands if r not in free]
    return all(r.kept(r.truth(loops, K, request.K_A)) > 0 for r in rest)
