"""Directions without mass: rows and mixtures of rows, and cures for them."""

from dataclasses import dataclass

import numpy as np
from flint import fmpq, fmpq_mat, nmod_mat
from scipy.linalg import null_space, qr, svd

from ..exact.rational import exact, null_basis
from ..runtime.sparse import issparse
from .checks import rank_deficient

MOST_NAMED = 12  # rows in an error, which is one line
PRIME = 2**61 - 1  # a rank that is full modulo it is full
WEIGHT = fmpq(355, 113)  # of damping beside mass: of no round ratio
PROPORTIONAL = 1e-12  # of the damping, by which it may differ from a multiple of S
NEAR_ZERO = 1e-12  # of the largest entry of a direction
ROUNDED = 1e-9  # relative: masses that were printed with ten digits
FEWER = ROUNDED, 1e-7, 1e-5  # of ten, eight or six digits, as files print them


def massless(M, D, tolerance=0.0):
    """The rows in which square M and D are zero, as in the columns of these numbers; or
    at most a ``tolerance``, of the largest entry.
    """
    parts = [abs(x) / (abs(x).max() or 1.0) for x in (M, D)]
    small = np.ones(M.shape[0], bool)
    for axis in (0, 1):
        sums = sum(np.asarray(x.sum(axis=axis)).ravel() for x in parts)
        small &= sums <= tolerance
    return np.flatnonzero(small)


def massless_directions(M, D, tolerance=0.0):
    """All z with M z = 0 and D z = 0, all y with y'M = 0 and y'D = 0, ``M`` and ``D``
    read as decimals: columns of fmpq, each one in a row of its own. With a
    ``tolerance``, of the largest entry, those for which they are as small, rounded.
    """
    if tolerance:
        N = _nearly_null(M, D, tolerance)
        symmetric = abs(M - M.T).max() == abs(D - D.T).max() == 0
        return N, N if symmetric else _nearly_null(M.T, D.T, tolerance)
    rows = massless(M, D)
    rest = np.setdiff1d(np.arange(len(M)), rows)
    if _full(*(exact(x[np.ix_(rest, rest)]) for x in (M, D))):
        units = exact(np.eye(len(M)))[:, rows]
        return units, units
    N = null_basis(np.vstack([M, D]))
    symmetric = (M == M.T).all() and (D == D.T).all()
    return N, N if symmetric else null_basis(np.vstack([M.T, D.T]))


def _nearly_null(M, D, tolerance):
    """The z for which M and D, scaled so that M has ones on its diagonal, are small."""
    scales = unit_scales(M)
    parts = [scales[:, None] * x * scales for x in (M, D)]
    _, sizes, right = svd(np.vstack([x / (abs(x).max() or 1.0) for x in parts]))
    N = scales[:, None] * right[np.count_nonzero(sizes > tolerance) :].T
    if not N.size:
        return exact(N)
    own = qr(N.T, pivoting=True, mode="r")[1][: N.shape[1]]
    N = N @ np.linalg.inv(N[own])
    N[abs(N) < NEAR_ZERO * abs(N).max()] = 0.0
    N[own] = np.eye(len(own))
    return exact(N)


def unit_scales(M):
    """Factors that make the diagonal of a square M one, where it isn't zero."""
    sizes = abs(M.diagonal())
    return np.where(sizes > 0, sizes, sizes.max() or 1.0) ** -0.5


def light(M):
    """The least eigenvalue of a symmetric dense M with ones on its diagonal, if it is
    next to nothing and isn't there for directions that have no mass exactly; or None.
    """
    scales = unit_scales(M)
    values = np.linalg.eigvalsh(scales[:, None] * M * scales)
    small = values[abs(values) <= ROUNDED]
    none = small.size and len(M) - _modular(exact(M)).rank()
    return small[0] if small.size > none else None


def _modular(M):
    """A matrix of fmpq modulo a prime, which hardly ever takes from its rank."""
    return nmod_mat(fmpq_mat(*M.shape, M.ravel().tolist()).numer_denom()[0], PRIME)


def _full(M, D):
    """True if a sum of two square matrices is regular modulo a prime: then it is."""
    return not len(M) or _modular(M + D * WEIGHT).rank() == len(M)


