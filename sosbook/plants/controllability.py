"""The modes that no input moves, found and proven in exact arithmetic.

Popov, Belevitch and Hautus: s is out of the inputs' reach exactly if some row v has v
(A - s E) = 0 and v B = 0. All of them are the eigenvalues of a matrix L with V A = L V
E and V B = 0; the rows V are found modulo primes, lifted to rationals, and then
checked.
"""

from dataclasses import dataclass
from itertools import count

import numpy as np
from flint import fmpq, fmpq_mat, fmpz, fmpz_mat, nmod_mat

from ..exact.algebraic import roots_of
from ..runtime.time_limit import check_time

PRIMES_BELOW = 2**62  # so that each prime fits a machine word
SECONDS_FOR_A_BIT = 2.5e-11  # by the square of the rows; measured
LONGER_TO_INVERT = 4.0  # times that: the inverse, and its product with A
SECONDS_FOR_AN_ENTRY = 1e-9  # by the rows, of elimination modulo a prime
MOST_PRIMES = 400  # are tried before the rows count as too long to write


@dataclass(frozen=True, eq=False)
class FixedPart:
    """The part of a plant that no input moves: ``rows`` V, (k, N), and ``dynamics`` L,
    (k, k), with V A = L V E and V B = 0; L's eigenvalues are the fixed modes.
    """

    rows: fmpq_mat
    dynamics: fmpq_mat

    def __len__(self):
        return self.dynamics.nrows()

    def modes(self):
        """The fixed modes as exact roots, each once."""
        if not len(self):
            return []
        check_time(_seconds(self.dynamics))
        return roots_of(self.dynamics.charpoly())


def fixed_part(E, A, B):
    """The part that the inputs of E x' = A x + B u, of fmpq, don't move: everything if
    ``E`` is regular and ``B`` has no columns, no rows if all is controllable; None
    where E is singular, or the rows have too many digits to be found. ``A`` is square.

    >>> from sosbook.exact.definite import exact
    >>> one, A = exact(np.eye(2)), exact(np.array([[0.1, 1], [0, -3]]))
    >>> [complex(s) for s in fixed_part(one, A, exact(np.array([[1.0], [0]]))).modes()]
    [(-3+0j)]
    >>> [fixed_part(A - A, A, exact(np.eye(2))[:, :m]) for m in (0, 1)]  # E = 0
    [None, None]
    """
    N, m = len(E), B.shape[1]
    E, A = matrix_of(E), matrix_of(A)
    if m == 0:
        check_time(_seconds(E) * LONGER_TO_INVERT)
        if is_singular(E):
            return None
        inverse = E.inv()
        return FixedPart(inverse, inverse * A)
    B = matrix_of(B)
    # rows are scaled to integers, which changes neither modes nor reach
    scale = _row_denominators(E, A, B)
    whole = [_scaled(X, scale) for X in (E, A, B)]
    guess = _Lift()
    for tried, p in enumerate(_primes()):
        check_time()
        if tried >= MOST_PRIMES:
            return None
        rows = _modulo(*whole, p)
        if rows is None:  # p divides det E
            if whole[0].det() == 0:
                return None
            continue
        if not rows[1]:
            return FixedPart(fmpq_mat(0, N), fmpq_mat(0, 0))
        guess.add(p, *rows)
        if guess.ready:
            part = _checked(guess.rational(), E, A, B, scale)
            if part is not None:
                return part


def matrix_of(x):
    """An array x of fmpq as flint's matrix."""
    check_time()
    return fmpq_mat(*x.shape, np.ravel(x).tolist())


def _seconds(X):
    """A guess of flint's seconds for a characteristic polynomial, by X's digits."""
    sizes = [e.p.bit_length() + e.q.bit_length() for e in X.entries() if e != 0]
    return SECONDS_FOR_A_BIT * X.nrows() ** 2 * sum(sizes)


def is_singular(E):
    """True if a square fmpq_mat, E, is singular: exact. A determinant that isn't zero
    modulo one prime isn't zero, and far sooner found.
    """
    whole = _scaled(E, _row_denominators(E))
    return nmod_mat(whole, next(_primes())).det() == 0 and whole.det() == 0


def _row_denominators(*matrices):
    """For each row the least common multiple of its denominators."""
    denominators, tables = [], []
    for X in matrices:
        check_time()
        tables.append(X.table())
    for rows in zip(*tables):
        check_time()
        scale = fmpz(1)
        for entry in (e for row in rows for e in row):
            scale = scale.lcm(entry.q)
        denominators.append(scale)
    return denominators


