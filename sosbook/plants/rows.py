"""The rows of a family's equations: which multiples and sums of them are taken."""

from math import prod

import numpy as np
from flint import fmpq

from ..exact.rational import null_basis, rational_matrix
from .parametric import Parametric

MOST_STEPS = 1000  # of one row less a multiple of another


def canonical(matrices, names):
    """Bring the rows of some ``matrices`` (object arrays of `Parametric` by name, those
    of ``names`` have the equations) into one form, in place, which changes no motion.
    Each row is multiplied by its denominators and divided by what it has in common.
    Then rows less multiples of others take their places, see `_combined`, where that
    makes no more of Bernstein's vertices. Returns T, (n, n), of `Parametric`: what is
    left is T times what was given.
    """
    there = [matrices[name] for name in names if name in matrices]
    ends = np.cumsum([x.shape[1] for x in there])
    units = np.eye(len(there[0]), dtype=int) + 0 * there[0][0, 0]
    whole = np.hstack([*there, units])
    wide, count = ends[-1], len(whole[0, 0].box.names)
    plain = _divided(whole, wide)
    several = [_combined(plain, wide, first) for first in range(count)]
    several = [x for x in several if x is not None] + [plain]
    best = min(several, key=lambda x: _vertices(x[:, :wide]))
    *parts, T = np.split(best, ends, axis=1)
    for matrix, part in zip(there, parts):
        matrix[:] = part
    return T


def _vertices(whole):
    """How many vertices Bernstein's form of these polynomials has."""
    several = [e for x in whole.flat for e in x.num.to_dict()]
    return prod(int(d) + 1 for d in np.max(several, axis=0))


def _divided(whole, wide):
    """The rows, each multiplied by the denominators of its first columns, so many, and
    divided by what these have in common.
    """
    rows = []
    for row in whole:
        factor = _cleared(row[:wide]) / _common(row[:wide])
        number = factor.num.is_constant() and factor.den.is_constant()
        rows.append(row if number else row * factor)
    return np.array(rows)


def _cleared(entries):
    """The least common denominator, positive on the box."""
    den = entries[0].den
    for x in entries:
        den = den * (x.den / den.gcd(x.den))
    return abs(Parametric(den, den * 0 + 1, entries[0].box))


def _common(entries):
    """The common factor of all numerators, positive on the box; else one."""
    common = entries[0].num * 0
    for x in entries:
        common = common.gcd(x.num)
    one, box = common * 0 + 1, entries[0].box
    whole = Parametric(common, one, box)
    if common.is_constant() or not whole.never_zero:
        whole = Parametric(one, one, box)
    return abs(whole)


def _combined(whole, wide, first):
    """The rows after each term of their first columns, so many, went that a multiple of
    another row's leading term can take away; the leading one has the highest degree,
    and then the highest power of the parameter ``first`` and those behind it. With one
    parameter this is Popov's form, which depends on no multiples of rows that were
    added to others. None where numbers are all that rows are multiplied by: sums like
    that change no hull.
    """
    one, changed = whole[0, 0] * 0 + 1, False
    constant = (0,) * len(one.box.names)
    rows = [_terms(row[:wide]) for row in whole]
    for i, row in enumerate(rows):  # beside it R, which makes them of the first
        row[constant, wide + i] = fmpq(1)
    for _ in range(MOST_STEPS):
        step = _step(rows, wide, first) or _hidden(rows, wide, one.box)
        if step is None:
            break
        i, addends = step
        changed = changed or any(any(powers) for _, powers, _ in addends)
        total = {}
        for j, powers, c in addends:
            for (e, k), x in rows[j].items():
                place = tuple(map(sum, zip(e, powers))), k
                total[place] = total.get(place, 0) + c * x
        rows[i] = {place: x for place, x in total.items() if x}
    if not changed:
        return None
    R = [[_entry(row, wide + j, one) for j in range(len(rows))] for row in rows]
    combined = np.array(R) @ whole
    divided = _divided(combined, wide)
    if (divided == combined).all():
        return combined
    again = _combined(divided, wide, first)
    return divided if again is None else again


def _terms(row):
    """The coefficients of a row's polynomials by exponents and column."""
    return {(e, k): c for k, x in enumerate(row) for e, c in x.num.to_dict().items()}


def _entry(row, column, one):
    """The entry of a row in this column; exponents may be negative."""
    terms = [(e, c) for (e, k), c in row.items() if k == column]
    gens = one.num.context().gens()
    gens = [Parametric(g, one.den, one.box) for g in gens]
    total = 0 * one
    for e, c in terms:
        total = total + prod((g**a for g, a in zip(gens, e) if a), start=c * one)
    return total


def _step(rows, wide, first):
    """The next step of `_combined`: (i, [(j, exponents, number), ...]), row i becomes
    the sum of the rows j times these; or None.
    """

    def order(place):
        e, k = place
        return sum(e), e[first:] + e[:first], -k

    inside = [sorted((t for t in row if t[1] < wide), key=order) for row in rows]
    if not all(inside):  # a row is zero: no plant
        return None
    leading = {}
    for j, row in enumerate(inside):
        e, k = row[-1]
        leading.setdefault(k, []).append((j, e))
    for i, row in enumerate(inside):
        for e, k in reversed(row):
            for j, other in leading.get(k, ()):
                powers = [a - b for a, b in zip(e, other)]
                if j != i and min(powers) >= 0:
                    c = rows[i][e, k] / rows[j][other, k]
                    return i, [(i, (0,) * len(e), fmpq(1)), (j, powers, -c)]
    return None


def _hidden(rows, wide, box):
    """The same where a sum of rows can be divided by a parameter."""
    for k, (low, high) in enumerate(zip(box.low, box.high)):
        if low <= 0 <= high:
            continue
        left = [{t for t in row if t[1] < wide and not t[0][k]} for row in rows]
        places = sorted(set().union(*left)) or [()]
        table = [[row.get(t, fmpq(0)) for row in rows] for t in places]
        basis = null_basis(rational_matrix(table))
        if basis.shape[1]:
            powers = [-int(j == k) for j in range(len(box.names))]
            some = [(j, powers, c) for j, c in enumerate(basis[:, 0]) if c]
            i = max(some, key=lambda x: max(sum(e) for e, c in rows[x[0]] if c < wide))
            return i[0], some
    return None


def told(T):
    """Words for each row that `canonical` changed by ``T``, by its number."""
    said = {}
    for i, row in enumerate(T):
        words, own = [], row[i]
        if own.num.is_one() and not own.den.is_one():
            words.append(f"divided by {own.words(own.den)}")
        elif not (own.num.is_constant() and own.den.is_one()):
            words.append(f"multiplied by {own}")
        others = [(j, x) for j, x in enumerate(row) if j != i and not x.num.is_zero()]
        words += [f"given {x} times row {j + 1}" for j, x in others]
        if words:
            said[i + 1] = " and ".join(words)
    return said
