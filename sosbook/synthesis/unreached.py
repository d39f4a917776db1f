"""A response that no input reaches: a gamma below it is excluded for every gain."""

import numpy as np
from scipy.linalg import qr

from ..bisection import lowest
from ..exact.definite import exact, round_digits
from ..exact.rational import decimal, decimals, echelon
from ..exact.refusal import Refusal
from ..plants.checks import logarithmic_scales
from ..runtime.time_limit import check_time
from .request_as_data import loop_data

MOST_VERTICES = 32  # that are tried
FREQUENCIES = 120  # that are tried
NEAR = 0.1  # of gamma; where the loudest of these is below, none reaches it
LEAST_DAMPED = 4  # poles, by pairs, that are looked at first
REFINED = 3  # of the frequencies that are louder than their neighbours
DIGITS = 12  # of what is free in the rows
BALANCINGS = 8  # rounds of scaling rows and columns
NOISE = 1e-12  # relative, of singular values and of rates


class UnreachedResponseRefusal(Refusal):
    """A combination of outputs that answers to w alike in every loop.

    Its ``text`` is a file with the plant, gamma, a point s with Re s >= 0, and
    rows v, y with v (s E - A) = y C and v B + y D_u = 0. In every loop
    s E x = A x + B u + B_w w gives y z = r w at s, with r = v B_w + y D_w. A loop
    that is stable has a bounded transfer matrix T there, with y T(s) = r, so its
    H-infinity norm is at least |r| / |y|, which isn't below gamma. With a
    given gain A and C are those of the loop and there is no B. What of x' is in the
    output is put in from the equation.
    """

    kind = "unreached response"

    @classmethod
    def contents(cls, request, r, k, s, v, y):
        """The data of the file for the vertex ``k``, from 0, of a ``request`` whose
        ``r`` bounds an H-infinity norm; ``s``, ``v``, ``y`` are two rows of rationals
        each, real and imaginary parts.
        """
        K, bound = request.gain, {"bound": decimal(r.bounds_response())}
        return {
            **loop_data(request),
            "K": None if K is None else decimals(K),
            **({"requirement": r.data()} if r.has_channel else bound),
            "vertex": k,
            **{
                n: [[str(e) for e in row] for row in x]
                for n, x in zip("svy", (s, v, y))
            },
        }


def _matrices(request, r, k, as_=exact):
    """E, A, B, B_w, C, D_u, D_w of a vertex, those of the given loop; in rationals, or
    as another function reads numbers.
    """
    (d,) = request.vertices_in(as_, [k])
    d = r.seen(d).explicit()
    Du, Dw = (
        as_(np.zeros((len(d.C), B.shape[1]))) if D is None else D
        for D, B in ((d.Du, d.Bu), (d.Dw, d.Bw))
    )
    A, B, C = d.A, d.Bu, d.C
    if request.gain is not None:
        K = as_(request.gain)
        A, C = A + B @ K, C + Du @ K
        B, Du = B[:, :0], Du[:, :0]
    return d.E, A, B, d.Bw, C, Du, Dw


def refuse_by_response(request, vertices=None):
    """The `UnreachedResponseRefusal` of a ``request`` at some ``vertices``, or None."""
    vertices = request.distinct[:MOST_VERTICES] if vertices is None else vertices
    for r in request.requirements:
        bounds = request.law.whole and r.bounds_response() is not None
        for k in vertices if bounds else ():
            check_time()
            proof = _at_vertex(request, r, k)
            if proof is not None and proof.proven:
                return proof
    return None


def hears_response(request):
    """True if floats see that of the first vertex of a ``request``, at s = 0 or as fast
    as one of its least damped poles: where an exact look comes first.
    """
    for r in request.requirements:
        gamma = r.bounds_response()
        loop = None if gamma is None else _floats(_matrices(request, r, 0, np.asarray))
        if loop is not None:
            s = _poles(loop)
            least = s[np.argsort(abs(s.real) / abs(s))][:LEAST_DAMPED]
            sizes, _ = _responses(loop, [0.0, *np.unique(abs(least))])
            if sizes.max() >= gamma:
                return True
    return False


def _floats(matrices):
    """The matrices in floats; None where the inputs reach all outputs."""
    loop = [x.astype(float) for x in matrices]
    _, _, B, Bw, C, *_ = loop
    return None if len(C) <= B.shape[1] or not Bw.size else loop


def _poles(loop):
    """The poles that aren't zero, in rad/s."""
    s = np.linalg.eigvals(np.linalg.solve(*loop[:2]))
    return s[abs(s) > NOISE * abs(s).max(initial=0.0)]


