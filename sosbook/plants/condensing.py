"""Coordinates without mass and damping, solved for and put into the other rows."""

from typing import TYPE_CHECKING

import numpy as np
from flint import arb, arb_mat, ctx, fmpq_mat
from scipy.sparse import csc_array, issparse
from scipy.sparse.linalg import splu

from ..exact.rational import exact
from ..runtime.saying import warn_outside
from .checks import checked_names, matrix, not_negative
from .massless import Massless, constraints, empty_rows, empty_words, kept, listed
from .second_order import SecondOrderSystem
from .sparse import MOST_DENSE, reader

if TYPE_CHECKING:
    from collections.abc import Iterable

    from .second_order import Matrix

BITS = 256, 1024, 4096  # of balls; a long chain loses a bit or two a link
SHARP = 120  # bits that an entry needs, lest neighbours of one value round apart
NO_MASS = "M and D are zero: no displacement has a mass or damping"
MOST_TOUCHED = 2 * MOST_DENSE  # rows of a large plant; they fill its S
MOST_FULL = 5000  # rows that floats may fill of a large plant
ROUNDING = 1e-14  # relative: less than that was never there
NOTHING = 2.0**-100  # of the largest: an entry below that is zero


def condense(
    M: "Matrix",
    D: "Matrix",
    S: "Matrix",
    B: "Matrix",
    F: "Matrix | None" = None,
    coordinates: "Iterable[str] | None" = None,
    *,
    tolerance: float = 0.0,
) -> SecondOrderSystem:
    r"""The plant without the displacements that have neither mass nor damping.

    They follow the others at once. This is no approximation: the poles and all
    motions of the rest stay what they are.

    Parameters
    ----------
    M, D, S, B, F, coordinates : array_like, and a sequence of str
        As `SecondOrderSystem` takes them. Rows z are condensed where M and D are zero
        in the row and in the column, and so is every mixture of rows for which they
        are, exactly, as decimals. In a large sparse plant no mixture is looked for.
        Where M alone is zero, and D is a positive multiple of S there with no entry of
        B and F (Rayleigh), they are condensed as without damping.
    tolerance : float
        Masses and damping up to so much of the largest count as none: for files that
        have ten digits, 1e-9. With Rayleigh's damping forces do, too. What is left out
        is in a warning. In a large sparse plant floats may solve, to a residual of so
        much.

    Returns
    -------
    SecondOrderSystem
        That of the other rows, or of what they have beside such a mixture: they are
        nameless then. Its entries are the exact ones, rounded once: enclosed
        by balls to 120 bits, and zero below :math:`2^{-100}` of the largest of S, or
        in a column of B or F. A proof is about the rounded ones. Without such rows it
        is the plant that was given.

    Raises
    ------
    ValueError
        On bad input, if no row is left, or if :math:`S_{zz}` is singular: its rows
        move freely.

    Warns
    -----
    UserWarning
        Of the masses and damping that a ``tolerance`` leaves out.

    Notes
    -----
    With :math:`S_{zz} q_z = B_z u + F_z w - S_{zk} q_k` the rows k have
    :math:`S_{kk} - S_{kz} S_{zz}^{-1} S_{zk}` for S and
    :math:`B_k - S_{kz} S_{zz}^{-1} B_z` for B. With mixtures N, where
    :math:`M N = D N = 0`, and L of the rows, they are :math:`S_{zz} = L^T S N`,
    :math:`S_{kz} = (S N)_k` and :math:`S_{zk} = (L^T S)_k`. With
    :math:`D_{zz} = \beta S_{zz}` and so on, :math:`D - \beta S` is zero there, and
    :math:`\beta` times the new S is added; what is left out decays with
    :math:`1/\beta`, whatever the others do.

    Examples
    --------
    A mass, and a point without one between two springs of stiffness 2:

    >>> M, D, S = np.diag([1, 0]), np.zeros((2, 2)), [[2, -2], [-2, 4]]
    >>> plant = condense(M, D, S, B=np.eye(2))
    >>> plant.S, plant.B
    (array([[1.]]), array([[1. , 0.5]]))
    """
    read = reader(M, D, S)
    given = {"M": read("M", M)}
    n = given["M"].shape[0]
    F = np.zeros((n, 0)) if F is None else F
    for name, value in dict(D=D, S=S, B=B, F=F).items():
        made = read if name in "DS" else matrix
        given[name] = made(name, value, (n, n if name in "DS" else None))
    names, tolerance = (
        checked_names(coordinates, n),
        not_negative("tolerance", tolerance),
    )
    there = Massless.of(given, tolerance)
    if there is None:
        return SecondOrderSystem(**given, coordinates=names)
    if there.count == n:
        raise ValueError(NO_MASS)
    damping = given["D"] - there.beta * given["S"] if there.beta else given["D"]
    part = (_in_part if issparse(given["M"]) else _without)(
        given | {"D": damping}, there, names, tolerance
    )
    if there.beta:
        part["D"] = part["D"] + there.beta * part["S"]
    return condense(**part, tolerance=tolerance)  # what else has no mass then


