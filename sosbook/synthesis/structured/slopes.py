"""How far a law's loops are from what is asked, and which way that falls."""

from contextlib import suppress

import numpy as np

from ...requirements.cost import QuadraticCost

GRID = 24  # frequencies between the slowest and the fastest pole
BEYOND = np.geomspace(1, 10, 7)[1:]  # times the fastest pole: zeros may be there
HILLS = 4  # of the highest frequencies, each of which may be beside the peak
NARROWER = 14  # times a bracket of the peak is cut
STEP = 1e-6  # of differences, of a free number's unit


class Poles:
    """The poles ``s`` of all ``loops``, (N, n), under the law's gain ``K``; infinite
    where they can't be computed.
    """

    def __init__(self, loops, K):
        self.loops = loops
        A = loops.closed(K)
        self.s = np.full(A.shape[:2], np.inf)
        if np.isfinite(A).all():
            with suppress(np.linalg.LinAlgError):
                self.s, self.V = np.linalg.eig(A)

    def worst(self, regions):
        """The largest violation of some ``regions``, (alpha, beta, unit of the
        violation) each, where, and its slope in that pole.
        """
        s, worst = self.s, (-np.inf, None, None)
        for alpha, beta, unit in regions:
            if len(alpha) == 1:
                levels = (alpha[0, 0] + beta[0, 0] * s + beta[0, 0] * s.conj()).real
            else:
                f = alpha + beta * s[..., None, None]
                f = f + beta.T * s.conj()[..., None, None]
                levels = np.linalg.eigvalsh(f)[..., -1]
            i, j = divmod(int(levels.argmax()), levels.shape[1])
            if levels[i, j] / unit > worst[0]:
                v = np.ones(1) if len(alpha) == 1 else np.linalg.eigh(f[i, j])[1][:, -1]
                worst = levels[i, j] / unit, (i, j), 2 * (v.conj() @ beta @ v) / unit
        return worst

    def slope(self, at, turn):
        """That of a violation in K: ``at`` a pole, which moves it by ``turn``."""
        (i, j), (_, B, *_) = at, self.loops.matrices
        one = np.zeros(len(self.V[i]))
        one[j] = 1.0
        left = np.linalg.lstsq(self.V[i].T, one + 0j, rcond=None)[0]
        S = np.outer(left @ B[i], self.loops.measured @ self.V[i, :, j])
        return (turn * S).real


def norm(loops, K, r, m):
    """The largest H-infinity norm of stable ``loops``, and its slope in ``K``, of the
    channel of ``r``, with ``m`` inputs u. A search in frequency, no bound: what is
    proven of the gain is proven elsewhere.
    """
    W, C, D, through, noisy = loops.channel(r, m)
    _, B, _ = loops.matrices
    KC, KD = K @ loops.measured, K @ noisy
    A, W, C, through = loops.closed(K), W + B @ KD, C + D @ KC, through + D @ KD
    s = np.linalg.eigvals(A)
    sizes = np.abs(s)
    grid = np.geomspace(max(sizes.min(), 1e-9 * sizes.max()), sizes.max(), GRID)
    grid = np.r_[0, grid, sizes.max() * BEYOND]
    omega = np.concatenate([np.tile(grid, (len(A), 1)), sizes, abs(s.imag)], axis=1)
    omega = np.sort(omega, axis=1)

    def gains(which, omega):
        pencil = 1j * omega[..., None, None] * np.eye(A.shape[1]) - A[which, None]
        answers = C[which, None] @ np.linalg.solve(pencil, W[which, None] + 0j)
        return np.linalg.norm(answers + through[which, None], 2, axis=(2, 3))

    found = gains(np.arange(len(A)), omega)
    around = np.pad(found, ((0, 0), (1, 1)), constant_values=-np.inf)
    hills = (found > around[:, :-2]) & (found >= around[:, 2:])
    ranked = np.argsort(np.where(hills, found, -np.inf), axis=None)[::-1][:HILLS]
    i, k = np.unravel_index(ranked, found.shape)
    mid, top, all_omega = omega[i, k], found[i, k], omega[i]
    low = np.where(all_omega < 0.999 * mid[:, None], all_omega, 0).max(axis=1)
    beyond = np.where(all_omega > 1.001 * mid[:, None], all_omega, np.inf)
    high = np.minimum(beyond.min(axis=1), 2 * omega[i, -1])
    for _ in range(NARROWER):
        two = np.array([(low + mid) / 2, (mid + high) / 2]).T
        a, b = gains(i, two).T
        left, right = (a > top) & (a >= b), (b > top) & (b > a)
        low, high = (
            np.where(left, low, np.where(right, mid, two[:, 0])),
            np.where(right, high, np.where(left, mid, two[:, 1])),
        )
        mid = np.where(left, two[:, 0], np.where(right, two[:, 1], mid))
        top = np.maximum(top, np.maximum(a, b))
    best = int(np.argmax(top))
    value, i, omega = top[best], i[best], mid[best]
    ends = np.linalg.norm(through, 2, axis=(1, 2))
    if ends.max() > value:
        i = int(np.argmax(ends))
        U, _, V = np.linalg.svd(through[i])
        left, right = U[:, 0] @ D[i], noisy @ V[0]
        return ends[i], np.outer(left, right)
    both = np.linalg.solve(
        1j * omega * np.eye(A.shape[1]) - A[i], np.hstack([W[i], B[i]]) + 0j
    )
    w, u = both[:, : W.shape[2]], both[:, W.shape[2] :]
    U, _, V = np.linalg.svd(C[i] @ w + through[i])
    left = U[:, 0].conj() @ (C[i] @ u + D[i])
    right = (loops.measured @ w + noisy) @ V[0].conj()
    return value, np.outer(left, right).real


def reached(loops, K, r, m, units):
    """The bound that the worst loop reaches of a requirement, and its slope in K.

    ``loops``, ``K``: as in `Poles`; ``r``: with a bound; ``m``: number of inputs u;
    ``units``, (k,): of the free numbers.
    """

    def worst(K):
        some = [loops.descriptor(i, K, m) for i in range(len(loops))]
        values = [r.reached([d], gain) for d, gain in some]
        i = int(np.argmax(values))
        return values[i], i, some[i]

    value, i, (d, gain) = worst(K)
    if isinstance(r, QuadraticCost):
        _, B, *_ = loops.matrices
        of_A, of_K, of_W = r.slopes(d, gain)
        S = B[i].T @ (of_A @ loops.measured.T + of_W @ loops.noisy.T)
        S[:m] += of_K @ loops.measured.T
        return value, S
    S = np.zeros_like(K)
    steps = np.abs(loops.directions) * (STEP * units)[:, None, None]
    for i, j in np.argwhere(loops.directions.any(axis=0)):
        for h in steps[:, i, j].max() * np.array([1, -1]):  # one side may be unstable
            moved = K.copy()
            moved[i, j] += h
            S[i, j] = (worst(moved)[0] - value) / h
            if np.isfinite(S[i, j]):
                break
    return value, S
