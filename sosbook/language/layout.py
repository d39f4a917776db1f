"""Block matrices of arrays, expressions and symbols."""

from itertools import accumulate

import numpy as np

from .expression import Affine, Term, is_zero
from .matrices import Matrices, Symbols


def block(rows):
    """Assemble a block matrix; a plain ``0`` is a zero block that fits.

    Parameters
    ----------
    rows : list of lists
        Entries of one kind (see the module's head) or ``0``.

    Raises
    ------
    ValueError
        If these aren't rows of one length, if a row or column has no entry that tells
        its size, or if the sizes don't agree.

    Examples
    --------
    >>> block([[np.eye(2), 0], [0, np.ones((1, 1))]])
    array([[1., 0., 0.],
           [0., 1., 0.],
           [0., 0., 1.]])
    """
    lists = list, tuple
    if not isinstance(rows, lists) or not all(isinstance(r, lists) and r for r in rows):
        raise ValueError(
            f"block takes rows, as block([[P, Y.T], [Y, Q]]); got {rows!r}"
        )
    if len({len(r) for r in rows}) != 1:
        raise ValueError(
            f"the rows of a block have {[len(r) for r in rows]} entries: give each row "
            "as many, with 0 for a block of zeros"
        )
    if len(rows) == len(rows[0]) == 1 and not isinstance(rows[0][0], int):
        return rows[0][0] * 1  # an array of its own, of the same kind
    columns = zip(*rows, strict=True)
    heights, widths = [_common(r, 0) for r in rows], [_common(c, 1) for c in columns]
    bottoms, rights = list(accumulate(heights)), list(accumulate(widths))
    size = bottoms[-1], rights[-1]
    across = [slice(end - w, end) for end, w in zip(rights, widths)]
    entries = [  # (place, entry) each, without the zeros
        ((slice(end - h, end), place), x)
        for row, end, h in zip(rows, bottoms, heights)
        for x, place in zip(row, across)
        if not is_zero(x)
    ]
    kinds = {type(x) for _, x in entries}
    if traced := [kind for kind in kinds if issubclass(kind, Symbols)]:
        return traced[0].block(entries, size, heights, widths)
    if any(issubclass(kind, Affine) for kind in kinds):
        return _block_affine(entries, size)
    if any(issubclass(kind, Matrices) for kind in kinds):
        some = next(x for _, x in entries if isinstance(x, Matrices))
        return some.block(entries, size)
    if all(issubclass(kind, np.ndarray) for kind in kinds):
        return _assembled(entries, size)
    from ..runtime.libraries import library

    return library("cvxpy").bmat(
        [
            [np.zeros((h, w), int) if is_zero(x) else x for x, w in zip(row, widths)]
            for row, h in zip(rows, heights)
        ]
    )


def _common(entries, axis):
    """The size of a row's or a column's ``entries`` along an ``axis``."""
    for x in entries:
        if not isinstance(x, int) and not hasattr(x, "shape"):
            raise ValueError(
                f"the entries of a block are matrices or 0, got {x!r}: a number is "
                f"written {x!r} * eye(1)"
            )
    sizes = {x.shape[axis] for x in entries if not isinstance(x, int)}
    if not sizes:
        raise ValueError(
            f"block sizes don't fit: a {('row', 'column')[axis]} has zeros alone; "
            "write one of them as an array of zeros, which has a size"
        )
    if len(sizes) != 1:
        raise ValueError(
            f"block sizes {sorted(sizes)} don't fit: the entries of a "
            f"{('row', 'column')[axis]} need equally many {('rows', 'columns')[axis]}"
        )
    return sizes.pop()


def _assembled(entries, size):
    """As numpy.block, which looks at all the entries several times."""
    kinds = {x.dtype for _, x in entries}
    kind = kinds.pop() if len(kinds) == 1 else np.result_type(*kinds)
    several = max((x.shape[:-2] for _, x in entries), key=len)
    matrix = np.zeros((*several, *size), kind)
    for (down, right), x in entries:
        matrix[..., down, right] = x
    return matrix


def _block_affine(entries, size):
    written = (x for _, x in entries if isinstance(x, Affine))
    kind = max(written, key=lambda x: x.decimals)
    entries = [(place, kind._read(x)) for place, x in entries]
    constant = _assembled([(place, x.constant) for place, x in entries], size)
    terms = []
    for (down, right), x in entries:
        for t in x.terms:
            L = _pad(t.left, down.start, size[0])
            R = _pad(t.right.mT, right.start, size[1]).mT
            terms.append(Term(L, t.unknown, t.transposed, R))
    return kind._of(constant, terms)


def _pad(matrix, start, size):
    *several, rows, cols = matrix.shape
    padded = np.zeros((*several, size, cols), matrix.dtype)
    padded[..., start : start + rows, :] = matrix
    return padded
