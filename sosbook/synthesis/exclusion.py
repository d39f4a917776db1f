"""Why there is no design: what is proven, and what was merely not found."""

from itertools import combinations, islice

import numpy as np

from ..exact.definite import exact
from ..plants.controllability import fixed_part, is_singular, matrix_of
from ..requirements.stability import Stability
from ..runtime.time_limit import check_time
from .exclusion_certificates import (
    FixedModeCertificate,
    SingularMassCertificate,
    plant_at,
)

__all__ = [
    "FixedModeCertificate",
    "SingularMassCertificate",
    "excluding_mass",
    "excluding_mode",
    "why_refused",
]

MOST_STATES = 20  # up to which it pays to prove how far multipliers reach
LEAST_RADIUS = 10.0  # of the gains in natural units; a shorter one isn't worth a word
MOST_MIDPOINTS = 100  # pairs of vertices between which the plant halfway is looked at


def excluding_mass(request):
    """The `SingularMassCertificate` of a request, or None without one.

    A proof for the whole polytope would make a plant without mass there
    stable; where only the vertices count, nothing is excluded.
    """
    vertices = request.vertices
    if request.coupling == "vertices" or all(
        np.array_equal(d.E, vertices[0].E) for d in vertices
    ):
        return None
    exactly = [matrix_of(d.E) for d in request.vertices_in(exact)]
    signs = [E.det() > 0 for E in exactly]
    if len(set(signs)) > 1:
        places = [sorted((signs.index(True), signs.index(False)))]
    else:
        pairs = islice(combinations(range(len(exactly)), 2), MOST_MIDPOINTS)
        places = [(i, j) for i, j in pairs if is_singular(exactly[i] + exactly[j])]
    proofs = (SingularMassCertificate.of_pair(request, *place) for place in places)
    return next((proof for proof in proofs if proof.proven), None)


def _parts(request):
    """The `FixedPart` of each plant that must be stable, with its place.

    These are the vertices and, where the whole polytope is meant, the
    plants halfway between two. None where the part isn't known.
    """
    count = len(request.vertices)
    places = [(k, k) for k in range(count)]
    if request.coupling != "vertices":
        pairs = combinations(range(count), 2)
        places += list(islice(pairs, MOST_MIDPOINTS))
    for place in places:
        check_time()
        yield place, fixed_part(*plant_at(request, place))


def excluding_mode(request):
    """The `FixedModeCertificate` of a request, or None without one."""
    asked = request.demands
    if not any(isinstance(r, Stability) for r in asked):
        asked = (*asked, Stability())  # whatever else is asked, all claims say it
    for place, part in _parts(request):
        for mode in part.modes() if part is not None else ():
            for r in asked:
                if r.holds_at(mode) is False:
                    proof = FixedModeCertificate.of_mode(request, place, part, mode, r)
                    if proof.proven:
                        return proof
    return None


def _proven_reach(first):
    """No point is shorter than this; exact, 0 if unknown."""
    if first.multipliers is None or first.problem.request.order > MOST_STATES:
        return 0.0
    return first.problem.excluded_radius(first.multipliers)


def _rounded_down(x):
    """To one digit, never more than x."""
    if np.isinf(x):
        return "any"
    power = int(np.floor(np.log10(x)))
    return f"{int(x / 10.0**power)}e{power}"


def why_refused(first):
    """Words for what phase one has seen where no proof was found.

    Parameters
    ----------
    first : LMISolution
        Of `ScaledLMIs`, without a point.

    Returns
    -------
    str
        The reason, in a sentence.
    """
    request = first.problem.request
    unknowns = "P" if request.gain is not None else "P, Y"
    if request.coupling == "slack":
        unknowns = unknowns.replace("P", "P_i, V", 1)
    reach = _proven_reach(first)
    if reach > LEAST_RADIUS:
        return (
            f"Exact multipliers exclude all {unknowns} shorter than "
            f"{_rounded_down(reach)} in the solver's coordinates; no exact proof was "
            "found that there is none at all."
        )
    if first.verdict == "infeasible":
        size = (
            "however large"
            if np.isinf(first.excluded_radius)
            else f"up to {first.excluded_radius:.0e}"
        )
        return (
            f"No {unknowns} {size} in the solver's coordinates, by multipliers "
            "in floating point; no exact proof was found."
        )
    return f"The numerics found neither {unknowns} nor multipliers that exclude them."