def _without(given, there, names, tolerance):
    """The remaining plant, by argument."""
    N, L, n = there.N, there.L, len(there.N)
    if tolerance:
        right, left = N.astype(float), L.astype(float)
        _say(given, there, lambda X: left.T @ X, lambda X: X @ right)
    # z = N zeta + what is kept; zeta stands in rows of its own, which go
    rows, (columns, gone) = kept(L)[0], kept(N)
    S, *pushes = (exact(given[x]) for x in "SBF")
    right = np.hstack([S[:, columns], *pushes])
    parts = schur(S @ N, right, L, rows, len(columns))
    if parts is None:
        raise _singular(given, gone)
    ends = len(columns), len(columns) + given["B"].shape[1]
    parts = dict(zip("SBF", np.split(parts, ends, axis=1)))
    inertia = {name: given[name][np.ix_(rows, columns)] for name in "MD"}
    alone = not N[columns].any() and n == len(rows) + len(gone)
    left = [names[i] for i in columns] if names and alone else None
    return dict(**inertia, **parts, coordinates=left)


def _say(given, there, rows, columns):
    """Warn of the masses and damping that a tolerance leaves out, and of forces where
    damping goes: those parts of a matrix that ``rows`` and ``columns`` return.
    """
    names = "MDBF" if there.beta else "MD"
    for name, X in ((x, given[x]) for x in names if given[x].shape[1]):
        parts = (rows(X), columns(X)) if name in "MD" else (rows(X),)
        size = max((abs(x).max() for x in parts if x.size), default=0.0)
        whole = abs(X).max()
        if name == "D":  # less what is condensed with S
            whole += there.beta * abs(given["S"]).max()
        if size > ROUNDING * whole:
            warn_outside(
                f"condense leaves out {size / whole:.1g} of {name} in "
                f"{there.count} directions: the plant that is left is another one by "
                "so much"
            )


def _singular(given, gone):
    """The error where nothing holds what is without mass, in these rows."""
    if empty := empty_rows({name: given[name] for name in "MDS"}):
        return ValueError(empty_words(empty, "M, D and S"))
    return ValueError(
        f"S is singular in the rows and columns {listed(gone)}, which have neither "
        f"mass nor damping, or nearer to it than {BITS[-1]} bits tell: what holds them?"
        f"{constraints(given, np.array(gone))}"
    )


