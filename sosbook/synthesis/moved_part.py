"""A point of a large plant's LMIs from those of the part that must move."""

from dataclasses import replace

import numpy as np
from scipy.linalg import LinAlgError, schur, solve_sylvester

from ..analysis.riccati import lyapunov
from ..plants.descriptor_system import DescriptorSystem
from ..runtime.time_limit import check_time, check_time_of_eigenvalues
from .request import Request
from .scaled_lmis import ScaledLMIs
from .scaling import Frame, in_unknowns_of
from .solution import Solution
from .starting_points import NOT_CENTRAL, SCHUR, InFrame, at, of_modes, units_of_modes

SIZES = 10.0 ** np.arange(-2, 11, 2)  # of the P of the modes that stay
PART = "{} of {} modes must move, and were looked at alone"
HARDLY = (
    "For them a gain with entries of up to {:.2g} was found, whose effect on the "
    "others floats don't tell: the inputs hardly move some of them. More inputs may, "
    "or others"
)
LOST = (
    "the efforts that move them lie sixteen digits apart, which floats don't tell from "
    "a mode that no input moves. More inputs may, or others"
)
LEAST = 1e-16  # of the largest effort's inverse


def is_of_parts(request):
    """True if all that a ``request`` asks can be asked of a part alone: poles, and K x.
    Modes that stay leave P without an end then, and so without a centre.
    """
    one = np.eye(request.order)
    return all(r.of_part(one) is not None for r in request.demands)


def point_of_part(request, solve, free=()):
    """The Solution of a ``request`` of one plant whose modes that must move ``solve``
    has a Solution of, with the part's bounds of the parameters ``free``; undecided
    where it has none, and None where what is asked isn't of a part.

    W' A = A_b W' for orthonormal columns W, and u = K_b W' x moves no other mode. With
    b = W' x and g in a complement, g' = A_g g + G b; R of a Sylvester equation makes h
    = g - R b move by itself, by A_g. P of b and any P of h that keeps what is asked of
    the poles of A_g, as large as x0 needs, are one of x. What excludes the part
    excludes the whole, too: nothing is lost, a least bound isn't either.
    """
    late = request.gain is not None or request.step is not None
    if late or len(request.vertices) > 1 or not is_of_parts(request):
        return None
    lmis = units_of_modes(request)
    if lmis is None:
        return None
    loop, frame = InFrame(request, lmis.frame), lmis.frame
    check_time_of_eigenvalues(request.order, SCHUR)
    S, Q, k = schur(loop.A.T, sort=lambda re, im: loop.moves(complex(re, im)))
    if not 0 < k < request.order:
        return None
    S, B = S.T, Q.T @ loop.B
    rows = Q[:, :k].T @ np.linalg.inv(frame.T)
    part = DescriptorSystem(np.eye(k), S[:k, :k], B[:k] / frame.scale)
    if _is_lost(S[:k, :k], B[:k], loop.decay() or np.abs(loop.poles).min() / 10):
        text = f"{PART.format(k, request.order)}: {LOST}."
        return Solution(request, "undecided", reason=text)
    asked = [r.of_part(rows) for r in request.requirements]  # stability joins again
    found = solve(Request(part, requirements=asked))
    K, how = found.K, PART.format(k, request.order)
    if found.status != "feasible":
        return Solution(request, "undecided", reason=f"{how}. {found.reason}")
    lost = f"{how}. {HARDLY.format(abs(K).max())}."
    undecided, K = Solution(request, "undecided", reason=lost), K / frame.scale
    why = f"{NOT_CENTRAL.format(how=how)} {found.reason if free else ''}".strip()
    try:
        R = solve_sylvester(
            S[k:, k:], -(S[:k, :k] + B[:k] @ K), -(S[k:, :k] + B[k:] @ K)
        )
        root = np.linalg.cholesky(of_modes(S[k:, k:]))
    except LinAlgError:
        return undecided
    # in [b; h], of which P has no other blocks than these two
    turn = np.hstack([Q @ np.vstack([np.eye(k), R]), Q[:, k:] @ root])
    bounds = {name: found.request.owner(name).bound for name in free}
    request, T = request.with_bounds(bounds), frame.T @ turn
    lmis = ScaledLMIs(request, Frame.at(request, T, frame.scale))
    K, own = found.K @ rows, T[:, :k] @ found.P @ T[:, :k].T
    rest = T[:, k:] @ T[:, k:].T * np.trace(found.P)
    for size in SIZES:
        check_time()
        whole = replace(found, request=request, K=K, P=own + size * rest)
        values = in_unknowns_of(request, lmis.frame, whole)
        point = None if values is None else at(lmis, values)
        if point is not None:
            return replace(point, central=False, reason=why)
    return undecided


def _is_lost(A, B, sigma):
    """True if the modes of A are right of -``sigma`` and the least effort that moves
    them left of it isn't one of floats: that of Y in `least_effort`.
    """
    F = A + sigma * np.eye(len(A))
    if np.linalg.eigvals(F).real.min() <= 0:
        return False
    sizes = np.linalg.eigvalsh(lyapunov(F, B @ B.T))
    return bool(sizes[0] < LEAST * sizes[-1])
