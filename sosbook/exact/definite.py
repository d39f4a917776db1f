"""Exact proofs in rational arithmetic (python-flint)."""

import numpy as np
from flint import fmpq, fmpz, fmpz_mat
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dpotrf

from ..language.expression import Affine
from ..runtime.time_limit import check_time
from .integers import Integers
from .rational import Rational, _matrix, exact, inverse, round_digits

__all__ = [
    "Rational",
    "definite",
    "exact",
    "in_floats",
    "inverse",
    "pivots",
    "positive",
    "round_digits",
    "semidefinite",
]


AT_ONCE_UP_TO_ROWS = 12  # elimination takes no time that could run out


def pivots(x):
    """Pivots of the exact LDL factorisation of x, a symmetric matrix of rationals.

    All of them if it is positive definite; else the list ends with the first that isn't
    positive. Raises ValueError if it isn't exactly symmetric.

    >>> pivots(exact(np.array([[2.0, 1.0], [1.0, 2.0]])))
    [2, 3/2]
    >>> pivots(exact(np.array([[1.0, 2.0], [2.0, 1.0]])))
    [1, -3]
    """
    integers, denominator = _symmetric(x)
    small = integers.nrows() <= AT_ONCE_UP_TO_ROWS
    heads, last = [], fmpz(1)
    for minor in (_minors_at_once if small else _minors)(integers):
        heads.append(fmpq(minor, last * denominator))
        if minor <= 0:
            break
        last = minor
    return heads


def _minors_at_once(integers):
    """The leading minors, up to the first that is zero."""
    check_time()
    order, _, _, upper = integers.fflu()
    for k in range(integers.nrows()):
        # rows are exchanged where a zero stood
        yield upper[k, k] if order[k, k] == 1 else fmpz(0)


