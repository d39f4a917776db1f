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
from ..exact.rational import decimals, read_array, round_places
from ..exact.refusal import Refusal
from ..plants.checks import inverse_by_rows
from ..plants.controllability import matrix_of
from ..plants.descriptor_system import DescriptorSystem
from ..requirements.lmi_region import by_matrices
from ..runtime.time_limit import check_time
from .request import Request
from .request_as_data import read_request, request_data
from .scaling import Frame

MOST_VERTICES = 32  # that are tried
OUTSIDE = 1e-9  # of the fastest mode; what lies nearer is left with the modes inside
RIDGE = 1e-10  # relative; keeps multipliers positive definite when they are rounded
MARGIN = 1e-9  # relative; the least eigenvalue of a share
DIGITS = 14  # of the multipliers
LARGE, FEW = 40, 10  # states from which, and digits to which, bases are rounded first
ROOM = 1.01  # by which bounds are wider than their image, in three digits
WIDE_ROOM = 2.0  # the same, where they grow slowly
SMALL_STEPS = 8  # before the room is wide
LEAST_BOUND = 1e-25  # relative; exact data leave no error at all


def pole_demands(request):
    """The requirements of a request that its LMIs make of the poles, by key."""
    asked = [r for r in request.requirements if r.pole_matrices() is not None]
    return {r.key: r for r in (*asked, request.claims.stability)}


def input_bound(request):
    """The one requirement of a request that bounds K x from x0; else None."""
    bounds = [r for r in request.requirements if r.bounds_input_from() is not None]
    return bounds[0] if len(bounds) == 1 else None


def refuse_by_input(request, search):
    """The `SmallInputRefusal` of a ``request``, or None; ``search`` makes an
    `LMISolution` of a Request.
    """
    bound = input_bound(request)
    late = request.gain is not None or request.step is not None
    if bound is None or late or request.coupling.own_P:
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
    """The result of ``work``, or None where the numbers give out."""
    try:
        return work(*arguments)
    except (ArithmeticError, ValueError):  # LinAlgError is a ValueError
        return None


class SmallInputRefusal(Refusal):
    """An input bound that is too small for the modes outside of the region. ``text`` is
    that of the file: the plant and what is asked of it, a `_Part`, and multipliers of
    its LMIs, in decimals; complex matrices are pairs of real and imaginary part.
    """

    kind = "small input"

    @property
    def place(self):
        """Which vertex has the modes, from 0."""
        return self.data["vertex"]

    @property
    def modes(self):
        """The modes, in rad/s, to the accuracy of floats."""
        data = self.data
        A = read_request(data).vertices[data["vertex"]].A
        k = len(data["spread"])
        T = _complex([x[:k] for x in data["rows"]])
        R = _complex([[row[:k] for row in x] for x in data["columns"]])
        return np.linalg.eigvals(T @ A @ R)

    @classmethod
    def contents(cls, request, vertex, bases, spread, blur, multipliers, share, price):
        """The data of the file for the ``vertex`` of a ``request`` that has the modes:
        ``bases``, T and R of `_Part` as pairs of real and imaginary part, its
        ``spread`` and ``blur``, ``multipliers`` of the poles' blocks by key, ``share``,
        which is U, and ``price``.
        """

        def pair(parts):
            return [decimals(x) for x in parts]

        return {
            **request_data(request),
            "K": None,
            "vertex": vertex,
            "rows": pair(bases[0]),
            "columns": pair(bases[1]),
            "spread": decimals(spread),
            "blur": decimals(blur),
            "multipliers": [[list(key), pair(z)] for key, z in multipliers],
            "share": pair(share),
            "price": pair(price),
        }


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
            for digits in (FEW, None) if len(rows) >= LARGE else (None,):
                proof = _tried(self._proof, digits, rows.copy(), count, *Z)
                if proof is not None:
                    return proof
        return None

    def _proof(self, digits, rows, count, Z, U, Q, N):
        """The exact refusal of some ``rows`` and multipliers, or None."""
        size = np.sqrt(Q.diagonal().real)  # of the rows: free of units
        Z = {key: _scaled(z, 1 / size) for key, z in Z.items()}
        U, N = _scaled(U, 1 / size), N / size[:, None]
        rows[:count] *= size[:, None] / size.mean()
        rows *= size.mean() / (np.abs(N).max() or 1.0)
        columns = self.frame.T @ np.linalg.inv(rows)
        bases = [[x.real, x.imag] for x in (rows @ self.left, columns)]
        if digits:
            bases = [round_places(pair, digits) for pair in bases]
        enclosed = _enclosed(self.request, self.k, bases, count)
        if enclosed is None:
            return None
        bounds = enclosed[1:]
        completed = _completed(self.request, *enclosed, Z, U)
        proof = SmallInputRefusal.of(
            SmallInputRefusal.contents(self.request, self.k, bases, *bounds, *completed)
        )
        return proof if proof.proven else None


