"""The dense Hessian: sums of Kronecker products.

With inverse blocks W it is the sum over the blocks of <dG, W dG W>, and
dG is a few products L dX R: what remains are Kronecker products of the
small matrices R W L, R W R' and L' W L.
"""

from functools import lru_cache
from itertools import product

import numpy as np

from .stacks import real, transposed

__all__ = ["Hessian"]


class Hessian:
    """The matrix of <G_ka, W_k G_kb W_k> for W = N' N."""

    def __init__(self, stacked):
        self.stacked = stacked
        self.pairs = _Pairs(stacked.slots, stacked.stacks)

    def __call__(self, roots):
        stacked = self.stacked
        if not stacked.slots:  # numbers only
            flat = np.hstack([
                np.sqrt(s.weight) * real(
                    (N @ s.slopes @ transposed(N)).reshape(
                        len(s.slopes), -1))
                for s, N in zip(stacked.stacks, roots)
            ])
            return flat @ flat.T
        H = np.zeros((stacked.variables,) * 2)
        self.pairs.add(H, roots)
        if len(stacked.numbers):
            inverses = [transposed(N) @ N for N in roots]
        for a, place in enumerate(stacked.numbers):
            bent = [
                W @ s.slopes[a] @ W
                for s, W in zip(stacked.stacks, inverses)
            ]
            H[:, place] = H[place] = stacked.adjoint(bent)
        return H


class _Pairs:
    """The Hessian of the unknown matrices as sums of Kronecker products.

    With V = [L1 R1' L2 R2' ..] the small matrices are the parts of
    M = V' W V. Two of them make one Kronecker product; index arrays
    say which.
    """

    def __init__(self, slots, stacks):
        self.slots, self.factors, layout, offset = slots, [], [], 0
        for s in stacks:
            wide = [
                [t.left for t in p.products]
                + [t.right.conj().T for t in p.products]
                for p in s.parts
            ]
            wide = [np.hstack(w) if w else np.zeros((k, 0))
                    for w, k in zip(wide, s.sizes)]
            c = max(w.shape[1] for w in wide)
            V = np.zeros((len(wide), s.q, c), s.constant.dtype)
            for v, w, k in zip(V, wide, s.sizes):
                v[:k, :w.shape[1]] = w
            self.factors.append(V)
            imaginary = len(wide) * c * c if s.weight == 2 else 0
            for i, p in enumerate(s.parts):
                layout.append((
                    tuple(t.slot for t in p.products), s.weight,
                    offset + i * c * c, c, imaginary))
            offset += len(wide) * c * c * s.weight
        self.jobs = _jobs(tuple(slots), tuple(layout))

    def add(self, H, roots):
        """Add these parts of the Hessian to H."""
        flat = []
        for V, N in zip(self.factors, roots):
            white = N @ V
            M = transposed(white) @ white
            flat.append(real(M.reshape(1, -1))[0])
        flat = np.concatenate(flat)
        for u, v, straight, crossed in self.jobs:
            a, b = self.slots[u].rows, self.slots[u].cols
            c, d = self.slots[v].rows, self.slots[v].cols
            total = _kronecker(flat, straight).reshape(b, c, d, a)
            total = total.transpose(3, 0, 1, 2)
            if crossed is not None:
                more = _kronecker(flat, crossed).reshape(b, d, c, a)
                total = total + more.transpose(3, 0, 2, 1)
            total = total.reshape(a * b, c * d)
            total = _packed(self.slots[u], total)
            total = _packed(self.slots[v], total.T).T
            i, j = self.slots[u].start, self.slots[v].start
            rows, cols = total.shape
            H[i:i + rows, j:j + cols] = total
            if u != v:
                H[j:j + cols, i:i + rows] = total.T


@lru_cache(16)  # the same for every request of one shape
def _jobs(slots, layout):
    """For each two unknowns the index arrays of their products."""
    found = []
    for u in range(len(slots)):
        for v in range(u, len(slots)):
            first, second = u, v
            if slots[v].symmetric and not slots[u].symmetric:
                first, second = v, u
            straight, crossed = _job(slots, first, second, layout)
            if straight is not None:
                found.append((first, second, straight, crossed))
    return found


def _job(slots, u, v, layout):
    straight, crossed = [], []
    for products, weight, base, c, imaginary in layout:
        lefts, rights = _columns(slots, products)
        for s, t in product(range(len(products)), repeat=2):
            if (products[s], products[t]) != (u, v):
                continue

            def place(rows, cols, base=base, c=c):
                return base + rows[:, None] * c + cols

            Ls, Rs, Lt, Rt = lefts[s], rights[s], lefts[t], rights[t]
            terms = [(straight, place(Rs, Lt), place(Rt, Ls))]
            if slots[u].symmetric:  # X may be transposed
                terms.append((straight, place(Lt, Ls).T, place(Rs, Rt).T))
            else:
                terms.append((crossed, place(Rs, Rt), place(Lt, Ls)))
            for found, A, B in terms:
                A, B = A.ravel(), B.ravel()
                found.append((A, B, 2.0 * weight))
                if imaginary:
                    found.append((A + imaginary, B + imaginary, -2.0 * weight))
    return _arrays(straight), _arrays(crossed)


def _columns(slots, products):
    """Columns of the left and the right factors within V."""
    widths = [slots[k].rows for k in products]
    widths += [slots[k].cols for k in products]
    ends = np.cumsum([0, *widths])
    spans = [np.arange(i, j) for i, j in zip(ends, ends[1:])]
    return spans[:len(products)], spans[len(products):]


def _arrays(entries):
    if not entries:
        return None
    A, B, weights = zip(*entries)
    return np.array(A), np.array(B), np.array(weights)[:, None]


def _kronecker(flat, job):
    A, B, weights = job
    return (flat[A] * weights).T @ flat[B]


def _packed(slot, rows):
    """Rows for the entries of a symmetric unknown, mirrored ones added."""
    if not slot.symmetric:
        return rows
    i, j, off = slot.lower
    n = slot.rows
    return rows[i * n + j] + off[:, None] * rows[j * n + i]