def _minors(integers):
    """The same, row by row: the time may end at any of them."""
    rows = [row[i:] for i, row in enumerate(integers.table())]  # from the diagonal on
    last = fmpz(1)
    while rows:  # Bareiss: the divisions leave no remainder
        check_time()
        head, *below = rows
        lead = head[0]
        yield lead
        rows = [
            [(lead * e - first * h) // last for e, h in zip(row, head[k:])]
            for k, (first, row) in enumerate(zip(head[1:], below), 1)
        ]
        last = lead


def _symmetric(x):
    """(integers, denominator) of x."""
    integers, d = (x.z, x.d) if isinstance(x, Integers) else _matrix(x).numer_denom()
    if integers != integers.transpose():
        raise ValueError("the matrix isn't symmetric")
    return integers, d


ELIMINATION_UP_TO_ROWS = 24  # beyond, verified Cholesky factors in integers are faster
FACTOR_BITS = 40  # after the point, of the rounded factors
SHORT_BITS = 104  # after the point, of a matrix whose sign alone is asked
LEFT_OVER = 2.0**-46  # of each row, what rounding errors of a factor leave to the rest


def definite(x):
    """(True if a symmetric rational x is positive definite, its least pivot).

    Both verdicts are proven. The measure, fmpq, is the smallest of `pivots` up to 24
    rows; in a larger positive definite matrix a lower bound of it, at most 1e-6 of it
    too small; in another one a value v' x v <= 0 of some v whose last nonzero entry is
    1. Raises ValueError if x isn't exactly symmetric.

    Floats only suggest a lower triangular W with powers of two on its diagonal; T = W x
    W' is exact. By Sylvester's law x is positive definite exactly if T is. A diagonal
    entry of T that isn't positive decides one way. Strict diagonal dominance
    (Gershgorin, after a diagonal scaling) decides the other way, and a row's surplus
    bounds the pivot from below: elimination of a row keeps the surplus of the others.
    Without a decision T, which is better conditioned, is treated in the same way.

    >>> definite(exact(np.array([[2.0, 1.0], [1.0, 2.0]])))
    (True, 3/2)
    """
    integers, denominator = _symmetric(x)
    if integers.nrows() > ELIMINATION_UP_TO_ROWS:
        verdict = _by_congruence(integers, denominator)
        if verdict is not None:
            return verdict
        if integers.rank() < integers.nrows():  # else it is close to a singular one
            return False, fmpq(0)
    diagonal = pivots(x)
    return diagonal[-1] > 0, min(diagonal)


def _by_congruence(T, denominator, passes=8):
    """(proven, measure) of `definite`, or None."""
    power = [0] * T.nrows()  # W has 2^power on its diagonal
    for _ in range(passes):
        check_time()
        rows = [[int(e) for e in row] for row in T.table()]
        values = [
            fmpq(row[i], 4**p) / denominator
            for i, (row, p) in enumerate(zip(rows, power))
        ]
        for value in values:
            if value <= 0:
                return False, value
        # sizes 2^s of the rows: T_ij / 2^(s_i + s_j) is about one
        sizes = [row[i].bit_length() // 2 for i, row in enumerate(rows)]
        top = max(sizes)
        shifted = [[abs(e) << top - s for e, s in zip(row, sizes)] for row in rows]
        surplus = [(2 * row[i] - sum(row), row[i]) for i, row in enumerate(shifted)]
        if all(1000000 * e > 999999 * d for e, d in surplus):
            return True, min(
                fmpq(e, 2 ** (top - s) * 4**p) / denominator
                for (e, _), s, p in zip(surplus, sizes, power)
            )
        floats = [
            [_ratio(e, 1 << s + t) for e, t in zip(row, sizes)]
            for row, s in zip(rows, sizes)
        ]
        W, doublings = _eliminator(np.array(floats))
        W = (W * 2.0**FACTOR_BITS).tolist()
        W = [[round(w) << top - s for w, s in zip(row, sizes)] for row in W]
        factor = fmpz_mat(W)
        T = factor * T * factor.transpose()
        power = [
            p + d + FACTOR_BITS + top - s for p, d, s in zip(power, doublings, sizes)
        ]
    return None


def _ratio(e, unit):
    """e / unit as a float, cut off where no definite matrix reaches."""
    return max(min(e, 9 * unit), -9 * unit) / unit


def _eliminator(T):
    """W, lower triangular with 2^k on its diagonal, for W T W' near one; and the k.

    Up to the first pivot that is lost in rounding errors; the rows from there on are
    only freed of the columns before it.
    """
    q = len(T)
    L, failed = dpotrf(T, lower=1)
    good = failed - 1 if failed else q
    weak = L.diagonal()[:good] ** 2 < q * 2.0**-46
    if weak.any():
        good = weak.argmax()
    L = L[:good, :good]
    root = L.diagonal()
    k = np.zeros(q, int)
    k[:good] = np.rint(-np.log2(root))
    inverted = solve_triangular(L, np.eye(good), lower=True)
    W = np.eye(q)
    W[:good, :good] = inverted * (root * 2.0 ** k[:good])[:, None]
    W[good:, :good] = -(T[good:, :good] @ inverted.T) @ inverted
    np.fill_diagonal(W, 2.0**k)
    return W, k.tolist()


def positive(x):
    """True if x is positive definite: see `definite`, which takes longer.

    A large x, or one of long numbers, is scaled to a diagonal of about one, and its
    entries are rounded down to `SHORT_BITS` bits after the point. The rest has entries
    of [0, 1) in the last place, so no eigenvalue of it is below -q. Where the rounded
    matrix less q there isn't certainly positive definite, `definite` decides.

    >>> x = exact(np.array([[2.0, 1.0], [1.0, 2.0]]))
    >>> positive(x / 3), positive(x - exact(2 * np.eye(2)))
    (True, False)
    """
    integers, _ = _symmetric(x)
    q = integers.nrows()
    heads = [integers[k, k] for k in range(q)]
    if any(e <= 0 for e in heads):
        return False
    small, sizes = q <= AT_ONCE_UP_TO_ROWS, [e.bit_length() // 2 for e in heads]
    if small and max(sizes, default=0) <= SHORT_BITS:
        return all(e > 0 for e in _minors_at_once(integers))
    check_time()
    flat = [int(e) for e in integers.entries()]
    short = [
        [_shifted(e, SHORT_BITS - s - t) for e, t in zip(flat[k * q :], sizes)]
        for k, s in enumerate(sizes)
    ]
    for i, row in enumerate(short):
        row[i] -= q
    if small:
        sure = all(e > 0 for e in _minors_at_once(fmpz_mat(short)))
    else:
        sure = _by_factor(short)
    return sure or definite(x)[0]


def _by_factor(rows):
    """True if symmetric ``rows`` of integers, over 2^SHORT_BITS, are certainly positive
    definite: they are L L' and a matrix with a dominant positive diagonal, for some L.

    Floats only suggest L; its integers, over 2^(SHORT_BITS / 2), are multiplied
    exactly.
    """
    if (
        max(max(map(abs, row)) for row in rows) > 9 << SHORT_BITS
    ):  # no definite matrix reaches so far
        return False
    S, q, half = np.array(rows, float) / 2.0**SHORT_BITS, len(rows), SHORT_BITS // 2
    L, failed = dpotrf(S - q * LEFT_OVER * np.eye(q), lower=1)
    if failed:
        return False
    check_time()
    integers = np.rint(np.tril(L) * 2.0**half).astype(int).ravel().tolist()
    factor = fmpz_mat(q, q, integers)
    product = [int(e) for e in (factor * factor.transpose()).entries()]
    for i, row in enumerate(rows):
        rest = [e - p for e, p in zip(row, product[i * q :])]
        if 2 * rest[i] <= sum(map(abs, rest)):
            return False
    return True


def _shifted(e, k):
    """The integer part of e 2^k, rounded down."""
    return e << k if k >= 0 else e >> -k


def semidefinite(x):
    """True if x, a symmetric matrix of rationals, is positive semidefinite.

    Where the columns in J are a basis of those of x, x[J, J] is regular, and x = Y'
    x[J, J] Y for some Y: so exactly if x[J, J] is positive definite.

    >>> x = exact(np.array([[1.0, 2.0], [2.0, 4.0]]))
    >>> semidefinite(x), semidefinite(-x), semidefinite(x - exact(np.diag([1.0, 0])))
    (True, False, False)
    """
    check_time()
    reduced, _, rank = _matrix(x).numer_denom()[0].rref()
    rows = reduced.table()[:rank]
    lead = [next(j for j, e in enumerate(row) if e != 0) for row in rows]
    return not rank or positive(x[np.ix_(lead, lead)])


def in_floats(g):
    """An `Affine` expression g in rationals, in floats."""
    return Affine(
        g.constant.astype(float), [t.map(lambda x: x.astype(float)) for t in g.terms]
    )
