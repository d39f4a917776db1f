"""Rational numbers in numpy arrays (python-flint's), and decimals as text."""

import re
from functools import lru_cache
from math import isfinite

import numpy as np
from flint import arb_mat, ctx, fmpq, fmpq_mat, fmpz

from ..language.matrices import Symbols
from ..runtime.reading import MOST_DIGITS
from ..runtime.time_limit import check_time

AT_ONCE = 2**17  # entries, between two looks at the clock
BITS = 128  # of the first balls in which a matrix is inverted
SHARP = 1e-12  # radius of their balls, by the largest entry
FRACTION = rf"-?\d{{1,{MOST_DIGITS}}}(/\d{{1,{MOST_DIGITS}}})?"


class Rational(np.ndarray):
    """An array of fmpq (dtype object), by `exact`, whose matrix products are flint's.

    Everything else is numpy's, as are the constructor's shape, buffer, offset, strides
    and order.

    >>> A = exact(np.array([[0.5, 0.1], [0.2, 1.0]]))
    >>> A @ A
    Rational([[27/100, 3/20],
              [3/10, 51/50]], dtype=object)
    """

    def __array_wrap__(self, array, context=None, return_scalar=False):
        if array.ndim == 0:  # a sum is a number
            return array[()]
        return super().__array_wrap__(array, context, return_scalar)

    def __matmul__(self, other):
        if _both_matrices(self, other):
            return _array(_matrix(self) * _matrix(other))
        return super().__matmul__(other)

    def __rmatmul__(self, other):
        if _both_matrices(self, other):
            return _array(_matrix(other) * _matrix(self))
        return super().__rmatmul__(other)


def rational_matrix(rows):
    """A `Rational` array of ``rows``, lists of fmpq."""
    return np.array(rows, object).view(Rational)


def _both_matrices(x, other):
    """True if flint multiplies both: rationals, and rationals or ints."""
    return (
        x.dtype == object
        and isinstance(other, np.ndarray)
        and other.dtype.kind in "Oi"
        and x.ndim == other.ndim == 2
    )


def _matrix(x):
    return fmpq_mat(*x.shape, x.ravel().tolist())


def _array(matrix):
    rationals = np.empty((matrix.nrows(), matrix.ncols()), object)
    rationals.flat = matrix.entries()
    return rationals.view(Rational)


def exact(x):
    """The fmpq of a number x, or `Rational` array of those of an array.

    >>> exact(0.1)
    1/10
    >>> exact(np.array([fmpq(1, 3), 2**60 + 1]))
    Rational([1/3, 1152921504606846977], dtype=object)
    """
    if isinstance(x, np.ndarray):
        out, flat = np.empty(x.size, dtype=object), x.ravel()
        for k in range(0, x.size, AT_ONCE):
            check_time()
            some = flat[k : k + AT_ONCE].tolist()
            out[k : k + AT_ONCE] = [  # a rational's hash takes longer than its reading
                x if type(x) is fmpq else _reading(x) for x in some
            ]
        return out.reshape(x.shape).view(Rational)
    return _reading(x)


@lru_cache(maxsize=4096)  # a plant's numbers are read for many blocks
def _reading(x):
    if isinstance(x, (int, fmpz, fmpq)):  # no decimal of theirs is read
        return fmpq(x)
    mantissa, _, exponent = repr(float(x)).partition("e")
    if "n" in mantissa:  # "nan", "inf"
        raise ValueError(f"{x!r} is no finite number")
    whole, _, decimals = mantissa.partition(".")
    digits, power = int(whole + decimals), int(exponent or 0) - len(decimals)
    return fmpq(digits * 10**power) if power >= 0 else fmpq(digits, 10**-power)


def digit_count(digits):
    """A number of digits as an int, or a ValueError."""
    whole = isinstance(digits, (int, np.integer)) and not isinstance(digits, bool)
    if not whole or digits < 1:
        raise ValueError(f"digits must be 1 or more, got {digits!r}")
    return int(digits)


def round_places(matrices, digits):
    """``matrices`` of one shape, such as a real and an imaginary part, their entries
    rounded to so many ``digits`` of the sizes of their row and column: the decimals
    have about one length then.
    """
    both = np.max(np.abs(matrices), axis=0)
    columns = both.max(axis=0)
    sizes = columns * (both / columns).max(axis=1)[:, None]
    places = 10.0 ** np.ceil(digits - np.log10(sizes))
    return [np.round(x * places) / places for x in matrices]


def round_digits(x, digits):
    """The numbers x rounded to so many significant ``digits``; a ValueError below one.

    >>> round_digits(np.array([123.456, 0.00123456]), 4)
    array([1.235e+02, 1.235e-03])
    """
    digits = digit_count(digits)
    x = np.asarray(x, float)
    return np.array([float(f"{v:.{digits - 1}e}") for v in x.flat]).reshape(x.shape)


def inverse(x):
    """The inverse of a matrix x of floats or of rationals, or traced.

    >>> inverse(exact(np.array([[2.0, 1.0], [1.0, 1.0]])))
    Rational([[1, -1],
              [-1, 2]], dtype=object)
    """
    if isinstance(x, Symbols):
        return x.word("inv", x.shape)
    if x.dtype != object:
        return np.linalg.inv(x)
    return _array(_matrix(x).inv())


# as text: what proof files are made of