class _Part:
    """An enclosure of a part of a plant that A leaves invariant, in floats.

    There are X and L with W A = L W E and W = [I X] T, and with every
    |X| <= spread and every |L - L0| <= blur, if the kernel says so, which decides it
    all from T, R and the bounds.

    ``E``, ``A``, ``B``: the plant at one vertex, in rationals; ``bases``: T and R, (N,
    N), as pairs of real and imaginary part: rows near those of the part and of a
    complement, and a matrix near the inverse of T E; ``k``: how many of the rows are
    the part's. With K = T A R and J = T E R the equation is [I X] K = L [I X] J, by
    blocks

        L = K11 + X K21 - L (J11 - I) - L X J21,
        X K22 - L X J22 = L J12 - K12.

    Divided by the differences of the diagonals of K22 and K11, both are maps of
    (L, X). Where they map the bounds into themselves a fixed point exists (Brouwer).
    What nearly cancels is subtracted in rationals: J - I and L0 J12 - K12.
    """

    def __init__(self, E, A, B, bases, k):
        """Multiply all of it in rationals."""
        self.k, N = k, len(E)
        T, R = (real_form(*map(exact, x)) for x in bases)
        E, A, B = (real_form(x, 0 * x) for x in (E, A, B))
        T, R, A, E, B = map(matrix_of, (T, R, A, E, B))
        K, J, push = (
            np.array((x).table(), object) for x in (T * A * R, T * E * R, T * B)
        )
        top, rest = ([*range(a, b), *range(N + a, N + b)] for a, b in ((0, k), (k, N)))
        first = K[np.ix_(top, top)] @ J[np.ix_(top, rest)] - K[np.ix_(top, rest)]
        off = J - exact(np.eye(2 * N))
        self.K, self.J, self.off, self.first, self.push = map(
            _complex_form, (K, J, off, first, push)
        )
        self.L, self.b = self.K[:k, :k], self.push[:k]

    def image(self, spread, blur):
        """The images' bounds, from ``spread``, (k, N - k), and ``blur``, (k, k): every
        image of X lies within the first over the second, of L - L0 within the third.
        """
        top, rest = slice(0, self.k), slice(self.k, None)
        K, J, off, first = map(_bound, (self.K, self.J, self.off, self.first))
        own, inner = np.diag(K.diagonal()), K - np.diag(K.diagonal())
        L = K[top, top] + blur
        new_blur = (
            spread @ K[rest, top] + L @ off[top, top] + L @ spread @ off[rest, top]
        )
        new_spread = (
            first
            + blur @ J[top, rest]
            + (inner[top, top] + blur) @ spread @ J[rest, rest]
            + own[top, top] @ spread @ off[rest, rest]
            + spread @ inner[rest, rest]
        )
        apart = self.K.diagonal()[None, rest] - self.K.diagonal()[top, None]
        gaps = np.maximum(abs(apart.real), abs(apart.imag))
        return new_spread, gaps, new_blur

    def sums(self, demands, multipliers, spread, blur):
        """The coefficients of p and y under ``multipliers`` z of the poles' blocks: for
        all p and y = Y V' the sum of <G, z> is -tr(Q p) - 2 Re tr(N y). ``demands`` are
        the regions' (alpha, beta). Returns Q, (k, k), and N, (k, m), at L0 and b0, and
        bounds of their errors. The sum is completed by a part U of Q, the multipliers
        [U N; N* price] of "u_max" and, with D = Q - U and h = V x0, [h* D h, -h* D; -D
        h, D] of "x0": it doesn't depend on p and y, and can't be negative, but is
        u_max^2 tr(price) - h* D h.
        """
        k, S, F = self.k, 0 * self.L, 0 * self.L
        for (alpha, beta), z in zip(demands, multipliers):
            for i, j in np.ndindex(alpha.shape):
                z_ji = z[j * k : j * k + k, i * k : i * k + k]
                S, F = S + float(alpha[i, j]) * z_ji, F + float(beta[i, j]) * z_ji
        move, size = F @ self.L, _bound(F)
        Q_blur = size @ blur
        N_blur = size @ spread @ _bound(self.push[k:])
        return S + move + move.conj().T, F @ self.b, Q_blur + Q_blur.T, N_blur


