"""A gain that puts the poles of one plant where they are asked, with many digits.

Where the LMIs ask for more digits than floats have, a gain may exist whose
entries are floats: two frequencies that differ in the seventh digit take a
gain of 1e8. It is computed by Ackermann's formula with hundreds of digits,
rounded, and only believed if the poles of its loop are where they should be,
in rational arithmetic.
"""

from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, ctx, fmpq, fmpq_mat

from ..analysis.linear import balancing
from ..exact.algebraic import roots_of
from ..exact.definite import exact
from ..exact.rational import rational_matrix
from ..plants.controllability import fixed_part, matrix_of
from ..runtime.time_limit import check_time
from .pole_places import dyadic, goals, modes_of, real_places
from .rounding import modes_by_rounding

__all__ = ["MOST_STATES", "binary", "keeps", "loop_matrix", "placed_gain"]

MOST_STATES = 60  # up to which characteristic polynomials are computed
FORMULA_BITS = 1024, 4096, 16384  # of Ackermann's formula, until it is known
MIXTURES = 2  # of several inputs that are tried
FEEDBACK = 0.0, 0.01, 1.0  # sizes of a first feedback, relative


def loop_matrix(request, K, number=exact):
    """E^-1 (A + B K) of a request's one plant, in rationals that ``number`` makes."""
    (d,) = request.vertices_in(number)
    return matrix_of(d.E).inv() * matrix_of(d.A + d.Bu @ number(K))


def keeps(request, K, number=exact):
    """Whether all poles of the loop provably lie where a request asks.

    Parameters
    ----------
    request : Request
        Of one plant; all that it asks is of poles.
    K : (m, N) array
        A gain of floats.
    number : callable
        How floats are read: as decimals without it, or `binary`.
    """
    poles = roots_of(loop_matrix(request, K, number).charpoly())
    return all(r.holds_at(s) is True for s in poles for r in request.demands)


def binary(x):
    """The numbers that floats x hold: 0.1 becomes 3602879701896397 / 2^55."""
    entries = [fmpq(*e.as_integer_ratio()) for e in np.asarray(x, float).ravel()]
    return rational_matrix(entries).reshape(np.shape(x))


def placed_gain(request):
    """A gain whose loop provably has its poles where a request asks.

    Parameters
    ----------
    request : Request
        Of one plant; all that it asks is of poles.

    Returns
    -------
    (m, N) array or None
        It does so whether floats are read as decimals or as the binary numbers
        that they hold, so that it doesn't live on rounding errors. None where
        none was found, or where every gain would: see `modes_by_rounding`.

    Notes
    -----
    Source: J. Ackermann, Regelungstechnik 20, 1972, 297-300. For one column b
    and the polynomial phi of the poles K = -e_N' [b Ab ...]^-1 phi(A). Modes
    that are where they should be stay, if they can. Several inputs move along one
    direction; a plant that no direction controls gets a small feedback first
    (M. Heymann, IEEE Trans. Automatic Control 13, 1968, 748-749).
    """
    places = real_places(request) if request.order <= MOST_STATES else []
    plant = _Reachable.of(request) if places else None
    if plant is None or modes_by_rounding(request):
        return None
    rng = np.random.default_rng(0)
    for size in FEEDBACK:
        first = plant.feedback(rng, size)
        A = plant.A + plant.B * first
        modes, controlled = modes_of(request, A), False
        for direction in plant.directions(rng):
            row = _last_row(A, plant.B * direction)
            if row is None:
                continue
            for factors in goals(request, modes, places):
                check_time()
                F = first + direction * _formula(row, A, factors)
                K = plant.gain(F)
                if np.isfinite(K).all() and all(
                    keeps(request, K, number) for number in (exact, binary)
                ):
                    return K
            controlled = True
        if controlled:
            return None
    return None


