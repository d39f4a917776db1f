"""The response that no input reaches, in floats: how loud it is at some frequencies."""

from functools import partial

import numpy as np

from ..plants.checks import logarithmic_scales

LEAST_DAMPED = 4  # poles, by pairs, that are looked at first
BALANCINGS = 8  # rounds of scaling rows and columns
NOISE = 1e-12  # relative, of singular values and of rates


def hears_response(request):
    """True if floats see that of the first vertex of a ``request``, at s = 0 or as fast
    as one of its least damped poles: where an exact look comes first.
    """
    for r in request.requirements:
        if (gamma := r.bounds_response()) is None:
            continue
        loop = in_floats(matrices_at(request, r, 0, partial(np.asarray, dtype=float)))
        if loop is None:
            continue
        try:
            s = poles_of(loop)
            least = s[np.argsort(abs(s.real) / abs(s))][:LEAST_DAMPED]
            sizes, _ = responses(loop, [0.0, *np.unique(abs(least))])
        except np.linalg.LinAlgError:  # of numbers that floats don't hold
            continue
        if sizes.max() >= gamma:
            return True
    return False


def matrices_at(request, r, k, as_):
    """E, A, B, B_w, C, D_u, D_w of the vertex ``k`` of a ``request``, or of its loop if
    a gain is given, with the output of ``r``; ``as_`` reads the numbers: `exact`, or as
    floats.
    """
    (d,) = request.vertices_in(as_, [k])
    d = r.seen(d).explicit()  # of ticks in rationals, whatever was given
    E, A, B, Bw, C = (as_(x) for x in (d.E, d.A, d.Bu, d.Bw, d.C))
    Du, Dw = (
        as_(np.zeros((len(C), X.shape[1])) if D is None else D)
        for D, X in ((d.Du, B), (d.Dw, Bw))
    )
    if request.gain is not None:
        K = as_(request.gain)
        A, C = A + B @ K, C + Du @ K
        B, Du = B[:, :0], Du[:, :0]
    return E, A, B, Bw, C, Du, Dw


def in_floats(matrices):
    """The ``matrices`` of `matrices_at` in floats; None if inputs reach all outputs."""
    loop = [x.astype(float) for x in matrices]
    _, _, B, Bw, C, *_ = loop
    return None if len(C) <= B.shape[1] or not Bw.size else loop


def poles_of(loop):
    """The poles of a ``loop``, as `in_floats` has it, that aren't zero, in rad/s."""
    s = np.linalg.eigvals(np.linalg.solve(*loop[:2]))
    return s[abs(s) > NOISE * abs(s).max(initial=0.0)]


def responses(loop, omegas):
    """The largest |v B_w + y D_w| / |y| at each s = j omega, (k,), and its [v y], (k, N
    + n), of a ``loop`` as `in_floats` has it, at ``omegas``; zero without such [v y].
    """
    E, _, _, Bw, *_, Dw = loop
    rows, left, _ = without_input(loop, omegas)
    left = left * rows[:, None, :]
    turn, sizes, _ = np.linalg.svd(left[..., len(E) :], full_matrices=False)
    held = sizes > NOISE * sizes[:, :1]
    shares = np.divide(1.0, sizes, out=np.zeros_like(sizes), where=held)
    left = (turn * shares[:, None, :]).conj().mT @ left  # now y y* = I, or zero
    c, sizes, _ = np.linalg.svd(left[..., : len(E)] @ Bw + left[..., len(E) :] @ Dw)
    return sizes[:, 0], (c.conj().mT[:, :1] @ left)[:, 0]


def without_input(loop, omegas):
    """Where neither x nor u of a ``loop`` counts at s = j omega, of ``omegas``: scales
    of the rows, and square [v y] whose first rows, as many as the third array says, are
    zero; the others are orthonormal, of the balanced matrix.
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
