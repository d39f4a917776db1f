"""The doors of "infeasible" for a law: what excludes every gain, exactly."""

import numpy as np

from ...exact.rational import exact, fractions, inverse
from ...exact.refusal import Refusal
from ...requirements.vocabulary import SIGMA
from ...runtime.time_limit import OutOfTime, time_limit
from ..counterexample import alone
from ..feasibility import answer
from ..fixed_mode import OfLaw, parts_data, refuse_by_mode
from ..request import Request
from ..request_as_data import loop_data
from ..solution import Solution
from ..unreached import refuse_by_response
from .any_order import excluded, of_plant_alone
from .moving_gain import corners_of, vertex_of

SECONDS = 20.0  # for the refusal of each plant by all of its state


class SumOfPoles(Refusal):
    """The poles' mean isn't left of what is asked, and no gain of the law moves it: the
    sum of the poles is the trace of E^-1 (A + B K C_y), and every K_k of the law has a
    product of trace zero there. ``text`` is that of a file with the plant, what the law
    joins to it, the K_k and the half-plane, None for the left one.
    """

    kind = "sum of poles"

    @classmethod
    def contents(cls, request, r, k, directions):
        """The data of the file, of a ``request`` whose law is left to it: ``r`` is the
        half-plane, None where it is the left one, ``k`` the vertex with the poles, from
        0, and ``directions`` those of the law's gains.
        """
        return {
            **loop_data(request),
            "law": parts_data(request.applied.parts),
            "gains": [fractions(exact(K)) for K in directions],
            "requirement": None if r is None else r.data(),
            "vertex": k,
        }


def mean_pole(d, parts, directions):
    """The mean of the poles of a plant ``d`` in rationals with the ``parts`` that a law
    joins; None if a gain, of the ``directions``, moves it.
    """
    whole = parts.joined(d)
    back = inverse(whole.E)
    pushed, measured = back @ whole.Bu, parts.measured
    if any((pushed @ exact(K) @ measured).trace() != 0 for K in directions):
        return None
    return (back @ whole.A).trace() / len(whole.E)


def refused_by_sum(request, loops, sought):
    """The Solution of a ``request`` with a law whose decay, or whose stability, the sum
    of the poles excludes; or None. ``loops`` are its own, whose structure is read; a
    bound that is ``sought`` refuses nothing.
    """
    if loops.first.any() or request.step is not None:
        return None  # a file says nothing of what is fixed, or of ticks
    asked = [r for r in request.requirements if r.parameter is SIGMA and r.bound > 0]
    r = max((r for r in asked if r is not sought), key=lambda r: r.bound, default=None)
    sigma = exact(0.0 if r is None else r.bound)  # the loop is stable in any case
    for d in corners_of(request).values():
        mean = mean_pole(d, request.applied.parts, loops.directions)
        if mean is None or mean + sigma < 0:
            continue
        _, k = vertex_of(request, d)
        proof = SumOfPoles.of(SumOfPoles.contents(request, r, k, loops.directions))
        text = f"{proof.claims[0][0].upper()}{proof.claims[0][1:]}."
        return Solution(request, "infeasible", None, reason=text, infeasibility=proof)
    return None


def refused_by_mode(request, sought=None):
    """The Solution of a ``request`` with a mode that no gain of the law moves; or None.
    Either its motion leaves the sensors still, or the input doesn't reach it, in the
    plant or in that with the law's states; a bound that is ``sought`` refuses nothing.
    """
    parts = request.applied.parts
    asked = [r for r in request.requirements if r.pole_matrices() and r is not sought]
    for where, d in corners_of(request).items():
        one, k = vertex_of(request, d, tuple(asked))
        for how, who, why in (
            (OfLaw(parts, True), "No controller", "these sensors don't see it"),
            (None, "No controller", "the input doesn't reach it"),
            (OfLaw(parts, False), "No gain of the law", "the input doesn't reach it"),
        ):
            proof = refuse_by_mode(one, [(k, k)], how)
            if proof:
                at = request.claims.place(proof.mode)
                text = f"{who} moves the mode of {where} at {at}: {why}. "
                text += f"It violates {proof.requirement}."
                return _refused(request, text, proof)
    return None


def _refused(request, text, proof):
    """The Solution with a proof, its reason a text that begins with "No"."""
    part = request.plant.reduction
    if part is not None:
        text = f"O{part.words[1:]}n{text[1:]}"
    return Solution(request, "infeasible", None, reason=text, infeasibility=proof)


def refused_by_a_door(request, sought=None):
    """The Solution of a ``request`` that excludes every controller at a corner; or
    None. One requirement at a time: by all of the state, and for a norm by every
    controller that sees what the law sees; what is ``sought`` has no bound that could
    be refused.
    """
    corners = corners_of(request)
    for where, d in corners.items():
        for r in request.requirements:
            if sought is not None and (r is sought or r.parameter is sought is SIGMA):
                continue
            proof, who = _all_of_the_state(request, d, r), "that sees all of the state"
            if proof is None and r.bounds_response() is not None:
                who = "of any order, with these sensors,"
                proof = excluded(request, d, r, r.bound)
            if proof is not None:
                at = f" for {where}" if len(corners) > 1 else ""
                text = f"No linear controller {who} keeps{at}: {r.statement}."
                return _refused(request, text, proof)
    return None


def _all_of_the_state(request, d, r):
    """The refusal of a requirement of a plant d by a state feedback, or None. Where x
    is measured without noise a static K does what any linear controller does: poles
    that can be moved go anywhere, and for the norm see P. P. Khargonekar, I. R.
    Petersen and M. A. Rotea, IEEE Trans. Automat. Control 33, 1988.
    """
    noisy = (request.applied.parts.noise != 0).any()
    if r.pole_matrices() is None and (r.bounds_response() is None or noisy):
        return None
    r, whole = of_plant_alone(r, d, request.applied.parts)
    if r is None:
        return None
    one, k = vertex_of(request, d, (r,))
    if len(one.vertices) > 1:  # the LMIs of all are no matter of this one
        if (proof := refuse_by_response(one, [k])) is not None:
            return proof
        plant = alone(whole, request.plant)
        if plant is None:
            return None
        one = Request(plant, requirements=[r.of_plant()])
    try:
        with time_limit(SECONDS):
            solution = answer(one)
    except (OutOfTime, np.linalg.LinAlgError, ArithmeticError):
        return None
    refused = solution.status == "infeasible" and solution.infeasibility.proven
    return solution.infeasibility if refused else None
