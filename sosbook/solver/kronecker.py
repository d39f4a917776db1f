"""The dense Hessian of the barrier: sums of Kronecker products.

The Hessian of -sum log det G_k(x) at inverse blocks W_k has the entries
H_ab = sum_k <G_ka, W_k G_kb W_k> (Boyd and Vandenberghe 2004, appendix A.4.3:
the second derivative of log det). In Nesterov and Todd's method W is the
scaling point instead, and the same matrix is the Schur complement of Newton's
equations (Todd, Toh and Tütüncü 1998).

A block's change is a few products with their transposes. For two of them,
dG = L dX R + R' dX' L' and dF = M dY S + S' dY' M', with vec the rows of a
matrix one after the other,

    <dG, W dF W> = 2 vec(dX)' [(L' W M) kron (R W S')] vec(dY)
                 + 2 vec(dX)' [(L' W S') kron (R W M)] vec(dY'),

so that only the small matrices L' W M, R W S', L' W S' and R W M are needed.
General cones form W G_kb W for every variable b, which is many times as much.
"""

from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from .dense import Dense
from .stacks import gram, transposed
from .structure import real
from .sums import sliced

__all__ = ["Hessian"]

SLABS_FROM_ROWS = 18  # of an unknown; of smaller ones all entries at once are faster
FEW_TERMS = 0.5  # as a fraction of an unknown's entries; of more all are faster, too
BATCH_ENTRIES = 60_000  # of the Kronecker products that are made together: half a MB


class Hessian:
    """The matrix H_ab = sum_k <G_ka, W_k G_kb W_k>.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    matrix : Dense or ArrowMatrix, optional
        What it is written to each time; without it a `Dense`.
    """

    def __init__(self, stacked, matrix=None):
        self.stacks, self.scalars = stacked.stacks, stacked.scalars
        self.matrix, self.adjoint = matrix, stacked.values.adjoint
        self.pairs = _Pairs(stacked.layouts, stacked.stacks)
        if stacked.layouts:
            k = stacked.variables
            self.matrix = Dense(np.empty((k, k))) if matrix is None else matrix

    def __call__(self, roots):
        """The (k, k) matrix at W = N' N, for a list of stacks N, ``roots``."""
        return self.upper(roots).whole()

    def upper(self, roots):
        """The same for ``roots``, as a `Dense` or an `ArrowMatrix`.

        It stands in one place each time: large arrays take long to be made.
        """
        if not self.pairs.layouts:  # scalar variables only
            flat = np.hstack(
                [
                    np.sqrt(s.weight)
                    * real(N @ s.slopes @ transposed(N)).reshape(len(s.slopes), -1)
                    for s, N in zip(self.stacks, roots)
                ]
            )
            return Dense(flat @ flat.T)
        H = self.matrix
        H.clear()
        self.pairs.add(H, roots)
        for s, N in zip(self.stacks, roots):
            if s.gradient is not None:
                H.add_square(N.item() ** 2 * s.gradient)
        if len(self.scalars):
            inverses = gram(roots)
        for a, index in enumerate(self.scalars):
            WGW = [W @ s.slopes[a] @ W for s, W in zip(self.stacks, inverses)]
            H.write_column(index, self.adjoint(WGW))
        return H


