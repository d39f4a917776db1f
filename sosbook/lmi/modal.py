"""A preconditioner: the Hessian's diagonal in modal coordinates.

In coordinates where the metric of P > 0 is the identity a well damped
closed loop is nearly a normal matrix: its Schur vectors U make all blocks
nearly diagonal. So the Hessian acts on U' dP U nearly entry by entry.
The method is this package's own; that Lyapunov inequalities have such a
structure, and that conjugate gradients use it, is due to Vandenberghe and
Boyd (1995).
"""

import numpy as np
from scipy.linalg import schur

__all__ = ["Modal"]


class Modal:
    """Approximate inverse of the Hessian in P, in Y = K P and in scalars.

    Parameters
    ----------
    stacked : Stacked
        The blocks; `fits` says whether their unknowns are of this kind.
    W : list of stacks
        The metric: the Hessian is the sum of <G_ka, W_k G_kb W_k>.
    x : (k,) array
        The point at which the gain K = Y inv(P) is taken.
    """

    def __init__(self, stacked, W, x):
        self.stacked = stacked
        self.P, self.Y = _layouts(stacked)
        groups, metric = [], None
        for s, stack in zip(stacked.stacks, W):
            for p, w, k in zip(s.blocks, stack, s.sizes):
                w = w[:k, :k]
                if _is_P(p):
                    metric = w
                factors = _factors(p, stacked)
                if factors:  # else it holds scalars only
                    groups.append((s.weight, w, factors))
        self.T = np.linalg.inv(np.linalg.cholesky(metric)).T
        self.K = None if self.Y is None else self.Y.matrix(x) @ metric
        modal = [
            (weight, w, [self._in_coordinates(*f) for f in factors])
            for weight, w, factors in groups
        ]
        self._diagonalise(modal)
        # single precision is enough for what is approximate anyway
        self.basis = (self.T @ self.Q).astype(np.float32)
        self.dX = self.dX.astype(np.float32)
        self.scalars = 1 / np.array(
            [
                sum(
                    s.weight * np.vdot(s.slopes[a], w @ s.slopes[a] @ w).real
                    for s, w in zip(stacked.stacks, W)
                )
                for a in range(len(stacked.scalars))
            ]
        )

    @staticmethod
    def fits(stacked):
        """Whether the unknowns of a `Stacked`, ``stacked``, are of this kind.

        These are P, perhaps Y, and some scalars.
        """
        return _layouts(stacked) is not None and any(
            _is_P(b) for s in stacked.stacks for b in s.blocks
        )

    def _in_coordinates(self, left_P, left_Y, right):
        """Factors of a product for dP = T X T' and dY = K dP + Z T'."""
        if left_Y is not None:
            left_P = left_Y @ self.K if left_P is None else left_P + left_Y @ self.K
        return left_P @ self.T, left_Y, self.T.T @ right

    def _diagonalise(self, groups):
        """Modal coordinates U of X, V of Z, and the Hessian's diagonals there."""
        loop = sum(R @ w @ L for _, w, factors in groups for L, _, R in factors)
        triangle, self.Q = schur(loop.real)
        self.pairs = _Conjugates(triangle)
        self.U = self.pairs.columns(self.Q)
        N = len(self.U)
        self.dX = np.zeros((N, N))
        if self.Y is not None:
            m = self.Y.rows
            effort = np.zeros((m, m))
            for weight, w, factors in groups:
                for _, left_Y, R in factors:
                    if left_Y is not None:
                        scale = weight * np.einsum("ij,ji->", R @ w, R.conj().T).real
                        effort += scale * (left_Y.conj().T @ w @ left_Y).real
            self.V = np.linalg.eigh(effort)[1]
            self.dZ = np.zeros((m, N))
        for weight, w, factors in groups:
            self._add(weight, w, factors)

    def _add(self, weight, w, factors):
        """Add one block's part to the diagonals dX and dZ."""
        T, U = len(factors), self.U
        columns = [L @ U for L, _, _ in factors]
        columns += [R.conj().T @ U for _, _, R in factors]
        weighted = [w @ v for v in columns]
        G = np.array([[(v.conj() * h).sum(axis=0) for h in weighted] for v in columns])
        swapped = np.roll(np.arange(2 * T), T)  # L and R change their places
        self.dX += weight * np.einsum("ija,jib->ab", G, G[swapped][:, swapped]).real
        for s, (_, left_s, _) in enumerate(factors):
            for t, (_, left_t, _) in enumerate(factors):
                if left_s is not None and left_t is not None:
                    inner = np.einsum(
                        "ia,ij,ja->a", self.V, (left_t.conj().T @ w @ left_s), self.V
                    )
                    outer = G[T + s, T + t]
                    self.dZ += 2 * weight * np.outer(inner, outer).real

    def __call__(self, g):
        """The approximate solution d of H d = g."""
        out = np.zeros_like(g)
        P, Y, basis = self.P, self.Y, self.basis
        i, j, off = P.lower
        G = np.empty((P.rows, P.rows), np.float32)
        G[i, j] = G[j, i] = g[P.start : P.start + P.size] / (1 + off)
        if Y is not None:
            of_Y = Y.matrix(g)
            through_K = self.K.T @ of_Y
            G += (through_K + through_K.T) / 2
            Z = self.V.T @ self.pairs.columns(of_Y.astype(np.float32) @ basis)
            Z = self.V @ self.pairs.real_rows(Z / self.dZ) @ basis.T
        X = self.pairs.both(basis.T @ (G @ basis)) / self.dX
        dP = (basis @ self.pairs.real_both(X) @ basis.T).astype(float)
        dP = (dP + dP.T) / 2
        out[P.start : P.start + P.size] = dP[i, j]
        if Y is not None:
            dY = self.K @ dP + Z
            out[Y.start : Y.start + Y.size] = dY.ravel()
        scalars = self.stacked.scalars
        out[scalars] = self.scalars * g[scalars]
        return out


