"""How far a law's loops are from what is asked, and which way that falls."""

from contextlib import suppress
from functools import cached_property

import numpy as np

GRID = 24  # frequencies between the slowest and the fastest pole
BEYOND = np.geomspace(1, 10, 7)[1:]  # times the fastest pole: zeros may be there
HILLS = 4  # of the highest frequencies, each of which may be beside the peak
CLIMBS = 6  # steps to the top of a hill
WIDER = 4  # times the other side of the top: such a side gets a point of its own
SKEWED = 1e6  # of the inverse of the modes: with larger ones pencils are solved
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

    @cached_property
    def modes(self):
        """The inverses of V; None where poles are too near each other for them."""
        with suppress(np.linalg.LinAlgError):
            modes = np.linalg.inv(self.V)
            if abs(modes).max() < SKEWED:
                return modes
        return None

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


def norm(loops, K, r, m, poles=None, beyond=np.inf):
    """The largest H-infinity norm of stable ``loops``, and its slope in ``K``, of the
    channel of ``r``, with ``m`` inputs u; ``poles`` are theirs, if known. A search in
    frequency, no bound: what is proven of the gain is proven elsewhere. Where the first
    frequencies show more than is ``beyond``, they do, and the slope is None.
    """
    W, C, D, through, noisy = loops.channel(r, m)
    _, B, _ = loops.matrices
    KC, KD = K @ loops.measured, K @ noisy
    A, W, C, through = loops.closed(K), W + B @ KD, C + D @ KC, through + D @ KD
    poles, half = poles or Poles(loops, K), 0.5j * (r.step or 0.0)
    s, modes, one = poles.s, poles.modes, np.eye(A.shape[1])
    sizes = np.abs(s)
    grid = np.geomspace(max(sizes.min(), 1e-9 * sizes.max()), sizes.max(), GRID)
    grid = np.concatenate([[0.0], grid, sizes.max() * BEYOND])
    omega = np.concatenate([np.tile(grid, (len(A), 1)), sizes, abs(s.imag)], axis=1)
    omega = np.sort(omega, axis=1)
    if modes is not None:
        seen, pushed = C @ poles.V, modes @ W

    def gains(i, omega):
        """Of the loops i, each at its row of frequencies; of ticks on z's circle, by
        the bilinear of `hinf_norm`.
        """
        omega = omega / (1 - half * omega)
        if modes is None:
            pencil = 1j * omega[..., None, None] * one - A[i, None]
            answers = C[i, None] @ np.linalg.solve(pencil, W[i, None] + 0j)
        else:
            near = 1 / (1j * omega[..., None] - s[i, None])
            answers = (seen[i, None] * near[..., None, :]) @ pushed[i, None]
        return _largest(answers + through[i, None])

    found = gains(np.arange(len(A)), omega)
    if beyond < found.max() < np.inf:
        return found.max(), None
    hills = np.ones(found.shape, bool)
    hills[:, 1:] = found[:, 1:] > found[:, :-1]
    hills[:, :-1] &= found[:, :-1] >= found[:, 1:]
    ranked = np.argsort(np.where(hills, found, -np.inf), axis=None)[::-1][:HILLS]
    i, k = np.unravel_index(ranked, found.shape)
    mid, all_omega = omega[i, k], omega[i]
    low = np.where(all_omega < 0.999 * mid[:, None], all_omega, 0).max(axis=1)
    beyond = np.where(all_omega > 1.001 * mid[:, None], all_omega, np.inf)
    high = np.minimum(beyond.min(axis=1), 2 * omega[i, -1])
    best, omega = _summit(lambda w: gains(i, w), np.array([low, mid, high]).T)
    i, omega = i[best], omega / (1 - half * omega)
    both = np.linalg.solve(1j * omega * one - A[i], np.hstack([W[i], B[i]]) + 0j)
    w, u = both[:, : W.shape[2]], both[:, W.shape[2] :]
    U, (value, *_), V = np.linalg.svd(C[i] @ w + through[i])
    left = U[:, 0].conj() @ (C[i] @ u + D[i])
    right = (loops.measured @ w + noisy) @ V[0].conj()
    ends = _largest(through)
    if ends.max() > value:
        i = int(np.argmax(ends))
        U, (value, *_), V = np.linalg.svd(through[i])
        left, right = U[:, 0] @ D[i], noisy @ V[0]
    return value, np.outer(left, right).real


def _summit(gains, omega):
    """Which of some hills is the highest, and where. ``gains`` takes a row of
    frequencies of each; ``omega``, (k, 3), are one on it and those on both sides. The
    inverse square of the gain is a parabola beside a mode that is lightly damped: its
    lowest point is tried, and another as far behind it, or one in a far wider side.
    """
    rows = np.arange(len(omega))[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        y = gains(omega) ** -2.0
        for _ in range(CLIMBS):
            (low, mid, high), (left, top, right) = omega.T, y.T
            a, b, left, right = mid - low, high - mid, left - top, right - top
            step = (b**2 * left - a**2 * right) / (2 * (b * left + a * right))
            step = np.where(np.isfinite(step), step, 0)
            up = np.where(step == 0, b > a, step > 0)
            way, room, other = 2 * up - 1, np.where(up, b, a), np.where(up, a, b)
            step = np.maximum(abs(step), 1e-7 * mid + 1e-3 * room)
            step = np.minimum(step, 0.9 * room)
            behind = step + np.minimum(step, (room - step) / 2)
            behind = np.where(other > WIDER * room, -other / (2 * WIDER), behind)
            more = np.array([mid + way * step, mid + way * behind]).T
            omega = np.concatenate([omega, more], axis=1)
            y = np.concatenate([y, gains(more) ** -2.0], axis=1)
            order = omega.argsort(axis=1)
            at = y[rows, order[:, 1:-1]].argmin(axis=1)[:, None] + np.arange(3)
            at = order[rows, at]
            omega, y = omega[rows, at], y[rows, at]
    k = int(np.argmin(y[:, 1]))
    return k, omega[k, 1]


def _largest(G):
    """The largest singular value of each matrix of a stack."""
    if G.shape[-2] < G.shape[-1]:
        G = G.swapaxes(-1, -2)
    square = G.conj().swapaxes(-1, -2) @ G
    if G.shape[-1] == 1:
        return np.sqrt(square[..., 0, 0].real)
    if G.shape[-1] == 2:
        a, b = square[..., 0, 0].real / 2, square[..., 1, 1].real / 2
        return np.sqrt(a + b + np.hypot(a - b, abs(square[..., 0, 1])))
    return np.sqrt(np.linalg.eigvalsh(square)[..., -1])


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
    known = r.slopes(d, gain)
    if known is not None:
        _, B, *_ = loops.matrices
        of_A, of_K, of_W = known
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
