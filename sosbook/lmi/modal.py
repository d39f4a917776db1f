"""A preconditioner: the Hessian's diagonal in modal coordinates.

In coordinates where the metric of P > 0 is the identity a well damped
closed loop is nearly a normal matrix: its Schur vectors U make all blocks
nearly diagonal. So the Hessian acts on U' dP U nearly entry by entry.
"""

import numpy as np
from scipy.linalg import schur

__all__ = ["Modal"]


class Modal:
    """Approximate inverse of the Hessian of P, of Y = K P and of numbers.

    Parameters
    ----------
    stacked : Stacked
    W : list of stacks
        The metric: the Hessian is the sum of <G_ka, W_k G_kb W_k>.
    x : (k,) array
        The point, for the gain K.
    """

    def __init__(self, stacked, W, x):
        self.stacked = stacked
        self.P, self.Y = _slots(stacked)
        groups, metric = [], None
        for s, stack in zip(stacked.stacks, W):
            for p, w, k in zip(s.parts, stack, s.sizes):
                w = w[:k, :k]
                if _is_P(p):
                    metric = w
                groups.append((s.weight, w, _pairs(p, stacked)))
        self.T = np.linalg.inv(np.linalg.cholesky(metric)).T
        self.K = None if self.Y is None else self.Y.matrix(x) @ metric
        hat = [
            (weight, w, [self._hat(pair) for pair in pairs])
            for weight, w, pairs in groups
        ]
        self._diagonalise(hat)
        # single precision is enough for what is approximate anyway
        self.basis = (self.T @ self.U).astype(np.complex64)
        self.dX = self.dX.astype(np.float32)
        self.numbers = 1 / np.array([
            sum(
                s.weight * np.vdot(s.slopes[a], w @ s.slopes[a] @ w).real
                for s, w in zip(stacked.stacks, W)
            ) for a in range(len(stacked.numbers))
        ])

    @staticmethod
    def fits(stacked):
        """Whether the unknowns are P, perhaps Y and some numbers."""
        return _slots(stacked) is not None and any(
            _is_P(p) for s in stacked.stacks for p in s.parts)

    def _hat(self, pair):
        """Factors for dP = T X T', dY = K dP + Z T'."""
        L, push, R = pair
        if push is not None:
            L = push @ self.K if L is None else L + push @ self.K
        return L @ self.T, push, self.T.T @ R

    def _diagonalise(self, hat):
        loop = sum(
            R @ w @ L for _, w, pairs in hat for L, _, R in pairs)
        U = schur(loop.astype(complex), output="complex")[1]
        N = len(U)
        self.U, self.dX = U, np.zeros((N, N))
        if self.Y is not None:
            m = self.Y.rows
            effort = np.zeros((m, m))
            for weight, w, pairs in hat:
                for _, push, R in pairs:
                    if push is not None:
                        size = np.einsum("ij,ji->", R @ w, R.conj().T).real
                        effort += weight * size * (
                            push.conj().T @ w @ push).real
            self.V = np.linalg.eigh(effort)[1]
            self.dZ = np.zeros((m, N))
        for weight, w, pairs in hat:
            self._add(weight, w, pairs)

    def _add(self, weight, w, pairs):
        """One block's part of the diagonals."""
        T, U = len(pairs), self.U
        wide = [L @ U for L, _, _ in pairs]
        wide += [R.conj().T @ U for _, _, R in pairs]
        heavy = [w @ v for v in wide]
        G = np.array([
            [(v.conj() * h).sum(axis=0) for h in heavy] for v in wide])
        mirror = np.roll(np.arange(2 * T), T)
        other = G[mirror][:, mirror]
        self.dX += weight * np.einsum("ija,jib->ab", G, other).real
        for s, (_, push, _) in enumerate(pairs):
            for t, (_, twin, _) in enumerate(pairs):
                if push is not None and twin is not None:
                    inner = np.einsum(
                        "ia,ij,ja->a", self.V, (twin.conj().T @ w @ push),
                        self.V)
                    outer = G[T + s, T + t]
                    self.dZ += 2 * weight * np.outer(inner, outer).real

    def __call__(self, g):
        """The approximate solution d of H d = g."""
        out = np.zeros_like(g)
        P, Y, basis = self.P, self.Y, self.basis
        i, j, off = P.lower
        G = np.empty((P.rows, P.rows), np.float32)
        G[i, j] = G[j, i] = g[P.start:P.start + P.size] / (1 + off)
        if Y is not None:
            of_Y = Y.matrix(g)
            shift = self.K.T @ of_Y
            G += (shift + shift.T) / 2
            Z = self.V.T @ (of_Y.astype(np.float32) @ basis) / self.dZ
            Z = self.V @ (Z @ basis.conj().T).real
        X = basis.conj().T @ (G @ basis) / self.dX
        dP = (basis @ X @ basis.conj().T).real.astype(float)
        dP = (dP + dP.T) / 2
        out[P.start:P.start + P.size] = dP[i, j]
        if Y is not None:
            dY = self.K @ dP + Z
            out[Y.start:Y.start + Y.size] = dY.ravel()
        numbers = self.stacked.numbers
        out[numbers] = self.numbers * g[numbers]
        return out


def _slots(stacked):
    """The slots of P and Y (or None), if these are the only unknowns."""
    square = [s for s in stacked.slots if s.symmetric]
    rest = [s for s in stacked.slots if not s.symmetric]
    if len(square) != 1 or len(rest) > 1:
        return None
    if rest and rest[0].cols != square[0].rows:
        return None
    return square[0], rest[0] if rest else None


def _is_P(part):
    """Whether a block is a multiple of P itself."""
    if len(part.products) != 1 or part.weight == 2:
        return False
    (t,) = part.products
    n = len(part.constant)
    return (
        t.left.shape == t.right.shape == (n, n)
        and np.array_equal(t.right, np.eye(n))
        and np.array_equal(t.left, t.left[0, 0] * np.eye(n))
    )


def _pairs(part, stacked):
    """(left of P, left of Y, right) for each right factor of a block."""
    found = {}
    for t in part.products:
        key = (np.round(t.right, 12) + 0.0).tobytes()
        pair = found.setdefault(key, [None, None, t.right])
        pair[0 if stacked.slots[t.slot].symmetric else 1] = t.left
    return list(found.values())
