"""The doors of "infeasible" for a law: what excludes every gain, exactly."""

from dataclasses import replace
from math import floor, log10

import numpy as np

from ...exact.proof import Examined
from ...exact.rational import decimals, exact, fractions, inverse, read_fractions
from ...exact.refusal import Refusal
from ...requirements.vocabulary import SIGMA
from ...runtime.time_limit import OutOfTime, time_limit
from ..broken import alone
from ..feasibility import answer
from ..fixed_mode import refuse_by_mode
from ..known_certificate import Joined, parts_data
from ..request import Request
from ..request_as_data import loop_data, read_request
from ..solution import Solution
from .any_order import excluded, seen
from .loops import corners_of

__all__ = [
    "SumOfPoles",
    "mean_pole",
    "refused_by_a_door",
    "refused_by_mode",
    "refused_by_sum",
]

SECONDS = 20.0  # for the refusal of each plant by all of its state


class SumOfPoles(Refusal):
    """The poles' mean lies too far right, and no gain of the law moves it.

    The sum of the poles is the trace of E^-1 (A + B K C_y), and every K_k of the law
    has a product of trace zero there. ``text`` is that of a file with the plant, what
    the law joins to it, the K_k and the half-plane.
    """

    kind = "sum of poles"

    @classmethod
    def examine(cls, data):
        directions = [read_fractions(K) for K in data["gains"]]
        if not directions or data["U"]:
            raise ValueError("the gains of a law are needed, and no U")
        law, wide = Joined(data["law"], len(directions[0])), directions[0].shape
        asked = dict(coupling="multipliers", epsilon=None, E0=None)
        asked = data | asked | dict(requirements=[data["requirement"]])
        request = read_request(asked, gain=decimals(np.zeros(wide)), law=law)
        (r,), places = request.requirements, list(corners_of(request).items())
        k, parts = data["vertex"], request.law_parts
        if type(k) is not int or not 0 <= k < len(places) or r.parameter is not SIGMA:
            raise ValueError("a vertex, from 0, and a half-plane are needed")
        mean = mean_pole(places[k][1], parts, directions)
        if mean is None:
            raise ValueError("a gain moves the sum of the poles")
        gains = [fractions(K) for K in directions]
        known = dict(loop_data(request), law=parts_data(parts), gains=gains)
        again = cls.contents(known, r, k, places[k][0], mean)
        beyond = mean + exact(r.bound)
        failed = () if beyond > 0 else ("mean",)
        claims = () if failed else tuple(again["claims"])
        return again, Examined(claims, {"mean": float(beyond)}, failed)

    @classmethod
    def contents(cls, known, r, k, where, mean):
        """The data of the file.

        Parameters
        ----------
        known : dict
            Plant, U, K_A, law and gains.
        r : Requirement
            The half-plane.
        k, where : int and str
            The number and the words of the plant that has the poles.
        mean : Rational
            Of its poles.
        """
        claim = (
            f"no gain of the law moves the sum of the poles of {where}; one "
            f"of them has a real part of at least {_downwards(mean)}, so none keeps: "
            f"{r.statement}"
        )
        return {"claims": [claim], **known, "requirement": r.data(), "vertex": k}


def _downwards(x):
    """A rational in six digits, not above it."""
    words = f"{float(x):.6g}"
    if exact(float(words)) <= x:
        return words
    return f"{float(x) - 10.0 ** (floor(log10(abs(float(x)))) - 5):.6g}"


def mean_pole(d, parts, directions):
    """The mean of the poles of a plant d with a law; None if a gain moves it.

    ``d``: without the law, in rationals; ``parts``: what the law joins; ``directions``:
    of its gains.
    """
    whole = parts.joined(d)
    back = inverse(whole.E)
    pushed, measured = back @ whole.Bu, parts.measured
    if any((pushed @ exact(K) @ measured).trace() != 0 for K in directions):
        return None
    return (back @ whole.A).trace() / len(whole.E)


