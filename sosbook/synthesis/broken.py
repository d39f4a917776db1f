"""A plant that breaks what is asked of a known gain, in exact arithmetic."""

from dataclasses import replace

import numpy as np

from ..exact.definite import exact
from ..plants.descriptor import MATRICES, Descriptor
from ..plants.joined import of_one
from ..plants.reduction import Reduction
from .fixed_mode import refuse_by_mode
from .request import Request
from .unreached import refuse_by_response


def broken(request, r, plants, point):
    """An exact proof that the plant at the rational ``point`` doesn't keep ``r``; None
    if unknown. It is about a polytope with that plant as a vertex, the request's own or
    a part of its family; elsewhere about that plant alone, in rationals. ``request``,
    ``r`` and ``plants`` are as for `sosbook.synthesis.known_gain.decided`.
    """
    asked, d = [r] if r in request.requirements else [], plants.at(point).plant
    if request.law is not None:
        return _broken_loop(request, r, plants.at(point).seen_by(r))
    part, k = request.plant, None
    if part.family is not None:
        part, k = plants.cornered(point)
    one = replace(request, requirements=asked, coupling="vertices", plant=part)
    for i in one.distinct if k is None else ():
        (v,) = one.vertices_in(exact, [i])
        if all((getattr(v, x) == getattr(d, x)).all() for x in MATRICES[:4]):
            k = i
    if k is None:
        plant, k = alone(d, request.plant), 0
        if plant is None:
            return None
        one = Request(plant, gain=request.gain, requirements=asked)
    return refuse_by_mode(one, [(k, k)]) or refuse_by_response(one, [k])


def _broken_loop(request, r, loop):
    """The proof about a loop by itself, whose law and output are in its matrices."""
    d, (E, A, B, C, D, rates) = loop.plant, loop.matrices
    D = None if d.Dw is None else D
    rates = None if d.Ca is None else rates
    d = Descriptor(E, A, d.Bu[:, :0], B, C, None, D, rates)
    plant = alone(d, request.plant)
    if plant is None:
        return None
    itself = r.pole_matrices() is not None or r.bounds_response() is not None
    one = Request(
        plant, gain=np.zeros((0, len(E))), requirements=[r.of_plant()] if itself else []
    )
    return refuse_by_mode(one, [(0, 0)]) or refuse_by_response(one, [0])


def alone(d, of):
    """A plant or loop ``d`` in rationals by itself, and a part of what ``of`` is a part
    of; None without one.
    """
    try:
        return of_one(d, Reduction.in_states(of, len(d.E)))
    except ValueError:  # its E is singular
        return None
