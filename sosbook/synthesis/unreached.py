"""A response that no input reaches: a gamma below it is excluded for every gain."""

import numpy as np
from flint import fmpq_mat
from scipy.linalg import qr
from scipy.optimize import minimize_scalar

from ..lmi.exact import exact, round_digits
from ..lmi.proof import Examined, ProofFile
from ..lmi.rational import decimal, decimals, fraction, rational_matrix, read_number
from ..lmi.time_limit import check_time
from ..plants.checks import logarithmic_scales
from .exclusion_certificates import loop_data, loop_request

__all__ = ["UnreachedResponseCertificate", "excluding_response"]

MOST_VERTICES = 32  # that are tried
FREQUENCIES = 120  # that are tried
NEAR = 0.1  # of gamma; where the loudest of these is below, none reaches it
REFINED = 3  # of the frequencies that are louder than their neighbours
DIGITS = 12  # of what is free in the rows
BALANCINGS = 8  # rounds of scaling rows and columns
NOISE = 1e-12  # relative, of singular values and of rates


class UnreachedResponseCertificate(ProofFile):
    """A combination of outputs that answers to w alike in every loop.

    Its ``text`` is a file with the plant, gamma, a point s with Re s >= 0, and
    rows v, y with v (s E - A) = y C and v B + y D_u = 0. In every loop
    s E x = A x + B u + B_w w gives y z = v B_w w at s. A loop that is stable
    has a bounded transfer matrix T there, with y T(s) = v B_w, so its
    H-infinity norm is at least |v B_w| / |y|, which isn't below gamma. With a
    given gain A and C are those of the loop and there is no B.
    """

    kind = "unreached response"

    @classmethod
    def examine(cls, data):
        request = loop_request(data)
        gamma, k = read_number(data["bound"]), data["vertex"]
        s, v, y = ([[fraction(e) for e in row] for row in data[n]] for n in "svy")
        again = cls.contents(request, gamma, k, s, v, y)
        E, A, B, Bw, C, Du = _matrices(request, k)
        (sigma,), (omega,) = s
        v, y = (rational_matrix(x) for x in (v, y))
        if v.shape != (2, len(E)) or y.shape != (2, len(C)):
            raise ValueError("v and y must have a real and an imaginary row each")
        turned = np.array([-v[1], v[0]])  # j v
        if (sigma * (v @ E) + omega * (turned @ E) - v @ A - y @ C != 0).any():
            return again, Examined.nothing("v (s E - A) isn't y C")
        if B.size and (v @ B + y @ Du != 0).any():
            return again, Examined.nothing("an input reaches this response")
        reached, asked = ((v @ Bw) ** 2).sum(), (y**2).sum() * exact(gamma) ** 2
        if sigma < 0 or reached <= 0 or reached < asked:
            return again, Examined.nothing("the response is below gamma")
        return again, Examined(tuple(again["claims"]), {}, ())

    @classmethod
    def contents(cls, request, gamma, k, s, v, y):
        """The data of the file.

        Parameters
        ----------
        request : Request
            With the plant.
        gamma : float
            The bound.
        k : int
            Which vertex, from 0.
        s, v, y : lists
            Two rows of rationals each, the real and the imaginary parts.
        """
        where = f"the vertex {k + 1}" if len(request.vertices) > 1 else "the plant"
        who = "no gain makes" if request.gain is None else "the given gain doesn't make"
        K = request.gain
        return {
            "claims": [
                f"{who} {where} stable with an H-infinity norm below {decimal(gamma)}"
            ],
            **loop_data(request),
            "K": None if K is None else decimals(K),
            "bound": decimal(gamma),
            "vertex": k,
            **{
                n: [[str(e) for e in row] for row in x]
                for n, x in zip("svy", (s, v, y))
            },
        }


def _matrices(request, k):
    """E, A, B, B_w, C and D_u of a vertex in rationals; those of the given loop."""
    if type(k) is not int or not 0 <= k < len(request.vertices):
        raise ValueError("vertex must be one of the plant's, from 0")
    (d,) = request.vertices_in(exact, [k])
    Du = exact(np.zeros((len(d.C), d.Bu.shape[1]))) if d.Du is None else d.Du
    A, B, C = d.A, d.Bu, d.C
    if request.gain is not None:
        K = exact(request.gain)
        A, C = A + B @ K, C + Du @ K
        B, Du = B[:, :0], Du[:, :0]
    return d.E, A, B, d.Bw, C, Du


