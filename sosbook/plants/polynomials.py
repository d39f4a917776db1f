"""Matrices of polynomials in parameters, and their entries as text."""

import re
from dataclasses import dataclass
from fractions import Fraction
from math import prod

import numpy as np
from flint import fmpq

from ..exact.rational import Rational, rational_matrix
from ..runtime.reading import MOST_DIGITS
from .bernstein import Box, rational, spelled
from .checks import rank_deficient

DIGITS = rf"[0-9]{{1,{MOST_DIGITS}}}"
NUMBER = rf"(?:{DIGITS}/{DIGITS}|{DIGITS}(?:[.]{DIGITS})?(?:e[-+]?[0-9]{{1,3}})?)"
FACTOR = rf"(?:{NUMBER}|[A-Za-z_][A-Za-z0-9_]*(?:\^[0-9]{{1,2}})?)"
TERM = re.compile(rf"([-+]?)({FACTOR}(?:\*{FACTOR})*)")


@dataclass(frozen=True)
class Polynomials:
    """A matrix of this ``shape``: ``coefficients`` (monomials, places) of
    ``monomials``, exponents with the constant's, at the ``places`` that aren't zero.
    """

    shape: tuple
    monomials: tuple
    places: list
    coefficients: Rational

    @classmethod
    def of(cls, shape, entries, count):
        """Of a shape; ``entries`` are coefficients by exponents, ``count`` each."""
        places = [k for k, terms in enumerate(entries) if terms]
        monomials = dict.fromkeys(m for k in places for m in entries[k])
        monomials = tuple(monomials) or ((0,) * count,)
        rows = [[entries[k].get(m, fmpq(0)) for k in places] for m in monomials]
        return cls(shape, monomials, places, rational_matrix(rows))

    def mixed(self, weights):
        """The matrices with some weights of the monomials, one matrix a row."""
        weights = rational_matrix(weights)
        mixed = np.full((len(weights), prod(self.shape)), fmpq(0), dtype=object)
        if self.places:
            mixed[:, self.places] = weights @ self.coefficients
        return mixed.reshape(len(weights), *self.shape).view(Rational)

    def coefficient(self, monomial):
        """The matrix that the exponents of a ``monomial`` have as their coefficient."""
        return self.mixed([[fmpq(m == monomial) for m in self.monomials]])[0]

    def at(self, box, point):
        """The matrix at a point, in the order of the names of a ``box``."""
        return self.mixed([box.powers(point, self.monomials)])[0]

    def vertices(self, box, degrees, pieces=None):
        """Bernstein coefficients, of ``degrees`` and ``pieces`` on a ``box``."""
        return self.mixed(box.bernstein(self.monomials, degrees, pieces))

    def words(self, names):
        """The entries as text, rows of a list, with the names of parameters."""
        entries = np.full(self.shape, "0", dtype=object)
        for k, column in zip(self.places, self.coefficients.T):
            terms = {m: c for m, c in zip(self.monomials, column) if c}
            entries.flat[k] = in_words(terms, names)
        return entries.tolist()


def in_words(terms, names):
    """A polynomial of coefficients by exponents, ``terms``, as text with ``names``.

    >>> in_words({(2, 0): fmpq(2), (1, 1): fmpq(-1, 2), (0, 0): fmpq(1)}, "mk")
    '2*m^2 - 0.5*m*k + 1'
    """
    said = []
    for powers, c in sorted(terms.items(), reverse=True):
        there = [(name, e) for name, e in zip(names, powers) if e]
        factors = [name if e == 1 else f"{name}^{e}" for name, e in there]
        if abs(c) != 1 or not factors:
            factors.insert(0, spelled(abs(c)))
        sign = ("-" if c < 0 else "+") if said or c < 0 else ""
        said.append(f" {sign} " if said else sign)
        said.append("*".join(factors))
    return "".join(said) or "0"


