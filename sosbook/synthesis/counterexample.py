"""A plant that breaks what is asked of a known gain, in exact arithmetic."""

import re
from dataclasses import replace

import numpy as np
from flint import arb, arb_mat, ctx, fmpq_mat
from scipy.linalg import expm

from ..exact.definite import exact, inverse, round_digits
from ..plants.descriptor import MATRICES, Descriptor
from ..plants.joined import of_one
from ..plants.reduction import Reduction
from .feasibility import answer
from .fixed_mode import FixedModeRefusal, refuse_by_mode
from .request import Request
from .unreached import refuse_by_response

PLACE = r"the (vertex \d+|plant( with \S+ = \S+( and \S+ = \S+)*)?)(?!\w)"
CLEARLY = 1e-9  # outside of a region, of a mode's place
MOST_STATES = 24  # of a loop whose LMIs are refused; larger ones take long
BITS = 256  # of the arithmetic that encloses a motion
DECAYED = 10.0  # slowest time constants in which a peak is looked for
SAMPLES = 2000  # of a motion
REFINED = 200.0  # times a bracket of the peak is cut


def broken(request, r, plants, point):
    """An exact proof that the plant at the rational ``point`` of the ``plants`` doesn't
    keep ``r`` of a ``request``, and what it says, in words; None if unknown. A plant
    that is no vertex, nor in the family's parts, is judged alone.
    """
    where = plants.point_words(point)
    proof = _by_a_mode(request, r, plants, point)
    if proof is not None:  # its vertices are those of a part
        claim = re.sub(PLACE, lambda _: where, _named(r, proof), count=1)
        return proof, f"{claim[0].upper()}{claim[1:]}."
    words = _value(request, r, plants.at(point)) if r.parameter is not None else None
    one = words and itself(request, r, plants.at(point))
    if not one or one.order > MOST_STATES or not one.requirements:
        return None
    proof = answer(one).infeasibility
    where = f"{where[0].upper()}{where[1:]}"
    return proof and (proof, f"{where} has under the given gain {words}.")


def _named(r, proof):
    """The words of a proof; of a region by its name where the mode is outside of what
    is named, too: the matrices lie inside of that, by a rounding error.
    """
    (claim, *_), before = proof.claims, "which breaks: "
    said, there, _ = claim.partition(before)
    if not there or "alpha + beta s" not in claim or r.pole_matrices() is None:
        return claim
    if not isinstance(proof, FixedModeRefusal):  # where its pole is isn't known
        return claim
    s = proof.mode
    outside = r.distance(s) < -CLEARLY * max(abs(s), 1.0)
    return f"{said}{before}{r.claim()}" if outside else claim


def _value(request, r, loop):
    """The value of ``r`` in a loop; an H2 norm or a cost of one loop loses nothing."""
    value = r.truth([loop.plant_in_floats], request.state_gain, request.K_A)
    if r.kept(value) > 0 or not np.isfinite(value):
        return None
    if r.lossless and r.of_package:
        return (
            f"{r.parameter.key} = {value:.6g}, which breaks: {r.claim()}. Of one plant "
            "these inequalities lose nothing, and exact multipliers exclude them"
        )
    start = r.bounds_input_from()
    if start is None or not request.law.whole:
        return None
    E, A, *_ = loop.matrices
    A, K, x0 = inverse(E) @ A, loop.K, exact(start)[:, None]
    t, u = _peak(A.astype(float), request.gain, start), K @ x0
    if (u.T @ u).item() > exact(r.bound) ** 2:
        size = float((u.T @ u).item()) ** 0.5
        return f"|K x(0)| = {size:.6g}, which breaks: {r.claim()}"
    with ctx.workprec(BITS):
        A, K, x0 = (arb_mat(fmpq_mat(x.tolist())) for x in (A * exact(t), K, x0))
        u = (K * A.exp() * x0).entries()
        squares = sum((x * x for x in u), arb(0))
        if not squares > arb(exact(r.bound) ** 2):
            return None
        size = float(squares.sqrt().mid())
    return f"|K x| = {size:.6g} at t = {t:g} s, enclosed, which breaks: {r.claim()}"


def _peak(A, K, x0):
    """A time of few digits near the largest |K x| of x' = ``A`` x from ``x0``."""
    end = DECAYED / -np.linalg.eigvals(A).real.max()
    best = 0.0
    for width in end * REFINED ** -np.arange(4.0):
        times = np.linspace(max(best - width, 0.0), best + width, SAMPLES)
        x, step = expm(A * times[0]) @ x0, expm(A * (times[1] - times[0]))
        sizes = []
        for _ in times:
            sizes.append(np.linalg.norm(K @ x))
            x = step @ x
        best = times[int(np.argmax(sizes))]
    return float(round_digits(np.array(best), 6))


def _by_a_mode(request, r, plants, point):
    """The proof by a mode or a response."""
    asked, d = [r] if r in request.requirements else [], plants.at(point).plant
    if not request.law.whole:
        one = itself(request, r, plants.at(point))
        return one and (refuse_by_mode(one, [(0, 0)]) or refuse_by_response(one, [0]))
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


def itself(request, r, loop):
    """The Request of ``r``, which a ``request`` asks, for one ``loop`` by itself, its
    output in its matrices, and its gain, too, unless x and u are weighed; None where it
    can't stand alone.
    """
    loop, asked = loop.seen_by(r), []
    d, (E, A, B, C, D, rates) = loop.plant, loop.matrices
    D = None if d.Dw is None else D
    rates = None if d.Ca is None else rates
    weighs = r.pole_matrices() is None and not r.needs_disturbance
    if weighs and request.law.whole:
        asked, gain = [r], request.gain
    else:
        d = Descriptor(E, A, d.Bu[:, :0], B, C, None, D, rates)
        gain = np.zeros((0, len(E)))
        asked = [] if weighs else [r.of_plant()]
    plant = alone(d, request.plant)
    return None if plant is None else Request(plant, gain=gain, requirements=asked)


def alone(d, of):
    """A plant or loop ``d`` in rationals by itself, and a part of what ``of`` is a part
    of; None without one.
    """
    try:
        part = Reduction.in_states(of, len(d.E))
        return of_one(d, part, getattr(of, "dt", None))
    except ValueError:  # its E is singular
        return None
