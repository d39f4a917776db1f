"""Plants with parameters in ranges, and the polytopes around them."""

from collections.abc import Callable
from functools import cached_property
from math import prod
from typing import Any

import numpy as np

from ..exact.definite import inverse
from ..exact.rational import exact, rational_matrix
from .bernstein import NO_RANGES, Box, corners_hold, spelled
from .checks import as_written, checked_names
from .checks import count as whole
from .descriptor_system import DescriptorSystem, keep
from .parametric import ParameterError, made_of
from .polynomials import Polynomials, check_regular, read_entries, read_ranges
from .second_order import Polytope, SecondOrderSystem

MOST_VERTICES = 256  # 256 of them are 32,896 pairs
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
    Rows are multiplied by their denominators and divided by what they have in common;
    then multiples of rows, by polynomials, are taken from others where terms of high
    degree go away. That changes no motion, and ``repr(family)`` says it. The plants
    lie in the polytope of the Bernstein coefficients: the corners, exactly, where no
    parameter has a power above one. `vertices` of higher powers needn't be plants of
    the family; they come nearer when the box is halved.

    The design functions take it as a plant, and what they prove is proven for all
    values of the parameters.

    Examples
    --------
    >>> import sosbook as sos
    >>> def drive(J2, k):
    ...     return sos.SecondOrderSystem(
    ...         M=[[0.0025, 0], [0, J2]],
    ...         D=[[0.004, -0.004], [-0.004, 0.004]],
    ...         S=[[k, -k], [-k, k]], B=[[1], [0]])
    >>> plants = Uncertain(drive, J2=(0.003, 0.006), k=(1.7, 2.1))
    >>> plants  # doctest: +NORMALIZE_WHITESPACE
    <Uncertain SecondOrderSystem: J2 in [0.003, 0.006] and k in [1.7, 2.1];
    4 vertices, the corners>
    >>> plants.at(J2=0.004, k=2).M
    array([[0.0025, 0.    ],
           [0.    , 0.004 ]])
    """

    schedule: tuple = ()  # measured parameters, with inputs for each of their corners

    def __init__(self, builder: Callable[..., Any], /, **ranges: Any) -> None:
        from .builder import built, check_by_numbers

        box = Box.of(**ranges)
        kind, matrices, rest = built(builder, box)
        T = self._in_canonical_form(kind, box, matrices, rest)

        def as_the_builder_has_them(point):
            found = self._at(point)
            back = inverse(rational_matrix([[x.at(point) for x in row] for row in T]))
            found |= {n: back @ found[n] for n in found.keys() & set(ROWS[kind])}
            return {name: matrix.astype(float) for name, matrix in found.items()}

        check_by_numbers(builder, box, as_the_builder_has_them)

    def _in_canonical_form(self, kind, box, matrices, rest):
        """Become the family of `Parametric` matrices; T of `canonical`."""
        from .rows import canonical, told

        T = canonical(matrices, ROWS[kind])
        for name, x in ((k, x) for k in matrices for x in matrices[k].flat):
            if not x.den.is_one():
                raise ParameterError(
                    f"{name} has the denominator {x.words(x.den)}, and no equation "
                    "to multiply by it: give the quotient a range of its own"
                )
        parts, count = {}, len(box.names)
        for name, matrix in matrices.items():
            terms = [x.num.to_dict() for x in matrix.flat]
            parts[name] = Polynomials.of(matrix.shape, terms, count)
        self._fill(kind, box, parts, rest)
        self.rows = told(T)
        if kind is DescriptorSystem:  # of a mass K_A may decide
            self.check_regular()
        return T

    def _fill(self, kind, box, parts, rest):
        """Set the fields of a family; raises where a parameter isn't used."""
        order = next(iter(parts.values())).shape[0]
        checked_names(rest.get("coordinates"), order)
        for name in ("F",) if kind is SecondOrderSystem else ("B", "B_w"):
            parts.setdefault(name, Polynomials.of((order, 0), (), len(box.names)))
        if kind is DescriptorSystem:
            parts.setdefault("C", Polynomials.of((0, order), (), len(box.names)))
        self.kind, self.box, self.parts, self._rest = kind, box, parts, rest
        self.rows, self.pieces = {}, dict.fromkeys(box.names, 1)
        used = np.max([m for part in parts.values() for m in part.monomials], axis=0)
        if idle := [name for name, d in zip(box.names, used) if not d]:
            raise ValueError(f"the plant doesn't depend on {', '.join(idle)}")
        #: The highest power of each parameter, by name.
        self.degree = dict(zip(box.names, used.tolist()))

    def within(self, box: Box) -> "Uncertain":
        """The same plants with the ranges of ``box``, a `Box`, not cut into pieces."""
        other = Uncertain.made(self.kind, box, self.parts, **self._rest)
        other.rows, other.schedule = self.rows, self.schedule
        return other

    @property
    def multi_affine(self) -> bool:
        """True if no parameter has a power above one: the vertices are the corners."""
        return max(self.degree.values(), default=1) == 1

    @cached_property
    def straight(self) -> bool:
        """True if each vertex is a mean of plants at the corners: no cut is nearer."""
        parts = self._stacks()
        return self.multi_affine or corners_hold(parts, self.degree, self.pieces)

    def _stacks(self):
        form = self.box, tuple(self.degree.values()), tuple(self.pieces.values())
        return {name: part.vertices(*form) for name, part in self.parts.items()}

    @property
    def count(self) -> int:
        """How many `vertices` there are."""
        return prod(2 + (d - 1) * self.pieces[k] for k, d in self.degree.items())

    def __repr__(self):
        powers = ", ".join(f"{d} in {k}" for k, d in self.degree.items())
        form = f"of Bernstein's form of degree {powers}"
        how = "the corners" if self.multi_affine else form
        rows = [f"; row {i} was {words}" for i, words in self.rows.items()]
        if len(rows) > 3:
            rows[3:] = [f"; so were {len(rows) - 3} rows more"]
        what = f"{self.box}; {self.count} vertices, {how}{''.join(rows)}"
        return f"<Uncertain {self.kind.__name__}: {what}>"

    def __eq__(self, other):
        if not isinstance(other, Uncertain):
            return NotImplemented
        return self.kind is other.kind and self.data() == other.data()

    def __hash__(self):
        return hash(self.box)

    def data(self) -> dict:
        """The ranges and the polynomials as words: see `plant_data`."""
        names = self.box.names
        words = {name: part.words(names) for name, part in self.parts.items()}
        ends = zip(names, map(spelled, self.box.low), map(spelled, self.box.high))
        cells = ([n] if n > 1 else [] for n in self.pieces.values())
        return {"parameters": [[*x, *n] for x, n in zip(ends, cells)], **words}

    @classmethod
    def of(cls, base: Any, /, **changes: Any) -> "Uncertain":
        """The plants that a base and multiples of some changes make.

        Parameters
        ----------
        base : SecondOrderSystem or DescriptorSystem
            Where all parameters are zero.
        **changes : (low, high, [(u, w), ...])
            By the name of the parameter p: its range, and pairs of a column u and a
            row w, all p u w' of which are added to [M D S B F], or to [E A B B_w].

        Examples
        --------
        >>> from sosbook import SecondOrderSystem
        >>> cart = SecondOrderSystem(1, 0.1, 2, 1)
        >>> load = 0, 3, [([1], [1, 0, 0, 0])]
        >>> Uncertain.of(cart, load=load).at(load=0.5).M
        array([[1.5]])
        """
        from .builder import along

        builder, ranges = along(base, changes, ROWS)
        return cls(builder, **ranges)

    @classmethod
    def made(cls, kind: type, box: Box, parts: dict, **rest: Any) -> "Uncertain":
        """The family of some matrices of polynomials, whatever its rows are.

        ``kind``: `SecondOrderSystem` or `DescriptorSystem`; ``box``: the ranges;
        ``parts``: `Polynomials` by the name of the constructor's argument; ``rest``:
        what else that takes.
        """
        family = object.__new__(cls)
        family._fill(kind, box, parts, rest)
        return family

    @classmethod
    def read(
        cls, kind: type, data: dict, rows: bool = False, **rest: Any
    ) -> "Uncertain":
        """The family of the ``data`` that `data` writes.

        Parameters
        ----------
        kind : type
            `SecondOrderSystem` or `DescriptorSystem`.
        data : dict
            Ranges and matrices by name, of numbers or polynomials in words.
        rows : bool
            Whether rows are brought into canonical form.
        **rest
            What else a plant has: ``coordinates``, ``reduction``.

        Examples
        --------
        >>> plants = Uncertain.read(SecondOrderSystem, {
        ...     "parameters": [["m", 1, 2]],
        ...     "M": [["m"]], "D": [["0.1*m + 1"]], "S": [[3]], "B": [[1]]})
        >>> plants.at(m=2).D
        array([[1.2]])
        """
        one = not rows and data["parameters"] == []  # a plant of rationals
        box, cut = (NO_RANGES, {}) if one else read_ranges(data["parameters"])
        entries: dict = {}
        for name, matrix in ((k, x) for k, x in data.items() if k != "parameters"):
            entries[name] = read_entries(matrix, box.names)
            if len(set(map(len, matrix))) > 1:
                raise ValueError(f"the rows of {name} differ in length")
        if rows:
            family = object.__new__(cls)
            made = {name: made_of(x, box) for name, x in entries.items()}
            family._in_canonical_form(kind, box, made, rest)
            return family
        order, parts = len(next(iter(entries.values()))), {}
        for name, several in entries.items():
            shape = len(several), len(several[0]) if several else order
            flat = [x for row in several for x in row]
            parts[name] = Polynomials.of(shape, flat, len(box.names))
        return cls.made(kind, box, parts, **rest).cut(**cut)

    def _at(self, point):
        """The matrices at a point of rationals, by name, in rationals."""
        return {name: part.at(self.box, point) for name, part in self.parts.items()}

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

    def exactly_at(self, point: list) -> Any:
        """The plant at a ``point`` of rationals, in order, that remembers its own."""
        return self._plant(self._at(point), kept=True)

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
        low, high = (np.array(x) for x in (self.box.low, self.box.high))
        return [self._plant(self._at(low + (high - low) * r)) for r in exact(shares)]

    @property
    def vertices(self) -> tuple:
        """Plants whose hull holds the family; the last parameter changes first."""
        return self.polytope().vertices

    @cached_property
    def _corners(self):
        """The vertices, by Bernstein's form; raises where they are too many."""
        if (count := self.count) > MOST_VERTICES:
            costs = {k: 2 + (d - 1) * self.pieces[k] for k, d in self.degree.items()}
            name = max(costs, key=costs.get)
            raise ValueError(
                f"the family has {count} vertices, more than {MOST_VERTICES}: {name} "
                f"costs most, a factor of {costs[name]}: fix what matters least, "
                "or cut into fewer pieces"
            )
        parts = self._stacks()
        return tuple(
            self._plant({name: stack[k] for name, stack in parts.items()}, kept=True)
            for k in range(count)
        )

    def _plant(self, matrices, kept=False):
        """A plant of floats next to rationals, which it keeps in mind if they are."""
        with as_written():  # a vertex needn't be a plant of the family
            floats = {name: x.astype(float) for name, x in matrices.items()}
            plant = self.kind(**floats, **self._rest)
        if kept:
            keep(plant, matrices)
        return plant

    def halves(self, name: str | None = None) -> "tuple[Uncertain, Uncertain]":
        """The two families with one half of a range each, not cut into pieces.

        Parameters
        ----------
        name : str, optional
            The parameter; the one whose range is widest for its size without it.
        """
        first, second = self.box.halves(name or self.box.widest())
        return self.within(first), self.within(second)

    def cut(self, /, **pieces: int) -> "Uncertain":
        """The same family with vertices nearer to it.

        Parameters
        ----------
        **pieces : int
            Into how many equal pieces the range of a parameter is cut, by name. Each
            has a Bernstein form of its own, and their hull holds the family. With
            powers up to one nothing comes nearer.

        Examples
        --------
        >>> from sosbook import SecondOrderSystem
        >>> square = Uncertain(
        ...     lambda v: SecondOrderSystem(1, v, v**2, 1), v=(0, 1))
        >>> [v.S.item() for v in square.vertices], len(square.cut(v=4).vertices)
        ([0.0, 0.0, 1.0], 6)
        """
        if unknown := pieces.keys() - set(self.box.names):
            named = ", ".join(self.box.names)
            raise ValueError(f"{min(unknown)!r} is no parameter: {named} are")
        cells = {name: whole(name, n, 1) for name, n in pieces.items()}
        other = self.within(self.box)
        other.pieces = self.pieces | cells
        return other

    def polytope(self) -> Any:
        """The polytope (or DescriptorSystem) of the vertices, with this as ``family``:
        what is proven of it is said of the parameters.
        """
        return self._around

    @cached_property
    def _around(self):
        several = [v.vertices[0] for v in self._corners]
        own = {k: self._rest.get(k) for k in ("reduction", "sensed", "states", "dt")}
        one = self.kind is SecondOrderSystem
        plants = Polytope(several) if one else DescriptorSystem.of(several, **own)
        object.__setattr__(plants, "family", self)
        return plants

    def check_regular(self) -> None:
        """Raise where E, or the mass, is singular for some of the values only."""
        name, degrees = ROWS[self.kind][0], tuple(self.degree.values())
        check_regular(name, self.parts[name], self.box, degrees)
