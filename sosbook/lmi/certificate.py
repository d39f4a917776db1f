"""Exact proofs in rational arithmetic (python-flint)."""

from fractions import Fraction

import numpy as np
from flint import fmpq, fmpq_mat

__all__ = ["exact", "pivots", "repair_multipliers", "round_digits"]


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


def repair_multipliers(blocks, Z, digits=8):
    """Make float multipliers satisfy sum <G_ka, Z_k> = 0 exactly.

    Each Z_k becomes L (I + X) L', where L is its rounded Cholesky
    factor, and the X_k are the smallest that satisfy the equations. It
    is positive definite if each row of |X| sums to less than one.

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
    try:
        factors = [
            _matrix(exact(round_digits(np.linalg.cholesky(z), digits)))
            for z in Z
        ]
    except np.linalg.LinAlgError:
        return None
    white, total = [], None
    for L, slopes in zip(factors, blocks.slopes):
        turned = [L.transpose() * _matrix(g) * L for g in slopes]
        white.append(turned)
        rows = fmpq_mat(len(turned), L.nrows() ** 2,
                        [e for h in turned for e in h.entries()])
        ones = fmpq_mat(L.nrows() ** 2, 1, [
            int(i == j) for i in range(L.nrows()) for j in range(L.nrows())
        ])
        part = rows * rows.transpose(), rows * ones
        total = part if total is None else (
            total[0] + part[0], total[1] + part[1])
    gram, residual = total
    # a variable that no block holds needs no equation
    used = [a for a in range(gram.nrows()) if gram[a, a] != 0]
    try:
        weights = fmpq_mat(len(used), len(used), [
            gram[a, b] for a in used for b in used
        ]).solve(fmpq_mat(len(used), 1, [residual[a, 0] for a in used]))
    except ZeroDivisionError:
        return None
    out = []
    for L, turned in zip(factors, white):
        q = L.nrows()
        X = fmpq_mat(q, q)
        for k, a in enumerate(used):
            X -= turned[a] * weights[k, 0]
        if any(sum(abs(e) for e in row) >= 1 for row in X.table()):
            return None
        one = fmpq_mat(q, q, [
            int(i == j) for i in range(q) for j in range(q)
        ])
        repaired = L * (one + X) * L.transpose()
        out.append(np.array(repaired.table(), dtype=object).reshape(q, q))
    value = sum((c * z).sum() for c, z in zip(blocks.constants, out))
    return (out, value) if value <= 0 else None
