"""The structure of LMI blocks: G(X) = C + sum of (L X R + its transpose).

General cones forget that the unknowns are matrices. Here they stay
matrices: the few factors L and R of each block are all that Newton's
method needs to know.
"""

from dataclasses import dataclass, replace

from functools import lru_cache

import numpy as np

__all__ = ["Part", "Product", "Slot", "structure", "unfold"]


@dataclass(frozen=True)
class Slot:
    """Where an unknown matrix lies in the vector of all variables."""

    start: int
    rows: int
    cols: int
    symmetric: bool

    @property
    def size(self):
        if self.symmetric:
            return self.rows * (self.rows + 1) // 2
        return self.rows * self.cols

    @property
    def lower(self):
        """Rows and columns of the free entries, off the diagonal or on."""
        return _lower(self.rows)

    def matrix(self, x):
        """The unknown's matrix in a vector of all variables."""
        part = x[self.start:self.start + self.size]
        if not self.symmetric:
            return part.reshape(self.rows, self.cols)
        X = np.empty((self.rows, self.rows))
        i, j, _ = self.lower
        X[i, j] = X[j, i] = part
        return X

    def gradient(self, X):
        """Derivatives by the variables, from those by the entries."""
        if not self.symmetric:
            return X.ravel()
        i, j, off = self.lower
        return X[i, j] + off * X[j, i]


@lru_cache(64)
def _lower(n):
    i, j = np.tril_indices(n)
    return i, j, (i != j).astype(float)


@dataclass(frozen=True, eq=False)
class Product:
    """The terms ``left @ X @ right`` and its conjugate transpose."""

    slot: int
    left: np.ndarray
    right: np.ndarray


@dataclass(frozen=True, eq=False)
class Part:
    """One block: a constant, products, and slopes of single variables.

    Parameters
    ----------
    constant : (q, q) array
    products : list of Product
    slopes : (s, q, q) array
        Derivatives by the ``s`` variables that are numbers.
    weight : int
        2 where a complex Hermitian block stands for the real one of
        twice its size, which has each eigenvalue twice.
    """

    constant: np.ndarray
    products: list
    slopes: np.ndarray
    weight: int = 1

    def joined(self, slope):
        """With the slope of one more number, given for the real block."""
        slope = _fold(slope) if self.weight == 2 else slope
        slopes = np.concatenate([self.slopes, slope[None]])
        return replace(self, slopes=slopes)

    def with_constant(self, constant):
        """With another constant, given for the real block."""
        if self.weight == 2:
            constant = _fold(constant)
        return replace(self, constant=constant)

    def sizes(self, slots):
        """What each diagonal entry of the real block may amount to."""
        squares = (np.diagonal(self.slopes, axis1=1, axis2=2).real**2).sum(0)
        for k, slot in enumerate(slots):
            pairs = [
                (t.left, t.right.T) for t in self.products if t.slot == k]
            squares += 4 * _row_squares(pairs, slot.symmetric)
        size = np.abs(np.diag(self.constant)) + np.sqrt(squares)
        return np.concatenate([size, size]) if self.weight == 2 else size


def _row_squares(pairs, symmetric):
    """For each row r: sum of squares of the entries of Re sum L_r' R_r.

    For a symmetric unknown, of what each free entry multiplies.
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
    """Slots, the places of the numbers among the variables, parts.

    Returns
    -------
    slots : list of Slot
    numbers : (s,) array of int
    parts : list of Part
    """
    slots, numbers, matrices, start = [], [], [], 0
    for u in unknowns:
        if u.shape == (1, 1):
            numbers.append(start)
        else:
            slots.append(Slot(start, *u.shape, u.symmetric))
            matrices.append(u)
        start += u.size
    single = [u for u in unknowns if u.shape == (1, 1)]
    parts = [_part(g, matrices, single) for g in expressions]
    return slots, np.array(numbers, int), parts


def _part(g, matrices, single):
    q = len(g.constant)
    constant = g.constant.astype(float)
    slopes = np.array([g.jacobian(u)[0] for u in single], float)
    slopes = slopes.reshape(-1, q, q)
    factors = [_factors(g, u) for u in matrices]
    weight = 1
    if _is_hermitian(constant, slopes, factors, matrices):
        constant, slopes, weight = _fold(constant), _fold(slopes), 2
        h = q // 2
        factors = [
            [(L[:h], R[:, :h] + 1j * R[:, h:]) for L, R in pairs]
            for pairs in factors
        ]
        factors = [[(L, R) for L, R in p if L.any()] for p in factors]
    products = [
        Product(k, L, R)
        for k, (pairs, u) in enumerate(zip(factors, matrices))
        for L, R in _merged(pairs, u.symmetric)
    ]
    return Part(constant, products, slopes, weight)


def _factors(g, unknown):
    """(L, R) of the terms in an unknown, the transposed ones flipped.

    Those with the same R are one, with the sum of their L.
    """
    found = {}
    for t in g.terms:
        if t.unknown is unknown:
            L, R = np.asarray(t.left, float), np.asarray(t.right, float)
            if t.transposed:
                L, R = R.T, L.T
            key = R.tobytes()
            found[key] = (found[key][0] + L, R) if key in found else (L, R)
    return [(L, R) for L, R in found.values() if L.any() and R.any()]


def _is_hermitian(constant, slopes, factors, matrices):
    """Whether the block is [[X, Y], [-Y, X]] whatever the unknowns are."""
    q = len(constant)
    if q % 2 or not all(_commutes(g) for g in (constant, *slopes)):
        return False
    total = np.zeros((q, q))
    for k, (pairs, u) in enumerate(zip(factors, matrices)):
        X = _some_matrix(k, *u.shape, u.symmetric)
        for L, R in pairs:
            total += L @ X @ R
    return _commutes(total + total.T)


@lru_cache(64)
def _some_matrix(k, rows, cols, symmetric):
    """One without any structure of its own."""
    X = np.cos(1 + k + np.arange(rows * cols) ** 1.5).reshape(rows, cols)
    return X + X.T if symmetric else X


def _commutes(g):
    h = len(g) // 2
    size = 1e-13 * abs(g).max()
    return (
        abs(g[:h, :h] - g[h:, h:]).max() <= size
        and abs(g[:h, h:] + g[h:, :h]).max() <= size
    )


def _fold(g):
    h = g.shape[-1] // 2
    return g[..., :h, :h] + 1j * g[..., :h, h:]


def unfold(z):
    """The real block of a Hermitian one."""
    return np.block([[z.real, z.imag], [-z.imag, z.real]])


def _merged(pairs, symmetric):
    """Sum the lefts of equal rights; half of each is its own mirror."""
    groups = {}
    for L, R in pairs:
        L, R, key = _normal(L, R)
        if symmetric and key not in groups:
            flipped = _normal(R.conj().T, L.conj().T)
            if flipped[2] in groups:
                L, R, key = flipped
        if key in groups:
            groups[key][0] = groups[key][0] + L / 2
        else:
            groups[key] = [L / 2, R]
    return [(L, R) for L, R in groups.values() if L.any()]


def _normal(L, R):
    """The right factor with a largest entry 1, and a key to find it."""
    flat = R.ravel()
    top = flat[abs(flat).argmax()]
    R = R / top
    if R.dtype == complex and not abs(R.imag).max() > 1e-15:
        R = R.real.copy()
    return L * top, R, (R.shape, (R.round(12) + 0.0).tobytes())
