"""Checks of numbers and matrices that callers give."""

import re
from collections.abc import Iterable
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache

import numpy as np

from ..runtime.sparse import issparse

SAME = 1.2  # a quotient of lengths that need no further scaling
CLEAR = 1e-3  # of rows and columns of about one length: no scaling hides a rank
RIDGE = 1e-9  # to equations of scales that leave a factor open
SIZE_LIMITS = 1e-100, 1e100  # of numbers whose squares and products are floats, too
HYSTERETIC = (
    "; of hysteretic damping give S.real for S, and D + S.imag / omega for D: at the "
    "frequency omega in rad/s that matters, or at both ends of a range, between which "
    "it has all of them: sosbook.Polytope([sosbook.SecondOrderSystem(M, D + S.imag / "
    "omega, S.real, B) for omega in (low, high)])"
)
REAL_FORM = (
    "; of a complex x give each matrix X as np.block([[X.real, -X.imag], [X.imag, "
    "X.real]]), which has the real parts first"
)

# of coordinates: what the package calls by itself, and what it makes of a name
OWN = re.compile(r"u\d*|xc\d+")
MADE = re.compile(
    r"(?:[+-]|\d[\d_]*(?:e[+-]?\d+)? |(?:rate|integral|set point) of |filtered )*"
    r"(.*?)'*",
    re.DOTALL,
)

_written = ContextVar("written", default=False)  # whether `as_written` is in force


@contextmanager
def as_written():
    """Take the numbers of a proof file as they are, whatever their sizes and ranks:
    floats judge a request for a clear error, exact arithmetic alone what a file proves.

    >>> with as_written():
    ...     matrix("M", [[1e-200]])
    array([[1.e-200]])
    """
    token = _written.set(True)
    try:
        yield
    finally:
        _written.reset(token)


def as_in_a_file():
    """True if `as_written` is in force."""
    return _written.get()


def finite(name, value):
    """A value as a finite float, or a ValueError that has the argument's name."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    real = isinstance(value, (int, float, np.integer, np.floating))
    try:
        good = real and not isinstance(value, bool) and np.isfinite(float(value))
    except OverflowError:
        good = False
    if not good:
        raise ValueError(f"{name} must be a finite number, got {value!r:.80}")
    _check_size(name, abs(float(value)))
    return float(value)


class SizeError(ValueError):
    """A number is out of the bounds that files have: other units are needed."""


def _check_size(name, largest):
    """Raise a `SizeError` where a number, or the largest of some, is out of bounds."""
    if _written.get():
        return
    if largest > SIZE_LIMITS[1]:
        raise SizeError(
            f"{name} = {largest:.3g} is beyond {SIZE_LIMITS[1]:g}: choose other units"
        )
    if 0 < largest < SIZE_LIMITS[0]:
        raise SizeError(
            f"{name} = {largest:.3g} is below {SIZE_LIMITS[0]:g}: choose other units"
        )


def is_word(value, words):
    """True if a value (anything, an array too) is one of some words."""
    return isinstance(value, str) and value in words


def count(name, value, least=0):
    """A value as an int of ``least`` or more, or a ValueError with its name."""
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not whole or value < least:
        raise ValueError(f"{name} must be {least}, {least + 1}, ..., got {value!r}")
    return int(value)


def positive(name, value):
    """A value as a positive float, or a ValueError that has the argument's name."""
    if finite(name, value) <= 0:
        raise ValueError(f"{name} must be positive, got {value!r}")
    return float(value)


def not_negative(name, value, unit=""):
    """A value in a ``unit`` as a float of 0 or more, or a ValueError with its name."""
    if finite(name, value) < 0:
        where = f", in {unit}" if unit else ""
        raise ValueError(f"{name} must be 0 or more{where}, got {value!r}")
    return float(value)


def matrix(name, value, shape=None):
    """A value as a read-only float matrix, or a ValueError with the argument's
    ``name``. An entry None of ``shape`` is free; a number is a matrix of one entry.
    """
    if not isinstance(value, np.ndarray) and issparse(value):
        value = value.toarray()
    array = _floats(name, value)
    if array.ndim == 0:
        array = array.reshape(1, 1)
    if array.ndim == 1:
        row = ", ".join(f"{x:g}" for x in array[:3]) + ", ..." * (array.size > 3)
        column = ", ".join(f"[{x:g}]" for x in array[:3]) + ", ..." * (array.size > 3)
        raise ValueError(
            f"{name} must be a matrix (two dimensions), got 1: write [[{row}]] "
            f"for one row or [{column}] for one column"
        )
    if array.ndim == 3:
        raise ValueError(
            f"{name} must be one matrix (two dimensions), got a list of {len(array)}"
        )
    if array.ndim != 2:
        raise ValueError(f"{name} must be a matrix (two dimensions), got {array.ndim}")
    largest = np.abs(array).max(initial=0.0)
    if not np.isfinite(largest):
        raise ValueError(f"{name} has NaN or infinite entries")
    _check_size(f"the largest entry of {name}", largest)
    for axis, word in enumerate(("rows", "columns")):
        wanted = None if shape is None else shape[axis]
        if wanted is not None and array.shape[axis] != wanted:
            raise ValueError(f"{name} has {array.shape[axis]} {word}, needs {wanted}")
    array.flags.writeable = False
    return array