@dataclass(frozen=True, eq=False)
class _Reachable:
    """x' = A x + B u of the states that u reaches, well scaled, in rationals.

    Parameters
    ----------
    A, B : fmpq_mat
        The matrices.
    back : fmpq_mat
        From the plant's states to these; K = F back.
    """

    A: fmpq_mat
    B: fmpq_mat
    back: fmpq_mat

    @classmethod
    def of(cls, request):
        """Of a request's one plant; None where no state is within reach."""
        (d,) = request.vertices_in(exact)
        E = matrix_of(d.E)
        part = None if E.det() == 0 else fixed_part(d.E, d.A, d.Bu)
        if part is None or len(part) == request.order or not d.Bu.shape[1]:
            return None
        A, B = E.inv() * matrix_of(d.A), E.inv() * matrix_of(d.Bu)
        floats = np.array([[_float(e) for e in row] for row in A.table()])
        units = [fmpq(1) * fmpq(2) ** int(k) for k in np.log2(balancing(floats))]
        into = fmpq_mat([[u * (i == j) for j, u in enumerate(units)]
                         for i in range(len(units))])  # fmt: skip
        A, B, back = into.inv() * A * into, into.inv() * B, into.inv()
        if len(part):
            X = _null_space(part.rows * E * into)
            left = (X.transpose() * X).inv() * X.transpose()
            A, B, back = left * A * X, left * B, left * back
        return cls(A, B, back)

    def directions(self, rng):
        """Columns that mix the inputs: with signs at random, then one alone."""
        m = self.B.ncols()
        sizes = [
            max(abs(_float(e)) for e in row) or 1.0
            for row in self.B.transpose().table()
        ]
        mixed = [] if m == 1 else list(rng.choice([-1.0, 1.0], (MIXTURES, m)))
        for column in [*mixed, np.eye(m)[int(np.argmax(sizes))]]:
            yield _column(column * 2.0 ** -np.round(np.log2(sizes)))

    def feedback(self, rng, size):
        """A first feedback of a relative size, at random."""
        A, B = (max(abs(_float(e)) for e in X.entries()) for X in (self.A, self.B))
        unit = 2.0 ** np.round(np.log2(A / B)) if A and B else 1.0
        F = np.round(rng.standard_normal((self.B.ncols(), self.A.nrows())), 2)
        return matrix_of(exact(unit * size * F))

    def gain(self, F):
        """The gain in the plant's units as floats."""
        K = F * self.back
        return np.array([[_float(e) for e in row] for row in K.table()])


def _column(x):
    return matrix_of(exact(np.asarray(x, float)[:, None]))


def _float(q):
    """The nearest float; infinite where there is none."""
    try:
        return int(q.p) / int(q.q)
    except OverflowError:
        return np.inf


def _null_space(rows):
    """A matrix whose columns span what the rows annul."""
    reduced, rank = rows.rref()
    table = [row for row in reduced.table()[:rank]]
    lead = [next(j for j, e in enumerate(row) if e != 0) for row in table]
    free = [j for j in range(rows.ncols()) if j not in lead]
    X = [[fmpq(i == j) for j in free] for i in range(rows.ncols())]
    for row, i in zip(table, lead):
        X[i] = [-row[j] for j in free]
    return fmpq_mat(X)


def _last_row(A, b):
    """The last row of [b Ab A^2 b ...]^-1 in rationals; None if it has none."""
    N = A.nrows()
    reach = [b]
    for _ in range(N - 1):
        reach.append(A * reach[-1])
    rows = [column.entries() for column in reach]
    last = [[fmpq(k == N - 1)] for k in range(N)]
    for bits in FORMULA_BITS:
        check_time()
        with ctx.workprec(bits):
            try:
                row = arb_mat(fmpq_mat(rows)).solve(arb_mat(fmpq_mat(last)))
            except ZeroDivisionError:
                continue
            size = max(abs(e.mid()) for e in row.entries())
            if all(e.rad() < size * arb(2) ** -(bits // 2) for e in row.entries()):
                return _middle(row.transpose())
    return None


def _middle(matrix):
    """The middle of balls in rationals."""
    return fmpq_mat([[dyadic(e) for e in row] for row in matrix.table()])


def _formula(row, A, factors):
    """- row phi(A), where phi is the product of factors without leading ones."""
    with ctx.workprec(FORMULA_BITS[-2]):
        y, A = arb_mat(row), arb_mat(A)
        for factor in factors:
            z, y = y, y * A
            if len(factor) == 1:
                y = y + z * arb(factor[0])
            else:
                y = y * A + y * arb(factor[1]) + z * arb(factor[0])
        return _middle(y * arb(-1))
