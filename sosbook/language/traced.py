"""Theorems that print themselves: matrices that are symbols.

A theorem that is called with `Traced` matrices returns a tree, and `text` lays it out
in the language of proof files: ``-[he(Theta), EP C'; ., -gamma^2] > 0``. Its words are

* ``+ - / '``, a product without a sign, a power ``^2`` of a number;
* ``[a, b; c, d]``, in which a number stands for that multiple of the identity, a 0
  fits everywhere and ``.`` is the mirror image of the block above the diagonal;
* ``he kron inv tr``, ``I(n)``, ``O(n, m)``, ``pick(k, p, n)`` (the k-th of p blocks of
  n rows each), ``at(X, i, j)``, ``rows(X)`` and ``cols(X)``.
"""

from fractions import Fraction

import numpy as np

from . import trees
from .matrices import Symbols
from .trees import MIRROR, ONE, ZERO


class Size(Symbols, int):
    """A number of rows or columns that knows what it is the size of.

    ``value``: the number; ``tree``: its tree, such as that of ``rows(A)``.
    """

    def __new__(cls, value, tree):
        size = super().__new__(cls, value)
        size.tree = tree
        return size

    def eye(self):
        """The traced identity with so many rows."""
        return Traced(("I", self.tree), (self, self))

    def pick(self, k, parts):
        """The traced matrix that picks the ``k``-th of ``parts`` with so many rows."""
        tree = ("pick", trees.number(k + 1), trees.number(parts), self.tree)
        return Traced(tree, (self, parts * self))


