"""The whole plant under the gain of a reduced model: what is found, what is proven."""

import warnings

from ..exact.definite import round_digits
from ..exact.proof import DIGITS, Unproven
from ..exact.rational import digit_count
from ..plants.second_order import SecondOrderSystem
from ..runtime.sparse import issparse
from ..runtime.time_limit import under_way
from .feasibility import answer
from .found import found_on, law_on
from .known_gain import kept_or_broken
from .known_proof import known_proof
from .proofs import prove
from .request import Request
from .starting_points import point

SPARSE = (
    "a plant in sparse matrices is too large for LMIs, so nothing is proven of it; "
    "design.check_on(whole) looks for its poles in floats"
)


def proven_on(design, whole, digits):
    """An exact proof that a ``design``'s gain, lifted and rounded to so many ``digits``
    (several are tried without), keeps of one ``whole`` plant what is asked of the
    part's poles; the rest is about the part's coordinates, and a warning says so. Of a
    design for no part all is asked.
    """
    law, K = law_on(design, whole)
    if isinstance(whole, SecondOrderSystem) and issparse(whole.M):
        return Unproven(SPARSE)
    seen = found_on(design, whole)
    if seen.broken:
        cure = f"ask less of the whole: {_alone(law)} takes any region"
        return Unproven(f"the whole doesn't keep it. By a search, {seen}; {cure}")
    asked, proof = _asked_of_whole(design.request, law), None
    for few in DIGITS if digits is None else (digit_count(digits),):
        gain = round_digits(K, few)
        how = "pairs" if law.whole else "multipliers"
        asked_now = dict(requirements=asked, gain=gain, law=law, coupling=how)
        request = Request(whole, **asked_now)
        if not law.whole:
            words = "the poles of the whole keep it in floats; multipliers were sought"
            with under_way(words):
                known = kept_or_broken(request)
                if known.status == "feasible":
                    return known_proof(request, known.parts)
            proof = Unproven(f"{known.reason} {seen}")
            continue
        with under_way(
            f"the poles of the whole keep it in floats; a P of {request.order} states "
            f"was sought for the gain in {few} digits"
        ):
            solution = point(request)
            if solution is None and design.request.plant.reduction is None:
                solution = answer(request, refuse=False)
        if solution is not None and solution.status == "feasible":
            with under_way(
                "the poles of the whole keep it in floats, and a P is found; its "
                f"{len(solution.margins)} blocks of up to {request.order} rows or more "
                "were being decided in exact arithmetic, which is the longest part"
            ):
                proof = prove(request, solution.K, solution.P, own=solution.own)
            if proof.proven:
                return proof
    if not law.whole:
        return proof
    return proof or Unproven(
        "no point of the LMIs was found from the modes of the whole that floats can "
        f"tell from their edge. {seen}"
    )


def _alone(law):
    """The call that asks something of the whole under the gain, in words."""
    if law.whole:
        return "analyse_pid(whole, part.reduction.lift(K), ...)"
    return "analyse_pid(whole, K, law=law, ...), with the law of the whole,"


def _asked_of_whole(request, law):
    """The requirements on the whole: those on poles, where the design is of a part, or
    of a ``law`` that has its sensors.
    """
    if law.whole and request.plant.reduction is None:
        return list(request.requirements)
    asked = [r for r in request.requirements if r.pole_matrices() is not None]
    if left := [r.words for r in request.requirements if r not in asked]:
        warnings.warn(
            f"of the whole the poles alone are proven: {', '.join(left)} is asked in "
            f"the design's coordinates. Ask it in the whole's by {_alone(law)}",
            stacklevel=2,
        )
    return asked
