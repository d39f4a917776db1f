"""Modes that only the last digits of a plant's numbers put within the inputs' reach."""

import numpy as np
from flint import acb, acb_mat, arb, ctx

from ..exact.algebraic import roots_of
from ..exact.definite import exact
from ..plants.controllability import matrix_of

__all__ = ["modes_by_rounding"]

LAST_DIGITS = 1e-13  # relative changes of numbers that are nobody's data
CLEARLY_REACHED = 1e-6  # a reach that floats are believed
BITS = 256


def modes_by_rounding(request):
    """Modes out of place that no input would move but for rounding errors.

    Parameters
    ----------
    request : Request
        Of one plant with a regular E; all that it asks is of poles.

    Returns
    -------
    list of complex
        The modes s with v A = s v E for which changing each number of B by its last
        digits, a part in 1e13, makes v B = 0: |v b| is that much less than |v| |b|
        for each column b. Other numbers are changed as well when a plant is turned
        or measured in other units, in floats; so whether such a mode can be moved,
        and by which gain, is no property of the plant. Units don't change v B's
        share of |v| |B|.

    Examples
    --------
    >>> from sosbook import PoleRegion, SecondOrderSystem
    >>> from sosbook.synthesis.problem import Request
    >>> def modes(b):
    ...     plant = SecondOrderSystem([[1, 0], [0, 1]], [[0, 0], [0, 0]],
    ...                               [[2, -1], [-1, 2]], [[1], [b]])
    ...     return modes_by_rounding(Request(plant, region=PoleRegion(sigma=1)))
    >>> modes(1 - 1e-9)
    []
    >>> [round(s.imag, 3) for s in modes(1 - 1e-15)]
    [1.732, -1.732]
    """
    (d,) = request.vertices_in(exact)
    if not d.Bu.shape[1] or _clearly_reached(request):
        return []
    inverse = matrix_of(d.E).inv()
    A = inverse * matrix_of(d.A)
    with ctx.workprec(BITS):
        poles, rows = acb_mat(A).eig(left=True, algorithm="approx")
        reach = _reach((rows * acb_mat(inverse)).table(), d.Bu)
        poles = np.array([complex(s.mid()) for s in poles])
    doubtful = poles[reach < LAST_DIGITS]
    if not len(doubtful):
        return []
    roots = roots_of(A.charpoly())
    places = np.array([complex(s) for s in roots])
    nearest = {int(np.abs(places - s).argmin()) for s in doubtful}
    return [
        complex(places[k])
        for k in sorted(nearest)
        if not all(r.holds_at(roots[k]) for r in request.demands)
    ]


def _clearly_reached(request):
    """Whether floats see that each mode is within reach."""
    (d,) = request.vertices
    inverse = np.linalg.inv(d.E)
    _, columns = np.linalg.eig((inverse @ d.A).T)
    rows = columns.T @ inverse
    with np.errstate(all="ignore"):
        reach = np.abs(rows @ d.Bu) / (np.abs(rows) @ np.abs(d.Bu))
    return (np.nan_to_num(reach).max(axis=1) > CLEARLY_REACHED).all()


def _reach(rows, B):
    """For each row v the largest |v b| / (|v| |b|) of the columns b of B."""
    columns = [[arb(e) for e in column] for column in B.T]
    shares = []
    for v in rows:
        sizes = [abs(e) for e in v]
        share = 0.0
        for b in columns:
            whole = sum((x * abs(y) for x, y in zip(sizes, b)), arb(0)).mid()
            if whole > 0:
                moved = abs(sum((x * y for x, y in zip(v, b)), acb(0)))
                share = max(share, float(moved.mid() / whole))
        shares.append(share)
    return np.array(shares)