@dataclass(frozen=True, eq=False)
class Massless:
    """Directions that can be solved for: columns ``N`` and rows ``L`` of directions, or
    indices of rows of a sparse plant as both; their damping is ``beta`` times their
    stiffness.
    """

    N: np.ndarray
    L: np.ndarray
    beta: float

    @classmethod
    def of(cls, given, tolerance=0.0):
        """That of ``given`` M, D, S, B and F by name, to a ``tolerance``; or None."""
        M, D = given["M"], given["D"]
        sparse = issparse(M)
        for damped in (D, 0 * D):
            if sparse:
                N = L = massless(M, damped, tolerance)
                count = len(N)
            else:
                N, L = massless_directions(M, damped, tolerance)
                count = N.shape[1] if N.shape == L.shape else 0
            if count and damped is D:
                return cls(N, L, 0.0)
        beta = count and _proportion(given, N, L, tolerance)
        return cls(N, L, beta) if beta else None

    @property
    def count(self):
        """How many directions."""
        return self.N.shape[-1]

    def solvable(self, given, definite=False):
        """True if S holds the directions, by floats, so that the rest of the ``given``
        matrices is a plant; or its mass ``definite``.
        """
        M, S, B = (given[x] for x in "MSB")
        if issparse(M):
            from scipy.sparse.linalg import splu

            try:
                splu(S[self.L][:, self.N].tocsc())
            except RuntimeError:
                return False
            rest = np.setdiff1d(np.arange(M.shape[0]), self.N)
            return not empty_rows({"M": M[rest][:, rest]})
        N, L = (np.array(x, float) for x in (self.N, self.L))
        inner = L.T @ S @ N
        if N.shape[1] == len(N) or rank_deficient(inner):
            return False
        rows, columns = kept(L)[0], kept(N)[0]
        mass = M[np.ix_(rows, columns)]
        if definite:
            return np.linalg.eigvalsh((mass + mass.T) / 2)[0] > 0
        pushed = B - S @ N @ np.linalg.solve(inner, L.T @ B)
        return not rank_deficient(np.hstack([mass, pushed[rows]]))


def kept(basis):
    """The rows in which a basis isn't the identity, and the others, in its order."""
    ones = (basis != 0).sum(axis=1) == 1
    own = [int(np.flatnonzero(ones & (x == 1))[-1]) for x in basis.T]
    return np.setdiff1d(np.arange(len(basis)), own), own


def _proportion(given, N, L, tolerance):
    """The beta > 0 with D = beta S along N and L, where no input acts; 0 if none."""
    D, S, B, F = (given[x] for x in "DSBF")
    if issparse(D):
        pairs = [(x[L], x[:, N]) for x in (D, S)]
        pushes = B[L], F[L]
    else:
        N, L = (np.array(x, float) for x in (N, L))
        pairs = [(L.T @ x, x @ N) for x in (D, S)]
        pushes = L.T @ B, L.T @ F
    (left, right), (stiff, stiff_right) = pairs
    size = (stiff * stiff).sum()
    beta = float((left * stiff).sum() / size) if size else 0.0
    gaps = abs(left - beta * stiff).max(), abs(right - beta * stiff_right).max()
    off = max(gaps) > max(tolerance, PROPORTIONAL) * abs(D).max()
    off = off or any(
        abs(x).max(initial=0.0) > tolerance * abs(whole).max(initial=0.0)
        for x, whole in zip(pushes, (B, F))
    )
    return 0.0 if off or beta <= 0 else beta


def empty_rows(given):
    """The rows in which all of the matrices ``given`` by name are zero, and the columns
    of the square M, D and S.
    """
    used = np.zeros(given["M"].shape[0], bool)
    for name, x in given.items():
        for axis in (1, 0) if name in "MDS" and x.shape[1] == len(used) else (1,):
            used |= np.asarray(abs(x).sum(axis=axis)).ravel() > 0
    return np.flatnonzero(~used).tolist()


def empty_words(rows, where):
    """The cure for ``rows`` that are empty in the matrices that ``where`` names."""
    if len(rows) == 1:
        return f"row {rows[0]} is empty in {where}: leave it out"
    return f"rows {listed(rows)} are empty in {where}: leave them out"