def read_words(text, names):
    """The coefficients by exponents of a ``text`` that `in_words` might write: numbers
    and ``names`` between ``+``, ``-``, ``*``, and whole powers behind ``^``; no
    brackets. A ValueError says where it ends to be a polynomial.

    >>> read_words("2*m^2 - 1/2*k*m + 1e-1", ("m", "k"))
    {(2, 0): 2, (1, 1): -1/2, (0, 0): 1/10}
    """
    rest, terms = text.replace(" ", ""), {}
    while rest or not terms:
        term = TERM.match(rest)
        if not term or (terms and not term[1]):
            raise ValueError(
                f"{text!r:.60} isn't a polynomial at {rest!r:.20}: write sums of "
                "products, as in 2*m^2 - 0.5*m*k"
            )
        c, powers = fmpq(-1 if term[1] == "-" else 1), dict.fromkeys(names, 0)
        for factor in term[2].split("*"):
            name, _, power = factor.partition("^")
            if name in powers:
                powers[name] += int(power or 1)
            elif name[0].isdigit():
                try:
                    c *= rational("", Fraction(factor))
                except ZeroDivisionError:
                    raise ValueError(f"{text!r:.60} divides by zero") from None
            else:
                raise ValueError(f"{name} in {text!r:.60} has no range")
        place = tuple(powers.values())
        terms[place] = terms.get(place, fmpq(0)) + c
        rest = rest[term.end() :]
    return {place: c for place, c in terms.items() if c}


def read_entries(rows, names):
    """The coefficients of numbers or words in ``rows``; ``names`` are parameters."""

    def read(entry):
        if isinstance(entry, str):
            return read_words(entry, names)
        value = rational("an entry", entry)
        return {(0,) * len(names): value} if value else {}

    return [[*map(read, row)] for row in rows]


def read_ranges(given):
    """The `Box` of ranges ``given`` in a file, and how often some are cut, by name."""

    def end(x):  # a number, or a text that spells one
        return sum(read_words(x, ()).values()) if isinstance(x, str) else x

    box = Box.of(**{name: [*map(end, x)] for name, *x in (x[:3] for x in given)})
    if len(box.names) < len(given):
        raise ValueError("two parameters have one name")
    return box, {name: cells for name, _, _, cells in (x for x in given if len(x) > 3)}


MOST_CELLS = 64  # boxes that are looked at


def check_regular(name, part, box, degrees):
    """Raise where the matrix ``part`` of this ``name`` is singular for some parameters
    only.

    Around a regular E_0 all E with He(E_0^-1 E) > 0 are regular, and these are convex:
    the ``box`` is halved until the vertices, of Bernstein's form of ``degrees``, have
    it. What isn't decided in so many boxes passes: no LMI with a singular E has a
    solution.
    """
    boxes, signs, last = [box], set(), box.inner
    for _ in range(MOST_CELLS):
        if not boxes:
            return
        box = boxes.pop()
        for point in (box.inner, box.middle, *box.corners()):
            E = part.at(box, point).astype(float)
            sign = 0.0 if rank_deficient(E, 1e-14) else np.linalg.slogdet(E)[0]
            if sign == 0 and not signs:  # at no special point: everywhere
                return
            signs.add(sign)
            if len(signs) > 1:
                where = f"at or beside {_words(box, point)}"
                if sign:
                    where = f"between {_words(box, last)} and {_words(box, point)}"
                raise ValueError(f"{name} is singular {where}: narrow the ranges")
            last = point
        middle = part.at(box, box.middle).astype(float)
        near = np.linalg.solve(middle, part.vertices(box, degrees).astype(float))
        least = np.linalg.eigvalsh(near + near.swapaxes(-1, -2))[:, 0]
        if (least <= 1e-9).any():
            boxes += box.halves(box.widest())


def _words(box, point):
    """The values of the parameters at a point."""
    return ", ".join(f"{k} = {spelled(x)}" for k, x in zip(box.names, point))
