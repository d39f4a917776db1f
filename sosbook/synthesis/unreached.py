"""A response that no input reaches: a gamma below it is excluded for every gain."""

import numpy as np
from scipy.linalg import qr

from ..bisection import lowest
from ..exact.definite import exact, round_digits
from ..exact.rational import decimal, decimals, echelon
from ..exact.refusal import Refusal
from ..runtime.time_limit import check_time
from .request_as_data import loop_data
from .responses import in_floats, matrices_at, poles_of, responses, without_input

MOST_VERTICES = 32  # that are tried
FREQUENCIES = 120  # that are tried
NEAR = 0.1  # of gamma; where the loudest of these is below, none reaches it
REFINED = 3  # of the frequencies that are louder than their neighbours
DIGITS = 12  # of what is free in the rows


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


def _at_vertex(request, r, k):
    """The refusal at vertex k, or None."""
    matrices, gamma = matrices_at(request, r, k, exact), r.bounds_response()
    loop = in_floats(matrices)
    if loop is None:
        return None
    rates = np.abs(poles_of(loop))
    low, high = (0.1 * rates.min(), 10 * rates.max()) if rates.size else (0.01, 100.0)
    points = np.array([0.0, *rates, *np.geomspace(low, high, FREQUENCIES)])
    omega = _loudest(lambda w: responses(loop, w)[0], points, gamma)
    omega = float(round_digits(np.array(omega), DIGITS))
    (size,), (row,) = responses(loop, [omega])
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


def _order(loop, omega):
    """The order of the entries of [v y] in which the last determine the others best."""
    _, (left,), (rank,) = without_input(loop, [omega])
    return qr(left[rank:], mode="r", pivoting=True)[1][::-1]


def _completed(system, x):
    """The solution of ``system`` x = 0 with what is free taken from x."""
    (rows, lead), x = echelon(system), list(x)
    others = [j for j in range(len(x)) if j not in set(lead)]
    for j, row in zip(lead, rows):
        x[j] = -sum((row[k] * x[k] for k in others if row[k] != 0), start=exact(0.0))
    return x