class _Conjugates:
    """Complex Schur vectors U = Q V of a real Schur form, without a product.

    V is unitary and mixes only the two columns of Q that belong to two
    conjugate eigenvalues: column j of U is own_j q_j + other_j q_p, where p
    is the partner of j, and j itself where the eigenvalue is real.

    Parameters
    ----------
    triangle : (N, N) array
        The real Schur form, with a block of two rows for each such pair.
    """

    def __init__(self, triangle):
        N = len(triangle)
        self.partner = np.arange(N)
        own, other = np.ones(N, np.complex64), np.zeros(N, np.complex64)
        for j in np.flatnonzero(np.diagonal(triangle, -1)):
            a, b = np.linalg.eig(triangle[j : j + 2, j : j + 2])[1][:, 0]
            self.partner[[j, j + 1]] = j + 1, j
            own[j], other[j] = a, b
            own[j + 1], other[j + 1] = np.conj(a), -np.conj(b)
        self.own, self.other = own, other

    def columns(self, M):
        """M V."""
        return M * self.own + M[:, self.partner] * self.other

    def both(self, M):
        """V* M V."""
        right = self.columns(M)
        own, other = self.own.conj()[:, None], self.other.conj()[:, None]
        return own * right + other * right[self.partner]

    def real_rows(self, M):
        """The real part of M V*."""
        back = self.other[self.partner].conj()
        return (M * self.own.conj() + M[:, self.partner] * back).real

    def real_both(self, M):
        """The real part of V M V*."""
        back = self.other[self.partner][:, None]
        return self.real_rows(self.own[:, None] * M + back * M[self.partner])


def _layouts(stacked):
    """The layouts of P and Y (or None), if these are the only unknowns."""
    symmetric = [u for u in stacked.layouts if u.symmetric]
    general = [u for u in stacked.layouts if not u.symmetric]
    if len(symmetric) != 1 or len(general) > 1:
        return None
    if general and general[0].cols != symmetric[0].rows:
        return None
    return symmetric[0], general[0] if general else None


def _is_P(block):
    """Whether a block is a multiple of P itself."""
    if len(block.products) != 1 or block.weight == 2:
        return False
    (t,) = block.products
    n = len(block.constant)
    return (
        t.left.shape == t.right.shape == (n, n)
        and np.array_equal(t.right, np.eye(n))
        and np.array_equal(t.left, t.left[0, 0] * np.eye(n))
    )


def _factors(block, stacked):
    """(left of P, left of Y, right) for each right factor of a block."""
    factors = {}
    for t in block.products:
        key = (np.round(t.right, 12) + 0.0).tobytes()
        lefts = factors.setdefault(key, [None, None, t.right])
        lefts[0 if stacked.layouts[t.unknown].symmetric else 1] = t.left
    return list(factors.values())
