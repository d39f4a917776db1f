"""The dense Hessian of the barrier: sums of Kronecker products.

The Hessian of -sum log det G_k(x) at inverse blocks W_k has the entries H_ab = sum_k
<G_ka, W_k G_kb W_k> (Boyd and Vandenberghe 2004, appendix A.4.3: the second derivative
of log det). In Nesterov and Todd's method W is the scaling point instead, and the same
matrix is the Schur complement of Newton's equations (Todd, Toh and Tütüncü 1998).

A block's change is a few products with their transposes. For two of them,
dG = L dX R + R' dX' L' and dF = M dY S + S' dY' M', with vec the rows of a
matrix one after the other,

    <dG, W dF W> = 2 vec(dX)' [(L' W M) kron (R W S')] vec(dY)
                 + 2 vec(dX)' [(L' W S') kron (R W M)] vec(dY'),

so that only the small matrices L' W M, R W S', L' W S' and R W M are needed.
General cones form W G_kb W for every variable b, which is many times as much.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import groupby, product
from typing import NamedTuple

import numpy as np

from .matrix import Dense
from .stacks import gram
from .structure import Product

#: Newton's matrix is made of a dense table of slopes of at most so many entries for
#: each two unknowns that share a block, else of Kronecker products. A machine's number.
TABLE_PER_PAIR = 10_000


class Hessian:
    """The matrix H_ab = sum_k <G_ka, W_k G_kb W_k> of the blocks ``stacked``.

    With V = [L1 R1' L2 R2' ..] all the small matrices of a block are submatrices of M =
    V' W V, and two make a Kronecker product. It is written to ``matrix`` each time, a
    `Dense` without one.
    """

    def __init__(self, stacked, matrix=None):
        """Plan the products of all pairs of unknowns, once for all points."""
        self.stacks, self.scalars = stacked.stacks, stacked.scalars
        self.matrix, self.adjoint = matrix, stacked.values.adjoint
        self.slabs_from = stacked.settings.slabs_from_rows
        self.layouts, self.forms, plan = stacked.layouts, [], []
        for k, s in enumerate(self.stacks):
            for some in alike(s.blocks):
                if some.products:
                    V, starts = _distinct(some, s.q)
                    self.forms.append((k, sliced(some.indices), V))
                    unknowns = tuple(t.unknown for t in some.products)
                    plan.append((unknowns, starts, V.shape[2]))
        self.pairs = _pairs(tuple(self.layouts), tuple(plan))
        self.slopes = None  # all of them, where few products are faster than many calls
        if not self.layouts:
            self.slopes = [s.slopes for s in self.stacks]
        elif matrix is None and stacked.table_entries <= (
            TABLE_PER_PAIR * len(self.pairs)
        ):
            self.slopes = stacked.values.slopes()
        if self.layouts:
            k = stacked.variables
            self.matrix = Dense(np.empty((k, k))) if matrix is None else matrix

    def __call__(self, roots):
        """The (k, k) matrix at W = N' N, for a list of stacks N, ``roots``."""
        return self.upper(roots).whole()

    def upper(self, roots):
        """The same for ``roots``, a `Dense` or `ArrowMatrix`, in one place."""
        if self.slopes is not None:  # N G_a N' are the rows of F in H = F F'
            flat = [
                (N @ s @ N.mT).reshape(len(s), -1) for s, N in zip(self.slopes, roots)
            ]
            F = np.hstack(flat)
            return Dense(F @ F.T)
        H, of = self.matrix, self.layouts
        H.clear()
        grams = gram([roots[k][blocks] @ V for k, blocks, V in self.forms])
        flat = [M.reshape(len(M), -1) for M in grams]
        for (u, v), (straight, crossed) in self.pairs.items():
            part = H.part(of[u], of[v])
            large = of[u].symmetric and of[v].symmetric
            if large and of[u].rows >= self.slabs_from:
                self._write_slabs(part, grams, u, v, straight.terms)
            else:
                part[...] = _at_once(flat, of[u], of[v], straight, crossed)
        for s, N in zip(self.stacks, roots):
            if s.gradient is not None:
                H.add_square(N.item() ** 2 * s.gradient)
        if len(self.scalars):
            inverses = gram(roots)
        for a, index in enumerate(self.scalars):
            WGW = [W @ s.slopes[a] @ W for s, W in zip(self.stacks, inverses)]
            H.write_column(index, self.adjoint(WGW))
        return H

    def _write_slabs(self, part, grams, u, v, terms):
        """The part of two symmetric unknowns, in its place from the beginning.

        An entry for dX_ab and dY_cd is the sum of four A_bc B_da, which differ
        by the order of a and b, and of c and d. For each a a product of two
        matrices has those of all b <= a; of one unknown with itself only those
        of c <= a are needed, for H is symmetric.
        """
        of_u, of_v = self.layouts[u], self.layouts[v]
        n, k, same = of_u.rows, of_v.rows, u == v
        A, B = map(np.concatenate, zip(*(t.vectors(grams) for t in terms)))
        A, B = 2 * A.reshape(-1, n, k), B.reshape(-1, k, n)
        left = np.concatenate([A.transpose(1, 2, 0), B.transpose(2, 1, 0)], axis=2)
        right = np.concatenate([B.transpose(2, 0, 1), A.transpose(1, 0, 2)], axis=1)
        c, d, off = of_v.lower
        start = 0
        for a in range(n):
            used = a + 1 if same else k
            slab = left[: a + 1, :used] @ right[a, :, :used]
            slab = slab.reshape(a + 1, -1)
            slab[a] /= 2  # both orders of a and b are one
            count = used * (used + 1) // 2
            i, j = c[:count], d[:count]
            rows = slab[:, i * used + j] + off[:count] * slab[:, j * used + i]
            if same:  # what lies below H's diagonal isn't read
                part[:count, start : start + a + 1] = rows.T
            else:
                part[start : start + a + 1, :count] = rows
            start += a + 1


