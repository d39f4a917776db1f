"""Advice on a law, tried before it is given: another law, or a weaker bound."""

from contextlib import suppress
from dataclasses import replace
from functools import reduce
from operator import and_
from time import monotonic

import numpy as np

from ...laws.dynamic import DynamicLaw
from ...laws.pid import PIDLaw
from ...requirements.pole_region import PoleRegion
from ...requirements.vocabulary import SIGMA
from ...runtime.time_limit import LEAST_TIME, OutOfTime, time_limit
from ..bounds import nearest
from ..observer import design_observer
from ..pid import design_pid
from ..request import Request
from ..search import Search
from .design import FEW, by_law
from .doors import corners_of

TRIAL = 20.0  # seconds, for a law with a memory, and for all bounds together
QUICK = Search(starts=FEW)
NOTHING = OutOfTime, ValueError, ArithmeticError, np.linalg.LinAlgError


FASTER = 2.0, 5.0  # an observer's error decays so many times as fast as the loop


def with_observer(request):
    """Words on an observer that keeps a ``request`` with the sensors of its `PIDLaw`,
    whose loop was proven within `TRIAL` seconds; or nothing. In the place of an
    integral it estimates a load at the inputs.
    """
    law, plant = request.law, request.plant
    seen, load = law.readings(plant), bool(np.any(law.integrate))
    if seen.late.any() or seen.Dw.any():
        return ""
    try:
        with time_limit(TRIAL):
            whole = design_pid(plant, requirements=request.requirements)
            rate = -whole.poles().real.max() if whole.status == "feasible" else 0.0
            known = dict(C=seen.C, disturbance=True if load else None)
            for share in FASTER if rate > 0 else ():
                place = PoleRegion(sigma=float(f"{share * rate:.3g}"))
                found = design_observer(plant, whole.K, region=place, **known)
                if found.L is not None and found.loop.prove(*request.requirements):
                    more = ", disturbance=True" * load
                    return (
                        "A design of all the state, K, with design_observer(plant, K, "
                        f"C=..., region=PoleRegion(sigma={place.sigma:g}){more}) does "
                        "it with these sensors, as tried. "
                    )
    except NOTHING:
        pass
    return ""


def with_memory(request):
    """Words on an observer, or else a `DynamicLaw` of the plant's order, that keeps a
    ``request`` with the sensors of its `PIDLaw`, each found within `TRIAL` seconds; or
    nothing.
    """
    law = request.law
    if not isinstance(law, PIDLaw):
        return ""
    if told := with_observer(request):
        return told
    order = len(next(iter(corners_of(request).values())).E)
    try:
        known = reduce(and_, filter(None, law.readings(request.plant).outputs()))
        more = DynamicLaw(order, sensors=known)
        asked = Request(request.plant, requirements=request.requirements, law=more)
        with time_limit(TRIAL):
            found = by_law(asked, {}, QUICK)
    except NOTHING:
        return ""
    kept = found.status == "feasible"
    return f"A DynamicLaw of order {order} does it, as tried. " if kept else ""


def _eased(request, r):
    """The Solution of a ``request`` with the nearest bound of ``r``, which can't be
    minimised, with which a quick search finds one; or None.
    """
    found = []

    def keeps(bounds):
        found.append(by_law(request.with_bounds(bounds), {}, QUICK))
        return found[-1].status == "feasible"

    with suppress(OutOfTime):  # what was found stays
        nearest((r,), keeps)
    kept = [s for s in found if s.status == "feasible"]
    harder, key = r.parameter.harder, r.parameter.key
    return max(kept, key=lambda s: harder * s.request.owner(key).bound, default=None)


def with_one_relaxed(request):
    """Sentences on the requirements of a ``request`` with a law, one at a time: the
    best bound with which a gain was found and proven that keeps the others. Nothing on
    those for which none was, within `TRIAL` seconds for all.
    """
    asked = replace(request, gain=None)
    relaxed = [r for r in asked.requirements if r.parameter]
    others = "With the others kept, the" if len(asked.requirements) > 1 else "The"
    text, end = "", monotonic() + TRIAL
    for left, r in zip(range(len(relaxed), 0, -1), relaxed):
        p = r.parameter
        try:
            with time_limit(max((end - monotonic()) / left, LEAST_TIME)):
                if p.power or (p is SIGMA and request.step is None):
                    found = by_law(asked, {p.key: 1.0}, QUICK)
                else:
                    found = _eased(asked, r)
        except NOTHING:
            continue
        if found is not None and found.status == "feasible":
            best = found.request.owner(p.key).bound
            most = "largest" if p.harder > 0 else "least"
            kept = ", which keeps all" if p.harder_than(r.bound, best) <= 0 else ""
            text += f"{others} {most} {r.words} that was found is {p.shown(best):.4g}"
            text += f" (asked: {p.shown(r.bound):.4g}){kept}. "
    return text
