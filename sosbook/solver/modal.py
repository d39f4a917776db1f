"""A preconditioner: the Hessian's diagonal in modal coordinates.

In coordinates where the metric of P > 0 is the identity a well damped closed loop is
nearly a normal matrix: its Schur vectors U make all blocks nearly diagonal. So the
Hessian acts on U' dP U nearly entry by entry. The method is this package's own; that
Lyapunov inequalities have such a structure, and that conjugate gradients use it, is due
to Vandenberghe and Boyd (1995).
"""

import numpy as np
from scipy.linalg import schur

from .sums import span

UNMOVED = 1e-12  # of the largest entry of the diagonal; smaller ones are rounding


class Modal:
    """Approximate inverse of the Hessian in P, in Y = K P and in scalars.

    The blocks ``stacked`` must be such that `fits` says so; W is the metric: the
    Hessian is the sum of <G_ka, W_k G_kb W_k>; at x the gain K = Y inv(P) is taken.
    """

    def __init__(self, stacked, W, x):
        """Diagonalise the metric's part in P, and in Y = K P."""
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
                    groups.append((w, factors))
        self.T = np.linalg.inv(np.linalg.cholesky(metric)).T
        self.K = None if self.Y is None else self.Y.matrix(x) @ metric
        self._diagonalise([_Block(*group, self.K) for group in groups])
        # single precision is enough for what is approximate anyway
        self.basis = self.basis.astype(np.complex64)
        self.dX = self.dX.astype(np.float32)
        self.scalars = 1 / np.array(
            [
                sum(
                    np.vdot(s.slopes[a], w @ s.slopes[a] @ w)
                    for s, w in zip(stacked.stacks, W)
                )
                for a in range(len(stacked.scalars))
            ]
        )

    @staticmethod
    def fits(stacked):
        """True if the unknowns of ``stacked`` are P, perhaps Y, and scalars."""
        return _layouts(stacked) is not None and any(
            _is_P(b) for s in stacked.stacks for b in s.blocks
        )

    def _diagonalise(self, blocks):
        """Modal coordinates U of X, V of Z, and the Hessian's diagonals there."""
        loop = sum(R.inner(L) for b in blocks for L, R in zip(b.lefts, b.rights))
        self.basis = self.T @ schur(self.T.T @ loop @ self.T, output="complex")[1]
        m = 0 if self.Y is None else self.Y.rows
        self.dX, effort = 0.0, np.zeros((m, m))
        for b in blocks:
            b.G = b.in_modes(self.basis)
            T = len(b.lefts)
            swapped = np.roll(np.arange(2 * T), T)  # L and R change their places
            products = np.einsum("ija,jib->ab", b.G, b.G[swapped][:, swapped])
            self.dX = self.dX + products.real
            for left, at in b.of_Y:
                scale = b.G[T + at, T + at].sum().real
                effort = effort + scale * (left.T @ b.w @ left)
        if self.Y is None:
            return
        self.V, dZ = np.linalg.eigh(effort)[1], np.zeros((m, len(self.basis)))
        for b in blocks:
            T = len(b.lefts)
            for left_s, s in b.of_Y:
                for left_t, t in b.of_Y:
                    middle = left_t.T @ b.w @ left_s
                    inner = np.einsum("ia,ij,ja->a", self.V, middle, self.V)
                    outer = np.outer(inner, b.G[T + s, T + t])
                    dZ = dZ + 2 * outer.real
        # an input that moves nothing, or what others do, leaves a row of zeros
        self.dZ = np.maximum(dZ, UNMOVED * dZ.max()) if dZ.any() else dZ + 1

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
            Z = self.V.T @ (of_Y.astype(np.float32) @ basis)
            Z = self.V @ (Z / self.dZ @ basis.conj().T).real
        X = basis.conj().T @ (G @ basis) / self.dX
        dP = (basis @ X @ basis.conj().T).real.astype(float)
        dP = (dP + dP.T) / 2
        out[P.start : P.start + P.size] = dP[i, j]
        if Y is not None:
            dY = self.K @ dP + Z
            out[Y.start : Y.start + Y.size] = dY.ravel()
        scalars = self.stacked.scalars
        out[scalars] = self.scalars * g[scalars]
        return out


class _Block:
    """A block's ``factors``, see `_factors`, for dP and dY = K dP + Z; metric w."""

    def __init__(self, w, factors, K):
        self.w = w
        self.of_Y = [(Y, at) for at, (_, Y, _) in enumerate(factors) if Y is not None]
        lefts = [P for P, *_ in factors]
        for Y, at in self.of_Y:
            lefts[at] = Y @ K if lefts[at] is None else lefts[at] + Y @ K
        self.lefts = [_Factor(w, L) for L in lefts]
        self.rights = [_Factor(w, R.T) for *_, R in factors]

    def in_modes(self, basis):
        """v* w v' for each two factors' columns v, v' of each mode, (2 T, 2 T, N)."""
        factors = self.lefts + self.rights
        modal = [f.own @ basis for f in factors]
        weighted = [f.weighted @ basis for f in factors]
        G = np.empty((len(factors), len(factors), len(basis)), complex)
        for i, f in enumerate(factors):
            for j in range(i, len(factors)):  # w is its own adjoint
                G[i, j] = np.einsum("ij,ij->j", modal[i].conj(), weighted[j][f.rows])
                G[j, i] = G[i, j].conj()
        return G


class _Factor:
    """A factor M of a product, by its rows that aren't zero, and w M."""

    def __init__(self, w, M):
        used = M.any(axis=1)
        self.rows = span(used) if used.any() else slice(0)
        self.own = M[self.rows]
        self.weighted = w[:, self.rows] @ self.own

    def inner(self, other):
        """M' w N of this one, M, and another, N."""
        return self.own.T @ other.weighted[self.rows]


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
    """True if a block is a multiple of P itself."""
    if len(block.products) != 1:
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