def _at_once(flat, of_u, of_v, straight, crossed):
    """The part of two unknowns from the Kronecker products of all entries: for dX_ab
    and dY_cd those of (b, c), (d, a) with vec(dY), and (b, d), (c, a) with vec(dY').
    """
    a, b, c, d = of_u.rows, of_u.cols, of_v.rows, of_v.cols
    total = straight.of(flat)
    total = total.reshape(b, c, d, a).transpose(3, 0, 1, 2)
    if crossed.terms:
        more = crossed.of(flat).reshape(b, d, c, a)
        total = total + more.transpose(3, 0, 2, 1)
    total = _packed(of_u, total.reshape(a * b, c * d))
    return _packed(of_v, total.T).T


@lru_cache(16)  # the same for every request of one shape
def _pairs(layouts, plan):
    """The terms of both Kronecker products: with vec(dY), and with vec(dY').

    Two `_Sum` for each two unknowns that share a block, a symmetric one first.
    """
    found = {}
    for k, (products, starts, _) in enumerate(plan):
        factors = [*zip(products, *_columns(layouts, products, starts))]
        for (u, Ls, Rs), (v, Lt, Rt) in product(factors, repeat=2):
            if (not layouts[u].symmetric, u) > (not layouts[v].symmetric, v):
                continue
            straight, crossed = found.setdefault((u, v), ([], []))
            straight.append(_Term(k, (Rs, Lt), (Rt, Ls), False))
            if layouts[u].symmetric:  # dX may be transposed
                straight.append(_Term(k, (Lt, Ls), (Rs, Rt), True))
            else:
                crossed.append(_Term(k, (Rs, Rt), (Lt, Ls), False))
    widths = [width for *_, width in plan]
    return {k: tuple(_Sum(t, widths) for t in found[k]) for k in sorted(found)}


class _Term(NamedTuple):
    """A product A kron B of submatrices of M = V' W V, for blocks of one form.

    ``form`` is an index of the plan; ``transposed``: the transposes of both are meant.
    """

    form: int
    A: tuple
    B: tuple
    transposed: bool

    def vectors(self, grams):
        """vec(A) and vec(B) of each block by rows; the same array where A is B."""
        M = grams[self.form]
        A = self._vectors(M[:, *self.A])
        B = A if self.A == self.B else self._vectors(M[:, *self.B])
        return A, B

    def places(self, width):
        """The same as places in M's entries by rows, of ``width`` columns."""
        M = np.arange(width * width).reshape(1, width, width)
        return self.vectors({self.form: M})

    def _vectors(self, some):
        some = some.mT if self.transposed else some
        return some.reshape(len(some), -1)


