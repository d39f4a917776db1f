"""What the writers of Rocq's files share: integer matrices, witnesses, literals."""

from fractions import Fraction
from math import isqrt, lcm

#: Bits of the factors L; a block that none of these shows is near the boundary.
BITS = (24, 32, 48, 64, 96, 128, 192, 256, 384, 512)


class Refused(Exception):
    """The file isn't covered; the text says why."""


class Failed(Exception):
    """Nothing was found that shows what the file says."""


def denominator(*matrices):
    return lcm(*(Fraction(a).denominator for x in matrices for r in x for a in r))


def times(d, matrix):
    return [[int(d * Fraction(a)) for a in row] for row in matrix]


def integers(*matrices):
    d = denominator(*matrices)
    return (d, *(times(d, x) for x in matrices))


def zeros(rows, columns):
    return [[0] * columns for _ in range(rows)]


def plus(a, b):
    return [[x + y for x, y in zip(r, s)] for r, s in zip(a, b)]


def transposed(a):
    return [list(r) for r in zip(*a)]


def product(a, b):
    columns = transposed(b)
    return [[sum(x * y for x, y in zip(r, c)) for c in columns] for r in a]


def witness(G):
    """u, t, L: the diagonal of u G - t L L' exceeds the rest of its row; or None."""
    top = max((row[i] for i, row in enumerate(G)), default=0).bit_length()
    for bits in BITS:
        up, down = max(0, 2 * bits - top), max(0, top - 2 * bits) // 2
        uG = [[a << up for a in row] for row in G]
        L = factor(uG, down, bits // 2)
        if L and dominant(less(uG, L, 2 * down)):
            return 1 << up, 1 << 2 * down, L
    return None


def less(G, L, shift):
    """G - 2^shift L L'"""
    return [
        [a - (sum(x * y for x, y in zip(r, s)) << shift) for a, s in zip(row, L)]
        for r, row in zip(L, G)
    ]


def factor(G, h, gap):
    """L up to the diagonal: L L' is near G / 4^h less 2^-gap of its diagonal."""
    L = []
    for i, row in enumerate(G):
        new = []
        for j in range(i + 1):
            a = row[j] - (row[j] >> gap if i == j else 0)
            rest = (a >> 2 * h) - sum(
                x * y for x, y in zip(new, L[j] if j < i else new)
            )
            if i == j and rest <= 0:
                return None
            new.append(isqrt(rest) if i == j else rest // L[j][j])
            if i == j and not new[-1]:
                return None
        L.append(new)
    return L


def dominant(R):
    return all(2 * row[i] > sum(map(abs, row)) for i, row in enumerate(R))


# ---- As Rocq reads it


def literal(matrix):
    """A list of lists, with the digits of the file."""
    rows = (
        "[:: " + "; ".join(map(digits, row)) + "]" if row else "[::]" for row in matrix
    )
    return "[:: " + ";\n  ".join(rows) + "]" if matrix else "[::]"


def digits(x):
    return "({} # {})".format(*x.split("/")) if "/" in str(x) else str(x)


def constant(name, kind, text):
    return f"Definition {name} : {kind} := {text}.\n"


def triple(witness):
    u, t, L = witness
    return f"({u}, {t}, {literal(L)})"


def ratio(x):
    return "({} # {})%Q".format(*Fraction(x).as_integer_ratio())


def rationals(x):
    return literal([[ratio(Fraction(a, x.d)) for a in row] for row in x.a])