def _enclosed(request, k, bases, count):
    """A `_Part` and bounds that hold in floats, spread and blur; or None."""
    d = request.vertices_in(exact)[k]
    part, N = _Part(d.E, d.A, d.Bu, bases, count), request.order
    most = np.abs(part.K).max()
    least = LEAST_BOUND * most
    spread, blur = np.zeros((count, N - count)), np.zeros((count, count))
    for step in range(4 * N + 20):
        room = ROOM if step < SMALL_STEPS else WIDE_ROOM
        new_spread, gaps, new_blur = part.image(spread, blur)
        if not (gaps > 0).all():
            return None
        new_spread = new_spread / gaps
        if (new_spread <= spread).all() and (new_blur <= blur).all():
            return part, spread, blur
        spread = np.maximum(spread, new_spread + LEAST_BOUND)
        spread = round_digits(room * spread, 3)
        blur = round_digits(room * np.maximum(blur, new_blur + least), 3)
        if not max(spread.max(), blur.max() / most) < 1:
            return None
    return None


def real_form(re, im):
    """The real matrix [re, -im; im, re] of a complex one: products stay products."""
    return np.vstack([np.hstack([re, -im]), np.hstack([im, re])])


def _complex_form(x):
    """The complex matrix in floats of a rational one in its `real_form`."""
    rows, columns = x.shape[0] // 2, x.shape[1] // 2
    return x[:rows, :columns].astype(float) + 1j * x[rows:, :columns].astype(float)


def _bound(x):
    """Of the size of each entry, from above."""
    return abs(x.real) + abs(x.imag)


def _multipliers(first, block, turn):
    """Those of the part in the basis of its rows, from the real one by ``turn``, (k,
    k): Z of the poles' blocks, by the requirement's key, U of P in the ``block`` of the
    input bound, Q in "x0" as well, and N, (k, m), of Y' in that block.
    """
    frame, k = first.problem.frame, len(turn)
    Z, back = {}, np.linalg.inv(turn)
    inward = np.linalg.solve(frame.T, back)  # frame.back has six digits only
    for name, z in zip(first.problem.text.expressions, first.multipliers):
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


def _completed(request, part, spread, blur, Z, U):
    """The multipliers, the share and the price of the file."""
    asked = pole_demands(request)
    demands = [asked[key].pole_matrices() for key in Z]
    Z = {key: _rounded(z) for key, z in Z.items()}
    as_rounded = [re + 1j * im for re, im in Z.values()]
    Q, N, Q_blur, N_blur = part.sums(demands, as_rounded, spread, blur)
    own, paid = (np.diag(N_blur.sum(axis=i)) for i in (1, 0))
    U = _share(Q, U, np.diag(Q_blur.sum(axis=1)) + own)
    U = [round_digits(x, DIGITS) for x in (U.real, U.imag)]
    inner = inverse(real_form(*map(exact, (U[0] - own, U[1]))))
    price = N.conj().T @ _complex_form(inner) @ N + paid
    return (
        list(Z.items()),
        U,
        _rounded(price + RIDGE * np.abs(price).max() * np.eye(len(paid))),
    )


def _share(Q, U, room):
    """The U near this one of which both U and Q - U exceed ``room``, clearly."""
    root = np.linalg.inv(np.linalg.cholesky(Q))
    least = MARGIN + np.linalg.norm(root @ room @ root.conj().T, 2)
    sizes, vectors = np.linalg.eigh(root @ U @ root.conj().T)
    back = np.linalg.solve(root, vectors)
    U = (back * np.clip(sizes, least, 1 - least)) @ back.conj().T
    return (U + U.conj().T) / 2


def _complex(pair):
    re, im = (read_array(x, None, None) for x in pair)
    return re + 1j * im
