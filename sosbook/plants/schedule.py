r"""A gain that follows measured parameters: a constant gain of a plant of more inputs.

Let p be measured, with c corners of their ranges, and w_i(p) the corners' weights:
products of (p - low)/(high - low) or (high - p)/(high - low), one for each parameter.
They are not negative, their sum is one, and the gain

.. math::

    K(p) = \sum_i w_i(p) K_i, \qquad
    B K(p) = \begin{bmatrix} w_1 B & \cdots & w_c B \end{bmatrix}
    \begin{bmatrix} K_1 \\ \vdots \\ K_c \end{bmatrix} .

So the plant with the inputs of the right-hand side, whose matrices are polynomials in
the parameters like those of any family, has the constant gain of all K_i. What is
designed, proven and refused of families is so of this one.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from flint import fmpq

from ..runtime.read_only import ReadOnly
from .bernstein import Box, rational
from .polynomials import Polynomials
from .uncertain import Uncertain

OF_INPUT = "B", "D_u"  # what the weights multiply


@dataclass(frozen=True, eq=False)
class Schedule(ReadOnly):
    """The measured parameters ``names`` among those of a ``box``, and the weights of
    the corners of their ranges; of the corners the last parameter changes first.

    >>> schedule = Schedule(("l",), Box.of(l=(2, 4), m=(1, 3)))
    >>> schedule.corners, schedule.weights(l=2.5).tolist()
    (({'l': 2.0}, {'l': 4.0}), [0.75, 0.25])
    """

    names: tuple
    box: Box

    def __post_init__(self):
        """Check that each is a parameter, and named once."""
        for name in self.names:
            if name not in self.box.names:
                raise ValueError(
                    f"{name!r} is measured, but is no parameter of the plant: "
                    f"{', '.join(self.box.names) or 'none'} are"
                )
        if not self.names or len(set(self.names)) < len(self.names):
            raise ValueError("name each measured parameter once, as in 'l'")
        super().__post_init__()

    @property
    def ends(self):
        """(low, high) of each measured range, in floats."""
        places = [self.box.names.index(name) for name in self.names]
        return [(float(self.box.low[k]), float(self.box.high[k])) for k in places]

    @property
    def corners(self):
        """The measured values at each corner, by name."""
        return tuple(dict(zip(self.names, x)) for x in product(*self.ends))

    def weights(self, /, **values):
        """The weights of the corners, in the program's order of operations: an array.

        ``values`` are of the measured parameters, by name, inside their ranges.
        """
        if values.keys() != set(self.names):
            raise ValueError(f"give a value of {', '.join(self.names)}, and no other")
        weights = np.ones(1)
        for name, (low, high) in zip(self.names, self.ends):
            x = float(rational(name, values[name]))
            if not low <= x <= high:
                raise ValueError(
                    f"{name} = {x:g} isn't in [{low:g}, {high:g}], where the gain is "
                    "proven"
                )
            up = (x - low) / (high - low)
            weights = np.ravel([[w * (1.0 - up), w * up] for w in weights])
        return weights

    def polynomials(self):
        """The weights as coefficients by exponents of the box's parameters."""
        none = (0,) * len(self.box.names)
        weights = [{none: fmpq(1)}]
        for name in self.names:
            k = self.box.names.index(name)
            low, high = self.box.low[k], self.box.high[k]
            one, over = (*none[:k], 1, *none[k + 1 :]), 1 / (high - low)
            ends = {one: -over, none: high * over}, {one: over, none: -low * over}
            weights = [_times(w, end) for w in weights for end in ends]
        return weights


def scheduled(family, names):
    """The `Uncertain` with an input for each input of a ``family`` and each corner of
    the measured parameters ``names``.
    """
    weights = Schedule(tuple(names), family.box).polynomials()
    count, parts = len(family.box.names), dict(family.parts)
    for name in parts.keys() & set(OF_INPUT):
        (rows, m), entries = parts[name].shape, _entries(parts[name])
        wide = [
            _times(entries[i * m + j], w)
            for i in range(rows) for w in weights for j in range(m)
        ]  # fmt: skip
        parts[name] = Polynomials.of((rows, m * len(weights)), wide, count)
    made = Uncertain.made(family.kind, family.box, parts, **family._rest)
    made.rows, made.schedule = family.rows, tuple(names)
    return made.cut(**family.pieces)


def _entries(part):
    """Coefficients by exponents of each entry of some `Polynomials`, row by row."""
    entries = [{} for _ in range(part.shape[0] * part.shape[1])]
    for place, column in zip(part.places, part.coefficients.T):
        entries[place] = {m: c for m, c in zip(part.monomials, column) if c}
    return entries


def _times(a, b):
    """The product of two polynomials, coefficients by exponents."""
    found = {}
    for (m, c), (n, d) in product(a.items(), b.items()):
        place = tuple(x + y for x, y in zip(m, n))
        found[place] = found.get(place, fmpq(0)) + c * d
    return {place: c for place, c in found.items() if c}
