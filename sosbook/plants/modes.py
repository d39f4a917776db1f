"""Real modes of M and S, the lowest squares of their frequencies first, by dense or
sparse matrices; how many squares are negative is counted by Sylvester's law of inertia.
"""

import numpy as np
from scipy.linalg import LinAlgError, eigh
from scipy.sparse import csc_array, issparse
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from ..runtime.threads import one_thread
from .checks import count
from .sparse import sparse_factor

SHIFT = 1e-8  # of |S| / |M|: so far to the left of zero no rigid mode is singular
RIGID = 1e-12  # of |S| / |M|: floats can't tell a square below it from zero
WIDER = 4.0  # from one shift to the next, among negative squares
NUDGES = 1.0, 1.01, 0.97, 1.07  # of a shift, where a factor without exchanges fails
EXACT = 1e-12  # relative, the residual of a factor on a random vector
HELD = 1e-10  # of the largest; below it, a direction is there already


class NoModes(ValueError):
    """A mass that isn't definite."""


def modal(M, S, modes):
    """Basis and back = basis' M of so many of the slowest real ``modes``.

    ``M`` is positive definite, of ``S`` the symmetric part counts; both may be sparse,
    and a mode is slower than another if the square of its frequency is lower. No mode
    of negative stiffness is left out: too few ``modes`` are a ValueError.
    """
    modes = few("modes", modes, M.shape[0])
    M, S = ((x + x.T) / 2 for x in (M, S))
    _check_positive(M)
    squares, V = lowest(M, S, modes)
    floor = -RIGID * _size(M, S)
    needed = below(M, S, floor) if squares[-1] < floor else 0
    if needed > modes:
        raise ValueError(
            f"{needed} modes of M and S have negative stiffness, and modes={modes} "
            f"would leave out {needed - modes} of them: a gain for the part can't hold "
            f"what it doesn't know. Keep modes={needed} or more"
        )
    V = V * np.sign(V[abs(V).argmax(axis=0), range(modes)])  # the same everywhere
    return V, V.T @ M


def static(M, S, rows, modes):
    """Basis and back of some ``rows`` of ``M`` and ``S``: others follow at rest
    (Guyan), or move in ``modes`` with these held, too (Craig and Bampton).
    """
    n, rows = M.shape[0], np.asarray(rows)
    good = rows.ndim == 1 and rows.size and rows.dtype.kind in "iu"
    if not good or rows.min() < 0 or rows.max() >= n or len(set(rows)) < len(rows):
        raise ValueError(f"rows must be different rows from 0 to {n - 1}, got {rows}")
    rest = np.setdiff1d(np.arange(n), rows)
    r, more = len(rows), 0 if modes is None else few("modes", modes, len(rest))
    few("rows and modes together", r + more, n)
    inner, coupling = S[rest][:, rest], S[rest][:, rows]
    try:
        if issparse(S):
            moved = -splu(csc_array(inner)).solve(coupling.toarray())
        else:
            moved = -np.linalg.solve(inner, coupling)
    except (LinAlgError, RuntimeError):
        raise ValueError(
            "S is singular in the rows that are left out: keep one of each part that "
            "moves freely"
        ) from None
    basis, back = np.zeros((n, r + more)), np.zeros((r + more, n))
    basis[rows, range(r)] = back[range(r), rows] = 1.0
    basis[rest, :r] = moved
    if more:
        V, inverse = modal(M[rest][:, rest], inner, more)
        basis[rest, r:], back[r:, rest] = V, inverse
        back[r:, rows] = -inverse @ moved
    elif needed := negative_modes(M[rest][:, rest], inner):
        raise ValueError(
            f"with these rows held the others have {needed} modes of negative "
            "stiffness, which don't follow at rest: "
            + (f"keep modes={needed}, too" if r + needed < n else "keep other rows")
        )
    return basis, back


def negative_modes(M, S):
    """How many squares of frequencies of the symmetric parts of ``M`` > 0 and ``S`` are
    negative, and not by rounding alone.
    """
    M, S = ((x + x.T) / 2 for x in (M, S))
    return below(M, S, -RIGID * _size(M, S))