class Traced(Symbols):
    """A matrix or a number, of which only its name is known, and its shape.

    It knows ``@ + - * / .T`` and powers of numbers; `sosbook.language`'s words take it.

    ``tree``: a word, and the trees that it is said of; ``shape``: two `Size` or int; ()
    for a number; ``value``: that of a number on which a theorem may decide, such as
    ``if mu == 0``.

    >>> A, P = Traced.matrix("A", 2), Traced.matrix("P", 2, symmetric=True)
    >>> (A @ P + P @ A.T).text
    'he(A P)'
    """

    __array_ufunc__ = None  # numpy hands its operators over to this class

    def __init__(self, tree, shape=(), value=None):
        self.tree, self.shape, self.value = tree, tuple(shape), value

    @classmethod
    def matrix(cls, name, rows, cols=None, symmetric=False):
        """A matrix of that ``name``: ``rows``, ``cols`` as many without a word,
        ``symmetric``.
        """
        tree = ("name", name, symmetric, False, None)
        square = symmetric or cols is None
        height = Size(rows, ("rows", tree))
        return cls(tree, (height, height if square else Size(cols, ("cols", tree))))

    @classmethod
    def number(cls, name, value=None):
        """A number of that ``name``, and of a ``value`` by which theorems decide."""
        value = None if value is None else Fraction(str(value))
        return cls(("name", name, True, True, None), (), value)

    @classmethod
    def of(cls, x):
        """Numbers x, or what is traced already, as `Traced`."""
        if isinstance(x, Traced):
            return x
        x = np.asarray(x)
        try:
            entries = [_fraction(e) for e in x.ravel()]
        except (TypeError, ValueError, AttributeError):
            raise TypeError(
                "not traced: a theorem that prints itself uses block, eye, he, kron "
                "and tr, and the operators @ + - * / .T, and nothing else"
            ) from None
        if x.ndim == 0:
            return cls(trees.number(entries[0]), (), entries[0])
        if not any(entries):
            return cls(("O", *map(trees.size, x.shape)), x.shape)
        rows = [
            entries[i : i + x.shape[-1]] for i in range(0, len(entries), x.shape[-1])
        ]
        if (x == x[0, 0] * np.eye(*x.shape, dtype=int)).all():
            one = ("I", trees.size(len(rows)))
            return cls(trees.scaled(entries[0], one), x.shape)
        return cls(("block", tuple(tuple(map(trees.number, r)) for r in rows)), x.shape)

    def __array__(self, *_, **__):
        self.of([None])

    @property
    def ndim(self):
        """2 for a matrix, 0 for a number."""
        return len(self.shape)

    @property
    def T(self):
        """The transpose."""
        return Traced(trees.flipped(self.tree), self.shape[::-1], self.value)

    @property
    def text(self):
        """The expression, without the definitions of names in it."""
        return trees.shown(self.tree)

    @property
    def definitions(self):
        """The lines that define the names in it, by `named`, in their order."""
        found = {}
        trees.collect(self.tree, found)
        return [f"{name} = {trees.shown(tree)}" for name, tree in found.items()]

    def named(self, name):
        """The same, called ``name`` from now on: see `definitions`."""
        symmetric = trees.flipped(self.tree) == self.tree
        tree = ("name", name, symmetric, trees.is_number(self.tree), self.tree)
        return Traced(tree, self.shape, self.value)

    def word(self, word, shape=(1, 1)):
        """The expression ``word`` applied to this one, of a given shape."""
        return Traced((word, self.tree), shape)

    def times_each(self, factors):
        """The Kronecker product of small ``factors`` and this, see `kron`."""
        if not isinstance(factors, Traced):
            rows = tuple(tuple(Traced.of(f).tree for f in row) for row in factors)
            shape = len(rows), len(rows[0])
            zero = all(f == ZERO for row in rows for f in row)
            tree = ("O", *map(trees.size, shape)) if zero else ("block", rows)
            factors = Traced(tree, shape)
        if trees.is_number(factors.tree):
            return Traced(factors.tree) * self
        if factors.shape == (1, 1) and factors.tree[0] != "name":
            return factors[0, 0] * self
        shape = [a * b for a, b in zip(factors.shape, self.shape)]
        if factors.tree[0] == "O":
            return Traced(("O", *map(trees.size, shape)), shape)
        return Traced(("kron", factors.tree, self.tree), shape)

    def reshape(self, shape, order="C"):
        """Itself, a column already: a ``shape`` of (-1, 1) in any ``order``."""
        if tuple(shape) != (-1, 1) or self.shape[1:] != (1,):
            self.of([None])
        return self

    def __getitem__(self, key):
        i, j = key if isinstance(key, tuple) else (None, None)
        if not (isinstance(i, int) and isinstance(j, int)):
            self.of([None])
        if self.tree[0] == "block" and len(self.tree[1]) == self.shape[0]:
            return Traced(self.tree[1][i][j])
        if self.tree[0] == "O":
            return Traced(ZERO, (), 0)
        return Traced(("at", self.tree, trees.number(i + 1), trees.number(j + 1)))

    def __neg__(self):
        tree = self.tree[1] if self.tree[0] == "neg" else ("neg", self.tree)
        if self.tree[0] == "O" or self.tree == ZERO:
            tree = self.tree
        return Traced(tree, self.shape, None if self.value is None else -self.value)

    def __add__(self, other):
        other = Traced.of(other)
        for one, two in ((self, other), (other, self)):
            if one.tree[0] == "O" or one.tree == ZERO:
                return two
        self._fits(other)
        value = None
        if self.value is not None and other.value is not None:
            value = self.value + other.value
        if self.ndim and trees.flipped(self.tree) == other.tree:
            return Traced(("he", self.tree), self.shape)
        return Traced(trees.add(self.tree, other.tree), self.shape, value)

    def __radd__(self, other):
        return Traced.of(other) + self

    def __sub__(self, other):
        return self + -Traced.of(other)

    def __rsub__(self, other):
        return Traced.of(other) + -self

    def __mul__(self, other):
        """The product; numbers scale, and factors of one disappear."""
        other = Traced.of(other)
        if self.ndim and (other.ndim == 0 or other.tree == ("I", ONE)):
            self, other = other, self
        if self.ndim and self.shape != (1, 1):
            self.of([None])  # a product of entries
        if self.value == 0 and self.tree == ZERO:
            zero = ("O", *map(trees.size, other.shape)) if other.ndim else ZERO
            return Traced(zero, other.shape, 0 if not other.ndim else None)
        for one, two in ((self, other), (other, self)):
            if one.tree in (ONE, ("I", ONE), ("neg", ONE)):
                two = Traced(two.tree, two.shape or one.shape, two.value)
                return -two if one.tree[0] == "neg" else two
        value = None
        if not other.ndim and self.value is not None and other.value is not None:
            value = self.value * other.value
        return Traced(trees.product(self.tree, other.tree), other.shape, value)

    def __rmul__(self, other):
        return Traced.of(other) * self

    def __truediv__(self, other):
        other = Traced.of(other)
        if self.tree[0] == "neg":
            return -(Traced(self.tree[1], self.shape) / other)
        return Traced(("div", self.tree, other.tree), self.shape)

    def __rtruediv__(self, other):
        return Traced.of(other) / self

    def __pow__(self, power):
        if power == 1:
            return self
        value = None if self.value is None else self.value**power
        return Traced(("pow", self.tree, str(power)), (), value)

    def __matmul__(self, other):
        other = Traced.of(other)
        if self.shape[1] != other.shape[0]:
            raise ValueError(f"shapes {self.shape} and {other.shape} don't multiply")
        shape = self.shape[0], other.shape[1]
        if "O" in (self.tree[0], other.tree[0]):
            return Traced(("O", *map(trees.size, shape)), shape)
        if "I" in (self.tree[0], other.tree[0]):
            return other if self.tree[0] == "I" else self
        return Traced(trees.product(self.tree, other.tree), shape)

    def __rmatmul__(self, other):
        return Traced.of(other) @ self

    def _fits(self, other):
        if self.shape != other.shape and {self.shape, other.shape} != {(), (1, 1)}:
            raise ValueError(f"shapes {self.shape} and {other.shape} don't add up")

    def __bool__(self):
        if self.value is None:
            raise TypeError(f"not traced: the theorem decides by {self.text}")
        return self.value != 0

    def __eq__(self, other):
        return self is other or not self - other

    __hash__ = object.__hash__

    @classmethod
    def block(cls, entries, size, heights, widths):
        """A block matrix.

        ``entries``: ((rows, columns), matrix) of each that isn't zero, rows as a slice;
        ``size``: its shape; ``heights``, ``widths``: those of its rows and columns of
        blocks.
        """
        tops = [sum(heights[:i]) for i in range(len(heights))]
        lefts = [sum(widths[:j]) for j in range(len(widths))]
        table = [[ZERO] * len(widths) for _ in heights]
        for (down, right), x in entries:
            i, j = tops.index(down.start), lefts.index(right.start)
            table[i][j] = trees.fitted(cls.of(x).tree)
        trees.tell_sizes(table, heights, widths)
        for i, row in enumerate(table):
            for j in range(min(i, len(row))):
                above = table[j][i] if i < len(table[j]) else ZERO
                if above != ZERO and above == trees.flipped(row[j]):
                    row[j] = MIRROR
        return cls(("block", tuple(map(tuple, table))), size)


def _fraction(e):
    """A number of any arithmetic as a fraction: that of the decimal of a float."""
    if isinstance(e, (float, np.floating)):
        return Fraction(repr(float(e)))
    return Fraction(e.p.__int__(), int(e.q)) if hasattr(e, "p") else Fraction(int(e))
