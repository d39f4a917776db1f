"""Proofs in exact rational arithmetic, of a loop or of its absence."""

from dataclasses import dataclass

import numpy as np

from ..lmi.exact import exact, round_digits
from ..lmi.proof import InfeasibilityCertificate, Proof, refute
from ..plants.checks import matrix

__all__ = [
    "Certificate",
    "InfeasibilityCertificate",
    "Proof",
    "prove",
    "prove_infeasible",
    "refute",
]


@dataclass(frozen=True, eq=False)
class Certificate(Proof):
    """An exact proof that a gain does what was asked, or its failure.

    Parameters
    ----------
    proven, claims, blocks, failed
        As in `Proof`.
    K : (m, N) array
        The gain that the proof is about: rounded to the printed digits.
    P : (N, N) array, or (vertices, N, N) with a slack matrix
        The rational Lyapunov matrix, as decimal floats.
    V : (N, N) array or None
        The rational slack matrix.
    """

    K: np.ndarray
    P: np.ndarray
    V: np.ndarray = None


def prove(request, K, P, digits=6, V=None, own=None):
    """Check every block of a request in exact arithmetic.

    Parameters
    ----------
    request : Request
    K : (m, N) array
        Rounded to ``digits`` significant digits before the proof.
    P : (N, N) array
        Rounded too; must be symmetric. With ``coupling="slack"`` one
        for each vertex.
    V : (N, N) array, optional
        The slack matrix; rounded too.
    own : dict, optional
        The requirements' own unknowns, by name; rounded too.

    Returns
    -------
    Certificate
    """
    if not isinstance(digits, int) or digits < 1:
        raise ValueError(f"digits must be 1 or more, got {digits!r}")
    shape = (request.order, request.order)
    K = round_digits(matrix("K", K, (request.plant.m, request.order)), digits)
    if request.coupling == "slack":
        P = np.array([matrix("P", p, shape) for p in P])
        V = matrix("V", V, shape)
    else:
        P = V = matrix("P", P, shape)
    slack = V if request.coupling == "slack" else None
    if not np.array_equal(P, P.swapaxes(-1, -2)):
        return Certificate(
            False, (), {}, ("P isn't symmetric",), K, P, slack)
    gain = exact(K)
    for places in (12, 17):  # short rationals first, then all digits
        lyapunov = exact(round_digits(P, places))
        right = exact(round_digits(V, places))
        found = Proof.of(request.blocks(
            lyapunov, gain @ right.T, exact, V=right, own={
                name: exact(round_digits(value, places))
                for name, value in (own or {}).items()},
        ), _claims(request))
        if found["proven"]:
            break
    P = round_digits(P, places)
    if slack is not None:
        slack = round_digits(V, places)
    return Certificate(**found, K=K, P=P, V=slack)


def _claims(request):
    N = len(request.vertices)
    if N == 1:
        where = "the plant"
    elif request.covers_polytope:
        where = "every plant of the polytope"
    else:
        where = f"each of the {N} vertices (not the plants between)"
    under = ", under u = K x," if request.plant.m else ""
    words = [f"{where}{under} is stable"]
    words += [r.claim() for r in request.requirements]
    return tuple(words)


def prove_infeasible(request, frame, Z):
    """Exact multipliers from float ones, where the repair succeeds.

    Parameters
    ----------
    request : Request
    frame : Frame
    Z : list of arrays
        Multipliers of the blocks in that frame.

    Returns
    -------
    InfeasibilityCertificate
    """
    return refute(*request.in_unknowns(frame, exact), Z)
