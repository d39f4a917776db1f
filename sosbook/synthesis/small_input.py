"""Why an input bound is too small for the modes that must be moved.

The LMIs of a plant imply those of a part of it: with rows W that A leaves
invariant, W A = L W E, they hold for p = V P V' and y = Y V', where V = W E, with
L, b = W B and the initial state V x0. The part of the modes outside of the region
decides: the other modes take any P that is large enough, and Y = 0. It is solved
instead of the whole because there multipliers may be positive definite; those of
the whole vanish on the other modes, which have irrational entries.

For one mode s and a half-plane the multipliers exist if and only if
dist(s) |W E x0| >= |W B| u_max. Rows are scaled until the multipliers of P and of y
have entries near one: errors are bounded row by row, which would depend on units.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import schur

from ..exact.definite import exact, inverse, round_digits
from ..plants.checks import inverse_by_rows
from ..plants.descriptor_system import DescriptorSystem
from ..requirements.lmi_region import by_matrices
from ..runtime.time_limit import check_time
from .request import Request
from .scaling import Frame
from .small_input_proof import (
    ModesPart,
    SmallInputRefusal,
    input_bound,
    pole_demands,
    real_form,
)

MOST_VERTICES = 32  # that are tried
OUTSIDE = 1e-9  # of the fastest mode; what lies nearer is left with the modes inside
RIDGE = 1e-10  # relative; keeps multipliers positive definite when they are rounded
MARGIN = 1e-9  # relative; the least eigenvalue of a share
DIGITS = 14  # of the multipliers
ROOM = 1.01  # by which bounds are wider than their image, in three digits
WIDE_ROOM = 2.0  # the same, where they grow slowly
SMALL_STEPS = 8  # before the room is wide
LEAST_BOUND = 1e-25  # relative; exact data leave no error at all


def refuse_by_input(request, search):
    """The `SmallInputRefusal` of a ``request``, or None; ``search`` makes an
    `LMISolution` of a Request.
    """
    bound = input_bound(request)
    if bound is None or request.gain is not None or request.coupling.own_P:
        return None
    known = [r for r in map(by_matrices, request.requirements) if r is not None]
    if known != list(request.requirements):
        request = replace(request, requirements=known)
    for k in request.distinct[:MOST_VERTICES]:
        check_time()
        vertex = _tried(_Vertex, request, bound, k)
        proof = None if vertex is None else _tried(vertex.proof, search)
        if proof is not None:
            return proof
    return None


def _tried(work, *arguments):
    """What ``work`` makes of its arguments, or None where the numbers give out."""
    try:
        return work(*arguments)
    except (ArithmeticError, ValueError):  # LinAlgError is a ValueError
        return None


class _Vertex:
    """A plant of a request, in a frame."""

    def __init__(self, request, bound, k):
        self.request, self.bound, self.k = request, bound, k
        d, self.frame = request.vertices[k], Frame.of(request)
        self.left = inverse_by_rows(d.E @ self.frame.T)
        self.A, self.B = self.left @ d.A @ self.frame.T, self.left @ d.Bu
        self.start = np.linalg.solve(self.frame.T, bound.bounds_input_from())
        self.regions = pole_demands(request)
        self.fastest = np.abs(np.linalg.eigvals(self.A)).max()

    def bad(self, x, y=None):
        """True if a mode, x or x + j y, is outside."""
        s = x if y is None else complex(x, y)
        least = min(r.distance(s) for r in self.regions.values())
        return least < -OUTSIDE * self.fastest

    def bases(self, count):
        """Rows that begin with so many, those of the part; in the frame. Eigenvectors
        keep an enclosure narrow; vectors of Schur always exist.
        """
        modes, vectors = np.linalg.eig(self.A)
        order = np.argsort([not self.bad(s) for s in modes], kind="stable")
        rows = _tried(np.linalg.inv, vectors[:, order])
        if rows is not None:
            yield rows / np.linalg.norm(rows, axis=1)[:, None]
        _, rows, same = schur(self.A.T, output="complex", sort=self.bad)
        if same == count:
            yield rows.conj().T

    def proof(self, search):
        """The `SmallInputRefusal` for all modes outside, or None."""
        small, count = schur(self.A.T, sort=self.bad)[1:]
        if not 0 < count < len(self.A):
            return None
        small = small[:, :count].T
        part = DescriptorSystem(np.eye(count), small @ self.A @ small.T, small @ self.B)
        kept = [r for r in self.request.requirements if r.pole_matrices() is not None]
        bound = replace(self.bound, x0=small @ self.start)
        first = search(Request(part, requirements=[*kept, bound]))
        if first.values is not None or first.multipliers is None:
            return None
        for rows in self.bases(count):
            turn = rows[:count] @ small.T  # from the real basis of the part
            Z = _multipliers(first, bound.parameter.key, turn)
            proof = _tried(self._proof, rows, count, *Z)
            if proof is not None:
                return proof
        return None

    def _proof(self, rows, count, Z, U, Q, N):
        size = np.sqrt(Q.diagonal().real)  # of the rows: free of units
        Z = {key: _scaled(z, 1 / size) for key, z in Z.items()}
        U, N = _scaled(U, 1 / size), N / size[:, None]
        rows[:count] *= size[:, None] / size.mean()
        rows *= size.mean() / (np.abs(N).max() or 1.0)
        columns = self.frame.T @ np.linalg.inv(rows)
        bases = [[x.real, x.imag] for x in (rows @ self.left, columns)]
        part = _enclosed(self.request, self.k, bases, count)
        if part is None:
            return None
        bounds = [x.astype(float) for x in (part.spread, part.blur)]
        completed = _completed(self.request, part, Z, U)
        proof = SmallInputRefusal.of(
            SmallInputRefusal.contents(self.request, self.k, bases, *bounds, *completed)
        )
        return proof if proof.proven else None


def _enclosed(request, k, bases, count):
    """A `ModesPart` in rationals with bounds that hold in floats, or None."""
    d = request.vertices_in(exact)[k]
    T, R = (real_form(*map(exact, x)) for x in bases)
    part = ModesPart(d.E, d.A, d.Bu, T, R, count)
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
            return part.within(exact(spread), exact(blur))
        spread = np.maximum(spread, new_spread + LEAST_BOUND)
        spread = round_digits(room * spread, 3)
        blur = round_digits(room * np.maximum(blur, new_blur + least), 3)
        if not max(spread.max(), blur.max() / np.abs(near.K).max()) < 1:
            return None
    return None


def _multipliers(first, block, turn):
    """Those of the part in the basis of its rows, from the real one by ``turn``, (k,
    k): Z of the poles' blocks, by the requirement's key, U of P in the ``block`` of the
    input bound, Q in "x0" as well, and N, (k, m), of Y' in that block.
    """
    frame, k = first.problem.frame, len(turn)
    Z, back = {}, np.linalg.inv(turn)
    inward = np.linalg.solve(frame.T, back)  # frame.back has six digits only
    for name, z in zip(first.problem.expressions, first.multipliers):
        if name.block == block:
            U = _turned(z[:k, :k], inward)
            N = inward.conj().T @ z[:k, k:] / frame.scale
        elif name.block == "x0":
            D = _turned(z[1:, 1:], inward)
        elif name.requirement is not None and name.block in ("", "stability"):
            q = len(z) // k
            Z[name.requirement] = _turned(z, np.kron(np.eye(q), frame.left @ back))
    return Z, U, U + D, N


def _turned(z, back):
    return back.conj().T @ z @ back


def _scaled(z, size):
    """z for p in other units, of each of the modes."""
    size = np.tile(size, len(z) // len(size))
    return size[:, None] * z * size


def _rounded(z):
    """Hermitian z, a little larger, as decimals: real and imaginary part."""
    z = (z + z.conj().T) / 2
    weight = np.abs(z.diagonal()) + RIDGE**2 * np.abs(z).max()
    size = np.sqrt(weight)
    least = np.linalg.eigvalsh(z / size / size[:, None])[0]
    z = z + (RIDGE + 2 * max(0.0, -least)) * np.diag(weight)
    return [round_digits(z.real, DIGITS), round_digits(z.imag, DIGITS)]


def _completed(request, part, Z, U):
    """The multipliers, the share and the price of the file."""
    asked = pole_demands(request)
    demands = [asked[key].pole_matrices() for key in Z]
    Z = {key: _rounded(z) for key, z in Z.items()}
    exactly = [real_form(*map(exact, z)) for z in Z.values()]
    Q, N, Q_blur, N_blur = part.sums(demands, exactly)
    k, m = part.k, N.shape[1] // 2
    own, paid = (np.diag(N_blur.astype(float).sum(axis=i)) for i in (1, 0))
    Q = Q.astype(float)
    room = np.diag(Q_blur.astype(float).sum(axis=1)) + own
    U = _share(Q[:k, :k] + 1j * Q[k:, :k], U, room)
    U = [round_digits(x, DIGITS) for x in (U.real, U.imag)]
    inner = real_form(*map(exact, U)) - real_form(*map(exact, (own, 0 * own)))
    price = (N.T @ inverse(inner) @ N).astype(float)
    price = price[:m, :m] + 1j * price[m:, :m] + paid
    return list(Z.items()), U, _rounded(price + RIDGE * np.abs(price).max() * np.eye(m))


def _share(Q, U, room):
    """The U near this one of which both U and Q - U exceed ``room``, clearly."""
    root = np.linalg.inv(np.linalg.cholesky(Q))
    least = MARGIN + np.linalg.norm(root @ room @ root.conj().T, 2)
    sizes, vectors = np.linalg.eigh(root @ U @ root.conj().T)
    back = np.linalg.solve(root, vectors)
    U = (back * np.clip(sizes, least, 1 - least)) @ back.conj().T
    return (U + U.conj().T) / 2