class _Pairs:
    """The Hessian of the unknown matrices as sums of Kronecker products.

    With V = [L1 R1' L2 R2' ..] all the small matrices of a block are
    submatrices of M = V' W V. Two of them make one Kronecker product; index
    arrays, made once for requests of one shape, say which.
    """

    def __init__(self, layouts, stacks):
        self.layouts, self.factors, plan, offset = layouts, [], [], 0
        self.blocks = []  # of each entry of the plan: a stack's index, and which
        for k, s in enumerate(stacks):
            found = [(some, *_distinct(some)) for some in s.alike]
            c = max(wide.shape[2] for _, wide, _ in found)
            V = np.zeros((len(s.blocks), s.q, c), s.constant.dtype)
            for some, wide, starts in found:
                V[some.indices, : wide.shape[1], : wide.shape[2]] = wide
                held = tuple(t.unknown for t in some.products)
                bases = offset + some.indices * c * c * s.weight
                plan.append((held, starts, s.weight, tuple(bases.tolist()), c))
                self.blocks.append((k, sliced(some.indices)))
            self.factors.append(V)
            offset += len(s.blocks) * c * c * s.weight
        jobs = _jobs(tuple(layouts), tuple(plan), SLABS_FROM_ROWS, BATCH_ENTRIES)
        self.slabs, self.alone, self.batches = jobs

    def add(self, H, roots):
        """Write these parts of the Hessian to H."""
        grams, of = gram([N @ V for V, N in zip(self.factors, roots)]), self.layouts
        flat = np.concatenate([real(M) for M in grams])
        some = [grams[k][blocks] for k, blocks in self.blocks]
        for u, v, job in self.slabs:
            self._write_slabs(H.part(of[u], of[v]), flat, u, v, job)
        for u, v, *jobs in self.alone:
            H.part(of[u], of[v])[...] = self._alone(some, of[u], of[v], *jobs)
        for batch in self.batches:
            for (u, v), part in zip(batch.pairs, batch.parts(flat)):
                H.part(of[u], of[v])[...] = part

    def _write_slabs(self, part, flat, u, v, job):
        """The part of two symmetric unknowns, in its place from the beginning.

        An entry for dX_ab and dY_cd is the sum of four A_bc B_da, which differ
        by the order of a and b, and of c and d. For each a a product of two
        matrices has those of all b <= a; of one unknown with itself only those
        of c <= a are needed, for H is symmetric.
        """
        of_u, of_v = self.layouts[u], self.layouts[v]
        n, k, same = of_u.rows, of_v.rows, u == v
        A, B, weights = job
        A = (flat[A] * weights).reshape(-1, n, k)
        B = flat[B].reshape(-1, k, n)
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

    def _alone(self, grams, of_u, of_v, straight, crossed):
        """The part of two other large unknowns."""
        a, b, c, d = of_u.rows, of_u.cols, of_v.rows, of_v.cols
        total = _sum_of(straight, grams)
        total = total.reshape(b, c, d, a).transpose(3, 0, 1, 2)
        if crossed:
            more = _sum_of(crossed, grams).reshape(b, d, c, a)
            total = total + more.transpose(3, 0, 2, 1)
        total = _packed(of_u, total.reshape(a * b, c * d))
        return _packed(of_v, total.T).T


class _Batch:
    """Pairs of unknowns of the same two kinds, in one product of matrices each.

    The entry for dX_ab and dY_cd is that of (b, c), (d, a) in the Kronecker product
    with vec(dY), and of (b, d), (c, a) in the one with vec(dY').
    """

    def __init__(self, layouts, pairs):
        first, second = layouts[pairs[0][0]], layouts[pairs[0][1]]
        self.pairs = [(u, v) for u, v, *_ in pairs]
        self.straight = _padded([job for *_, job, _ in pairs])
        self.crossed = None
        self.taken, self.halved = _packing(first, second)
        if pairs[0][3] is not None:
            self.crossed = _padded([job for *_, job in pairs])
            self.exchanged = _crossing(first, second)

    def parts(self, flat):
        """For each pair the derivatives by the free entries of both, a matrix."""
        straight = _kronecker(flat, self.straight)
        total = np.take(straight, self.taken[0], axis=1)
        for places in self.taken[1:]:
            total += np.take(straight, places, axis=1)
        if self.crossed is not None:
            crossed = _kronecker(flat, self.crossed)
            total += np.take(crossed, self.exchanged, axis=1)
        rows, cols = self.halved
        total[:, rows] /= 2
        total[:, :, cols] /= 2
        return total


