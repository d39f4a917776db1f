"""Displacements without mass and damping, solved for and put into the other rows."""

from typing import TYPE_CHECKING

import numpy as np
from flint import arb, arb_mat, ctx, fmpq_mat

from ..exact.rational import exact
from .checks import checked_names, massless, matrix
from .second_order import SecondOrderSystem

if TYPE_CHECKING:
    from collections.abc import Iterable

    from .second_order import Matrix

__all__ = ["condense"]

BITS = 256, 1024, 4096  # of balls; a long chain loses a bit or two a link
SHARP = 120  # bits that an entry needs, lest neighbours of one value round apart
NOTHING = 2.0**-100  # of the largest: an entry below that is zero


def condense(
    M: "Matrix",
    D: "Matrix",
    S: "Matrix",
    B: "Matrix",
    F: "Matrix | None" = None,
    coordinates: "Iterable[str] | None" = None,
) -> SecondOrderSystem:
    r"""The plant without the displacements that have neither mass nor damping.

    They follow the others at once. This is no approximation: the poles and all
    motions of the rest stay what they are.

    Parameters
    ----------
    M, D, S, B, F, coordinates : array_like, and a sequence of str
        As `SecondOrderSystem` takes them. Rows z are condensed where M and D are zero
        in the row and in the column.

    Returns
    -------
    SecondOrderSystem
        That of the other rows. Its entries are the exact ones, rounded once: enclosed
        by balls to 120 bits, and zero below :math:`2^{-100}` of the largest of S, or
        in a column of B or F. A proof is about the rounded ones. Without such rows it
        is the plant that was given.

    Raises
    ------
    ValueError
        On bad input, if no row is left, or if :math:`S_{zz}` is singular: its rows
        move freely.

    Notes
    -----
    With :math:`S_{zz} q_z = B_z u + F_z w - S_{zk} q_k` the rows k have
    :math:`S_{kk} - S_{kz} S_{zz}^{-1} S_{zk}` for S and
    :math:`B_k - S_{kz} S_{zz}^{-1} B_z` for B.

    Examples
    --------
    A mass, and a point without one between two springs of stiffness 2:

    >>> M, D, S = np.diag([1, 0]), np.zeros((2, 2)), [[2, -2], [-2, 4]]
    >>> plant = condense(M, D, S, B=np.eye(2))
    >>> plant.S, plant.B
    (array([[1.]]), array([[1. , 0.5]]))
    """
    given = {"M": matrix("M", M)}
    n = len(given["M"])
    F = np.zeros((n, 0)) if F is None else F
    for name, value in dict(D=D, S=S, B=B, F=F).items():
        given[name] = matrix(name, value, (n, n if name in "DS" else None))
    z = massless(given["M"], given["D"])
    k = np.setdiff1d(np.arange(n), z)
    if not len(z):
        return SecondOrderSystem(**given, coordinates=coordinates)
    if not len(k):
        raise ValueError("M and D are zero: no displacement has a mass or damping")
    whole = exact(np.hstack([given[x] for x in "SBF"]))
    columns = np.setdiff1d(np.arange(whole.shape[1]), z)
    reduced = _schur(whole[:, z], whole[:, columns], z, k)
    ends = len(k), len(k) + given["B"].shape[1]
    parts = dict(zip("SBF", np.split(reduced, ends, axis=1)))
    inertia = {name: given[name][np.ix_(k, k)] for name in "MD"}
    if names := checked_names(coordinates, n):
        names = [names[i] for i in k]
    return SecondOrderSystem(**inertia, **parts, coordinates=names)


def _schur(left, right, z, k):
    """right_k - left_k left_z^-1 right_z, to the float."""
    sizes = abs(right).max(axis=0).astype(float)
    sizes[: len(k)] = sizes[: len(k)].max()  # S stays symmetric
    for bits in BITS:
        with ctx.workprec(bits):
            try:
                moved = _balls(left[z]).solve(_balls(right[z]))
            except ZeroDivisionError:
                continue
            table = (_balls(right[k]) - _balls(left[k]) * moved).table()
            rounded = [[*map(_float, row, sizes)] for row in table]
            if not any(x is None for row in rounded for x in row):
                return np.array(rounded)
    rows = ", ".join(map(str, z))
    raise ValueError(
        f"S is singular in the rows and columns {rows}, which have neither mass nor "
        f"damping, or nearer to it than {BITS[-1]} bits tell: what holds them?"
    )


def _balls(x):
    return arb_mat(fmpq_mat(*x.shape, x.ravel().tolist()))


def _float(x, size):
    """The float of a ball; None if it isn't sharp enough."""
    if x == 0 or abs(x) < arb(size) * arb(NOTHING):
        return 0.0
    return float(x.mid()) if x.rel_accuracy_bits() >= SHARP else None
