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

import numpy as np

from .stacks import gram, real, transposed

__all__ = ["Hessian"]

SLABS_FROM_ROWS = 18  # of an unknown; of smaller ones all entries at once are faster


class Hessian:
    """The matrix H_ab = sum_k <G_ka, W_k G_kb W_k>.

    Parameters
    ----------
    stacked : Stacked
        The blocks.
    """

    def __init__(self, stacked):
        self.stacked = stacked
        self.pairs = _Pairs(stacked.layouts, stacked.stacks)

    def __call__(self, roots):
        """The (k, k) matrix at W = N' N, for a list of stacks N, ``roots``."""
        stacked = self.stacked
        if not stacked.layouts:  # scalar variables only
            flat = np.hstack(
                [
                    np.sqrt(s.weight)
                    * real(N @ s.slopes @ transposed(N)).reshape(len(s.slopes), -1)
                    for s, N in zip(stacked.stacks, roots)
                ]
            )
            return flat @ flat.T
        H = np.zeros((stacked.variables,) * 2)
        self.pairs.add(H, roots)
        for s, N in zip(stacked.stacks, roots):
            if s.gradient is not None:
                g = N.item() ** 2 * s.gradient
                H += np.outer(g, g)
        if len(stacked.scalars):
            inverses = gram(roots)
        for a, index in enumerate(stacked.scalars):
            WGW = [W @ s.slopes[a] @ W for s, W in zip(stacked.stacks, inverses)]
            H[:, index] = H[index] = stacked.adjoint(WGW)
        return H


class _Pairs:
    """The Hessian of the unknown matrices as sums of Kronecker products.

    With V = [L1 L2 .. R1' R2' ..] all the small matrices of a block are
    submatrices of M = V' W V. Two of them make one Kronecker product; index
    arrays, made once for requests of one shape, say which.
    """

    def __init__(self, layouts, stacks):
        self.layouts, self.factors, plan, offset = layouts, [], [], 0
        for s in stacks:
            wide = [
                [t.left for t in p.products] + [t.right.conj().T for t in p.products]
                for p in s.blocks
            ]
            wide = [
                np.hstack(w) if w else np.zeros((k, 0)) for w, k in zip(wide, s.sizes)
            ]
            c = max(w.shape[1] for w in wide)
            V = np.zeros((len(wide), s.q, c), s.constant.dtype)
            for v, w, k in zip(V, wide, s.sizes):
                v[:k, : w.shape[1]] = w
            self.factors.append(V)
            for i, p in enumerate(s.blocks):
                plan.append(
                    (
                        tuple(t.unknown for t in p.products),
                        s.weight,
                        offset + i * c * c * s.weight,
                        c,
                    )
                )
            offset += len(wide) * c * c * s.weight
        self.jobs = _jobs(tuple(layouts), tuple(plan))

    def add(self, H, roots):
        """Add these parts of the Hessian to H."""
        flat = []
        for V, N in zip(self.factors, roots):
            white = N @ V
            flat.append(real(transposed(white) @ white))
        flat = np.concatenate(flat)
        for u, v, straight, crossed in self.jobs:
            if self.layouts[u].symmetric and self.layouts[v].symmetric:
                if self.layouts[u].rows >= SLABS_FROM_ROWS:
                    self._add_slabs(H, flat, u, v, straight)
                    continue
            a, b = self.layouts[u].rows, self.layouts[u].cols
            c, d = self.layouts[v].rows, self.layouts[v].cols
            total = _kronecker(flat, straight).reshape(b, c, d, a)
            total = total.transpose(3, 0, 1, 2)
            if crossed is not None:
                more = _kronecker(flat, crossed).reshape(b, d, c, a)
                total = total + more.transpose(3, 0, 2, 1)
            total = total.reshape(a * b, c * d)
            total = _packed(self.layouts[u], total)
            total = _packed(self.layouts[v], total.T).T
            i, j = self.layouts[u].start, self.layouts[v].start
            rows, cols = total.shape
            H[i : i + rows, j : j + cols] = total
            if u != v:
                H[j : j + cols, i : i + rows] = total.T

    def _add_slabs(self, H, flat, u, v, job):
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
        start, first = of_u.start, of_v.start
        for a in range(n):
            used = a + 1 if same else k
            slab = left[: a + 1, :used] @ right[a, :, :used]
            slab = slab.reshape(a + 1, -1)
            slab[a] /= 2  # both orders of a and b are one
            count = used * (used + 1) // 2
            i, j = c[:count], d[:count]
            rows = slab[:, i * used + j] + off[:count] * slab[:, j * used + i]
            H[start : start + a + 1, first : first + count] = rows
            start += a + 1
        at = slice(of_u.start, start), slice(first, first + of_v.size)
        if same:
            H[at] = np.tril(H[at]) + np.tril(H[at], -1).T
        else:
            H[at[::-1]] = H[at].T


@lru_cache(16)  # the same for every request of one shape
def _jobs(layouts, plan):
    """For each two unknowns the index arrays of their products."""
    jobs = []
    for u in range(len(layouts)):
        for v in range(u, len(layouts)):
            first, second = u, v
            if layouts[v].symmetric and not layouts[u].symmetric:
                first, second = v, u
            straight, crossed = _job(layouts, first, second, plan)
            if straight is not None:
                jobs.append((first, second, straight, crossed))
    return jobs


def _job(layouts, u, v, plan):
    """Indices of both Kronecker products: with vec(dY), and with vec(dY')."""
    straight, crossed = [], []
    for products, weight, base, c in plan:
        lefts, rights = _columns(layouts, products)
        for s, t in product(range(len(products)), repeat=2):
            if (products[s], products[t]) != (u, v):
                continue

            def at(rows, cols, base=base, c=c, weight=weight):
                return base + (rows[:, None] * c + cols) * weight

            Ls, Rs, Lt, Rt = lefts[s], rights[s], lefts[t], rights[t]
            terms = [(straight, at(Rs, Lt), at(Rt, Ls))]
            if layouts[u].symmetric:  # dX may be transposed
                terms.append((straight, at(Lt, Ls).T, at(Rs, Rt).T))
            else:
                terms.append((crossed, at(Rs, Rt), at(Lt, Ls)))
            for entries, A, B in terms:
                A, B = A.ravel(), B.ravel()
                entries.append((A, B, 2.0 * weight))
                if weight == 2:  # an imaginary part follows its real one
                    entries.append((A + 1, B + 1, -2.0 * weight))
    return _arrays(straight), _arrays(crossed)


def _columns(layouts, products):
    """Columns of the left and the right factors within V."""
    widths = [layouts[k].rows for k in products]
    widths += [layouts[k].cols for k in products]
    ends = np.cumsum([0, *widths])
    spans = [np.arange(i, j) for i, j in zip(ends, ends[1:])]
    return spans[: len(products)], spans[len(products) :]


def _arrays(entries):
    if not entries:
        return None
    A, B, weights = zip(*entries)
    return np.array(A), np.array(B), np.array(weights)[:, None]


def _kronecker(flat, job):
    A, B, weights = job
    return (flat[A] * weights).T @ flat[B]


def _packed(layout, rows):
    """Rows for an unknown's free entries: mirrored ones are added up."""
    if not layout.symmetric:
        return rows
    i, j, off = layout.lower
    n = layout.rows
    return rows[i * n + j] + off[:, None] * rows[j * n + i]
