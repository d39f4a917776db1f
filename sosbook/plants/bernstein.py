"""Boxes of parameters, and polynomials in Bernstein's form on them."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import cycle, product
from math import comb, prod

import numpy as np
from flint import fmpq

from ..exact.rational import echelon, exact, rational_matrix

MOST_CELLS = 128  # in which a sign is looked for
NO_WEIGHT = 1e-9  # of a point in a mean, by floats
FARTHEST = 64  # directions in which the farthest of some points is no mean of others
SHOWN = 10  # decimals of a rational in words; one with more is a fraction


@dataclass(frozen=True)
class Box:
    """Ranges of named parameters: ``names``, and tuples of fmpq, ``low`` and ``high``.

    >>> Box.of(m=(1, 2), k=(0.5, 1.5))
    m in [1, 2] and k in [0.5, 1.5]
    """

    names: tuple
    low: tuple
    high: tuple

    @classmethod
    def of(cls, /, **ranges):
        """The box of ``ranges``, pairs (low, high) of numbers, by name."""
        if not ranges:
            raise ValueError("there is no parameter: give ranges, name=(low, high)")
        ends = [_range(name, given) for name, given in ranges.items()]
        return cls(tuple(ranges), *zip(*ends))

    def __repr__(self):
        if not self.names:
            return "no parameter"
        *most, last = (
            f"{name} in [{spelled(low)}, {spelled(high)}]"
            for name, low, high in zip(self.names, self.low, self.high)
        )
        return f"{', '.join(most)} and {last}" if most else last

    @property
    def middle(self):
        """The point in the middle, rationals in the order of the names."""
        return tuple((a + b) / 2 for a, b in zip(self.low, self.high))

    @property
    def inner(self):
        """A point inside at which nothing special happens."""
        shares = cycle((fmpq(11, 31), fmpq(17, 31), fmpq(5, 31)))
        return tuple(a + (b - a) * s for a, b, s in zip(self.low, self.high, shares))

    def corners(self):
        """The corners; the last parameter changes first."""
        return product(*zip(self.low, self.high))

    def point(self, values):
        """The rationals of ``values`` by name; a ValueError names a wrong one."""
        if values.keys() != set(self.names):
            raise ValueError(f"give a value of {', '.join(self.names)}, and no other")
        point = tuple(rational(name, values[name]) for name in self.names)
        for name, x, low, high in zip(self.names, point, self.low, self.high):
            if not low <= x <= high:
                raise ValueError(
                    f"{name} = {spelled(x)} isn't in [{spelled(low)}, {spelled(high)}]"
                )
        return point

    def widest(self):
        """The name of the range that is widest for the size of its numbers."""
        ends = zip(self.low, self.high)
        wide = [(b - a) / max(abs(a), abs(b)) for a, b in ends]
        return self.names[wide.index(max(wide))]

    def halves(self, name):
        """The two boxes of one half of the range of ``name`` each."""
        if name not in self.names:
            raise ValueError(f"{name!r} is no parameter: {', '.join(self.names)} are")
        k = self.names.index(name)
        cut = (self.middle[k],)
        return (
            Box(self.names, self.low, self.high[:k] + cut + self.high[k + 1 :]),
            Box(self.names, self.low[:k] + cut + self.low[k + 1 :], self.high),
        )

    def powers(self, point, monomials):
        """The values of ``monomials`` (tuples of exponents) at a point."""
        return [
            prod((x**e for x, e in zip(point, powers) if e), start=fmpq(1))
            for powers in monomials
        ]

    def bernstein(self, monomials, degrees, pieces=None):
        """Bernstein coefficients, by rows, of ``monomials`` (exponents) in Bernstein's
        form of some ``degrees`` with each range cut into equal ``pieces``; the last
        parameter's index runs first. A polynomial's values on the box lie in their
        hull.

        :math:`t^e` has the blossom that is the mean of all products of e of d
        arguments, and its coefficient i is that with i arguments at the upper end and
        the others at the lower one. Where two pieces meet, the coefficient is the mean
        of those beside it, as the slope is one; so it is left out.

        >>> box = Box.of(v=(1, 3))
        >>> box.bernstein([(0,), (1,), (2,)], [2]).tolist()
        [[1, 1, 1], [1, 2, 3], [1, 3, 9]]
        >>> box.bernstein([(1,), (2,)], [2], [2]).tolist()
        [[1, 1], [3/2, 2], [5/2, 6], [3, 9]]
        """
        pieces = pieces or [1] * len(degrees)
        ends = zip(degrees, self.low, self.high, pieces)
        places = product(*(_places(*end) for end in ends))

        def entry(place, powers):
            each = (_blossom(i, e, *end) for (i, *end), e in zip(place, powers))
            return prod(each, start=fmpq(1))

        return rational_matrix([[entry(x, m) for m in monomials] for x in places])

    def answers(self, terms, sure, never):
        """{True}, {False}, or both: the answers ``sure`` and ``never`` give for a
        polynomial with coefficients ``terms``. The box is halved until they tell;
        beyond ``MOST_CELLS`` None joins.
        """
        if not terms:
            return {sure(0, 0)}
        degrees = np.max(list(terms), axis=0).tolist()
        column = rational_matrix([[c] for c in terms.values()])
        found, waiting = set(), [self]
        for _ in range(MOST_CELLS):
            if not waiting or len(found) == 2:
                return found
            box = waiting.pop(0)
            values = (box.bernstein(list(terms), degrees) @ column).ravel()
            ends = min(values), max(values)
            if sure(*ends) or never(*ends):
                found.add(sure(*ends))
                continue
            for point in (box.low, box.middle, box.high):
                x = sum(p * c for p, c in zip(box.powers(point, terms), column.flat))
                found.add(sure(x, x))
            grid = values.reshape([d + 1 for d in degrees])
            moved = [np.max(np.ptp(grid, axis=k)) for k in range(grid.ndim)]
            waiting += box.halves(box.names[moved.index(max(moved))])
        return found | {None}


NO_RANGES = Box((), (), ())


def corners_hold(stacks, degrees, pieces):
    """True if each vertex is a mean of those at the corners: ``stacks`` of the matrices
    by name, of Bernstein's form with ``degrees`` and ``pieces``, by parameter.
    """
    places = [range(2 + (d - 1) * pieces[k]) for k, d in degrees.items()]
    ends = [all(i in (0, p[-1]) for i, p in zip(x, places)) for x in product(*places)]
    points = np.hstack([stack.reshape(len(ends), -1) for stack in stacks.values()])
    points = points[:, (points != points[0]).any(axis=0)]
    corners = points[ends]
    return all(is_mean(x, corners) for x in points[~np.array(ends)])


def is_mean(point, others):
    """True if a ``point``, (k,), is a mean of some ``others``, (n, k), in rationals.

    >>> corners = exact(np.array([[0.0, 0.0], [1.0, 0.3], [0.0, 1.0]]))
    >>> is_mean(exact(np.array([0.5, 0.15])), corners)
    True
    """
    return mean_weights(point, others) is not None


def mean_weights(point, others):
    """The weights, by place, of a mean of some ``others``, (n, k), that a ``point``,
    (k,), is; None without one. Floats say which ones, and the weights are solved for in
    rationals.

    >>> ends = exact(np.array([[0.0], [3.0]]))
    >>> mean_weights(exact(np.array([1.0])), ends)
    {0: 2/3, 1: 1/3}
    """
    from scipy.optimize import linprog

    rows = np.vstack([others.T, others[:, 0] * 0 + 1])
    wanted = np.append(point, fmpq(1))
    scale = np.abs(rows.astype(float)).max(axis=1)
    scale[scale == 0] = 1.0
    floats = rows.astype(float) / scale[:, None], wanted.astype(float) / scale
    found = linprog(np.zeros(len(others)), A_eq=floats[0], b_eq=floats[1])
    if found.x is None:
        return None
    some = np.flatnonzero(found.x > NO_WEIGHT)
    table = np.column_stack([rows[:, some], wanted])
    solved, lead = echelon(rational_matrix(table.tolist()))
    if len(solved[0]) - 1 in lead or len(lead) != len(some):  # none, or not one
        return None
    weights = [row[-1] for row in solved[: len(some)]]
    return dict(zip(some.tolist(), weights)) if min(weights) >= 0 else None


def means(points):
    """The ``points``, (n, k) rationals, that repeat or are means of others.

    Each is mapped to its weights by the places of those that stay; see `mean_weights`.

    >>> means(exact(np.array([[0.0], [2.0], [1.0], [2.0]])))
    {2: {0: 1/2, 1: 1/2}, 3: {1: 1}}
    """
    points = points[:, (points != points[0]).any(axis=0)]
    first, found = {}, {}
    for k, row in enumerate(map(tuple, points)):
        if first.setdefault(row, k) != k:
            found[k] = {first[row]: fmpq(1)}
    single, floats = list(first.values()), points.astype(float)
    ways = np.random.default_rng(0).normal(size=(floats.shape[1], FARTHEST))
    heights = (floats / np.maximum(np.abs(floats).max(axis=0), 1e-300)) @ ways
    far = {int(k) for k in [*heights.argmax(axis=0), *heights.argmin(axis=0)]}
    for k in [k for k in single if first[tuple(points[k])] not in far]:
        others = [i for i in single if i != k]
        if weights := mean_weights(points[k], points[others]):
            single = others
            found[k] = {others[i]: w for i, w in weights.items()}
    for weights in found.values():  # what stood for another may have gone since
        while gone := weights.keys() & found.keys():
            i = gone.pop()
            w = weights.pop(i)
            for j, share in found[i].items():
                weights[j] = weights.get(j, fmpq(0)) + w * share
    return dict(sorted(found.items()))


def _places(degree, low, high, pieces):
    """(i, degree, low, high) of each coefficient, but those where two pieces meet."""
    step = (high - low) / pieces
    for k in range(pieces):
        there = degree, low + k * step, low + (k + 1) * step
        if k == 0:
            yield 0, *there
        for i in range(1, degree):
            yield i, *there
        if k == pieces - 1 and degree:
            yield degree, *there


@lru_cache(maxsize=4096)
def _blossom(i, power, degree, low, high):
    """The coefficient i of t^power on [low, high] in Bernstein's form of a degree."""
    several = (
        comb(i, j) * comb(degree - i, power - j) * high**j * low ** (power - j)
        for j in range(max(0, power - degree + i), min(i, power) + 1)
    )
    return sum(several, fmpq(0)) / comb(degree, power)