def matrices_of(name, value):
    """A list of matrices from one or several (value), or a ValueError with its name."""
    try:
        dimensions = np.ndim(value)
    except ValueError:  # several shapes
        dimensions = 3
    if issparse(value) or dimensions in (0, 2):
        return [matrix(name, value)]
    if dimensions == 1 and not any(issparse(x) or np.ndim(x) for x in value):
        matrix(name, value)  # raises: it is a vector
    matrices = [matrix(name, x) for x in value]
    if not matrices:
        raise ValueError(f"{name} is an empty list: give one matrix or more")
    return matrices


def numbers(name, value):
    """A value as a float array, perhaps with NaN, or a ValueError with its name."""
    array = _floats(name, value, "must be real numbers")
    largest = np.abs(array[np.isfinite(array)]).max(initial=0.0)
    _check_size(f"the largest entry of {name}", max(largest, SIZE_LIMITS[0]))
    return array


def _floats(name, value, what="must be a real matrix"):
    """A float array of its own, or a ValueError that says what isn't a number."""
    if type(value) is np.ndarray and value.dtype == float:  # most are
        return value.copy()
    if value is None:
        raise ValueError(f"{name} is missing: give a matrix")
    labels = getattr(value, "columns", ())
    if any(isinstance(x, str) for x in labels):
        raise ValueError(
            f"{name} is a table with the columns {', '.join(map(str, labels))}, and "
            f"names in tables aren't read: put it in order, and give {name}.to_numpy()"
        )
    try:
        if isinstance(value, (list, tuple)) and _ragged(value):
            raise TypeError("its rows have different lengths")
        raw = np.asarray(value)
        if raw.dtype.kind == "c":
            raise TypeError(f"it has complex entries{_real_form(name, raw)}")
        if raw.dtype.kind in "US" or _holds(raw, (str, bytes)):
            raise TypeError("it holds text; write numbers without quotes")
        if raw.dtype.kind == "b" or _holds(raw, bool) or _says_true(value):
            raise TypeError("it holds True or False; write 1 and 0")
        if raw.dtype.kind not in "iufO":
            raise TypeError(f"its entries are of the type {raw.dtype}")
        if np.ma.is_masked(value):
            raise TypeError("it has masked entries; fill them in")
        return np.array(raw, dtype=float)
    except Exception as error:  # an object may make an array of itself, and fail
        raise ValueError(f"{name} {what}: {error}") from None


def _says_true(value):
    """True if lists hold True or False, which numpy takes for 1 and 0 there."""
    if isinstance(value, (list, tuple)):
        return any(map(_says_true, value))
    return isinstance(value, (bool, np.bool_))


def _real_form(name, raw):
    """The cure where a ``raw`` matrix of this ``name`` is complex, in words."""
    square = raw.ndim == 2 and len(set(raw.shape)) == 1
    if name == "S" and not (square and np.array_equal(raw, raw.conj().T)):
        return HYSTERETIC
    return REAL_FORM if square and name in "MDSA" else ""


def _ragged(rows):
    """True if lists or tuples, the rows of a list, differ in length."""
    return len({len(x) for x in rows if isinstance(x, (list, tuple))}) > 1


def _holds(array, kinds):
    return array.dtype == object and any(isinstance(x, kinds) for x in array.flat)


def logarithmic_scales(M):
    """Factors of the rows and the columns of M, (..., k, l), that bring its entries
    near one, in least squares of their logarithms; zeros don't count. The scaled matrix
    is the same in all units of rows and columns.

    Source: A. R. Curtis and J. K. Reid, J. Inst. Maths Applics 10, 1972, 118-124.

    >>> import numpy as np
    >>> M = np.array([[1e-9, 1.0], [1.0, 1e9]])
    >>> rows, columns = logarithmic_scales(M)
    >>> (rows[:, None] * M * columns).round(6).tolist()
    [[1.0, 1.0], [1.0, 1.0]]
    """
    entries = np.abs(M)
    there = entries > 0
    logs = np.log(np.where(there, entries, 1))
    sums = np.concatenate([logs.sum(axis=-1), logs.sum(axis=-2)], axis=-1)
    rows, size = M.shape[-2], sums.shape[-1]
    pairs = np.zeros((*sums.shape, size))
    pairs[..., :rows, rows:] = there
    pairs[..., rows:, :rows] = there.swapaxes(-1, -2)
    pairs[..., range(size), range(size)] = pairs.sum(axis=-1) + RIDGE
    scales = np.exp(-np.linalg.solve(pairs, sums[..., None])[..., 0])
    return scales[..., :rows], scales[..., rows:]


