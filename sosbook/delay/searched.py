"""Gains of a law behind a delay: searched behind a filter like it, then proven."""

from dataclasses import replace

import numpy as np

from ..laws import Filter, ShapedLaw
from ..loops import Loop
from ..requirements import PoleRegion
from ..runtime.time_limit import check_time
from ..synthesis.pid import design_pid
from .design import DelayDesign
from .rising import solve_rising
from .solve import solve_delay

MORE = 1.25  # times the decay is asked of the filtered loop, which isn't the late one


def late_filter(tau):
    """Padé's filter of second order of a delay of ``tau`` seconds."""
    high = np.array([tau**2 / 12, tau / 2, 1.0])
    return Filter(high * [1, -1, 1], high, f"delay of {tau:g} s")


def searched(request, law):
    """The `DelayDesign` of a ``request`` for a ``law`` whose gains are searched.

    A delay of u is one of all readings, of which Padé's filter is the like: a law that
    passes it is found by `design_pid`, and the gain is proven with the delay itself.
    """
    plant, delta = request.plant, request.delta
    behind = late_filter(request.tau)
    if isinstance(law, ShapedLaw):
        late = replace(law, through=(*law.through, behind))
    else:
        late = ShapedLaw(law, [behind])
    slowest, found = [], None
    rate = PoleRegion(MORE * delta or 1.0)
    goals = [dict(region=rate)] if delta else []
    for goal in [*goals, dict(maximize=rate.parts[0].parameter.key)]:
        check_time()
        found = design_pid(plant, law=late, **goal)
        if found.gains:
            loop = Loop(plant, law, found.gains)
            design = proven(request, loop)
            if design.status == "feasible":
                return design
            slowest.append((*design.slowest_decay(), design))
    if not slowest:
        reason = f"behind a filter like the delay no gain was found: {found.reason}"
        return DelayDesign(request, "undecided", reason=reason)
    rate, at, design = max(slowest, key=lambda x: x[0])
    reason = (
        "no gain that was found has a proof; in floats the best one decays with "
        f"{rate:.3g} 1/s at the delay {at:.4g} s, where it is slowest"
    )
    if rate > delta:
        reason += ". constant_delays proves delays that are constant in pieces"
    return replace(design, status="undecided", infeasibility=None, reason=reason)


def proven(request, loop):
    """The `DelayDesign` of a ``loop`` by the first method that proves what a
    ``request`` asks, or by the last one.
    """
    plant, K = loop.opened
    request = replace(request, plant=plant, U=None, gain=K)
    several = [lambda: solve_delay(request, refuse=False)]
    if len(request.vertices) == 1 and request.method == "functional":
        several.insert(0, lambda: solve_rising(request.at(method="legendre")))
    for solve in several:
        design = replace(solve(), source=loop)
        if design.status == "feasible":
            break
    return design