def refused_by_sum(request, loops):
    """The Solution of a request whose decay the sum of the poles excludes; or None.

    ``request``: with a law; ``loops``: its loops, whose structure is read.
    """
    asked = [r for r in request.requirements if r.parameter is SIGMA]
    if not asked:
        return None
    r = max(asked, key=lambda r: r.bound)
    parts = request.law_parts
    for k, (where, d) in enumerate(corners_of(request).items()):
        mean = mean_pole(d, parts, loops.directions)
        if mean is None or mean + exact(r.bound) <= 0:
            continue
        gains = [fractions(exact(K)) for K in loops.directions]
        known = dict(loop_data(request), law=parts_data(parts), gains=gains)
        proof = SumOfPoles.of(SumOfPoles.contents(known, r, k, where, mean))
        text = f"{proof.claims[0][0].upper()}{proof.claims[0][1:]}."
        return Solution(request, "infeasible", None, reason=text, infeasibility=proof)
    return None


DUAL = " The proof is about the transposed plant, whose inputs are the sensors."
JOINED = " The proof is about the plant with the law's states."


def refused_by_mode(request, sought=None):
    """The Solution of a request with a mode that no gain of the law moves; or None.

    Either its motion leaves the sensors still: then it is one of the transposed plant
    E' x' = A' x + C' u, where C are the sensors, that no input moves. The proof is
    about that plant, which has the same poles. Or the input doesn't reach it, in the
    plant or in that with the law's states. ``sought``: the requirement whose bound is
    looked for, which refuses nothing.
    """
    parts = request.law_parts
    asked = [r for r in request.requirements if r.pole_matrices() and r is not sought]
    for where, d in corners_of(request).items():
        none = exact(np.zeros((len(d.E), 0)))
        dual = dict(E=d.E.T, A=d.A.T, Bu=parts.rows.T, Bw=none, C=none.T)
        dual |= dict.fromkeys(("Du", "Dw", "Ca"))
        for side, who, why, about in (
            (replace(d, **dual), "No controller", "these sensors don't see it", DUAL),
            (d, "No controller", "the input doesn't reach it", ""),
            (
                parts.joined(d),
                "No gain of the law",
                "the input doesn't reach it",
                JOINED,
            ),
        ):
            plant = alone(side, request.plant)
            proof = plant and refuse_by_mode(Request(plant, requirements=asked))
            if proof:
                text = (
                    f"{who} moves the mode of {where} at {proof.mode:.4g} rad/s: "
                    f"{why}. It violates {proof.requirement}.{about}"
                )
                return _refused(request, text, proof)
    return None


def _refused(request, text, proof):
    """The Solution with a proof, its reason a text that begins with "No"."""
    part = request.plant.reduction
    if part is not None:
        text = f"O{part.words[1:]}n{text[1:]}"
    return Solution(request, "infeasible", None, reason=text, infeasibility=proof)


def refused_by_a_door(request, sought=None):
    """The Solution of a request that excludes every controller at a corner; or None.

    One requirement at a time: by all of the state, and for a norm by every controller
    that sees what the law sees. What is sought has no bound that could be refused.
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
                at = f" at {where}" if len(corners) > 1 else ""
                text = f"No linear controller {who} keeps{at}: {r.statement}."
                return _refused(request, text, proof)
    return None


def _all_of_the_state(request, d, r):
    """The refusal of a requirement of a plant d by a state feedback, or None.

    Where x is measured without noise a static K does what any linear controller does:
    poles that can be moved go anywhere, and for the norm see P. P. Khargonekar, I. R.
    Petersen and M. A. Rotea, IEEE Trans. Automat. Control 33, 1988.
    """
    noisy = (request.law_parts.noise != 0).any()
    if r.pole_matrices() is None and (r.bounds_response() is None or noisy):
        return None
    whole = seen(r, d)
    plant = whole and alone(whole, request.plant)
    if plant is None:
        return None
    try:
        one = Request(plant, requirements=[r.of_plant()])
        with time_limit(SECONDS):
            solution = answer(one)
    except (OutOfTime, np.linalg.LinAlgError, ArithmeticError):
        return None
    refused = solution.status == "infeasible" and solution.infeasibility.proven
    return solution.infeasibility if refused else None
