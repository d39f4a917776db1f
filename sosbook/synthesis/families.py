"""Families whose ranges are cut: with powers vertices are no plants of a family."""

from dataclasses import replace

from ..runtime.time_limit import OutOfTime, check_time
from .objectives import WORTH, value

MOST_VERTICES = 12  # of a family that is cut; with more an LMI takes too long


def in_pieces(request, objective, solve):
    """The Solution, by ``solve``, of a ``request`` for a family, whose ranges are cut
    while that helps: powers of parameters have vertices that are no plants of the
    family, and come nearer where a range is cut, see `Uncertain.cut`. ``objective`` is
    as in `optimum`; without one the first feasible Solution is taken.
    """
    best, family = solve(request), request.plant.family
    while family is not None and not (best.status == "feasible" and not objective):
        found = []
        for cut in _cuts(family):
            try:
                check_time()
                like = best.request if best.status == "feasible" else request
                found.append((solve(replace(like, plant=cut.polytope())), cut))
            except OutOfTime:
                break
        found = [pair for pair in found if pair[0].status == "feasible"]
        if not found and best.status != "feasible" and (more := _cuts(family)):
            family = more[0]  # farther on there may be one
            continue
        if not found:
            break
        least, cut = min(found, key=lambda pair: value(pair[0], objective))
        if value(least, objective) > WORTH * value(best, objective):
            break
        said = best.reason if best.status == "feasible" else ""  # else it's overtaken
        best, family = replace(least, reason=least.reason or said), cut
    return best


def _cuts(family):
    """The families with one range cut into twice as many pieces, if not too many."""
    several = (
        family.cut(**{name: 2 * family.pieces[name]})
        for name, degree in family.degree.items()
        if degree > 1 and not family.straight
    )
    return [cut for cut in several if cut.count <= MOST_VERTICES]