def inverse_by_rows(M):
    """The inverse of a regular M whose rows have units of their own: where they differ
    by the digits of floats, elimination loses them all; powers of two bring them near
    one.

    >>> import numpy as np
    >>> M = np.array([[1e-9, 2e-9], [3e9, 1e9]])
    >>> bool(np.allclose(inverse_by_rows(M) @ M, np.eye(2)))
    True
    """
    sizes = np.abs(M).max(axis=1, initial=0.0)
    rows = np.exp2(-np.round(np.log2(np.where(sizes > 0, sizes, 1.0))))
    return np.linalg.inv(rows[:, None] * M) * rows


def check_rank(M, fault, tolerance=1e-10):
    """A ValueError, ``fault``, where M is `rank_deficient` (``tolerance``)."""
    if not _written.get() and rank_deficient(M, tolerance):
        raise ValueError(fault)


def rank_deficient(M, tolerance=1e-10):
    """True if M lacks rank, its rows and columns of unit length, both with
    `logarithmic_scales` and without: so neither units nor entries that are next to
    nothing matter. Singular values below the ``tolerance`` count as zero.
    """
    return _deficient(M.tobytes(), M.dtype, M.shape, tolerance)


@lru_cache(maxsize=1024)  # a plant is made again for each request of it
def _deficient(entries, kind, shape, tolerance):
    M = np.frombuffer(entries, kind).reshape(shape)
    if not M.size:
        return len(M) > 0
    if not _lacks_rank(M, tolerance):
        return False
    with np.errstate(over="ignore", invalid="ignore"):  # of scales that tiny entries
        rows, columns = logarithmic_scales(M)  # or a long triangle spoil
        scaled = rows[:, None] * M * columns
    return not np.isfinite(scaled).all() or _lacks_rank(scaled, tolerance)


def _lacks_rank(M, tolerance):
    """True if a singular value is below the tolerance, rows and columns of one length:
    one, for the columns of a square matrix; of others it can't be. Where all are
    `CLEAR` as soon as the lengths have been taken once, none of this is asked.
    """
    for k, axis in enumerate(20 * (1, 0)):
        lengths = np.sqrt((abs(M) ** 2).sum(axis=axis, keepdims=True))
        some = lengths[lengths > 0]
        M = M / np.where(lengths > 0, lengths, 1.0)
        if axis == 0 and (not some.size or some.max() < SAME * some.min()):
            break
        if k == 1 and not _lower(M, CLEAR):
            return False
    return _lower(M, tolerance)


def _lower(M, size):
    """True if M has fewer singular values above a ``size`` than rows."""
    return np.count_nonzero(np.linalg.svd(M, compute_uv=False) > size) < len(M)


def checked_names(coordinates, n, what="coordinates"):
    """The names of n ``coordinates``, or ``what`` they are, checked; None without."""
    if coordinates is None:
        return None
    one = isinstance(coordinates, str) or not isinstance(coordinates, Iterable)
    names = (coordinates,) if one else tuple(coordinates)
    good = all(isinstance(name, str) and name for name in names)
    good = good and len(names) == len(set(names)) == n
    if not good:
        raise ValueError(f"{what} must be {n} different names, got {coordinates!r}")
    if what == "coordinates":
        _unmistakable(names)
    return names


def _unmistakable(names):
    """Raise ValueError where one of the ``names`` of coordinates is also a name of an
    input or of a law's memory, or in words something that is made of another.
    """
    bare = [name.replace(".", "_") for name in names]  # python-control has no points
    known = dict(zip(bare, names))
    for name, k in zip(names, bare):
        if OWN.fullmatch(k):
            raise ValueError(
                f"coordinates: {name!r} is what an input or a law's memory is called: "
                "give it another name"
            )
        terms = {k, *re.split(r" [+-] ", k)}
        read = {MADE.fullmatch(x).group(1) for x in terms} | terms
        if other := [known[x] for x in read if known.get(x, name) != name]:
            raise ValueError(
                f"coordinates: {name!r} could be taken for something made of "
                f"{other[0]!r}: give it another name"
            )
