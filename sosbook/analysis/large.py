"""Large plants under a gain: their poles, in floats."""

from dataclasses import dataclass
from functools import cached_property
from warnings import catch_warnings

import numpy as np
from scipy.linalg import LinAlgError, LinAlgWarning, lu_factor, lu_solve
from scipy.sparse import csc_array, issparse
from scipy.sparse.linalg import (
    ArpackError,
    ArpackNoConvergence,
    LinearOperator,
    eigs,
    splu,
)

from ..plants.modes import NUDGES, negatives, symmetric_factor
from ..plants.sparse import least_filled
from ..runtime.read_only import ReadOnly
from ..runtime.threads import one_thread
from ..runtime.time_limit import check_time, check_time_of_eigenvalues

STEPS = 5  # of Newton's method; each squares the error, which begins near 1e-9
SETTLED = 1e-10  # of the pole's size: the next step is the square of a smaller one
SHARP = 1e-10  # residual, of the sizes of its terms; a larger one is no pole's
LAST_STEP = 1e-6  # of the pole's size: two poles that coincide settle slowly
SYMMETRIC = dict(diag_pivot_thresh=0.01, options=dict(SymmetricMode=True))
AT_ONCE = 6  # poles near each point where a sparse pencil is looked at
RESTARTS = 5  # of Arnoldi's method; far from all poles it doesn't settle at all
LOOSE = 1e-8  # relative, of its values: each pole is settled afterwards
NEAR_ZERO, FARTHER = 1e-6, 4.0  # of the fastest rate, about; and to the next count
EVEN = 1e-12  # relative: what differs less from its transpose is symmetric
RIGHTMOST = 8  # of all poles of a dense pencil are refined
VECTORS = 2.0  # times as long as eigenvalues alone
SAME = 1e-7  # of a pole's size, from another one that was found


