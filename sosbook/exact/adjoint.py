"""Derivatives of <G, Z> by the unknowns of G, in exact arithmetic."""

import numpy as np
from flint import arb, arb_mat, fmpq, fmpq_mat, fmpz, fmpz_mat

from ..runtime.time_limit import check_time

FLOAT = "a float is no exact number: read it by `exact`"


def adjoint(expressions, unknowns, Z):
    """sum_k <G_ka, Z_k> for each variable a of the ``unknowns``: rationals, or balls.

    ``expressions`` G_k have arrays of rationals, integers or balls; a TypeError if of
    floats. A term L X R contributes L' Z R' to the derivative by X. The sums are of
    integers, with one denominator as long as those of the terms divide it.

    >>> from sosbook.exact.definite import exact
    >>> from sosbook.language.expression import Unknown, he
    >>> A, P = exact(np.array([[0, 1], [-2, -0.3]])), Unknown("P", 2, symmetric=True)
    >>> adjoint([he(A @ P)], [P], [exact(np.eye(2))])
    array([0, -2, -3/5], dtype=object)
    """
    try:
        products = [_integers(t, z) for t, z in _terms(expressions, Z, _cleared)]
    except TypeError:  # a ball
        return _in_balls(expressions, unknowns, Z)
    return _packed(products, unknowns, _sum_of_rationals)


def _in_balls(expressions, unknowns, Z):
    """The result of `adjoint`, in balls."""
    check_time()
    products = [
        (t, _arb_mat(t.left).transpose() * z * _arb_mat(t.right).transpose(), None)
        for t, z in _terms(expressions, Z, _arb_mat)
    ]
    return _packed(products, unknowns, _sum_of_balls)


def _terms(expressions, Z, convert):
    """(term, converted Z) of all terms."""
    pairs = [(g, convert(z)) for g, z in zip(expressions, Z)]
    return [(t, z) for g, z in pairs for t in g.terms]


def _cleared(x):
    """(integers, denominator); TypeError unless x has rationals or integers."""
    return fmpq_mat(*x.shape, x.ravel().tolist()).numer_denom()


def _integers(t, z):
    """(term, L' Z R' without its denominator, denominator)."""
    check_time()
    (left, l), (z, d), (right, r) = _cleared(t.left), z, _cleared(t.right)
    return t, left.transpose() * z * right.transpose(), l * d * r


def _arb_mat(x):
    if x.dtype.kind == "f":
        raise TypeError(FLOAT)
    return arb_mat(*x.shape, [arb(e) for e in x.ravel().tolist()])


def _packed(products, unknowns, total):
    """The sums of (term, product, denominator), as the unknowns' free entries."""
    packed, by_unknown = [], {id(u): [] for u in unknowns}
    for t, product, denominator in products:
        if id(t.unknown) in by_unknown:
            product = product.transpose() if t.transposed else product
            by_unknown[id(t.unknown)].append((product, denominator))
    for u in unknowns:
        entries = np.empty(u.shape, object)
        entries.flat = total(u.shape, by_unknown[id(u)]).entries()
        packed.append(u.gradient(entries))
    return np.concatenate(packed)


def _sum_of_balls(shape, products):
    total = arb_mat(*shape)
    for product, _ in products:
        total += product
    return total


def _sum_of_rationals(shape, products):
    """The sum of products over denominators, which cancel where vertices end."""
    total, common = fmpz_mat(*shape), fmpz(1)
    for product, denominator in products:
        if common % denominator != 0:
            total, common = (fmpq_mat(total) * fmpq(1, common)).numer_denom()
            more = common.lcm(denominator)
            total, common = total * (more // common), more
        total += product * (common // denominator)
    return fmpq_mat(total) * fmpq(1, common)


def slopes_at(g, unknowns, entries):
    """The derivatives of <g, Z> by ``unknowns``, for each of the ``entries`` (i, j).

    Z is one at i, j and at j, i alone. Returns (entries, variables): most numbers of
    the factors are zeros, which are left out where they are exact.
    """
    places, count = {}, 0
    for u in unknowns:
        places[id(u)] = u.unpack(np.arange(count, count + u.size))
        count += u.size
    terms = [
        (
            _nonzero(t.left),
            _nonzero(t.right.T),
            (places[u].T if t.transposed else places[u]).tolist(),
        )
        for t in g.terms
        if (u := id(t.unknown)) in places
    ]
    slopes = np.full((len(entries), count), 0, object)
    for slope, (i, j) in zip(slopes, entries):
        check_time()
        for left, right, place in terms:
            for row, column in {(i, j), (j, i)}:
                for p, x in left[row]:
                    for q, y in right[column]:
                        slope[place[p][q]] += x * y
    return slopes


def _nonzero(x):
    """(index, entry) of each row, without exact zeros; a TypeError if of floats.

    A ball around zero may be zero, so it is neither == 0 nor != 0.
    """
    if x.dtype.kind == "f":
        raise TypeError(FLOAT)
    return [
        [(k, e) for k, e in enumerate(row) if not e == 0]  # noqa: SIM201
        for row in x.tolist()
    ]