@lru_cache(64)
def _packing(first, second):
    """Where the entries lie that become one of two unknowns' free ones, and halves.

    Mirrored entries of a symmetric unknown are added up; on its diagonal both are
    the same entry, which counts twice then.
    """
    (a, b), (c, d) = _entries(first), _entries(second)
    orders = [(a, b, c, d)]
    if first.symmetric:
        orders += [(b, a, c, d) for a, b, c, d in orders]
    if second.symmetric:
        orders += [(a, b, d, c) for a, b, c, d in orders]
    C, D, A = second.rows, second.cols, first.rows
    taken = [((b[:, None] * C + c) * D + d) * A + a[:, None] for a, b, c, d in orders]
    none = np.zeros(0, int)
    return taken, (
        np.flatnonzero(a == b) if first.symmetric else none,
        np.flatnonzero(c == d) if second.symmetric else none,
    )


@lru_cache(64)
def _crossing(first, second):
    """Where the entries of two unknowns, neither symmetric, lie with vec(dY')."""
    (a, b), (c, d) = _entries(first), _entries(second)
    C, D, A = second.rows, second.cols, first.rows
    return ((b[:, None] * D + d) * C + c) * A + a[:, None]


def _entries(layout):
    """Rows and columns of an unknown's free entries."""
    if layout.symmetric:
        return layout.lower[:2]
    return [x.ravel() for x in np.indices((layout.rows, layout.cols))]


@lru_cache(16)  # the same for every request of one shape
def _jobs(layouts, plan, slabs_from, most_entries):
    """Pairs of large symmetric unknowns, other large ones, all others in batches."""
    slabs, alone, kinds = [], [], {}
    for (first, second), (straight, crossed) in _pairs(layouts, plan).items():
        X, Y = layouts[first], layouts[second]
        few = sum(t.count(plan) for t in straight) < FEW_TERMS * X.rows**2
        if X.symmetric and Y.symmetric and X.rows >= slabs_from and few:
            slabs.append((first, second, _arrays(straight, plan)))
            continue
        if X.rows * X.cols * Y.rows * Y.cols > most_entries:
            alone.append((first, second, straight, crossed))
            continue
        kind = X.rows, X.cols, X.symmetric, Y.rows, Y.cols, Y.symmetric
        arrays = _arrays(straight, plan), _arrays(crossed, plan)
        kinds.setdefault(kind, []).append((first, second, *arrays))
    batches = []
    for (rows, cols, _, *second, _), pairs in kinds.items():
        pairs.sort(key=lambda pair: len(pair[2][0]))  # these are padded the least
        most = most_entries // (rows * cols * second[0] * second[1])
        for start in range(0, len(pairs), most):
            batches.append(_Batch(layouts, pairs[start : start + most]))
    return slabs, alone, batches


def _pairs(layouts, plan):
    """The terms of both Kronecker products: with vec(dY), and with vec(dY').

    Two lists of `_Term` for each two unknowns that share a block, a symmetric one
    first.
    """
    found = {}
    for k, (products, starts, *_) in enumerate(plan):
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
    return dict(sorted(found.items()))


class _Term(NamedTuple):
    """A product A kron B of two submatrices of M = V' W V, for all blocks of a form.

    Parameters
    ----------
    form : int
        Which blocks: an index of the plan.
    A, B : (slice, slice)
        Rows and columns.
    transposed : bool
        Whether the transposes of both are meant.
    """

    form: int
    A: tuple
    B: tuple
    transposed: bool

    def count(self, plan):
        """Of how many real products it is the sum."""
        _, _, weight, bases, _ = plan[self.form]
        return weight * len(bases)

    def indices(self, plan):
        """Where A and B stand among all M's entries, and the products' weights."""
        _, _, weight, bases, c = plan[self.form]
        places = np.arange(c * c).reshape(c, c) * weight
        A, B = (
            self._vectors(np.array(bases)[:, None, None] + places[part])
            for part in (self.A, self.B)
        )
        if weight == 2:  # an imaginary part follows its real one
            A, B = np.concatenate([A, A + 1]), np.concatenate([B, B + 1])
        signs = np.repeat([2.0 * weight, -2.0 * weight][:weight], len(bases))
        return A, B, signs

    def vectors(self, grams):
        """vec(A) and vec(B) of each block by rows, from the M of each form; a weight.

        They are the same array where A is B. Complex ones stand for two products, of
        the real parts less that of the imaginary ones.
        """
        M = grams[self.form]
        A = self._vectors(M[:, *self.A])
        B = A if self.A == self.B else self._vectors(M[:, *self.B])
        return A, B, 4.0 if M.dtype == complex else 2.0

    def _vectors(self, some):
        some = some.mT if self.transposed else some
        return some.reshape(len(some), -1)


