"""The proof of a loop of which only the poles are asked, in as many digits as it takes.

By Lyapunov's theorem a P exists whenever the poles lie where they should. Floats
may be too short to write it; here it has all the digits that its proof needs.
"""

import numpy as np
from flint import acb_mat, arb, ctx, fmpq, fmpq_mat

from ..analysis.linear import balancing
from ..exact.definite import exact, round_digits
from ..exact.proof import DIGITS
from ..exact.rational import digit_count, exact_margin, log2, rational_matrix
from ..runtime.time_limit import check_time
from .certificates import prove_with
from .placement import MOST_STATES, keeps, loop_matrix, placed_gain
from .pole_places import dyadic
from .scaling import Frame
from .solution import Solution

__all__ = ["decided_by_poles", "of_poles_alone", "prove_poles"]

BITS_AND_PLACES = (256, 25), (256, 50), (512, 100), (1024, 200), (2048, 400)


def of_poles_alone(request):
    """Whether a request asks one plant for the place of its poles and no more."""
    return (
        len(request.vertices) == 1
        and request.coupling != "slack"
        and request.order <= MOST_STATES
        and all(r.of_poles for r in request.demands)
    )


def decided_by_poles(request):
    """The Solution of a request of poles alone; None where none was found.

    Parameters
    ----------
    request : Request
        With or without a gain that is given.
    """
    if not of_poles_alone(request):
        return None
    K = placed_gain(request) if request.gain is None else request.gain
    P = None if K is None else _proven_P(request, K)
    if P is None:
        return None
    margins = {n: exact_margin(g) for n, g in _blocks(request, K, P).items()}
    P = P.astype(float)
    frame = Frame.of(request)
    return Solution(request, "feasible", K, P, K @ P, None, margins, frame, own={})


def prove_poles(request, K, digits=None):
    """The `Certificate` of a gain, with a P of many digits; None where there is none.

    Parameters
    ----------
    request : Request
        What is asked of the plant.
    K : (m, N) array
        The gain.
    digits : int or None
        As in `prove`.
    """
    if not of_poles_alone(request):
        return None
    tries = DIGITS if request.gain is None else DIGITS[-1:]
    for some in tries if digits is None else (digit_count(digits),):
        rounded = round_digits(K, some)
        P = _proven_P(request, rounded)
        if P is not None:
            return prove_with(request, rounded, {"P": P})
    return None


def _blocks(request, K, P):
    return request.blocks(P, exact(K) @ P, exact)


def _proven_P(request, K):
    """A rational P that proves a loop; None where a pole is out of place."""
    if not keeps(request, K):
        return None
    A = loop_matrix(request, K)
    for bits, places in BITS_AND_PLACES:
        check_time()
        P = _of_eigenvectors(A, bits, places)
        if P is not None and prove_with(request, K, {"P": P}).proven:
            return P
    return None


def _of_eigenvectors(A, bits, places):
    """Re V V* of the right eigenvectors V of A, rounded to some decimal places.

    With A V = V L it turns alpha P + beta A P + beta' P A' into a congruence of
    alpha + beta L + beta' L*, a diagonal matrix for each pair of entries, which is
    negative if all poles lie in the region. Rounding isn't looked at: the proof is.
    """
    N = A.nrows()
    floats = np.array([[float(e) for e in row] for row in A.table()])
    units = [fmpq(2) ** int(k) for k in np.log2(balancing(floats))]
    scaled = [[A[i, j] * units[j] / units[i] for j in range(N)] for i in range(N)]
    with ctx.workprec(bits):
        _, V = acb_mat(fmpq_mat(scaled)).eig(right=True, algorithm="approx")
        sizes = [sum((abs(V[i, k]) ** 2 for i in range(N)), arb(0)) for k in range(N)]

        def entry(i, j):
            terms = ((V[i, k] * V[j, k].conjugate()).real / sizes[k] for k in range(N))
            return dyadic(sum(terms, arb(0))) * units[i] * units[j]

        P = [[entry(i, j) for j in range(i + 1)] for i in range(N)]
    roots = [round(log2(P[i][i]) * np.log10(2) / 2) for i in range(N)]
    top = max(roots)
    rounded = [[None] * N for _ in range(N)]
    for i in range(N):
        for j in range(i + 1):
            # relative to the diagonal, which is about one at most
            unit = fmpq(10) ** (places - roots[i] - roots[j])
            x = fmpq((P[i][j] * unit).round()) / unit / fmpq(100) ** top
            rounded[i][j] = rounded[j][i] = x
    return rational_matrix(rounded)
