"""Why an input bound is too small for the modes that must be moved.

The LMIs of a plant imply those of a part of it: with rows W that A leaves
invariant, W A = L W E, they hold for p = V P V' and y = Y V', where V = W E, with
L, b = W B and the initial state V x0. The part of the modes outside of the region
decides: the other modes take any P that is large enough, and Y = 0. It is solved
instead of the whole because there multipliers may be positive definite; those of
the whole vanish on the other modes, which have irrational entries.

For one mode s and a half-plane the multipliers exist if and only if
dist(s) |W E x0| >= |W B| u_max.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import schur

from ..lmi.exact import exact, round_digits
from ..lmi.time_limit import check_time
from ..plants.descriptor_system import DescriptorSystem
from ..requirements.lmi_region import LMIRegion
from .problem import Request
from .scaling import Frame
from .small_input_certificate import (
    ModesPart,
    SmallInputCertificate,
    input_bound,
    pole_demands,
    real_form,
)

__all__ = ["excluding_input"]

MOST_VERTICES = 32  # that are tried
OUTSIDE = 1e-9  # of the fastest mode; what lies nearer is left with the modes inside
RIDGE = 1e-10  # relative; keeps multipliers positive definite when they are rounded
DIGITS = 14  # of the multipliers
ROOM = 1.01  # by which bounds are wider than their image, in three digits
WIDE_ROOM = 2.0  # the same, where they grow slowly
SMALL_STEPS = 8  # before the room is wide
LEAST_BOUND = 1e-25  # relative; exact data leave no error at all


def excluding_input(request, search):
    """The `SmallInputCertificate` of a request, or None without one.

    Parameters
    ----------
    request : Request
        What is asked of the plant.
    search : callable
        From a Request to an `LMISolution`.
    """
    bound = input_bound(request)
    if bound is None or request.gain is not None or request.coupling == "slack":
        return None
    for k in request.distinct[:MOST_VERTICES]:
        check_time()
        try:
            proof = _at_vertex(request, bound, k, search)
        except (ArithmeticError, ValueError):  # LinAlgError is a ValueError
            continue
        if proof is not None and proof.proven:
            return proof
    return None


def _at_vertex(request, bound, k, search):
    d, frame = request.vertices[k], Frame.of(request)
    left = np.linalg.inv(d.E @ frame.T)
    A = left @ d.A @ frame.T
    regions = pole_demands(request).values()

    def bad(x, y=None):
        s = x if y is None else complex(x, y)
        return min(_distance(r, s) for r in regions) < -OUTSIDE * fastest

    fastest = np.abs(np.linalg.eigvals(A)).max()
    _, rows, count = schur(A.T, output="complex", sort=bad)
    real = schur(A.T, sort=bad)
    if not 0 < count < len(A) or real[2] != count:
        return None
    rows, small = rows.conj().T, real[1][:, :count].T
    turn = rows[:count] @ small.T  # from the real basis of the part to the complex
    start = np.linalg.solve(frame.T, bound.bounds_input_from())
    part = DescriptorSystem(np.eye(count), small @ A @ small.T, small @ left @ d.Bu)
    kept = [r for r in request.requirements if isinstance(r, LMIRegion)]
    reduced = Request(part, requirements=[*kept, replace(bound, x0=small @ start)])
    first = search(reduced)
    if first.values is not None or first.multipliers is None:
        return None
    bases = [[x.real, x.imag] for x in (rows @ left, frame.T @ rows.conj().T)]
    enclosure = _enclosed(request, bound, k, bases, count)
    if enclosure is None:
        return None
    spread, blur = (x.astype(float) for x in (enclosure.spread, enclosure.blur))
    multipliers = _completed(
        request, enclosure, *_multipliers(first, bound.parameter.key, turn)
    )
    return SmallInputCertificate.of(
        SmallInputCertificate.contents(request, k, bases, spread, blur, *multipliers)
    )


def _distance(requirement, s):
    if isinstance(requirement, LMIRegion):
        return requirement.distance(s)
    return -s.real


def _enclosed(request, bound, k, bases, count):
    """A `ModesPart` in rationals with bounds that hold, or None."""
    d = request.vertices_in(exact)[k]
    T, R = (real_form(*map(exact, x)) for x in bases)
    start = exact(bound.bounds_input_from())[:, None]
    part = ModesPart(d.E, d.A, d.Bu, start, T, R, count)
    near, N = part.in_floats(), request.order
    least = LEAST_BOUND * np.abs(near.K).max()
    spread, blur = np.zeros((count, N - count)), np.zeros((count, count))
    for step in range(4 * N + 20):
        room = ROOM if step < SMALL_STEPS else WIDE_ROOM
        new_spread, gaps, new_blur = near.within(spread, blur).image()
        if not (gaps > 0).all():
            return None
        new_spread = new_spread / gaps
        if (new_spread <= spread).all() and (new_blur <= blur).all():
            part = part.within(exact(spread), exact(blur))
            return part if part.holds() else None
        spread = _rounded_up(np.maximum(spread, new_spread + LEAST_BOUND), room)
        blur = _rounded_up(np.maximum(blur, new_blur + least), room)
        if not max(spread.max(), blur.max() / np.abs(near.K).max()) < 1:
            return None
    return None


def _rounded_up(x, room):
    return round_digits(room * x, 3)


def _multipliers(first, block, turn):
    """Those of the part, in its complex basis.

    Parameters
    ----------
    first : LMISolution
        Of the part in its real basis.
    block : str
        The name of the block of the input bound.
    turn : (k, k) array
        The unitary matrix from one to the other.

    Returns
    -------
    Z : dict
        Of the poles' blocks, by the requirement's key.
    U : (k, k) array
        Of P in that block.
    """
    frame, Z, U = first.problem.frame, {}, None
    for name, z in zip(first.problem.expressions, first.multipliers):
        if name.block == block:
            back = frame.back @ turn.conj().T
            U = back.conj().T @ z[: len(turn), : len(turn)] @ back
        elif name.requirement is not None and name.block in ("", "stability"):
            q = len(z) // len(turn)
            back = np.kron(np.eye(q), frame.left @ turn.conj().T)
            Z[name.requirement] = back.conj().T @ z @ back
    size = max(np.abs(z).max() for z in Z.values())
    return {key: _rounded(z / size) for key, z in Z.items()}, _rounded(U / size)


def _rounded(z):
    """Hermitian, a little larger, as decimals: real and imaginary part."""
    z = (z + z.conj().T) / 2
    z = z + RIDGE * np.abs(z).max() * np.eye(len(z))
    return [round_digits(z.real, DIGITS), round_digits(z.imag, DIGITS)]


def _completed(request, part, Z, U):
    """The multipliers, the share and the price of the file."""
    asked = pole_demands(request)
    demands = [asked[key].pole_matrices() for key in Z]
    exactly = [real_form(*map(exact, z)) for z in Z.values()]
    _, N, _, N_blur = part.sums(demands, exactly)
    k, m = part.k, N.shape[1] // 2
    N, N_blur = N.astype(float), N_blur.astype(float)
    N = N[:k, :m] + 1j * N[k:, :m]
    room = np.diag(N_blur.sum(axis=1))
    U_room = U[0] + 1j * U[1] - room
    price = N.conj().T @ np.linalg.solve(U_room, N) + np.diag(N_blur.sum(axis=0))
    return list(Z.items()), U, _rounded(price)