def _scaled(X, scale):
    """The rows times integers, as an integer matrix."""
    entries = []
    for row, s in zip(X.table(), scale):
        check_time()
        entries += [(e * s).p for e in row]
    return fmpz_mat(X.nrows(), X.ncols(), entries)


def _primes():
    """Primes below 2^62, downwards."""
    return (n for n in count(PRIMES_BELOW - 1, -2) if fmpz(n).is_prime())


def _modulo(E, A, B, p):
    """The pivots of the rows V modulo p, and their reduced echelon form's other
    entries; None and None if E is singular modulo p.
    """
    N = E.nrows()
    check_time(SECONDS_FOR_AN_ENTRY * N**3)
    E, A, B = (nmod_mat(X, p) for X in (E, A, B))
    try:
        inverse_E = E.inv()
    except ZeroDivisionError:
        return None
    step, reached = inverse_E * A, _basis((inverse_E * B).transpose())
    step = step.transpose()  # rows span what u reaches
    power = step
    while True:
        check_time()
        rank = reached.nrows()
        if rank == N:
            return (), []
        further = _basis(_stacked(reached, reached * power))
        if further.nrows() == rank:
            break
        check_time()
        reached, power = further, power * power
    null, k = reached.nullspace() if rank else (nmod_mat(N, N, p), N)
    if not rank:
        for i in range(N):
            null[i, i] = 1
    columns = [[int(null[i, j]) for i in range(N)] for j in range(k)]
    V = nmod_mat(k, N, [e for row in columns for e in row], p) * inverse_E
    V, _ = V.rref()
    rows = [[int(e) for e in row] for row in V.table()]
    return tuple(next(j for j, e in enumerate(row) if e) for row in rows), rows


def _basis(rows):
    """Independent rows with the same span."""
    reduced, rank = rows.rref()
    entries = reduced.entries()[: rank * reduced.ncols()]
    return nmod_mat(rank, reduced.ncols(), entries, rows.modulus())


def _stacked(one, two):
    entries = one.entries() + two.entries()
    return nmod_mat(one.nrows() + two.nrows(), one.ncols(), entries, one.modulus())


class _Lift:
    """Rows modulo several primes, lifted to rationals."""

    def __init__(self):
        self.pivots = self.rows = None
        self.modulus, self.used = 1, 0

    def add(self, p, pivots, rows):
        """Join another prime, unless it is known to be a bad one."""
        # a bad prime loses rank or moves a pivot to the right
        rank, current = len(pivots), self.pivots
        if current is None or (rank, pivots) < (len(current), current):
            self.pivots, self.rows = pivots, [list(row) for row in rows]
            self.modulus, self.used = p, 1
        elif pivots == current:
            inverse = pow(self.modulus, -1, p)
            for both in zip(self.rows, rows):
                both[0][:] = [
                    old + self.modulus * ((new - old) * inverse % p)
                    for old, new in zip(*both)
                ]
            self.modulus, self.used = self.modulus * p, self.used + 1

    @property
    def ready(self):
        """True if it is time for another trial: after 1, 2, 4, ... primes."""
        return self.used & (self.used - 1) == 0

    def rational(self):
        """The rows as rationals, or None if an entry has none."""
        limit, rationals = int(fmpz(self.modulus // 2).isqrt()), []
        for row in self.rows:
            values = [_fraction(entry, self.modulus, limit) for entry in row]
            if None in values:
                return None
            rationals.append(values)
        return rationals


def _fraction(entry, modulus, limit):
    """The fraction a / b with |a|, b <= limit and b entry = a, or None."""
    if entry <= limit:
        return fmpq(entry)
    if modulus - entry <= limit:
        return fmpq(entry - modulus)
    (a, s), (b, t) = (modulus, 0), (entry, 1)
    while b > limit:
        q = a // b
        (a, s), (b, t) = (b, t), (a - q * b, s - q * t)
    return fmpq(b, t) if 0 < abs(t) <= limit else None


def _checked(rows, E, A, B, scale):
    """The `FixedPart` of these rows, if they are what they should be."""
    if rows is None:
        return None
    entries = [e * s for row in rows for e, s in zip(row, scale)]
    V = fmpq_mat(len(rows), E.nrows(), entries)
    if any(e != 0 for e in (V * B).entries()):
        return None
    VE, VA = V * E, V * A
    columns = _pivot_columns(VE)
    dynamics = _columns(VA, columns) * _columns(VE, columns).inv()
    return FixedPart(V, dynamics) if dynamics * VE == VA else None


def _pivot_columns(X):
    reduced, rank = X.rref()
    return [
        next(j for j, e in enumerate(row) if e != 0) for row in reduced.table()[:rank]
    ]


def _columns(X, chosen):
    return fmpq_mat([[row[j] for j in chosen] for row in X.table()])
