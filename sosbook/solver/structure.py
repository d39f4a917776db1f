"""The structure of LMI blocks: G(X) = C + sum of (L X R + its transpose).

General cones forget that the unknowns are matrices. Here they stay matrices: the few
factors L and R of each block are all that Newton's method needs to know.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..language.expression import lower_triangle


@dataclass(frozen=True)
class UnknownLayout:
    """Where a (rows, cols) unknown begins (``start``) among the free entries of all.

    Of a ``symmetric`` one the lower triangle is free.
    """

    start: int
    rows: int
    cols: int
    symmetric: bool

    @property
    def size(self):
        """Number of free entries, an int."""
        if self.symmetric:
            return self.rows * (self.rows + 1) // 2
        return self.rows * self.cols

    @property
    def lower(self):
        """Row indices, column indices, and 1 off the diagonal, 0 on it."""
        return _lower(self.rows)

    def matrix(self, x):
        """The (rows, cols) matrix that a vector x of all variables holds."""
        part = x[self.start : self.start + self.size]
        if not self.symmetric:
            return part.reshape(self.rows, self.cols)
        X = np.empty((self.rows, self.rows), part.dtype)
        i, j, _ = self.lower
        X[i, j] = X[j, i] = part
        return X

    def gradient(self, X):
        """Derivatives by the free entries, from X, those by all the entries."""
        if not self.symmetric:
            return X.ravel()
        i, j, off = self.lower
        return X[i, j] + off * X[j, i]


@lru_cache(64)
def _lower(n):
    i, j = lower_triangle(n)
    return i, j, (i != j).astype(float)


@dataclass(frozen=True, eq=False)
class Product:
    """``left @ X @ right`` plus its transpose; ``unknown``: the index of X."""

    unknown: int
    left: np.ndarray
    right: np.ndarray


@dataclass(frozen=True, eq=False)
class StructuredBlock:
    """One (q, q) block: ``constant``, `Product` ``products``, (s, q, q) ``slopes``.

    The latter are derivatives by the s scalar variables.
    """

    constant: np.ndarray
    products: list
    slopes: np.ndarray

    def one(self, k):
        """The k-th of the blocks that arrays with one more axis, the first, hold."""

        def of(x):
            return x if x.ndim == 2 else x[k]

        return StructuredBlock(
            of(self.constant),
            [Product(t.unknown, of(t.left), of(t.right)) for t in self.products],
            self.slopes[:, k] if self.slopes.ndim == 4 else self.slopes,
        )

    def diagonal_squares(self, layouts):
        """Squares of the diagonal entries' derivatives, summed, for ``layouts``."""
        squares = np.zeros(len(self.constant))
        pairs = {}
        for t in self.products:
            pairs.setdefault(t.unknown, []).append((t.left, t.right.T))
        for k in sorted(pairs):
            squares += 4 * _row_squares(pairs[k], layouts[k].symmetric)
        return squares


def _row_squares(pairs, symmetric):
    """For each row the squares of sum L_r' R_r added; of free entries if symmetric."""
    total = 0.0
    for L, R in pairs:
        for left, right in pairs:
            product = (L * left).sum(1) * (R * right).sum(1)
            if symmetric:
                product = product + (L * right).sum(1) * (R * left).sum(1)
            total = total + product
    if symmetric:
        total = total - (sum(L * R for L, R in pairs) ** 2).sum(1)
    return total


def structure(expressions, unknowns):
    """Affine ``expressions`` as matrix products: layouts, scalars, blocks.

    ``unknowns`` of shape (1, 1) become scalar variables, the others have a layout.
    """
    layouts, scalars, matrices, start = [], [], [], 0
    for u in unknowns:
        if u.shape == (1, 1):
            scalars.append(start)
        else:
            layouts.append(UnknownLayout(start, *u.shape, u.symmetric))
            matrices.append(u)
        start += u.size
    single = [u for u in unknowns if u.shape == (1, 1)]
    wholes, blocks = {}, []
    for g in expressions:
        if g.whole is None:
            blocks.append(_structured(g, matrices, single))
            continue
        whole, k = g.whole
        if whole not in wholes:
            wholes[whole] = _structured(whole, matrices, single)
        blocks.append(wholes[whole].one(k))
    return layouts, np.array(scalars, int), blocks


def _structured(g, matrices, single):
    """The `StructuredBlock` of an expression, with one more axis if it is several."""
    constant = g.constant.astype(float)
    slopes = np.zeros((len(single), *constant.shape))
    for slope, u in zip(slopes, single):
        for t in g.terms:
            if t.unknown is u:
                slope += np.asarray(t.left @ t.right, float)
    held = {t.unknown for t in g.terms}
    factors = {k: _factors(g, u) for k, u in enumerate(matrices) if u in held}
    products = [
        Product(k, L, R)
        for k, pairs in factors.items()
        for L, R in _merged(pairs, matrices[k].symmetric)
    ]
    return StructuredBlock(constant, products, slopes)


def _factors(g, unknown):
    """Factors (L, R) of an expression's terms in one unknown.

    L X' R is written as R' X L', its mirror. The L of one R are added up.
    """
    factors = {}
    for t in g.terms:
        if t.unknown is unknown:
            L, R = np.asarray(t.left, float), np.asarray(t.right, float)
            if t.transposed:
                L, R = R.mT, L.mT
            key = R.shape, R.tobytes()
            factors[key] = (factors[key][0] + L, R) if key in factors else (L, R)
    return [(L, R) for L, R in factors.values() if L.any() and R.any()]


@lru_cache(64)
def some_matrix(k, rows, cols, symmetric):
    """A matrix without any structure of its own, always the same."""
    X = np.cos(1 + k + np.arange(rows * cols) ** 1.5).reshape(rows, cols)
    return X + X.T if symmetric else X


def _merged(pairs, symmetric):
    """Sum the L of pairs with equal R; half of each pair is its own mirror."""
    groups = {}
    for left, right in pairs:
        L, R, key = _normal(left, right)
        if symmetric and key not in groups:
            flipped = _normal(right.mT, left.mT)
            if flipped[2] in groups:
                L, R, key = flipped
        if key in groups:
            groups[key][0] = groups[key][0] + L / 2
        else:
            groups[key] = [L / 2, R]
    return [(L, R) for L, R in groups.values() if L.any()]


def _normal(L, R):
    """The pair with R scaled to a largest entry 1, and a key for that R."""
    if R.ndim == 2:
        top = R.ravel()[abs(R).argmax()] or 1.0
    else:
        flat = R.reshape(*R.shape[:-2], 1, -1)
        top = np.take_along_axis(flat, abs(flat).argmax(-1, keepdims=True), axis=-1)
        top = np.where(top == 0, 1, top)  # one of several factors may be zero
    R = R / top
    return L * top, R, (R.shape, (R.round(12) + 0.0).tobytes())
