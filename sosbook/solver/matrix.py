"""Newton's matrix: dense, or an arrow of independent unknowns and a shared border.

With a slack matrix each vertex of a plant has a Lyapunov matrix of its own, and no
block holds two of them. So Newton's matrix has a block for each on its diagonal, a
border of the unknowns that many blocks hold, and zeros elsewhere:

    H = [[A, B], [B', C]] + U U',    A = diag(A_1, A_2, ...).

The few columns of U are those of a ball and of a row. With A_i = L_i L_i' and
[X Y] = inv(L) [B U_1], elimination leaves the border

    S = C - X' X + T inv(M) T',    T = U_2 - X' Y,    M = I + Y' Y.

That is Cholesky's method in an order without fill, and as accurate; its time grows
with the number of leaves A_i, not with its cube.
"""

import numpy as np
from scipy.linalg.blas import dsyr, dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf, dpotrs, dtrtrs


class _Matrix:
    """A matrix with the diagonals of all ``squares`` on its own."""

    def add_diagonal(self, number):
        """Add ``number`` times I."""
        for matrix in self.squares:
            own = diagonal(matrix)
            own += number

    def fill_empty(self):
        """Put ones on the diagonal where no block wrote anything.

        Raises LinAlgError if a diagonal entry is negative or no number.
        """
        for matrix in self.squares:
            own = diagonal(matrix)
            own[own == 0] = 1.0
            if not own.min(initial=1.0) > 0:
                raise np.linalg.LinAlgError("the Hessian isn't positive definite")


class Dense(_Matrix):
    """A symmetric (k, k) array ``entries``, of which the triangle above is read."""

    def __init__(self, entries):
        self.entries = entries
        self.squares = [entries]

    def clear(self):
        """Write zeros everywhere: large arrays take long to be made."""
        self.entries.fill(0)

    def part(self, u, v):
        """Where derivatives by two unknowns of layouts ``u``, ``v`` are written."""
        if u.start > v.start:
            return self.part(v, u).T
        rows, cols = u.start + u.size, v.start + v.size
        return self.entries[u.start : rows, v.start : cols]

    def write_column(self, index, column):
        """Write a whole (k,) ``column`` at an ``index``, and its mirror."""
        self.entries[:index, index] = column[:index]
        self.entries[index, index:] = column[index:]

    def add_square(self, g):
        """Add g g', for a (k,) array ``g``."""
        dsyr(1.0, g, lower=1, a=self.entries.T, overwrite_a=1)

    def copy(self):
        """Another one with the same entries."""
        return Dense(self.entries.copy())

    def whole(self):
        """The (k, k) array with both triangles."""
        return _mirrored(self.entries)

    def factor(self, ridge):
        """A function that solves H d = g, or None; the factor takes the matrix's place.

        The diagonal grows by ``ridge``, a fraction.
        """
        own = diagonal(self.entries)
        own *= 1 + ridge
        factor = cholesky(self.entries)
        if factor is None:
            return None
        return lambda g, tolerance=None: dpotrs(factor, g, lower=1)[0]


def diagonal(matrix):
    """The diagonal of a square ``matrix``, to be written to."""
    return np.einsum("ii->i", matrix)


def cholesky(matrix):
    """The lower factor of a ``matrix``, or None.

    It takes the place of the triangle above the diagonal: LAPACK reads columns.
    """
    factor, failed = dpotrf(matrix.T, lower=1, clean=0, overwrite_a=1)
    return None if failed else factor


FEWEST_LEAVES = 2


