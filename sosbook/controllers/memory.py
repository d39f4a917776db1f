"""What a controller remembers: an estimate of the state, older outputs, integrals.

All of it is one linear system, x+ = A x + B y + B_r r + W (v - u), u = C x + D y +
D_r r, where v is what is left of u after its limits.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_discrete_are

from ..exact.rational import exact, round_digits
from ..sampled.discretize import SampleTiming

DIGITS = 12  # significant decimal digits of what is computed for a controller
OF_GAINS = 6  # of an observer's gains: any near the best ones will do
ROUNDING = 1e-9  # of the largest entry: what is smaller is zero but for rounding
REST = 1e-12  # of the noise of the process, on every state: no gain dies out


@dataclass(frozen=True, eq=False)
class Estimate:
    """x^ = stay s + take y of a memory s+ = A s + B y + older v(k-1), ... + now v(k).

    Parameters
    ----------
    stay, take : (N, l) and (N, q) arrays
        How the estimate of the plant's state is made.
    A, B : (l, l) and (l, q) arrays
        How the memory moves.
    older, now : (l, m d) and (l, m) arrays
        How outputs act on it: those of ticks before, the last one first, and this.
    start : (l, q) array
        The memory at the start, of what is measured there.
    states : tuple of str
        What s is, in words.
    words : str
        What kind of estimate it is.
    predicts : (q, l) array or None
        What will be measured, of s; None: it is what was measured last.
    errors : bool
        Whether set points are those of the first readings, by `shifted`, rather than
        of the coordinates.
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

    @property
    def knows_the_output(self):
        """Whether it moves by outputs, and needs those of ticks before."""
        return bool(self.older.any() or self.now.any())

    @property
    def winds_up(self):
        """Whether it is a law's that doesn't forget by itself."""
        sizes = abs(np.linalg.eigvals(self.A)) if self.errors else []
        return max(sizes, default=0) > 1 - ROUNDING


def direct(rows, m):
    """The estimate where ``rows`` pick the whole state of a plant with m inputs."""
    (q, N), none = rows.shape, np.zeros((0, 0))
    return Estimate(
        np.zeros((N, 0)),
        np.linalg.inv(rows),
        none,
        np.zeros((0, q)),
        none,
        np.zeros((0, m)),
        np.zeros((0, q)),
    )


def filtered(rows, n, m, T, tracking, names):
    """Rates by a filter of first order, where all coordinates are measured.

    ``rows``, (q, 2n): what is measured of [z; z']; all z are; ``n``, ``m``: coordinates
    and inputs; ``T``, ``tracking``: the time between samples and the filter's time
    constant, in s; with zero it is the difference of two samples; ``names``: of the
    coordinates.
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
    return Estimate(
        stay,
        take,
        (1 - share) * np.eye(len(late)),
        share * picks,
        np.zeros((len(late), 0)),
        np.zeros((len(late), m)),
        picks,
        tuple(f"{names[k]}, filtered" for k in late),
        f"rates by {what}",
    )


def observed(d, timing, rows, M, names):
    """A Kalman filter at the ticks: x^ = s + M (y - rows s), s predicted from x^.

    ``d``: the plant that it knows; ``timing``: when it samples, and how late outputs
    act; ``rows``, (q, N): what is measured; ``M``, (N, q): how far the estimate follows
    what is measured; ``names``: of the plant's state.
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
    return Estimate(
        stay,
        M,
        flow @ stay,
        flow @ M,
        A[:N, N:],
        B[:N],
        round_digits(start, DIGITS),
        tuple(f"{name}, predicted" for name in names),
        "an observer at the ticks",
        rows,
    )


def kalman(d, T, rows, noise, push):
    """M of the stationary Kalman filter of a plant for a process noise.

    ``d``: the plant; ``T``: time between samples, in s; ``rows``, (q, N): what is
    measured; ``noise``, (q,): standard deviation of what is measured; ``push``: that of
    the inputs and disturbances that nobody knows, from tick to tick.
    """
    forced = np.hstack([d.Bu, d.Bw]) if d.Bw.size else d.Bu
    N = len(d.E)
    if not d.Bw.size:  # forces on every equation
        forced = np.hstack([forced, np.eye(N)[:, N // 2 :]])
    wide = type(d)(d.E, d.A, forced, d.Bw, d.C)
    A, G = SampleTiming.of(T, 0.0).held(wide)
    size = np.linalg.norm(G, axis=0)
    G = G / np.where(size > 0, size, 1)
    process = push**2 * (G @ G.T)
    process = process + REST * np.trace(process) * np.eye(N)
    R = np.diag(noise**2)
    P = solve_discrete_are(A.T, rows.T, process, R)
    return round_digits(np.linalg.solve(rows @ P @ rows.T + R, rows @ P).T, OF_GAINS)


def assembled(estimate, timing, K_x, K_I, sums, T, K_r):
    """The matrices A, B, B_r, C, D, D_r, W of a controller, and what its states are.

    ``estimate``: of the plant's state; ``timing``: how late outputs act; ``K_x``,
    ``K_I``, (m, N) and (m, a): gains of the state and of the integrals; ``sums``, (a,
    q): what is integrated, of what is measured; ``T``: time between samples, in s;
    ``K_r``, (m, p): how the set points act on u at once. Returns the matrices by name.
    W has what the limits take away in the registers and in the estimate; the integrals
    know nothing of it yet.
    """
    m, a, p = len(K_x), K_I.shape[1], K_r.shape[1]
    l, q = estimate.A.shape[0], estimate.take.shape[1]
    d = m * timing.n_past_inputs if estimate.knows_the_output else 0
    order = l + d + a
    older = estimate.older if d else np.zeros((l, 0))
    C = np.hstack([K_x @ estimate.stay, np.zeros((m, d)), K_I])
    D = K_x @ estimate.take
    A, B, B_r, W = (np.zeros((order, k)) for k in (order, q, p, m))
    A[:l, :l], A[:l, l : l + d] = estimate.A, older
    A[l + m : l + d, l : l + d - m] = np.eye(max(d - m, 0))
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
    """The ``parts`` of a controller that takes readings R r for zeros, exactly.

    ``parts``: of `assembled`; ``start``, (l, q): the memory at rest, of what is
    measured there; ``R``, (n, p): the first n readings for one unit of each set point.
    """
    l, n = len(start), len(R)
    A, B, C, D, rest, r = map(exact, (*(parts[x] for x in "ABCD"), start, R))
    moved = rest - A[:l, :l] @ rest - B[:l]
    asked = D + C[:, :l] @ rest
    B_r = parts["B_r"].copy()
    B_r[:l] = moved[:, :n] @ r
    return parts | {"B_r": B_r, "D_r": -np.asarray(asked[:, :n] @ r, float) + 0.0}


def forgetting(A, C, share):
    """The least W for which all eigenvalues of A - W C are within a ``share`` of one.

    So a memory x+ = A x + W (v - u), u = C x, forgets while its output is held.

    Notes
    -----
    The gain of a Kalman filter without noise of the process mirrors what isn't within.
    """
    fast, rest = A / share, REST * np.eye(len(A))
    P = solve_discrete_are(fast.T, C.T, rest, np.eye(len(C)))
    gain = np.linalg.solve(C @ P @ C.T + np.eye(len(C)), C @ P @ fast.T).T
    return round_digits(share * gain, OF_GAINS)
