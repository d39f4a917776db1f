"""The structure of LMI blocks: G(X) = C + sum of (L X R + its transpose).

General cones forget that the unknowns are matrices. Here they stay
matrices: the few factors L and R of each block are all that Newton's
method needs to know.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..language.expression import lower_triangle

__all__ = [
    "Product",
    "StructuredBlock",
    "UnknownLayout",
    "fold",
    "real",
    "some_matrix",
    "structure",
    "unfold",
]


@dataclass(frozen=True)
class UnknownLayout:
    """Where an unknown matrix lies in the vector of all variables.

    Parameters
    ----------
    start : int
        Index of its first free entry among the variables.
    rows, cols : int
        Shape of the matrix.
    symmetric : bool
        Whether only the lower triangle is free.
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
    """The term ``left @ X @ right`` plus its conjugate transpose.

    Parameters
    ----------
    unknown : int
        Index of X among the unknown matrices.
    left, right : array
        The factors of shapes (q, rows) and (cols, q).
    """

    unknown: int
    left: np.ndarray
    right: np.ndarray


@dataclass(frozen=True, eq=False)
class StructuredBlock:
    """One block: a constant, products, and slopes of scalar variables.

    Parameters
    ----------
    constant : (q, q) array
        The block where all unknowns are zero.
    products : list of Product
        The terms in the unknown matrices.
    slopes : (s, q, q) array
        Derivatives by the ``s`` scalar variables.
    weight : int
        2 where a complex Hermitian block stands for the real one of
        twice its size, which has each eigenvalue twice.
    """

    constant: np.ndarray
    products: list
    slopes: np.ndarray
    weight: int = 1

    def one(self, k):
        """The k-th of the blocks that arrays with one more axis, the first, hold."""

        def of(x):
            return x if x.ndim == 2 else x[k]

        return StructuredBlock(
            of(self.constant),
            [Product(t.unknown, of(t.left), of(t.right)) for t in self.products],
            self.slopes[:, k] if self.slopes.ndim == 4 else self.slopes,
            self.weight,
        )

    def with_constant(self, constant):
        """The block with another ``constant``, given for the real block."""
        if self.weight == 2:
            constant = fold(constant)
        return replace(self, constant=constant)

    def unfolded(self):
        """The real block of twice the size, if the weight is 2; else this one."""
        if self.weight == 1:
            return self
        products = []
        for t in self.products:
            lefts, rights = np.hsplit(unfold(t.left), 2), np.vsplit(unfold(t.right), 2)
            products += [Product(t.unknown, L, R) for L, R in zip(lefts, rights)]
        slopes = np.array([unfold(s) for s in self.slopes])
        slopes = slopes.reshape(-1, 2 * len(self.constant), 2 * len(self.constant))
        return StructuredBlock(unfold(self.constant), products, slopes)

    def diagonal_squares(self, layouts):
        """Sums of squares of the diagonal entries' derivatives.

        Parameters
        ----------
        layouts : list of UnknownLayout
            The layouts of the unknown matrices.

        Returns
        -------
        (q,) array
            By the unknown matrices, without the scalar variables.
        """
        squares = np.zeros(len(self.constant))
        pairs = {}
        for t in self.products:
            pairs.setdefault(t.unknown, []).append((t.left, t.right.T))
        for k in sorted(pairs):
            squares += 4 * _row_squares(pairs[k], layouts[k].symmetric)
        return squares


def _row_squares(pairs, symmetric):
    """For each row r the sum of squares of the entries of Re sum L_r' R_r.

    Where the unknown is symmetric these are the factors of its free entries.
    """
    rows = [
        (part(L), sign * part(R))
        for L, R in pairs
        for part, sign in ((np.real, 1), (np.imag, -1))
        if part(L).any() and part(R).any()
    ]
    total = 0.0
    for L, R in rows:
        for left, right in rows:
            product = (L * left).sum(1) * (R * right).sum(1)
            if symmetric:
                product = product + (L * right).sum(1) * (R * left).sum(1)
            total = total + product
    if rows and symmetric:
        total = total - (sum(L * R for L, R in rows) ** 2).sum(1)
    return total