class Arrow:
    """Which variables of ``stacked`` belong to a leaf, and which to the border.

    ``leaf`` has each unknown matrix's leaf, or -1: the border, where scalars are, too.
    Of the leaves ``sizes`` and ``inner`` variables, one after the other, those of the
    ``border``, and in ``places`` from an unknown's start its leaf, and where it begins
    there.
    """

    def __init__(self, stacked, leaf):
        """Number the variables of the leaves and of the border."""
        self.variables, self.places = stacked.variables, {}
        self.sizes = [0] * (max(leaf) + 1)
        members, border = [[] for _ in self.sizes], [stacked.scalars]
        inside = len(stacked.scalars)
        for u, k in zip(stacked.layouts, leaf):
            own = np.arange(u.start, u.start + u.size)
            if k < 0:
                self.places[u.start] = -1, inside
                border.append(own)
                inside += u.size
            else:
                self.places[u.start] = k, self.sizes[k]
                members[k].append(own)
                self.sizes[k] += u.size
        self.inner = np.concatenate([own for some in members for own in some])
        self.border = np.concatenate(border)

    @property
    def entries(self):
        """How many numbers its matrix takes."""
        inner, border = len(self.inner), len(self.border)
        return sum(s * s for s in self.sizes) + (inner + border) * border

    @property
    def products(self):
        """How many products of numbers its factor takes."""
        inner, border = len(self.inner), len(self.border)
        leaves = sum(s**3 / 3 + s * s * border for s in self.sizes)
        return leaves + inner * border**2 + border**3 / 3


class ArrowMatrix(_Matrix):
    """A symmetric matrix of an ``arrow``, written part by part like a `Dense`.

    ``parts``: the leaves' entries in a row, the border beside them, the corner;
    ``columns``: those of U. Of leaves and corner the triangle above is read.
    """

    def __init__(self, arrow, parts=None, columns=()):
        self.arrow, self.columns = arrow, list(columns)
        inner, border = len(arrow.inner), len(arrow.border)
        if parts is None:
            own = sum(s * s for s in arrow.sizes)
            parts = np.zeros(own), np.zeros((inner, border)), np.zeros((border,) * 2)
        self.parts = self.own, self.beside, self.corner = parts
        self.leaves, self.spans, at, row = [], [], 0, 0
        for s in arrow.sizes:
            self.leaves.append(self.own[at : at + s * s].reshape(s, s))
            self.spans.append(slice(row, row + s))
            at, row = at + s * s, row + s
        self.squares = [*self.leaves, self.corner]

    def clear(self):
        """As `Dense.clear`."""
        for part in self.parts:
            part.fill(0)
        self.columns = []

    def part(self, u, v):
        """As `Dense.part`, for ``u`` and ``v``."""
        (k, i), (m, j) = self.arrow.places[u.start], self.arrow.places[v.start]
        if (k < 0, i) > (m < 0, j):
            return self.part(v, u).T
        if k < 0:
            home = self.corner
        else:
            home = self.leaves[k] if m == k else self.beside[self.spans[k]]
        return home[i : i + u.size, j : j + v.size]

    def write_column(self, index, column):
        """Write a whole (k,) ``column``; its ``index`` belongs to the border."""
        (at,) = np.flatnonzero(self.arrow.border == index)
        self.beside[:, at] = column[self.arrow.inner]
        self.corner[:, at] = self.corner[at] = column[self.arrow.border]

    def add_square(self, g):
        """Add g g', for a (k,) array ``g``, as one more column of U."""
        self.columns.append(g)

    def copy(self):
        """As `Dense.copy`."""
        return ArrowMatrix(self.arrow, [p.copy() for p in self.parts], self.columns)

    def whole(self):
        """As `Dense.whole`."""
        k, inner, border = self.arrow.variables, self.arrow.inner, self.arrow.border
        H = np.zeros((k, k))
        for leaf, span in zip(self.leaves, self.spans):
            H[np.ix_(inner[span], inner[span])] = _mirrored(leaf)
        H[np.ix_(inner, border)] = self.beside
        H[np.ix_(border, inner)] = self.beside.T
        H[np.ix_(border, border)] = _mirrored(self.corner)
        return H + sum(np.outer(g, g) for g in self.columns)

    def factor(self, ridge):
        """As `Dense.factor`, where the diagonal grows by a ``ridge``."""
        inner, border = self.arrow.inner, self.arrow.border
        U = np.array(self.columns).reshape(-1, self.arrow.variables).T
        self._raise(ridge, (U * U).sum(axis=1))
        XY = np.hstack([self.beside, U[inner]])
        factors = []
        for leaf, span in zip(self.leaves, self.spans):
            L = cholesky(leaf)
            if L is None:
                return None
            factors.append(L)
            dtrsm(1.0, L, XY[span].T, side=1, lower=1, trans_a=1, overwrite_b=1)
        b, squares = len(border), _mirrored(dsyrk(1.0, XY.T))
        S, M, T = self.corner - squares[:b, :b], None, U[border] - squares[:b, b:]
        if self.columns:
            M = cholesky(np.eye(len(self.columns)) + squares[b:, b:])
            half = dtrtrs(M, T.T, lower=1)[0]
            S += half.T @ half
        S = cholesky(S)
        return None if S is None else _Solver(self, factors, XY, M, T, S)

    def _raise(self, ridge, squares):
        """Let the diagonal grow, with the ``squares`` that U adds to it."""
        more = ridge * squares[self.arrow.inner]
        for leaf, span in zip(self.leaves, self.spans):
            own = diagonal(leaf)
            own += ridge * own + more[span]
        own = diagonal(self.corner)
        own += ridge * (own + squares[self.arrow.border])