def _in_part(given, there, names, tolerance):
    """A large plant without its massless rows: what they don't touch stays as it is."""
    M, D, S, B, F = (given[name] for name in "MDSBF")
    n, gone = M.shape[0], there.N
    if tolerance:
        _say(given, there, lambda X: X[gone], lambda X: X[:, gone])
    left = np.setdiff1d(np.arange(n), gone)
    near = abs(S[gone]).sum(axis=0) + abs(S[:, gone]).sum(axis=1)
    near = np.setdiff1d(np.flatnonzero(near), gone)
    count = len(near) + len(gone)
    if count > MOST_TOUCHED and not tolerance:
        raise ValueError(
            f"the {len(gone)} displacements without mass and damping touch {count} "
            f"rows of S, which would be full there: at most {MOST_TOUCHED} are solved "
            "for exactly. "
            + (
                "With tolerance=1e-9 floats solve for them, to that residual"
                if len(near) <= MOST_FULL and there.solvable(given)
                else "Condense them in the program that they come from"
            )
        )
    if count > MOST_TOUCHED:
        new, B_near, F_near = _by_floats(given, gone, near, tolerance)
    else:
        touched = np.concatenate([near, gone])
        pushes = [exact(x[touched]) for x in (B, F)]
        local = exact(S[touched][:, touched].toarray())
        k = len(near)
        units = exact(np.eye(count))[:, k:]
        right = np.hstack([local[:, :k], *pushes])
        parts = schur(local[:, k:], right, units, np.arange(k), k)
        if parts is None:
            raise _singular(given, gone)
        new, B_near, F_near = np.split(parts, (k, k + B.shape[1]), axis=1)
    S, B, F = S.tolil(), B.copy(), F.copy()
    S[np.ix_(near, near)], B[near], F[near] = new, B_near, F_near
    M, D, S = (csc_array(x)[left][:, left] for x in (M, D, S))
    kept = [names[i] for i in left] if names else None
    return dict(M=M, D=D, S=S, B=B[left], F=F[left], coordinates=kept)


def _by_floats(given, gone, near, tolerance):
    """S, B and F in the rows ``near`` those that are gone, to a residual."""
    S, B, F = (given[name] for name in "SBF")
    inner = csc_array(S[gone][:, gone])
    driven = np.hstack([S[gone][:, near].toarray(), B[gone], F[gone]])
    try:
        moved = splu(inner).solve(driven)
    except RuntimeError:
        raise _singular(given, gone) from None
    residual = abs(inner @ moved - driven).max() / abs(driven).max()
    if not residual <= tolerance:
        raise ValueError(
            f"floats solve for the massless displacements to {residual:.1g} only: give "
            "a tolerance as large, or condense them in the program that they come from"
        )
    rows = np.hstack([S[near][:, near].toarray(), B[near], F[near]])
    parts = rows - S[near][:, gone] @ moved
    same = not (S != S.T).nnz
    k = len(near)
    if same:
        parts[:, :k] = (parts[:, :k] + parts[:, :k].T) / 2
    return np.split(parts, (k, k + B.shape[1]), axis=1)


def schur(left, right, L, k, square):
    """right_k - left_k (L' left)^-1 L' right in the rows ``k`` of ``left`` and
    ``right``, to the float, or None; the first columns, as many as ``square``, are S,
    which stays symmetric.
    """
    sizes = abs(right).max(axis=0).astype(float)
    sizes[:square] = sizes[:square].max()
    inner, driven = L.T @ left, L.T @ right
    for bits in BITS:
        with ctx.workprec(bits):
            try:
                moved = _balls(inner).solve(_balls(driven))
            except ZeroDivisionError:
                continue
            table = (_balls(right[k]) - _balls(left[k]) * moved).table()
            rounded = [[*map(_float, row, sizes)] for row in table]
            if not any(x is None for row in rounded for x in row):
                return np.array(rounded)
    return None


def _balls(x):
    return arb_mat(fmpq_mat(*x.shape, x.ravel().tolist()))


def _float(x, size):
    """The float of a ball; None if it isn't sharp enough."""
    if x == 0 or abs(x) < arb(size) * arb(NOTHING):
        return 0.0
    return float(x.mid()) if x.rel_accuracy_bits() >= SHARP else None