def _sum_of(terms, grams):
    """The sum of some terms, from the M of each form.

    That of A kron A is a product of a matrix with its transpose, which takes half of
    the time.
    """
    squares, others = {1: [], -1: []}, ([], [])
    for t in terms:
        A, B, weight = t.vectors(grams)
        for sign, part in ((1, np.real), (-1, np.imag))[: 1 + np.iscomplexobj(A)]:
            if B is A:
                squares[sign].append(weight**0.5 * part(A))
            else:
                others[0].append(sign * weight * part(A))
                others[1].append(part(B))
    total = 0.0
    for sign, some in squares.items():
        if some:
            some = np.concatenate(some)
            total = total + sign * (some.T @ some)
    if others[0]:
        A, B = map(np.concatenate, others)
        total = total + A.T @ B
    return total


def _distinct(some):
    """The different ones of L1, R1', L2, R2', .. side by side, and where each begins.

    Of some blocks that are `Alike`. Most factors are rows of an identity, which many
    products share.
    """
    columns, width, found, starts = [], 0, {}, []
    for t in some.products:
        for factor in (t.left, t.right.conj().mT):
            key = factor.shape, factor.dtype.char, factor.tobytes()
            if key not in found:
                found[key] = width
                columns.append(factor)
                width += factor.shape[2]
            starts.append(found[key])
    if not columns:
        return np.zeros((1, 0, 0)), ()
    shape = len(some.indices), *columns[0].shape[1:2]
    wide = [np.broadcast_to(f, (*shape, f.shape[2])) for f in columns]
    return np.concatenate(wide, axis=2), tuple(starts)


def _columns(layouts, products, starts):
    """Columns of the left and the right factors within V."""
    widths = [n for k in products for n in (layouts[k].rows, layouts[k].cols)]
    spans = [slice(i, i + n) for i, n in zip(starts, widths)]
    return spans[::2], spans[1::2]


def _arrays(terms, plan):
    """Indices and weights of some terms, see `_kronecker`; None without any."""
    if not terms:
        return None
    A, B, weights = map(np.concatenate, zip(*(t.indices(plan) for t in terms)))
    return A, B, weights[:, None]


def _padded(jobs):
    """The jobs of several pairs as one, with weights of zero where one has less."""
    most = max(len(weights) for *_, weights in jobs)
    A, B, weights = zip(*jobs)

    def stacked(arrays):
        total = np.zeros((len(arrays), most, arrays[0].shape[1]), arrays[0].dtype)
        for part, array in zip(total, arrays):
            part[: len(array)] = array
        return total

    return stacked(A), stacked(B), stacked(weights)


def _kronecker(flat, job):
    """Sums of Kronecker products; of a batch one row for each pair."""
    A, B, weights = job
    total = (np.take(flat, A) * weights).mT @ np.take(flat, B)
    return total.reshape(*total.shape[:-2], -1)


def _packed(layout, rows):
    """Rows for an unknown's free entries: mirrored ones are added up."""
    if not layout.symmetric:
        return rows
    i, j, off = layout.lower
    n = layout.rows
    return rows[i * n + j] + off[:, None] * rows[j * n + i]
