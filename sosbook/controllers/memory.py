"""The memory of a controller (an estimate of the state, older outputs, integrals), one
linear system: x+ = A x + B y + B_r r + W (v - u), u = C x + D y + D_r r, where v is
what is left of u after its limits.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_discrete_are

from ..exact.rational import exact, round_digits

DIGITS = 12  # significant decimal digits of what is computed for a controller
OF_GAINS = 6  # of an observer's gains: any near the best ones will do
ROUNDING = 1e-9  # of the largest entry: what is smaller is zero but for rounding
REST = 1e-12  # of the noise of the process, on every state: no gain dies out


@dataclass(frozen=True, eq=False)
class Estimate:
    """x^ = stay s + take y of a memory s+ = A s + B y + older v(k-1), ... + now v(k).

    ``older``, (l, m d), takes outputs of ticks before, the last first; the memory
    begins at ``start`` times what is measured; ``states``: what s is, in words;
    ``words``: what kind of estimate it is; ``predicts``, (q, l): what will be measured,
    of s; None: as last; ``errors``: set points are those of the first readings, by
    `shifted`, not of the coordinates; ``chosen``: the `Chosen` observer, if one is.
    """

    stay: np.ndarray
    take: np.ndarray
    A: np.ndarray
    B: np.ndarray
    older: np.ndarray
    now: np.ndarray
    start: np.ndarray
    states: tuple = ()
    words: str = "everything is measured"
    predicts: np.ndarray | None = None
    errors: bool = False
    chosen: object = None

    @property
    def knows_the_output(self):
        """True if the memory moves by outputs, and needs those of ticks before."""
        return bool(self.older.any() or self.now.any())

    @property
    def winds_up(self):
        """True if a law's memory doesn't forget by itself."""
        sizes = abs(np.linalg.eigvals(self.A)) if self.errors else []
        return max(sizes, default=0) > 1 - ROUNDING


def direct(rows, m):
    """The estimate where ``rows`` pick the whole state of a plant with m inputs."""
    (q, N), none = rows.shape, np.zeros((0, 0))
    seen, given = np.zeros((0, q)), np.zeros((0, m))
    back = np.linalg.inv(rows)
    return Estimate(np.zeros((N, 0)), back, none, seen, none, given, seen)


def filtered(rows, n, m, T, tracking, names):
    """Rates by a filter of time constant ``tracking`` (zero: differences) every T s; of
    [z; z'], n coordinates with ``names``, ``rows`` has all z; m inputs.
    """
    share = round_digits([1 - np.exp(-T / tracking) if tracking else 1.0], DIGITS)[0]
    q = len(rows)
    seen = [bool(rows[:, n + k].any()) for k in range(n)]
    take = rows.T.copy()  # what is measured stays so
    late = [k for k in range(n) if not seen[k]]
    picks = np.array([rows[:, k] for k in late]).reshape(len(late), q)
    stay = np.zeros((2 * n, len(late)))
    for j, k in enumerate(late):
        take[n + k] = share / T * picks[j]
        stay[n + k, j] = -share / T
    what = f"a filter of {tracking:g} s" if tracking else "the difference of samples"
    A, now = (1 - share) * np.eye(len(late)), np.zeros((len(late), m))
    words = tuple(f"{names[k]}, filtered" for k in late), f"rates by {what}"
    return Estimate(stay, take, A, share * picks, now[:, :0], now, picks, *words)


def observed(d, timing, rows, M, names):
    """A Kalman filter at the ticks: x^ = s + M (y - rows s), s predicted from x^ by a
    plant d that it knows, with ``timing`` and ``names`` of the plant's state.
    """
    A, B = timing.held(d)
    N = len(d.E)
    stay = np.eye(N) - M @ rows
    flow = A[:N, :N]
    # of all states with these readings the one that is nearest to rest
    start = np.linalg.pinv(rows)
    free = np.linalg.svd(rows)[2][len(rows) :].T
    moves = np.linalg.solve(d.E, d.A)
    start = start - free @ (np.linalg.pinv(moves @ free) @ (moves @ start))
    start = np.where(abs(start) > ROUNDING * abs(start).max(), start, 0.0)
    start = round_digits(start, DIGITS)
    words = tuple(f"{name}, predicted" for name in names), "an observer at the ticks"
    moved = flow @ stay, flow @ M, A[:N, N:], B[:N]
    return Estimate(stay, M, *moved, start, *words, predicts=rows)


def kalman(d, timing, rows, noise, push):
    """M of the stationary Kalman filter of d at the ticks of a ``timing``: ``rows``,
    (q, N), have standard deviations ``noise``, unknown inputs and disturbances
    ``push``, at each one.
    """
    forced = np.hstack([d.Bu, d.Bw]) if d.Bw.size else d.Bu
    N = len(d.E)
    if not d.Bw.size:  # forces on every equation
        forced = np.hstack([forced, np.eye(N)[:, d.n :]])
    wide = type(d)(d.E, d.A, forced, d.Bw, d.C)
    A, G = timing.at_once.held(wide)
    size = np.linalg.norm(G, axis=0)
    G = G / np.where(size > 0, size, 1)
    process = push**2 * (G @ G.T)
    process = process + REST * np.trace(process) * np.eye(N)
    R = np.diag(noise**2)
    P = solve_discrete_are(A.T, rows.T, process, R)
    return round_digits(np.linalg.solve(rows @ P @ rows.T + R, rows @ P).T, OF_GAINS)


def assembled(estimate, timing, K_x, K_I, sums, T, K_r):
    """The matrices A, B, B_r, C, D, D_r, W of a controller by name, and what its states
    are.

    ``estimate`` is of the plant's state; ``timing``: how late outputs act; ``K_x``,
    ``K_I``: gains of the state and of the integrals of ``sums``, (a, q), of what is
    measured every T s; ``K_r``: set points act on u at once. W has what the limits take
    away in the registers and in the estimate; the integrals know nothing of it yet.
    """
    m, a, p = len(K_x), K_I.shape[1], K_r.shape[1]
    l, q = estimate.A.shape[0], estimate.take.shape[1]
    d = m * timing.n_past_inputs if estimate.knows_the_output else 0
    order = l + d + a
    known = min(d, estimate.older.shape[1])  # none of later inputs
    older = np.pad(estimate.older[:, :known], ((0, 0), (0, d - known)))
    C = np.hstack([K_x @ estimate.stay, np.zeros((m, d)), K_I])
    D = K_x @ estimate.take
    A, B, B_r, W = (np.zeros((order, k)) for k in (order, q, p, m))
    A[:l, :l], A[:l, l : l + d] = estimate.A, older
    A[l + m : l + d, l : l + max(d - m, 0)] = np.eye(max(d - m, 0))
    A[l + d :, l + d :] = np.eye(a)
    B[:l], B[l + d :] = estimate.B, T * sums
    if a:
        B_r[l + d :, :a] = -T * np.eye(a, p)
    W[:l] = estimate.now
    if d:
        W[l : l + m] = np.eye(m)
    found = dict(A=A + W @ C, B=B + W @ D, B_r=B_r + W @ K_r, C=C, D=D, D_r=K_r, W=W)
    found = {name: round_digits(x, DIGITS) for name, x in found.items()}
    registers = tuple(f"output {k % m + 1} of {k // m + 1} ticks ago" for k in range(d))
    return found, estimate.states + registers


def shifted(parts, start, R):
    """The ``parts`` of `assembled` that take readings R r for zeros, exactly:
    ``start``, (l, q), is the memory at rest, R, (n, p), n readings for units of r.
    """
    l, n = len(start), len(R)
    A, B, C, D, rest, r = map(exact, (*(parts[x] for x in "ABCD"), start, R))
    moved = rest - A[:l, :l] @ rest - B[:l]
    asked = D + C[:, :l] @ rest
    B_r = parts["B_r"].copy()
    B_r[:l] = moved[:, :n] @ r
    return parts | {"B_r": B_r, "D_r": -np.asarray(asked[:, :n] @ r, float) + 0.0}


def forgetting(A, C, share):
    """The least W for which all eigenvalues of A - W C are within a ``share`` of one,
    so that a memory x+ = A x + W (v - u), u = C x, forgets while its output is held.
    The gain of a Kalman filter without noise of the process mirrors what isn't within.
    """
    fast, rest = A / share, REST * np.eye(len(A))
    P = solve_discrete_are(fast.T, C.T, rest, np.eye(len(C)))
    gain = np.linalg.solve(C @ P @ C.T + np.eye(len(C)), C @ P @ fast.T).T
    return round_digits(share * gain, OF_GAINS)