class _Sum:
    """The sum of ``terms``, of each form of blocks all factors at once by their places
    in M, of ``widths`` columns; A kron A takes half of the time of two factors.
    """

    def __init__(self, terms, widths):
        self.terms, self.widths = terms, widths

    @cached_property
    def places(self):
        """[(form, A's)] of squares, and those of the A and of the B of the others."""
        squares, left, right = [], [], []
        for form, some in groupby(self.terms, lambda t: t.form):
            places = [t.places(self.widths[form]) for t in some]
            for to, found in (
                (squares, [A for A, B in places if A is B]),
                (left, [A for A, B in places if A is not B]),
                (right, [B for A, B in places if A is not B]),
            ):
                if found:
                    to.append((form, np.concatenate(found)))
        return squares, left, right

    def of(self, flat):
        """The sum, from each form's M as rows, ``flat``."""
        squares, left, right = self.places
        total = 0.0
        if squares:
            A = _taken(flat, squares)
            total = A.T @ A
        if left:
            total = total + _taken(flat, left).T @ _taken(flat, right)
        return 2 * total


def _taken(flat, places):
    """The entries of M at ``places``, (form, array), below one another."""
    rows = [
        flat[form].take(at, 1).swapaxes(0, 1).reshape(-1, at.shape[1])
        for form, at in places
    ]
    return rows[0] if len(rows) == 1 else np.concatenate(rows)


def _distinct(some, q):
    """The different L1, R1', L2, R2', .. side by side, and where each begins.

    They have q rows, zero where a block is padded. Most are rows of an identity.
    """
    columns, width, found, starts = [], 0, {}, []
    for t in some.products:
        for factor in (t.left, t.right.mT):
            key = factor.shape, factor.dtype.char, factor.tobytes()
            if key not in found:
                found[key] = width
                columns.append(factor)
                width += factor.shape[2]
            starts.append(found[key])
    V, at = np.zeros((len(some.indices), q, width)), 0
    for factor in columns:
        V[:, : factor.shape[1], at : at + factor.shape[2]] = factor
        at += factor.shape[2]
    return V, tuple(starts)


def _columns(layouts, products, starts):
    """Columns of the left and the right factors within V."""
    widths = [n for k in products for n in (layouts[k].rows, layouts[k].cols)]
    spans = [slice(i, i + n) for i, n in zip(starts, widths)]
    return spans[::2], spans[1::2]


def _packed(layout, rows):
    """Rows for an unknown's free entries: mirrored ones are added up."""
    if not layout.symmetric:
        return rows
    i, j, off = layout.lower
    n = layout.rows
    return rows[i * n + j] + off[:, None] * rows[j * n + i]


@dataclass(frozen=True, eq=False)
class Alike:
    """Those ``indices`` of b blocks whose ``products`` have the same unknowns and
    shapes: factors (b, rows, columns), or (1, ...) where all are the same.
    """

    indices: np.ndarray
    products: list


def alike(blocks):
    """The `Alike` of some ``blocks``, a list; each block is in one of them."""
    forms = {}
    for index, b in enumerate(blocks):
        form = tuple(
            (t.unknown, t.left.shape, t.left.dtype, t.right.shape, t.right.dtype)
            for t in b.products
        )
        forms.setdefault(form, []).append(index)
    found = []
    for indices in forms.values():
        products = zip(*(blocks[i].products for i in indices))
        found.append(Alike(np.array(indices), [_together(some) for some in products]))
    return found


def _together(products):
    """Products of the same shapes as one."""
    left, right = (
        _array([getattr(t, side) for t in products]) for side in ("left", "right")
    )
    return Product(products[0].unknown, left, right)


def _array(matrices):
    """Matrices of one shape as an array; of equal ones the first."""
    first = matrices[0]
    if all(m is first for m in matrices):
        return first[None]
    array = np.array(matrices)
    return array[:1] if (array[1:] == first).all() else array


def sliced(indices):
    """A slice of these ``indices`` where no other is between them."""
    if (np.diff(indices) == 1).all():
        return slice(int(indices[0]), int(indices[-1]) + 1)
    return indices
