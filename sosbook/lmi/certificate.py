"""Exact proofs in rational arithmetic (python-flint)."""

from fractions import Fraction

import numpy as np
from flint import fmpq, fmpq_mat

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


def repair_multipliers(blocks, Z, digits=12):
    """Make float multipliers satisfy sum <G_ka, Z_k> = 0 exactly.

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
    flat = _matrix(np.hstack(
        [s.reshape(len(s), -1) for s in blocks.slopes]
    ))
    vector = _matrix(np.concatenate([z.ravel() for z in Z])[:, None])
    gram = flat * flat.transpose()
    for a in range(gram.nrows()):  # a variable that no block holds
        if gram[a, a] == 0:
            gram[a, a] = 1
    try:
        weights = gram.solve(flat * vector)
    except ZeroDivisionError:
        return None
    repaired = vector - flat.transpose() * weights
    entries = np.array(repaired.entries(), dtype=object)
    out, start = [], 0
    for z in Z:
        part = entries[start:start + z.size].reshape(z.shape)
        start += z.size
        if not _stays_positive(z, part):
            return None
        out.append(part)
    value = sum((c * z).sum() for c, z in zip(blocks.constants, out))
    return (out, value) if value <= 0 else None


def _stays_positive(near, far):
    """Whether ``far`` is positive definite because ``near`` is.

    With short rationals in ``near``, and c above every entry of |far -
    near|, near - q c I > 0 implies far > 0.
    """
    q = len(near)
    change = max(abs(e) for e in (far - near).flat)
    if change == 0:
        c = fmpq(0)
    else:
        c = fmpq(1, 2) ** -(int(np.ceil(np.log2(float(change)))) + 1)
    lowered = near - q * c * np.eye(q, dtype=int)
    return pivots(lowered)[-1] > 0