def _at_vertex(request, r, k):
    """The refusal at vertex k, or None."""
    matrices, gamma = _matrices(request, r, k), r.bounds_response()
    loop = _floats(matrices)
    if loop is None:
        return None
    rates = np.abs(_poles(loop))
    low, high = (0.1 * rates.min(), 10 * rates.max()) if rates.size else (0.01, 100.0)
    points = np.array([0.0, *rates, *np.geomspace(low, high, FREQUENCIES)])
    omega = _loudest(lambda w: _responses(loop, w)[0], points, gamma)
    omega = float(round_digits(np.array(omega), DIGITS))
    (size,), (row,) = _responses(loop, [omega])
    if not size >= gamma:
        return None
    order, w = _order(loop, omega), exact(omega)
    E, A, B, _, C, Du, _ = matrices
    N, count = len(E), len(E) + len(C)
    zero = np.zeros((len(C), N), int)
    real = np.vstack([np.hstack([-A, B]), np.hstack([-C, Du])])
    imaginary = np.hstack(
        [np.vstack([w * E, w * exact(zero)]), np.vstack([0 * B, 0 * Du])]
    )
    system = np.block([[real, imaginary], [-imaginary, real]]).T
    both = np.stack([order, order + count], axis=1).ravel()
    free = np.empty(2 * count, object)
    free[both] = _completed(
        system[:, both],
        exact(round_digits(np.hstack([row.real, row.imag])[both], DIGITS)),
    )
    v = [free[:N], free[count : count + N]]
    y = [free[N:count], free[count + N :]]
    return UnreachedResponseRefusal.of(
        UnreachedResponseRefusal.contents(request, r, k, [[0], [w]], v, y)
    )


def _loudest(sizes_at, points, enough):
    """The frequency at which the size is largest, or ``enough``; of the ``points``
    those louder than their neighbours are looked at closely.
    """
    points = np.unique(points)
    sizes = sizes_at(points)
    best = points[sizes.argmax()]
    if sizes.max() >= enough or sizes.max() < NEAR * enough:
        return best
    walls = np.concatenate([[-np.inf], sizes, [-np.inf]])
    tops = np.flatnonzero((sizes >= walls[:-2]) & (sizes >= walls[2:]))
    top = sizes.max()
    for k in tops[np.argsort(-sizes[tops])][:REFINED]:
        low, high = points[max(k - 1, 0)], points[min(k + 1, len(points) - 1)]
        near = lowest(lambda w: -sizes_at([w]).item(), low, high, 1e-10 * high)
        if -near[1] > top:
            best, top = near[0], -near[1]
    return best


def _responses(loop, omegas):
    """The largest |v B_w + y D_w| / |y| at each s = j omega, (k,), and its [v y], (k, N
    + n); zero without such [v y]. ``loop``: E, A, B, B_w, C, D_u and D_w in floats.
    """
    E, _, _, Bw, *_, Dw = loop
    rows, left, _ = _without_input(loop, omegas)
    left = left * rows[:, None, :]
    turn, sizes, _ = np.linalg.svd(left[..., len(E) :], full_matrices=False)
    held = sizes > NOISE * sizes[:, :1]
    shares = np.divide(1.0, sizes, out=np.zeros_like(sizes), where=held)
    left = (turn * shares[:, None, :]).conj().mT @ left  # now y y* = I, or zero
    c, sizes, _ = np.linalg.svd(left[..., : len(E)] @ Bw + left[..., len(E) :] @ Dw)
    return sizes[:, 0], (c.conj().mT[:, :1] @ left)[:, 0]


def _order(loop, omega):
    """The order of the entries of [v y] in which the last determine the others best."""
    _, (left,), (rank,) = _without_input(loop, [omega])
    return qr(left[rank:], mode="r", pivoting=True)[1][::-1]


def _without_input(loop, omegas):
    """Where neither x nor u counts at s = j omega: scales of the rows, and square [v y]
    whose first rows, as many as the third array says, are zero; the others are
    orthonormal, of the balanced matrix.
    """
    E, A, B, _, C, Du, _ = loop
    N, s = len(E), 1j * np.asarray(omegas, float)[:, None, None]
    M = np.zeros((len(s), N + len(C), N + B.shape[1]), complex)
    M[:, :N, :N], M[:, :N, N:] = s * E - A, B
    M[:, N:, :N], M[:, N:, N:] = -C, Du
    rows, M = _balanced(M)
    directions, sizes, _ = np.linalg.svd(M)
    rank = (sizes > NOISE * sizes[:, :1]).sum(axis=1)
    zero = np.arange(M.shape[1]) < rank[:, None]
    return rows, np.where(zero[..., None], 0, directions.conj().mT), rank


def _balanced(M):
    """Scales of the rows of matrices M, and balanced M. The first scales are those of
    `logarithmic_scales`: the same matrix comes out whatever its units.
    """
    rows, columns = logarithmic_scales(M)
    M = M * columns[:, None, :] * rows[..., None]
    for _ in range(BALANCINGS):
        M = M / _largest(M, 1)
        sizes = _largest(M, 2)
        M, rows = M / sizes, rows / sizes[..., 0]
    return rows, M


def _largest(M, axis):
    """The largest magnitudes along an axis; one where all entries are zero."""
    sizes = np.abs(M).max(axis=axis, keepdims=True)
    return np.where(sizes > 0, sizes, 1.0)


def _completed(system, x):
    """The solution of ``system`` x = 0 with what is free taken from x."""
    (rows, lead), x = echelon(system), list(x)
    others = [j for j in range(len(x)) if j not in set(lead)]
    for j, row in zip(lead, rows):
        x[j] = -sum((row[k] * x[k] for k in others if row[k] != 0), start=exact(0.0))
    return x