def decimal(x):
    """A float x as the shortest decimal that is read back as it.

    >>> decimal(0.1), decimal(150.0), decimal(-0.0), decimal(1e-7)
    ('0.1', '150', '0', '1e-07')
    """
    if not isfinite(x):
        raise ValueError(f"{x!r} is no decimal number")
    return repr(float(x) + 0.0).removesuffix(".0")


def echelon(x):
    """Rows of the reduced echelon form of x, and their leading columns.

    >>> rows, lead = echelon(np.array([[0.0, 2.0, 4.0], [0.0, 0.1, 0.2]]))
    >>> [[str(e) for e in row] for row in rows], lead
    ([['0', '1', '2']], [1])
    """
    reduced, rank = _matrix(x if x.dtype == object else exact(x)).rref()
    rows = reduced.table()[:rank]
    return rows, [next(j for j, e in enumerate(row) if e != 0) for row in rows]


def null_basis(rows):
    """An exact basis of the x with ``rows`` x = 0, as columns; see `echelon`."""
    reduced, lead = echelon(rows)
    rest = [j for j in range(rows.shape[1]) if j not in lead]
    basis = exact(np.zeros((rows.shape[1], len(rest))))
    for column, j in enumerate(rest):
        basis[j, column] = fmpq(1)
        for row, k in zip(reduced, lead):
            basis[k, column] = -row[j]
    return basis


def decimals(x):
    """An array x of floats as nested lists of decimals."""
    return np.vectorize(decimal, otypes=[object])(np.asarray(x, float)).tolist()


def read_number(text):
    """The float of a decimal ``text`` as `decimal` writes it; else a ValueError."""
    if isinstance(text, str) and re.fullmatch(r"[-+.e0-9]{1,30}", text, re.ASCII):
        try:
            if decimal(float(text)) == text:
                return float(text)
        except ValueError:
            pass
    raise ValueError(f"{str(text)[:40]!r} isn't a decimal number in its shortest form")


def read_array(rows, *shape):
    """The read-only array of nested decimals ``rows``; a None in ``shape`` is free."""
    if not shape:
        return read_number(rows)
    if not isinstance(rows, list) or shape[0] not in (None, len(rows)):
        raise ValueError(f"a list of {shape[0]} is needed")
    entries = [read_array(row, *shape[1:]) for row in rows]
    if len({np.shape(x) for x in entries}) > 1:
        raise ValueError("the rows differ in length")
    entries = np.array(entries, float)
    if not entries.size:
        entries = np.zeros([n or 0 for n in (len(rows), *shape[1:])])
    entries.flags.writeable = False
    return entries


def read_regular(rows, N):
    """As `read_array`, for ``rows`` of an (N, N) matrix that must have an inverse."""
    x = read_array(rows, N, N)
    try:
        inverse(exact(x))
    except ZeroDivisionError:
        raise ValueError("a matrix that must be regular is singular") from None
    return x


def fractions(x):
    """The rows of an array of rationals x, as texts that `fraction` reads."""
    return [[str(e) for e in row] for row in np.asarray(x).tolist()]


def read_fractions(rows, columns=0):
    """The rationals of ``rows`` of texts; without a row they have so many columns."""
    if len({len(row) for row in rows}) > 1:
        raise ValueError("the rows of a matrix differ in length")
    if not rows or not rows[0]:
        return exact(np.zeros((len(rows), 0 if rows else columns)))
    return rational_matrix([[fraction(e) for e in row] for row in rows])


def fraction(text):
    """The rational of a text "p/q", as str(fmpq) writes it."""
    if isinstance(text, str) and re.fullmatch(FRACTION, text, re.ASCII):
        p, _, q = text.partition("/")
        denominator = fmpz(q or "1")
        if denominator:
            rational = fmpq(fmpz(p), denominator)
            if str(rational) == text:
                return rational
    raise ValueError(f"{str(text)[:40]!r} isn't a fraction in lowest terms")


def exact_margin(g):
    """The least eigenvalue of a positive definite g, its diagonal scaled to one.

    It is that of the inverse, whose largest eigenvalue floats know, however small its
    own is. The diagonal is scaled by powers of four.

    >>> thin = exact(np.array([[1.0, 0.99999999999999], [0.99999999999999, 1.0]]))
    >>> round(exact_margin(thin) * 1e14, 6)
    1.0
    """
    d = [fmpq(2) ** round(log2(fmpq(e)) / 2) for e in np.diagonal(g)]
    scaled = [e / (a * b) for row, a in zip(g, d) for e, b in zip(row, d)]
    rows, largest = _inverse_in_floats(fmpq_mat(*g.shape, scaled))
    return float(1 / (largest * float(np.linalg.eigvalsh(rows)[-1])))


def _inverse_in_floats(matrix):
    """The inverse of a regular fmpq_mat: floats of at most one, and their unit, an arb.

    By balls, with as many digits as it takes: rationals take far longer.
    """
    size, bits = matrix.nrows(), BITS
    while True:
        with ctx.workprec(bits):
            try:
                entries = arb_mat(matrix).inv().entries()
            except ZeroDivisionError:  # so few digits can't tell it from a singular one
                entries = []
            if entries and all(e.is_finite() for e in entries):
                largest = max(abs(e).mid() for e in entries)
                if all(e.rad() < SHARP * largest for e in entries):
                    rows = [float((e / largest).mid()) for e in entries]
                    return np.array(rows).reshape(size, size), largest
        bits *= 2


def log2(x):
    """The logarithm to base 2 of a positive fmpq x, nearly: a whole number."""
    return int(x.p).bit_length() - int(x.q).bit_length()