def rational(name, value):
    """A number (its value) as a rational of decimals, or a ValueError with its name."""
    try:
        if isinstance(value, (bool, np.bool_)) or np.ndim(value):
            raise ValueError
        if isinstance(value, fmpq):
            return value
        if isinstance(getattr(value, "denominator", None), int):  # int, Fraction
            return fmpq(int(value.numerator), value.denominator)
        if not isinstance(value, (int, float, np.integer, np.floating)):
            raise ValueError
        return exact(value.item() if isinstance(value, np.generic) else value)
    except (ValueError, TypeError):
        raise ValueError(f"{name} must be a finite number, got {value!r:.80}") from None


def _range(name, given):
    """The ends of a range, or a ValueError that says what is wrong with it."""
    if not (name.isascii() and name.isidentifier()):
        raise ValueError(f"{name!r:.40} must be a name of ASCII letters and digits")
    try:
        low, high = given
    except (TypeError, ValueError):
        raise ValueError(
            f"{name} must be a pair (low, high) of numbers, got {given!r:.80}"
        ) from None
    low, high = rational(name, low), rational(name, high)
    if low == high:
        raise ValueError(
            f"the range of {name} is one number: write {name} = {spelled(low)} into "
            "the builder"
        )
    if low > high:
        raise ValueError(
            f"the range of {name} is empty: low {spelled(low)} isn't below high "
            f"{spelled(high)}"
        )
    return low, high


def spelled(x):
    """A rational x as the decimals it has, or as a fraction where they are many."""
    whole = x * 10**SHOWN
    if whole.q != 1:
        return str(x)
    digits = str(abs(whole.p)).rjust(SHOWN + 1, "0")
    text = f"{digits[:-SHOWN]}.{digits[-SHOWN:]}".rstrip("0").removesuffix(".")
    return "-" * (x < 0) + text