def structure(expressions, unknowns):
    """Write affine expressions as products of matrices.

    Parameters
    ----------
    expressions : list of Affine
        The blocks.
    unknowns : list of Unknown
        Those of shape (1, 1) become scalar variables.

    Returns
    -------
    layouts : list of UnknownLayout
        One for each unknown matrix.
    scalars : (s,) array of int
        Indices of the scalar variables among all variables.
    blocks : list of StructuredBlock
        One for each expression.
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
    """The `StructuredBlock` of an expression; folded where it is Hermitian.

    Of several expressions, see `Affine.each`, it holds arrays with one more axis.
    """
    q = g.shape[0]
    constant = g.constant.astype(float)
    slopes = np.zeros((len(single), *constant.shape))
    for slope, u in zip(slopes, single):
        for t in g.terms:
            if t.unknown is u:
                slope += np.asarray(t.left @ t.right, float)
    held = {t.unknown for t in g.terms}
    factors = {k: _factors(g, u) for k, u in enumerate(matrices) if u in held}
    weight = 1
    if _is_hermitian(constant, slopes, factors, matrices):
        constant, slopes, weight = fold(constant), fold(slopes), 2
        h = q // 2
        for k, pairs in factors.items():
            pairs = [(L[..., :h, :], R[..., :h] + 1j * R[..., h:]) for L, R in pairs]
            factors[k] = [(L, R) for L, R in pairs if L.any()]
    products = [
        Product(k, L, R)
        for k, pairs in factors.items()
        for L, R in _merged(pairs, matrices[k].symmetric)
    ]
    return StructuredBlock(constant, products, slopes, weight)


def _factors(g, unknown):
    """Factors (L, R) of an expression's terms in one unknown.

    A term in the transpose, L X' R, is written as R' X L', its mirror. Terms
    with the same R become one with the sum of their L.
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


def _is_hermitian(constant, slopes, factors, matrices):
    """Whether the block is [[X, Y], [-Y, X]] whatever the unknowns are."""
    q = constant.shape[-1]
    if q % 2 or not all(_commutes(g) for g in (constant, *slopes)):
        return False
    total = np.zeros((q, q))
    for k, pairs in factors.items():
        X = some_matrix(k, *matrices[k].shape, matrices[k].symmetric)
        for L, R in pairs:
            total = total + L @ X @ R
    return _commutes(total + total.mT)


@lru_cache(64)
def some_matrix(k, rows, cols, symmetric):
    """A matrix without any structure of its own, always the same."""
    X = np.cos(1 + k + np.arange(rows * cols) ** 1.5).reshape(rows, cols)
    return X + X.T if symmetric else X


def _commutes(g):
    """Whether g has the form [[X, Y], [-Y, X]], to rounding."""
    h = g.shape[-1] // 2
    tolerance = 1e-13 * abs(g).max(axis=(-2, -1), keepdims=True)
    equal = abs(g[..., :h, :h] - g[..., h:, h:]) <= tolerance
    return bool((equal & (abs(g[..., :h, h:] + g[..., h:, :h]) <= tolerance)).all())


def fold(g):
    """X + i Y of g = [[X, Y], [-Y, X]]: the same eigenvalues at half the size."""
    h = g.shape[-1] // 2
    return g[..., :h, :h] + 1j * g[..., :h, h:]


def unfold(z):
    """The real block [[X, Y], [-Y, X]] of a Hermitian z = X + i Y."""
    rows, cols = z.shape
    g = np.empty((2 * rows, 2 * cols))
    g[:rows, :cols] = g[rows:, cols:] = z.real
    g[:rows, cols:] = z.imag
    g[rows:, :cols] = -z.imag
    return g


def _merged(pairs, symmetric):
    """Sum the L of pairs with equal R; half of each pair is its own mirror."""
    groups = {}
    for left, right in pairs:
        L, R, key = _normal(left, right)
        if symmetric and key not in groups:
            flipped = _normal(right.conj().mT, left.conj().mT)
            if flipped[2] in groups:
                L, R, key = flipped
        if key in groups:
            groups[key][0] = groups[key][0] + L / 2
        else:
            groups[key] = [L / 2, R]
    return [(L, R) for L, R in groups.values() if L.any()]


def _normal(L, R):
    """The pair with R scaled to a largest entry 1, and a key for that R."""
    flat = R.reshape(*R.shape[:-2], 1, -1)
    top = np.take_along_axis(flat, abs(flat).argmax(axis=-1, keepdims=True), axis=-1)
    top = np.where(top == 0, 1, top)  # one of several factors may be zero
    R = R / top
    if R.dtype == complex and not abs(R.imag).max() > 1e-15:
        R = R.real.copy()
    return L * top, R, (R.shape, (R.round(12) + 0.0).tobytes())


def real(z):
    """The entries of z in a row, complex ones as pairs of reals."""
    flat = z.reshape(-1)
    return flat if flat.dtype == float else flat.view(float)
