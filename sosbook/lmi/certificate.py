"""Exact proofs in rational arithmetic (python-flint)."""

from fractions import Fraction

import numpy as np
from flint import fmpq, fmpq_mat
from scipy.linalg import qr

from .centre import refine

__all__ = [
    "exact",
    "inverse",
    "pivots",
    "repair_multipliers",
    "round_digits",
]


def exact(x):
    """Decimal reading of floats: 0.1 becomes 1/10.

    Parameters
    ----------
    x : float or array of floats

    Returns
    -------
    fmpq, or array of them (dtype object)

    Examples
    --------
    >>> exact(0.1)
    1/10
    """
    if isinstance(x, np.ndarray):
        out = np.empty(x.shape, dtype=object)
        for index, entry in np.ndenumerate(x):
            out[index] = exact(entry)
        return out
    f = Fraction(repr(float(x)))
    return fmpq(f.numerator, f.denominator)


def round_digits(x, digits):
    """Round to so many significant digits.

    Examples
    --------
    >>> round_digits(np.array([123.456, 0.00123456]), 4)
    array([1.235e+02, 1.235e-03])
    """
    x = np.asarray(x, float)
    return np.array([float(f"{v:.{digits - 1}e}") for v in x.flat]).reshape(
        x.shape
    )


def _matrix(x):
    rows, cols = x.shape
    entries = [e if isinstance(e, fmpq) else fmpq(int(e)) for e in x.flat]
    return fmpq_mat(rows, cols, entries)


def inverse(x):
    """Inverse of a matrix of floats or of rationals.

    Examples
    --------
    >>> inverse(exact(np.array([[2.0, 1.0], [1.0, 1.0]])))
    array([[1, -1],
           [-1, 2]], dtype=object)
    """
    if x.dtype != object:
        return np.linalg.inv(x)
    entries = _matrix(x).inv().entries()
    return np.array(entries, dtype=object).reshape(x.shape)


def pivots(x):
    """Pivots of the exact LDL factorisation of a rational matrix.

    Parameters
    ----------
    x : (q, q) array of fmpq

    Returns
    -------
    list of fmpq
        All q pivots if the matrix is positive definite; otherwise the
        list ends with the first pivot that isn't positive.

    Raises
    ------
    ValueError
        If the matrix isn't exactly symmetric.

    Examples
    --------
    >>> pivots(exact(np.array([[2.0, 1.0], [1.0, 2.0]])))
    [2, 3/2]
    >>> pivots(exact(np.array([[1.0, 2.0], [2.0, 1.0]])))
    [1, -3]
    """
    a = _matrix(x)
    if a != a.transpose():
        raise ValueError("the matrix isn't symmetric")
    rows = a.table()
    found = []
    while rows:
        head = rows[0]
        found.append(head[0])
        if head[0] <= 0:
            break
        rows = [
            [r[j] - r[0] / head[0] * head[j] for j in range(1, len(r))]
            for r in rows[1:]
        ]
    return found


def repair_multipliers(blocks, Z, digits=15):
    """Make float multipliers satisfy sum <G_ka, Z_k> = 0 exactly.

    Only as many entries are changed as there are variables: those that
    the smallest eigenvalues of the Z_k leave the most room to change.

    Parameters
    ----------
    blocks : Blocks of exact arrays
    Z : list of float arrays

    Returns
    -------
    (multipliers, value) or None
        Exact positive definite Z_k, and sum <G_k0, Z_k> <= 0; None if
        the repaired Z_k prove nothing.
    """
    Z = refine(blocks, Z)
    Z = [exact(round_digits((z + z.T) / 2, digits)) for z in Z]
    lower = [np.tril_indices(len(z)) for z in Z]
    slopes = [
        np.where(i == j, 1, 2) * s[:, i, j]
        for s, (i, j) in zip(blocks.slopes, lower)
    ]
    flat = np.hstack(slopes)
    flat = flat[(flat != 0).any(axis=1)]  # variables that a block holds
    vector = np.concatenate([z[ij] for z, ij in zip(Z, lower)])
    try:
        stiff = [np.linalg.inv(z.astype(float)).diagonal() for z in Z]
    except np.linalg.LinAlgError:
        return None
    if min(s.min() for s in stiff) <= 0:
        return None
    room = np.concatenate([
        1 / np.sqrt(s[i] * s[j]) for s, (i, j) in zip(stiff, lower)
    ])
    white = flat.astype(float) * room
    white /= np.linalg.norm(white, axis=1)[:, None]
    few = qr(white, mode="economic", pivoting=True)[2][:len(flat)]
    residual = _matrix(flat) * _matrix(vector[:, None])
    try:
        change = _matrix(flat[:, few]).solve(residual).entries()
    except ZeroDivisionError:
        return None
    vector[few] -= change
    ends = np.cumsum([len(i) for i, _ in lower])[:-1]
    out = []
    for z, (i, j), part in zip(Z, lower, np.split(vector, ends)):
        repaired = z.copy()
        repaired[i, j] = repaired[j, i] = part
        if not _stays_positive(z, repaired):
            return None
        out.append(repaired)
    value = sum((c * z).sum() for c, z in zip(blocks.constants, out))
    return (out, value) if value <= 0 else None


def _stays_positive(near, far):
    """Whether ``far`` is positive definite because ``near`` is.

    With short rationals in ``near``, and c_i above the sum of row i of
    |far - near|, near - diag(c) > 0 implies far > 0 (Gershgorin).
    """
    lowered = near.copy()
    for i, row in enumerate(far - near):
        change = sum(abs(float(e)) + 1e-300 for e in row if e != 0)
        lowered[i, i] -= exact(float(f"{1.01 * change:.2e}"))
    return pivots(lowered)[-1] > 0