def massless_cure(given, definite=False):
    """The cure for massless directions in ``given`` M, D, S, B and F, by name, for
    errors: it is tried before it is told. Empty where nothing is known to help, or no
    ``definite`` mass is left.

    >>> halves, none = np.full((2, 2), 0.3), np.zeros((2, 2))
    >>> given = {"M": halves, "D": none, "S": np.eye(2), "B": halves[:, :1], "F": none}
    >>> massless_cure(given)
    '; sosbook.plants.condense solves for the 1 direction without mass exactly'
    """
    if empty := empty_rows(given):
        return f"; {empty_words(empty, 'M, D, S, B and F')}"
    there = Massless.of(given)
    if there is None:
        return _pushed_cure(given)
    rows = massless(given["M"], (there.beta == 0) * given["D"])
    if not there.solvable(given, definite):
        return constraints(given, rows)
    if len(rows):
        return f"; sosbook.plants.condense solves for z[{listed(rows)}] exactly"
    some = f"{there.count} direction" + "s" * (there.count > 1)
    return f"; sosbook.plants.condense solves for the {some} without mass exactly"


def _pushed_cure(given):
    """The cure where only inputs keep damped rows from being condensed."""
    unpushed = given | {name: 0 * given[name] for name in "BF"}
    there = Massless.of(unpushed)
    if there is None or not there.solvable(given):
        return ""
    return (
        ", but for the inputs there sosbook.plants.condense would solve for them with "
        "their damping, a multiple of S: let B and F act on rows with mass, or "
        "condense the plant without that damping, and add it to what is left"
    )


def light_cure(given, definite=False):
    """As `massless_cure` (``given``, ``definite``) of what has next to no mass."""
    for tolerance in FEWER:
        there = Massless.of(given, tolerance)
        if there is not None and there.solvable(given, definite):
            how = f"condense(..., tolerance={tolerance:g}) of sosbook.plants"
            return f"; {how} takes it for none"
    return ""


def definite_cure(given):
    """The cure where the mass ``given`` with D, S, B and F isn't definite."""
    M, S = given["M"], given["S"]
    if issparse(M):
        return ""
    if cure := massless_cure(given, True) or light_cure(given, True):
        return cure
    gone = massless(M, 0 * M)
    rows = np.setdiff1d(np.arange(len(M)), gone)
    if not len(gone) or len(rows) > MOST_NAMED:
        return ""
    held = S[np.ix_(gone, gone)]
    if rank_deficient(held) or np.linalg.eigvalsh((held + held.T) / 2)[0] <= 0:
        return ""
    mass = M[np.ix_(rows, rows)]
    good = np.linalg.eigvalsh((mass + mass.T) / 2)[0] > 0
    return f"; give rows=[{listed(rows)}] instead of modes" if good else ""


def listed(rows):
    """The numbers of some rows in words, of many the first."""
    more = ", ..." * (len(rows) > MOST_NAMED)
    return ", ".join(map(str, rows[:MOST_NAMED])) + more


def constraints(given, rows):
    """The cure for ``given`` M, D, S, B and F where the ``rows`` without mass say what
    others must keep; empty where that isn't it.
    """
    M, S, B = (given[x] for x in "MSB")
    rest = np.setdiff1d(np.arange(M.shape[0]), rows)
    if issparse(M) or not len(rows) or not len(rest) or S[np.ix_(rows, rows)].any():
        return ""
    Q = null_space(S[np.ix_(rows, rest)])
    free = abs(Q.T @ S[np.ix_(rest, rows)]).max(initial=0.0) <= ROUNDED * abs(S).max()
    moved = np.hstack([Q.T @ M[np.ix_(rest, rest)] @ Q, Q.T @ B[rest]])
    if B[rows].any() or not free or not Q.size or rank_deficient(moved):
        return ""
    return (
        f"; the rows r = [{listed(rows)}] are constraints, for S is zero between them: "
        "with k the other rows and Q = scipy.linalg.null_space(S[r][:, k]) give "
        "Q.T @ M[k][:, k] @ Q, the same of D and S, and Q.T @ B[k]"
    )