@dataclass(frozen=True, eq=False)
class Pencil(ReadOnly):
    """The loop of s^2 M + s D + S and a controller, whose zeros are the poles: ``B`` u
    with u = ``K`` [q; s q] + ``C`` x_c and s x_c = ``A`` x_c + ``G`` [q; s q]. The
    plant is dense or sparse; vectors are [q; x_c].
    """

    M: object
    D: object
    S: object
    B: np.ndarray
    K: np.ndarray
    A: np.ndarray
    G: np.ndarray
    C: np.ndarray

    @property
    def n(self):
        """How many rows the plant has."""
        return self.B.shape[0]

    @property
    def order(self):
        """How many poles the loop has; a plant of first order has M = 0."""
        first = not issparse(self.M) and not np.any(self.M)
        return (2 - first) * self.n + len(self.A)

    @cached_property
    def columns(self):
        """The order of columns in which factors of a sparse plant fill least."""
        return least_filled(abs(self.M) + abs(self.D) + abs(self.S))

    def _gains(self, s):
        """K and G at s, as factors of q."""
        return (x[:, : self.n] + s * x[:, self.n :] for x in (self.K, self.G))

    def solver(self, s):
        """A function that solves the loop at s for a right side; of a sparse one the
        plant is factored, and the controller, of low rank, added.
        """
        n, m, A = self.n, self.B.shape[1], s * np.eye(len(self.A)) - self.A
        plant, (K, G) = s * s * self.M + s * self.D + self.S, self._gains(s)
        if not issparse(plant):
            loop = np.block([[plant - self.B @ K, -self.B @ self.C], [-G, A]])
            with catch_warnings(action="error", category=LinAlgWarning):
                factors = lu_factor(loop)
            return lambda x: lu_solve(factors, x)
        factor = splu(
            csc_array(plant, dtype=complex), permc_spec=self.columns, **SYMMETRIC
        )
        moved, W = factor.solve(self.B.astype(complex)), np.vstack([K, G])
        loop = np.block([[np.eye(m) - K @ moved, -self.C], [-G @ moved, A]])
        small = np.linalg.inv(loop)  # of u and x_c

        def solve(x):
            y = factor.solve(x[:n].astype(complex))
            right = W @ y
            right[m:] += x[n:]
            found = small @ right
            return np.concatenate([y + moved @ found[:m], found[m:]])

        return solve

    def slope(self, s, q):
        """The derivative by s, times q."""
        q, i = np.split(q, [self.n])
        force = self.B @ (self.K[:, self.n :] @ q)
        own = 2 * s * (self.M @ q) + self.D @ q - force
        return np.concatenate([own, i - self.G[:, self.n :] @ q])

    def residual(self, s, q):
        """How far q is from a null vector at s, of the sizes of what is summed."""
        sizes, left = self._left(s, q)
        parts = np.split(left, [self.n])
        return max(np.linalg.norm(x) / size for x, size in zip(parts, sizes))

    def _left(self, s, q):
        """The sizes of what is summed where the loop at s takes q, of the plant and of
        the controller, and the sum.
        """
        q, i = np.split(q, [self.n])
        K, G = self._gains(s)
        parts = (s * s, self.M), (s, self.D), (1.0, self.S)
        force = self.B @ (K @ q + self.C @ i)
        left = sum(c * (x @ q) for c, x in parts) - force
        left = np.concatenate([left, s * i - self.A @ i - G @ q])
        size = sum(abs(c) * np.linalg.norm(abs(x) @ abs(q)) for c, x in parts)
        own = abs(s * i) + abs(self.A) @ abs(i) + abs(G) @ abs(q)
        sizes = size + np.linalg.norm(force), np.linalg.norm(own)
        return [x or 1.0 for x in sizes], left

    def refined(self, s, q):
        """The pole near s by Newton's method (inverse iteration with the derivative)
        from a vector q, and its doubt, or None. Its error is that of a residual, not
        1e-16 of the largest pole. Two poles that coincide at zero don't settle: the
        last step is their doubt.
        """
        step = s
        for _ in range(STEPS):
            check_time()
            try:
                y = self.solver(s)(self.slope(s, q))
            except (LinAlgError, LinAlgWarning, RuntimeError, ZeroDivisionError):
                y = np.inf
            if not np.isfinite(y).all():
                step = 0.0  # singular to the last bit
                break
            step = (q.conj() @ q) / (q.conj() @ y)
            s, q = s - step, y / np.linalg.norm(y)
            if abs(step) < SETTLED * abs(s):
                break
        if not self.residual(s, q) < SHARP:
            return None
        return s, abs(step) if abs(step) > LAST_STEP * abs(s) else 0.0

    @one_thread
    def near(self, shift, count=0):
        """Poles, vectors and doubts near a complex ``shift``, of a sparse pencil; more
        of them where ``count`` are expected. The doubt is None where a pole didn't
        settle with the factor of the shift.
        """
        n, a = self.n, len(self.A)
        K_D, G_D = self.K[:, n:], self.G[:, n:]
        check_time()
        solve, size = self.solver(shift), abs(shift)

        def back(x):  # through the first-order form [size z; z'; x_c]
            check_time()
            z, v, i = np.split(x, [n, 2 * n])
            z = z / size
            force = self.M @ (v + shift * z) + self.D @ z - self.B @ (K_D @ z)
            q = solve(np.concatenate([-force, G_D @ z - i]))
            return np.concatenate([size * q[:n], z + shift * q[:n], q[n:]])

        rows, count = 2 * n + a, max(AT_ONCE, count + 2)
        operator = LinearOperator((rows, rows), back, dtype=complex)
        start = np.random.default_rng(0).normal(size=rows)
        try:
            values, vectors = eigs(
                operator, count, v0=start, maxiter=RESTARTS, tol=LOOSE
            )
        except ArpackNoConvergence as some:
            values, vectors = some.eigenvalues, some.eigenvectors
        except ArpackError:
            return []
        pairs = zip(values, vectors.T)
        parts = [(x, np.concatenate([v[:n], size * v[2 * n :]])) for x, v in pairs]
        return [self._settled(solve, shift + 1 / x, v) for x, v in parts if x]

    def _settled(self, solve, s, q):
        """The pole near s, its vector and its doubt by inverse iteration on residuals:
        what ``solve`` does at a shift nearby serves for all poles there. The doubt is
        None, and s and q are as they were, where they don't settle.

        Source: A. Neumaier, SIAM J. Numerical Analysis 22, 1985.
        """
        start, q = (s, q), q / np.linalg.norm(q)
        for _ in range(STEPS):
            check_time()
            moved = solve(np.array([self._left(s, q)[1], self.slope(s, q)]).T)
            step = (q.conj() @ moved[:, 0]) / (q.conj() @ moved[:, 1])
            s, q = s - step, q - moved @ [1.0, -step]
            q = q / np.linalg.norm(q)
            if not np.isfinite(s) or abs(step) < SETTLED * abs(s):
                break
        good = abs(step) < SETTLED * abs(s) and self.residual(s, q) < SHARP
        return (s, q, 2 * abs(step)) if good else (*start, None)

    def right_of_zero(self):
        """How many poles at least are right of the imaginary axis, or None, and
        places on the real axis near which real ones are sought, with how many.

        The symmetric part of the pencil at a real s > 0 is positive definite for large
        s. If the pencil is symmetric there, each of its negative eigenvalues near s = 0
        becomes zero at some s > 0, which is a pole. If D alone isn't, but its symmetric
        part is positive definite, as many poles are right of the axis by the theorem of
        Kelvin, Tait and Chetaev. Else None: the counts only say where to look.
        """
        M, D, S = ((x + x.T) / 2 for x in (self.M, self.D, self.S))
        size = np.sqrt(abs(S).max() / abs(M).max() or 1.0)
        s, places = NEAR_ZERO * size, []
        first = count = self._negatives(M, D, S, s)
        while count:
            check_time()
            less = self._negatives(M, D, S, FARTHER * s)
            if less < count:
                places.append((np.sqrt(FARTHER) * s, count - less))
            s, count = FARTHER * s, less
        return (first if self._is_counted(M, D, S) else None), places

    def _negatives(self, M, D, S, s):
        """Negative eigenvalues of the pencil's symmetric part at a real s > 0, of the
        plant's symmetric parts ``M``, ``D``, ``S``: those of the plant, and of what
        Haynsworth's law adds for the gain, B W + W' B' of low rank.
        """
        for nudge in NUDGES:
            at = nudge * s
            x = csc_array(at * at * M + at * D + S)
            factor = symmetric_factor(x, self.columns)
            if factor is not None:
                break
        else:
            raise ArithmeticError("no factor tells the signs of its eigenvalues")
        count = int((factor.U.diagonal() < 0).sum())
        m, (K, G) = self.B.shape[1], self._gains(at)
        W = K + self.C @ np.linalg.solve(at * np.eye(len(self.A)) - self.A, G)
        if not W.any():
            return count
        share = np.sqrt(np.linalg.norm(W) / np.linalg.norm(self.B))
        both = np.hstack([share * self.B, W.T / share])
        zero, two = np.zeros((m, m)), 2 * np.eye(m)
        small = np.block([[zero, two], [two, zero]]) - both.T @ factor.solve(both)
        return count + int((np.linalg.eigvalsh(small + small.T) < 0).sum()) - m

    def _is_counted(self, M, D, S):
        """True if the negative eigenvalues of the symmetric part at zero, of ``M``,
        ``D`` and ``S``, are poles right of the axis; ``M`` is positive definite.
        """
        if len(self.A):
            return False
        K_P, K_D = self.K[:, : self.n], self.K[:, self.n :]
        v = np.random.default_rng(1).normal(size=self.n)

        def even(x, W):
            left, right = x @ v - self.B @ (W @ v), x.T @ v - W.T @ (self.B.T @ v)
            sizes = abs(x) @ abs(v) + abs(self.B) @ abs(W @ v)
            return np.linalg.norm(left - right) <= EVEN * np.linalg.norm(sizes)

        none = 0.0 * K_P
        if not (even(self.M, none) and even(self.S, K_P)):
            return False
        if negatives(csc_array(M)) != 0:
            return False
        if even(self.D, K_D):
            return True
        return not K_D.any() and negatives(csc_array(D)) == 0

    def everywhere(self):
        """All poles and vectors of a dense pencil; one of first order has M = 0."""
        n, a, first = self.n, len(self.A), self.order < 2 * self.n
        check_time_of_eigenvalues(self.order, VECTORS)
        (K_P, K_D), (G_P, G_D) = (np.split(x, [n], axis=1) for x in (self.K, self.G))
        rows = [self.B @ K_P - self.S, self.B @ K_D - self.D, self.B @ self.C]
        low = [G_P, G_D, self.A]
        if first:
            del rows[1], low[1]
        rows = np.linalg.solve(self.D if first else self.M, np.hstack(rows))
        top = np.eye(0 if first else n, self.order, n)
        values, vectors = np.linalg.eig(np.vstack([top, rows, np.hstack(low)]))
        places = np.r_[:n, self.order - a : self.order]
        return [(s, q, None) for s, q in zip(values, vectors[places].T)]