class _Solver:
    """The solution of H d = g by the factors of an `ArrowMatrix`."""

    def __init__(self, matrix, factors, XY, M, T, S):
        self.arrow, self.spans, self.factors = matrix.arrow, matrix.spans, factors
        self.XY, self.M, self.T, self.S = XY, M, T, S

    def __call__(self, g, tolerance=None):
        """The d, a (k,) array; the ``tolerance`` isn't needed."""
        inner, border = self.arrow.inner, self.arrow.border
        y, b = self._leaves(g[inner], 0), len(border)
        left = self.XY.T @ y
        right, w = g[border] - left[:b], left[b:]
        if self.M is not None:
            w = dpotrs(self.M, w, lower=1)[0]
            right = right - self.T @ w
        d = np.empty_like(g)
        d[border] = outer = dpotrs(self.S, right, lower=1)[0]
        if self.M is not None:
            w = w + dpotrs(self.M, self.T.T @ outer, lower=1)[0]
        d[inner] = self._leaves(y - self.XY @ np.append(outer, w), 1)
        return d

    def _leaves(self, g, transposed):
        """inv(L) g, or inv(L') g."""
        y = np.empty_like(g)
        for L, span in zip(self.factors, self.spans):
            y[span] = dtrtrs(L, g[span], lower=1, trans=transposed)[0]
        return y


def leaves(held, count):
    """Leaves of ``count`` things that share no block, for one border after another.

    What shares blocks with many others belongs to the border; how many is too many, the
    caller finds out. ``held``: the indices that each block holds. Yields a (count,)
    array: the leaf of each, 0, 1, ..., or -1 for the border. What no block holds is a
    leaf.

    >>> [leaf.tolist() for leaf in leaves([{0, 1}, {1, 2}, {1, 3}], 5)]
    [[0, -1, 1, 2, 3], [0, 0, 0, 0, 1]]
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    pairs = [(k, thing) for k, some in enumerate(held) for thing in some]
    places = np.array(pairs, int).reshape(-1, 2).T
    shape = len(held), count
    holds = csr_array((np.ones(len(pairs)), tuple(places)), shape=shape)
    shared = (holds.T @ holds).tocsr()
    others = np.diff(shared.indptr)
    for most in np.unique(others[others > 0]):
        inner = np.flatnonzero(others <= most)
        leaf = np.full(count, -1)
        leaf[inner] = connected_components(shared[inner][:, inner])[1]
        yield leaf


def arrow_of(stacked):
    """The `Arrow` of a `Stacked`, ``stacked``; None where a `Dense` is as good.

    An unknown that shares blocks with many others belongs to the border. How many is
    too many is tried out; the factor must take half of the products or less.
    """
    count, fewest = len(stacked.layouts), stacked.settings.arrow_from_variables
    if count <= FEWEST_LEAVES or stacked.variables < fewest:
        return None
    blocks = (b for s in stacked.stacks for b in s.blocks)
    held = [{t.unknown for t in b.products} for b in blocks]
    best, least = None, stacked.variables**3 / 6
    for leaf in leaves(held, count):
        arrow = Arrow(stacked, leaf)
        if len(arrow.sizes) >= FEWEST_LEAVES and len(arrow.border):
            if arrow.products < least:
                best, least = arrow, arrow.products
    return best


def _mirrored(upper):
    """A matrix with the triangle above the diagonal on both sides."""
    return np.triu(upper) + np.triu(upper, 1).T