def excluding_response(request):
    """The `UnreachedResponseCertificate` of a request, or None without one."""
    bounds = [r.bounds_response() for r in request.requirements]
    for gamma in (bound for bound in bounds if bound is not None):
        for k in request.distinct[:MOST_VERTICES]:
            check_time()
            proof = _at_vertex(request, gamma, k)
            if proof is not None and proof.proven:
                return proof
    return None


def _at_vertex(request, gamma, k):
    matrices = _matrices(request, k)
    E, A, B, Bw, C, Du = (x.astype(float) for x in matrices)
    if len(C) <= B.shape[1] or not Bw.size:
        return None  # the inputs reach all outputs
    rates = np.abs(np.linalg.eigvals(np.linalg.solve(E, A)))
    rates = rates[rates > NOISE * rates.max(initial=0.0)]
    low, high = (0.1 * rates.min(), 10 * rates.max()) if rates.size else (0.01, 100.0)
    points = np.array([0.0, *rates, *np.geomspace(low, high, FREQUENCIES)])
    omega = _loudest(lambda w: _response(E, A, B, Bw, C, Du, w)[0], points, gamma)
    omega = float(round_digits(np.array(omega), DIGITS))
    size, row, order = _response(E, A, B, Bw, C, Du, omega)
    if not size >= gamma:
        return None
    w = exact(omega)
    E, A, B, Bw, C, Du = matrices
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
    return UnreachedResponseCertificate.of(
        UnreachedResponseCertificate.contents(request, gamma, k, [[0], [w]], v, y)
    )


def _loudest(size, points, enough):
    """The frequency at which ``size`` is largest, or ``enough``.

    Of the ``points`` those louder than their neighbours are looked at closely.
    """
    points = np.unique(points)
    sizes = np.array([size(w) for w in points])
    best = points[sizes.argmax()]
    if sizes.max() >= enough or sizes.max() < NEAR * enough:
        return best
    walls = np.concatenate([[-np.inf], sizes, [-np.inf]])
    tops = np.flatnonzero((sizes >= walls[:-2]) & (sizes >= walls[2:]))
    top = sizes.max()
    for k in tops[np.argsort(-sizes[tops])][:REFINED]:
        low, high = points[max(k - 1, 0)], points[min(k + 1, len(points) - 1)]
        near = minimize_scalar(
            lambda w: -size(w),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-10 * high},
        )
        if -near.fun > top:
            best, top = near.x, -near.fun
    return best


def _response(E, A, B, Bw, C, Du, omega):
    """The largest |v B_w| / |y| at s = j omega, [v y], and the order of its entries.

    In that order the last ones determine the others best.
    """
    M = np.vstack([np.hstack([1j * omega * E - A, B]), np.hstack([-C, Du])])
    rows, M = _balanced(M)
    directions, sizes, _ = np.linalg.svd(M)
    left = directions[:, (sizes > NOISE * sizes[0]).sum() :].conj().T
    chosen = qr(left, mode="r", pivoting=True)[1]
    left = left * rows
    turn, sizes, _ = np.linalg.svd(left[:, len(E) :], full_matrices=False)
    held = sizes > NOISE * sizes[0]
    if not held.any():
        return 0.0, None, None
    left = (turn[:, held] / sizes[held]).conj().T @ left  # now y y* = I
    c, sizes, _ = np.linalg.svd(left[:, : len(E)] @ Bw)
    return sizes[0], c[:, 0].conj() @ left, chosen[::-1]


def _balanced(M):
    """Scales of the rows of M, and a balanced M.

    The first scales are those of `logarithmic_scales`: the same matrix comes out
    whatever its units.
    """
    rows, columns = logarithmic_scales(M)
    M = M * columns * rows[:, None]
    for _ in range(BALANCINGS):
        M = M / (np.abs(M).max(axis=0) + 1e-300)
        sizes = np.abs(M).max(axis=1) + 1e-300
        M, rows = M / sizes[:, None], rows / sizes
    return rows, M


def _completed(system, x):
    """The solution of ``system`` x = 0 with what is free taken from x."""
    reduced, rank = fmpq_mat([list(row) for row in system]).rref()
    rows = reduced.table()[:rank]
    lead = [next(j for j, e in enumerate(row) if e != 0) for row in rows]
    x = list(x)
    others = [j for j in range(len(x)) if j not in set(lead)]
    for j, row in zip(lead, rows):
        x[j] = -sum((row[k] * x[k] for k in others if row[k] != 0), start=exact(0.0))
    return x
