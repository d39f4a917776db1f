"""Advice on a law, tried before it is given: another law, or a weaker bound."""

from dataclasses import replace
from functools import reduce
from operator import and_
from time import monotonic

import numpy as np

from ...laws.dynamic import DynamicLaw
from ...laws.pid import PIDLaw
from ...requirements.vocabulary import SIGMA
from ...runtime.time_limit import LEAST_TIME, OutOfTime, time_limit
from ..request import Request
from ..search import Search
from .design import FEW, by_law
from .doors import corners_of

TRIAL = 20.0  # seconds, for a law with a memory, and for all bounds together
QUICK = Search(starts=FEW)
NOTHING = OutOfTime, ValueError, ArithmeticError, np.linalg.LinAlgError


def with_memory(request):
    """Words on a `DynamicLaw` of the plant's order that keeps a ``request`` with the
    sensors of its `PIDLaw`, found within `TRIAL` seconds; or nothing.
    """
    law = request.law
    if not isinstance(law, PIDLaw):
        return ""
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


def with_one_relaxed(request):
    """Sentences on the requirements of a ``request`` with a law, one at a time: the
    best bound with which a gain was found and proven that keeps the others. Nothing on
    those for which none was, within `TRIAL` seconds for all.
    """
    asked = replace(request, gain=None)
    relaxed = [
        r
        for r in asked.requirements
        if r.parameter and (r.parameter.power or r.parameter is SIGMA)
    ]
    others = "With the others kept, the" if len(asked.requirements) > 1 else "The"
    text, end = "", monotonic() + TRIAL
    for left, r in zip(range(len(relaxed), 0, -1), relaxed):
        p = r.parameter
        try:
            with time_limit(max((end - monotonic()) / left, LEAST_TIME)):
                found = by_law(asked, {p.key: 1.0}, QUICK)
        except NOTHING:
            continue
        if found.status == "feasible":
            best = found.request.owner(p.key).bound
            most = "largest" if p.harder > 0 else "least"
            kept = ", which keeps all" if p.harder_than(r.bound, best) <= 0 else ""
            text += f"{others} {most} {r.words} that was found is {p.shown(best):.4g}"
            text += f" (asked: {p.shown(r.bound):.4g}){kept}. "
    return text
