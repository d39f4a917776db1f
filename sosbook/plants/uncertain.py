"""Plants with parameters in ranges, and the polytopes around them."""

from collections.abc import Callable
from functools import cached_property
from math import prod
from typing import Any

import numpy as np
from flint import fmpq

from ..exact.rational import Rational, exact, rational_matrix
from .bernstein import Box, in_words, spelled
from .builder import built, check_by_numbers, rows_in_canonical_form
from .checks import as_written, rank_deficient
from .checks import count as whole
from .descriptor import keep_rationals
from .descriptor_system import DescriptorSystem
from .parametric import ParameterError
from .second_order import Polytope, SecondOrderSystem

__all__ = ["Uncertain"]

MOST_VERTICES = 256  # 256 of them are 32,896 pairs
MOST_CELLS = 64  # boxes in which a singular E is looked for
ROWS = {SecondOrderSystem: tuple("MDSBF"), DescriptorSystem: ("E", "A", "B", "B_w")}


class Uncertain:
    r"""A plant with parameters of which ranges are known.

    Parameters
    ----------
    builder : callable
        Takes the parameters by name and returns a `SecondOrderSystem` or a
        `DescriptorSystem`. Any code will do that is rational in them: sums,
        products, quotients, numpy, loops. It is called once with expressions, and
        three times with numbers to check it.
    **ranges : pairs of numbers
        ``name=(low, high)``. Floats are read as decimals.

    Raises
    ------
    ValueError
        If a range is empty, the plant doesn't depend on a parameter, or the mass
        is singular for some of its values.
    ParameterError
        A ValueError: where the code isn't rational in a parameter, such as
        ``np.sin(q)``, or decides differently within the ranges. The text names
        the parameter, quotes the line and says what to write instead.

    Notes
    -----
    Each row of the equations is multiplied by its denominators and divided by what
    it has in common, which changes no motion. Then the matrices are polynomials,
    and the plants lie in the polytope of their Bernstein coefficients. These are
    the corners, and exact, where no parameter has a power above one. `vertices` of
    higher powers needn't be plants of the family; they come nearer when the box is
    halved.

    The design functions take it as a plant, and what they prove is proven for all
    values of the parameters.

    Examples
    --------
    >>> import sosbook as sos
    >>> def drive(J2, k):
    ...     return sos.SecondOrderSystem(
    ...         M=[[0.0025, 0], [0, J2]], D=[[0.004, -0.004], [-0.004, 0.004]],
    ...         S=[[k, -k], [-k, k]], B=[[1], [0]])
    >>> plants = Uncertain(drive, J2=(0.003, 0.006), k=(1.7, 2.1))
    >>> plants  # doctest: +NORMALIZE_WHITESPACE
    <Uncertain SecondOrderSystem: J2 in [0.003, 0.006] and k in [1.7, 2.1]; 4 vertices,
    the corners>
    >>> plants.at(J2=0.004, k=2).M
    array([[0.0025, 0.    ],
           [0.    , 0.004 ]])
    """

    def __init__(self, builder: Callable[..., Any], /, **ranges: Any) -> None:
        box = Box.of(**ranges)
        kind, matrices, rest = built(builder, box)
        factors = rows_in_canonical_form(matrices, ROWS[kind])
        for name, matrix in matrices.items():
            for x in matrix.flat:
                if not x.den.is_one():
                    raise ParameterError(
                        f"{name} has the denominator {x.words(x.den)}, and no equation "
                        "to multiply by it: give the quotient a range of its own"
                    )
        parts = {
            name: _part(matrix.shape, [x.num.to_dict() for x in matrix.flat], box)
            for name, matrix in matrices.items()
        }
        self._fill(kind, box, parts, rest)
        #: By the row, from 1, what it was multiplied or divided by, in words.
        self.rows = {i + 1: _told(factor) for i, factor in factors.items()}

        def as_the_builder_has_them(point):
            scales = {i: f.at(point) for i, f in factors.items()}
            found = self._at(point)
            for name in found.keys() & set(ROWS[kind]):
                for i, scale in scales.items():
                    found[name][i] = found[name][i] / scale
            return {name: matrix.astype(float) for name, matrix in found.items()}

        if kind is DescriptorSystem:  # of a mass K_A may decide
            self.check_regular()
        check_by_numbers(builder, box, as_the_builder_has_them)

    def _fill(self, kind, box, parts, rest):
        self.kind, self.box, self._parts, self._rest = kind, box, parts, rest
        self.rows = {}
        used = np.max([m for part in parts.values() for m in part[1]], axis=0)
        idle = [name for name, d in zip(box.names, used) if not d]
        if idle:
            raise ValueError(f"the plant doesn't depend on {', '.join(idle)}")
        #: The highest power of each parameter, by name.
        self.degree = dict(zip(box.names, used.tolist()))

    def _with(self, box):
        """The same plants with other ranges."""
        other = object.__new__(Uncertain)
        other._fill(self.kind, box, self._parts, self._rest)
        other.rows = self.rows
        return other

    @property
    def multi_affine(self) -> bool:
        """Whether no parameter has a power above one: the vertices are the corners."""
        return max(self.degree.values()) == 1

    def __repr__(self):
        count = prod(d + 1 for d in self.degree.values())
        how = "the corners"
        if not self.multi_affine:
            powers = ", ".join(f"{d} in {k}" for k, d in self.degree.items())
            how = f"of Bernstein's form of degree {powers}"
        rows = "".join(f"; row {i} was {words}" for i, words in self.rows.items())
        return (
            f"<Uncertain {self.kind.__name__}: {self.box}; {count} vertices, {how}"
            f"{rows}>"
        )

    def __eq__(self, other):
        if not isinstance(other, Uncertain):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self):
        return hash(self.box)

    def _key(self):
        return self.kind, self.box, self.texts()

    def texts(self):
        """The matrices by name, their entries polynomials in words."""
        found = {}
        for name, (shape, monomials, places, coefficients) in self._parts.items():
            entries = np.full(shape, "0", dtype=object)
            for k, column in zip(places, coefficients.T):
                terms = {m: c for m, c in zip(monomials, column) if c}
                entries.flat[k] = in_words(terms, self.box.names)
            found[name] = entries.tolist()
        return found

    def _at(self, point):
        """The matrices at a point of rationals, by name, in rationals."""
        return {
            name: _filled(part, [self.box.powers(point, part[1])])[0]
            for name, part in self._parts.items()
        }

    def at(self, /, **values: Any) -> Any:
        """The plant with some values of the parameters.

        Parameters
        ----------
        **values : numbers
            One of each parameter, by name, inside its range.

        Returns
        -------
        SecondOrderSystem or DescriptorSystem
            Its rows are multiplied as those of all others of the family.
        """
        return self._plant(self._at(self.box.point(values)))

    @property
    def nominal(self) -> Any:
        """The plant in the middle of all ranges."""
        return self._plant(self._at(self.box.middle))

    def sample(self, count: int, seed: int) -> list:
        """Random plants, uniform over the ranges.

        Parameters
        ----------
        count : int
            How many.
        seed : int
            The seed of numpy's generator: the same seed gives the same plants.
        """
        rng = np.random.default_rng(whole("seed", seed))
        shares = rng.random((whole("count", count), len(self.box.names))).round(9)
        ends = list(zip(self.box.low, self.box.high))
        points = [
            [a + (b - a) * s for (a, b), s in zip(ends, r)] for r in exact(shares)
        ]
        return [self._plant(self._at(point)) for point in points]

    @cached_property
    def vertices(self) -> tuple:
        """Plants whose hull holds all of the family: see the notes.

        The last parameter changes first.
        """
        degrees = tuple(self.degree.values())
        count = prod(d + 1 for d in degrees)
        if count > MOST_VERTICES:
            name, degree = max(self.degree.items(), key=lambda item: item[1])
            raise ValueError(
                f"the family has {count} vertices, more than {MOST_VERTICES}: fix the "
                "parameters that matter least"
                + (f"; {name} costs most, by its power {degree}" if degree > 1 else "")
            )
        parts = {
            name: _filled(part, self.box.bernstein(part[1], degrees))
            for name, part in self._parts.items()
        }
        return tuple(
            self._plant({name: stack[k] for name, stack in parts.items()})
            for k in range(count)
        )

    def _plant(self, matrices):
        """A plant of rationals, which stay with the floats next to them."""
        with as_written():  # a vertex needn't be a plant of the family
            plant = self.kind(
                **{name: x.astype(float) for name, x in matrices.items()}, **self._rest
            )
        keep_rationals(plant.vertices[0], matrices)
        return plant

    def halves(self, name: str | None = None) -> "tuple[Uncertain, Uncertain]":
        """The two families with one half of a range each.

        Parameters
        ----------
        name : str, optional
            The parameter; the one whose range is widest for its size without it.
        """
        if name is None:
            wide = {
                k: (b - a) / max(abs(a), abs(b))
                for k, a, b in zip(self.box.names, self.box.low, self.box.high)
            }
            name = max(wide, key=wide.__getitem__)
        first, second = self.box.halves(name)
        return self._with(first), self._with(second)

    def polytope(self) -> Any:
        """The polytope of the vertices.

        Returns
        -------
        Polytope or DescriptorSystem
            With this family as its ``family``: what is proven of it is said of the
            parameters.
        """
        several = [v.vertices[0] for v in self.vertices]
        one = self.kind is SecondOrderSystem
        plants = Polytope(several) if one else DescriptorSystem.of(several)
        object.__setattr__(plants, "family", self)
        return plants

    def check_regular(self) -> None:
        """Raise where E, or the mass, is singular for some of the values only.

        Around a regular E_0 all E with He(E_0^-1 E) > 0 are regular, and these are
        convex: the box is halved until the vertices have it. This is for a clear
        word in good time; no LMI with a singular E has a solution. One that isn't
        decided in so many halvings, or is singular everywhere, passes.
        """
        part = self._parts["M" if self.kind is SecondOrderSystem else "E"]
        families, signs = [self], set()
        for _ in range(MOST_CELLS):
            if not families:
                return
            family = families.pop()
            box = family.box
            for point in (box.inner, box.middle, *box.corners()):
                E = _filled(part, [box.powers(point, part[1])])[0].astype(float)
                sign = 0.0 if rank_deficient(E, 1e-14) else np.linalg.slogdet(E)[0]
                if sign == 0 and not signs:  # at no special point: everywhere
                    return
                signs.add(sign)
                if len(signs) > 1:
                    where = ", ".join(
                        f"{k} = {spelled(x)}" for k, x in zip(box.names, point)
                    )
                    raise ValueError(
                        f"{'M' if 'M' in self._parts else 'E'} is singular at or "
                        f"beside {where}: narrow the ranges"
                    )
            stack = _filled(part, box.bernstein(part[1], tuple(self.degree.values())))
            middle = _filled(part, [box.powers(box.middle, part[1])])[0]
            near = np.linalg.solve(middle.astype(float), stack.astype(float))
            least = np.linalg.eigvalsh(near + near.swapaxes(-1, -2))[:, 0]
            if (least <= 1e-9).any():
                families += family.halves()


def _told(factor):
    """What was done to a row."""
    if factor.num.is_one():
        return f"divided by {factor.words(factor.den)}"
    return f"multiplied by {factor}"


def _part(shape, entries, box):
    """A matrix of polynomials: its shape, monomials, places and their coefficients.

    ``entries`` are dicts from exponents to coefficients, one of each place.
    """
    places = [k for k, terms in enumerate(entries) if terms]
    constant = (0,) * len(box.names)
    monomials = tuple(dict.fromkeys(m for k in places for m in entries[k])) or (
        constant,
    )
    rows = [[entries[k].get(m, fmpq(0)) for k in places] for m in monomials]
    return shape, monomials, places, rational_matrix(rows)


def _filled(part, weights):
    """The matrices of a part with so many weights of its monomials, one a row."""
    shape, _, places, coefficients = part
    weights = rational_matrix(weights)
    filled = np.full((len(weights), prod(shape)), fmpq(0), dtype=object)
    if places:
        filled[:, places] = weights @ coefficients
    return filled.reshape(len(weights), *shape).view(Rational)
