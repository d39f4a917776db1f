"""The weights of a cost: symmetric and semidefinite, exactly and not nearly."""

import numpy as np

from ..exact.definite import definite, exact, semidefinite
from ..plants.checks import matrix
from ..runtime.time_limit import check_time

ROUNDING = 1e-12  # of the root of the diagonal entries beside an entry
STEPS = 2.0 ** np.arange(-52, -39)  # relative, by which a diagonal is raised


def symmetric_weight(name, Q):
    """A weight ``Q``, ``name`` in errors, that is exactly symmetric in floats that are
    read as decimals: entries opposite each other that differ by rounding get their
    mean.
    """
    Q = matrix(name, Q)
    if Q.shape[0] != Q.shape[1]:
        raise ValueError(f"{name} must be square, got {Q.shape[0]} x {Q.shape[1]}")
    size = np.sqrt(np.abs(Q.diagonal()))
    if (np.abs(Q - Q.T) > ROUNDING * np.outer(size, size)).any():
        raise ValueError(f"{name} must be symmetric")
    return Q if (Q == Q.T).all() else Q / 2 + Q.T / 2


def semidefinite_weight(name, Q):
    """A weight ``Q``, ``name`` in errors, that is exactly symmetric and positive
    semidefinite as rationals prove; if it is so but for rounding its diagonal gets
    larger, by as few roundings of each entry as it takes: then x' Q x isn't smaller for
    any x. This is free of the states' units.

    >>> C = np.array([[0.3, 0.7]])
    >>> bool(semidefinite(exact(C.T @ C)))
    False
    >>> bool(semidefinite(exact(semidefinite_weight("Q", C.T @ C))))
    True
    """
    from scipy.sparse.csgraph import connected_components

    Q = symmetric_weight(name, Q)
    count, parts = connected_components(Q != 0, directed=False)
    for part in range(count):
        rows = np.flatnonzero(parts == part)
        here = np.ix_(rows, rows)
        if not _is_semidefinite(Q[here]):
            Q = Q.copy()
            Q[here] = _raised(name, Q[here], rows)
    return Q


def _is_semidefinite(Q):
    x = exact(Q)
    return x[0, 0] >= 0 if len(x) == 1 else definite(x)[0] or semidefinite(x)


def _raised(name, Q, rows):
    """An irreducible part of a weight with its diagonal raised until it is definite."""
    diagonal = Q.diagonal()
    if (diagonal > 0).all():
        for step in STEPS:
            raised = Q.copy()
            np.fill_diagonal(raised, np.nextafter(diagonal * (1 + step), np.inf))
            if definite(exact(raised))[0]:
                return raised
    raise ValueError(
        f"{name} has a negative eigenvalue, in the states {(rows + 1).tolist()}: it "
        "must be positive semidefinite. A weight of outputs y = C x is given as C"
    )


def square_factors(Q):
    """Rationals L, W with ``Q`` = L W^-1 L', W diagonal and regular. Raises ValueError
    if Q isn't positive semidefinite: nothing of it is left out.
    """
    remainder, columns, sizes = Q.copy(), [], []
    for k in range(len(Q)):
        check_time()
        pivot = remainder[k, k]
        if pivot > 0:
            column = remainder[:, k : k + 1] / pivot
            rows = np.flatnonzero(column[:, 0] != 0)  # few, where Q is sparse
            there, part = np.ix_(rows, rows), column[rows]
            remainder[there] = remainder[there] - pivot * (part @ part.T)
            columns.append(column)
            sizes.append(1 / pivot)
    if (remainder != 0).any():
        raise ValueError("Q has a negative eigenvalue: it must be semidefinite")
    L = np.hstack(columns) if columns else Q[:, :0]
    W = exact(np.zeros((len(sizes), len(sizes))))
    W[range(len(sizes)), range(len(sizes))] = sizes
    return L, W