def lowest(M, S, modes):
    """The lowest squares of frequencies, ascending, and modes, V' M V = I, of symmetric
    ``M`` > 0 and ``S``. Sparse ones are sought by Lanczos' method near shifts, just
    left of zero and, for as many as are counted there, further left.
    """
    if not issparse(S):
        return eigh(S, M, subset_by_index=(0, modes - 1))
    shift = -SHIFT * _size(M, S)
    shift, found, solve = _counted(M, S, shift)
    edges, counts = [shift], [found]
    while counts[-1]:
        edges.append(WIDER * edges[-1])
        counts.append(below(M, S, edges[-1]))
    start = np.random.default_rng(0).normal(size=M.shape[0])

    def near(place, k, solve):
        k, inverse = min(k, M.shape[0] - 1), LinearOperator(M.shape, solve, dtype=float)
        with one_thread:
            return eigsh(S, k, M, sigma=place, v0=start, OPinv=inverse)

    squares, V = near(shift, modes + counts[0], solve)
    if counts[0]:
        some = [V]
        for edge, more, less in zip(edges, counts, counts[1:]):
            if more > less:
                place, _, solve = _counted(M, S, edge * (1 + WIDER) / 2)
                some.append(near(place, counts[0], solve)[1])
        squares, V = _ritz(M, S, np.hstack(some))
        found = int((squares < shift).sum())
        if found != counts[0]:
            raise ArithmeticError(
                f"{counts[0]} modes lie left of {shift:.3g}, and {found} were found: "
                "are the units far apart?"
            )
    order = np.argsort(squares)[:modes]
    return squares[order], V[:, order]


def _ritz(M, S, X):
    """Squares and modes in the span of the columns of X, which may repeat."""
    sizes, turn = eigh(X.T @ (M @ X))
    kept = sizes > HELD * sizes[-1]
    X = X @ (turn[:, kept] / np.sqrt(sizes[kept]))
    squares, turn = eigh(X.T @ (S @ X))
    return squares, X @ turn


def below(M, S, square):
    """How many squares of frequencies are less than ``square``, of symmetric ``M`` > 0
    and ``S``: as many as S - square M has negative eigenvalues.
    """
    if issparse(S):
        return _counted(M, S, square)[1]
    return negatives(S - square * M)


def _counted(M, S, square):
    """A ``square``, or one beside it, at which a factor of S - square M tells the signs
    of its eigenvalues; how many are negative, and what solves with that factor.
    """
    for nudge in NUDGES:
        factor = symmetric_factor(csc_array(S - nudge * square * M))
        if factor is not None:
            count = int((factor.U.diagonal() < 0).sum())
            return nudge * square, count, factor.solve
    raise ArithmeticError("no factor of S tells the signs of its eigenvalues")


def negatives(x):
    """How many eigenvalues of a symmetric matrix ``x`` are negative; None where the
    factor of a sparse one doesn't tell.

    >>> [negatives(csc_array(np.diag([1.0, -2, c]))) for c in (3, -3)]
    [1, 2]
    """
    if not issparse(x):
        return int((np.linalg.eigvalsh(x) < 0).sum())
    factor = symmetric_factor(x)
    return None if factor is None else int((factor.U.diagonal() < 0).sum())


def symmetric_factor(x, *order):
    """`sparse_factor` of a symmetric sparse ``x``, perhaps in an ``order``, whose
    diagonal has the signs of its eigenvalues; None where rows were exchanged, or
    rounding spoilt it.
    """
    factor = sparse_factor(x, *order)
    if factor is None or (factor.perm_r != factor.perm_c).any():
        return None
    v = np.random.default_rng(0).normal(size=x.shape[0])
    y = factor.solve(v)
    size = np.linalg.norm(abs(x) @ abs(y)) + np.linalg.norm(v)
    good = np.linalg.norm(x @ y - v) < EXACT * size
    return factor if good and (factor.U.diagonal() != 0).all() else None


def _check_positive(M):
    if issparse(M):
        positive = negatives(M) == 0
    else:
        try:
            np.linalg.cholesky(M)
            positive = True
        except LinAlgError:
            positive = False
    if not positive:
        raise NoModes("M isn't positive definite: it has no real modes")


def _size(M, S):
    return abs(S).max() / (abs(M).max() or 1.0) or 1.0


def few(name, value, all_):
    """``value``, a count of coordinates that are kept, less than ``all_``; ``name`` is
    the argument's.
    """
    if count(name, value, 1) >= all_:
        raise ValueError(f"{name} must be less than {all_}, which are all, got {value}")
    return int(value)
