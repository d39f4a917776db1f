"""Characteristic roots of loops with one delay.

Everything here is about x'(t) = A x(t) + A_d x(t - h) with a constant
delay h: what is true of the loop, to be held beside what an LMI proves.
Its roots are the zeros of det(s I - A - A_d e^(-s h)). The generator is discretised on
Chebyshev nodes (Breda, Maset and Vermiglio 2005), and each of its eigenvalues is then
polished on the characteristic matrix itself.
"""

import numpy as np
from scipy.linalg import eigvals, matrix_balance

from ..bisection import lowest
from ..plants.checks import matrix, not_negative

LARGEST_ORDER = 1000  # of an eigenvalue problem that is solved
SHORT = 1e-8  # of the loop's own times: a delay of which squares are rounding
EPS = np.finfo(float).eps


def delayed_loop(d, K):
    """A and A_d of the loop of a plant with a delayed input.

    Parameters
    ----------
    d : Descriptor
        E x' = A x + B_u u(t - h).
    K : (m, N) array_like
        The gain ``[K_P K_D K_I]`` in u = K x.

    Returns
    -------
    A, A_d : (N, N) arrays
        E^-1 A and E^-1 B_u K.

    Notes
    -----
    Source: thesis (2.10). K_A must be zero: an acceleration that is fed
    back late makes a neutral loop, which isn't of this form.

    Examples
    --------
    >>> from sosbook import SecondOrderSystem
    >>> from sosbook.plants.descriptor import descriptors
    >>> d, = descriptors(SecondOrderSystem([[1]], [[0]], [[4]], [[2]]))
    >>> A, A_d = delayed_loop(d, [[-1, -3]])
    >>> A_d
    array([[ 0.,  0.], [-2., -6.]])
    """
    N, m = d.Bu.shape
    A, Bu, _ = d.state_space()
    return A, Bu @ matrix("K", K, (m, N))


def characteristic_roots(A, A_d, delay, count=10):
    """The rightmost roots of det(s I - A - A_d e^(-s delay)).

    Parameters
    ----------
    A, A_d : (N, N) array_like
        The matrices of x' = A x + A_d x(t - d).
    delay : float
        In seconds, 0 or more.
    count : int
        How many. There are N without delay, else mostly infinitely
        many. A conjugate pair isn't split, so one more may come.

    Returns
    -------
    (k,) complex array
        In rad/s, by falling real part, the upper root of a pair first; a multiple root
        as often as its multiplicity. No root right of the last one is missing. There
        are fewer than ``count`` where the loop has only finitely many, or where
        rounding errors in A_d decide about those further left; N where the delay is
        below 1e-8 of the loop's own times, and the others are far away.

    Raises
    ------
    ValueError
        On bad input, and if ``delay`` is so long that the roots would
        need a discretisation with more than 1000 unknowns.

    Notes
    -----
    Chebyshev collocation of the infinitesimal generator (Breda, Maset, Vermiglio, SIAM
    J. Sci. Comput. 27, 2005), of the delayed signals only: A_d of rank r gives an
    eigenvalue problem of order N + r k, with k nodes. Roots right of c lie in the disk
    whose radius is the largest spectral radius of A + A_d e^(-c delay + j theta); k is
    raised until that disk is resolved, for c of the last root found (Wu and Michiels,
    J. Comput. Appl. Math. 236, 2012). Newton's method on the smallest singular value of
    the characteristic matrix polishes each root; what it leaves with a residual is
    dropped. Entries of A_d below rounding of its largest singular value count as zero.

    Examples
    --------
    >>> characteristic_roots([[0]], [[-1]], delay=1, count=2).round(6)
    array([-0.318132+1.337236j, -0.318132-1.337236j])
    """
    A, A_d = checked_pair(A, A_d)
    delay = not_negative("delay", delay)
    whole = isinstance(count, (int, np.integer))
    if not whole or isinstance(count, bool) or count < 1:
        raise ValueError(f"count must be a positive integer, got {count!r}")
    return rightmost_roots(A, A_d, delay, int(count))


def spectral_abscissa(A, A_d, delay):
    """Real part of the rightmost root of x' = A x + A_d x(t - delay), in 1/s.

    Minus this number is the loop's exponential decay rate under that constant delay.
    Parameters, errors and method as in `characteristic_roots`.

    Examples
    --------
    >>> round(spectral_abscissa([[-1]], [[0.5]], 0), 9)
    -0.5
    """
    A, A_d = checked_pair(A, A_d)
    delay = not_negative("delay", delay)
    return rightmost_real(A, A_d, delay)


def slowest_decay(A, A_d, low, high):
    """The slowest decay over all constant delays of an interval.

    Parameters
    ----------
    A, A_d : (N, N) array_like
        The matrices of x' = A x + A_d x(t - d).
    low, high : float
        Ends of the interval, in seconds; 0 <= low <= high.

    Returns
    -------
    rate : float
        The smallest decay rate, in 1/s; negative if a delay is unstable.
    delay : float
        Where.

    Notes
    -----
    A grid with 16 steps to a period of the fastest root that can be the rightmost (32
    to 2000 steps in all), then Brent's method around each local minimum of the grid.
    The rate is attained at ``delay``, so the true minimum is no greater. That it is no
    smaller holds as far as the grid sees each dip; it isn't proven.

    Examples
    --------
    >>> rate, delay = slowest_decay([[0]], [[-1]], 0.1, 1)
    >>> round(rate, 6), delay
    (0.318132, 1.0)
    """
    A, A_d = checked_pair(A, A_d)
    low, high = not_negative("low", low), not_negative("high", high)
    if low > high:
        raise ValueError(f"low must not exceed high, got {low} > {high}")

    def rate(h):
        return -rightmost_real(A, A_d, h)

    if low == high:
        return rate(low), low
    slowest = min(rate(low), rate(high))
    turns = root_radius(A * high, A_d * high, -slowest * high) / (2 * np.pi)
    steps = np.clip(16 * turns * (1 - low / high), 32, 2000)
    grid = np.linspace(low, high, int(np.ceil(steps)) + 1)
    rates = np.array([rate(h) for h in grid])
    best = [(float(rates.min()), float(grid[rates.argmin()]))]
    inner = (rates[1:-1] <= rates[:-2]) & (rates[1:-1] <= rates[2:])
    for i in np.flatnonzero(inner) + 1:
        where, least = lowest(rate, grid[i - 1], grid[i + 1], 1e-9 * high)
        best.append((float(least), float(where)))
    return min(best)


def checked_pair(A, A_d):
    """A and A_d, checked and balanced: a diagonal similarity keeps every root."""
    A = matrix("A", A)
    if A.shape[0] == 0:
        raise ValueError("A is empty: a loop has at least one state")
    A = matrix("A", A, (len(A), len(A)))
    A_d = matrix("A_d", A_d, A.shape)
    return balanced(A, A_d)


def rightmost_real(A, A_d, delay):
    """The real part of the rightmost root of A and A_d with a constant ``delay``."""
    return float(rightmost_roots(A, A_d, delay, 1)[0].real)


def decays(A, A_d, delay):
    """True if the loop of A and A_d decays for a ``delay``, by more than rounding."""
    size = np.linalg.norm(A) + np.linalg.norm(A_d)
    return rightmost_real(A, A_d, delay) < -1e-12 * size


def balanced(A, A_d, growth=1.0):
    """A and A_d after a diagonal similarity, with A_d weighted by ``growth``."""
    _, (scale, _) = matrix_balance(
        abs(A) + growth * abs(A_d), permute=False, separate=True
    )
    change = scale / scale[:, None]
    return A * change, A_d * change


def rightmost_roots(A, A_d, delay, count):
    """`characteristic_roots` of checked A, A_d and ``delay``: ``count`` of them."""
    if delay == 0 or not A_d.any():
        roots = eigvals(A + A_d)
        return _paired(roots[roots.imag >= 0], count)
    # in the delay's unit of time, as a product of thin matrices
    A, A_d = A * delay, A_d * delay
    if np.linalg.norm(A) + np.linalg.norm(A_d) < SHORT:
        # e^-s = 1 - s; other roots lie left of -18, a billion times as far
        roots = eigvals(np.linalg.solve(np.eye(len(A)) + A_d, A + A_d)) / delay
        return _paired(roots[roots.imag >= 0], count)
    left, right = rank_factors(A_d)
    nodes, enough = 20, max(160, 4 * count)
    while True:
        order = len(A) + len(right) * nodes
        if order > LARGEST_ORDER:
            raise ValueError(
                f"delay is too long for this loop: {order} unknowns are "
                f"needed to resolve its roots, {LARGEST_ORDER} are allowed; "
                "shorten it or leave out the loop's fast modes"
            )
        starts = eigvals(_generator(A, left, right, nodes))
        resolved = (abs(starts) <= (nodes - 15) / 0.6) & (
            starts.real > -600
        )  # so that e^-s is a number
        starts = starts[resolved & (starts.imag >= 0)]
        starts = starts[np.argsort(-starts.real)][: count + 4]
        roots = _paired(_polish(A, A_d, starts), count)
        needed = 2 * nodes
        if len(roots):
            needed = 15 + 0.6 * root_radius(A, A_d, roots[-1].real)
        if nodes >= needed and (len(roots) >= count or nodes >= enough):
            return roots / delay
        if nodes >= needed:
            needed = enough
        nodes = int(np.ceil(min(needed, 2 * nodes)))


def _paired(upper, count):
    """With conjugates, by falling real part, cut behind ``count``."""
    upper = upper[np.lexsort((upper.imag, -upper.real))]
    paired = []
    for root in upper:
        if len(paired) >= count:
            break
        paired += [root] if root.imag == 0 else [root, root.conjugate()]
    return np.array(paired, complex)


def rank_factors(A_d):
    """A_d = left @ right, with as few columns as its rank."""
    U, size, Vh = np.linalg.svd(A_d)
    rank = int((size > len(A_d) * EPS * size[0]).sum())
    root = np.sqrt(size[:rank])
    return U[:, :rank] * root, root[:, None] * Vh[:rank]


def _generator(A, left, right, nodes):
    """Of x' = A x + left y(-1), y(t) = right x(t), on Chebyshev nodes.

    The unknowns are x(t) and y at t + node, without the node 0, where y
    is known; there y' is the derivative of the interpolant.
    """
    N, r = len(A), len(right)
    slope = _differentiation(nodes)[1:]
    G = np.zeros((N + r * nodes, N + r * nodes))
    G[:N, :N] = A
    G[:N, -r:] = left
    G[N:, :N] = np.kron(slope[:, :1], right)
    G[N:, N:] = np.kron(slope[:, 1:], np.eye(r))
    return G


def _differentiation(nodes):
    """Chebyshev's, on [-1, 0], from 0 downwards (Trefethen's cheb)."""
    k = np.arange(nodes + 1)
    x = (np.cos(np.pi * k / nodes) - 1) / 2
    c = np.where((k == 0) | (k == nodes), 2.0, 1.0) * (-1.0) ** k
    D = np.outer(c, 1 / c) / (x[:, None] - x + np.eye(nodes + 1))
    return D - np.diag(D.sum(axis=1))


def root_radius(A, A_d, c):
    """Roots right of c, for delay 1, lie within this radius.

    They are eigenvalues of A + A_d z with abs(z) <= e^-c, and by the maximum principle
    that circle has the largest. Where it is large, only eigenvalues that aren't clearly
    left of c count: fast stable modes don't. A tenth is added for what lies between
    samples.
    """
    z = np.exp(-c + 1j * np.linspace(0, np.pi, 17))
    size = abs(np.linalg.eigvals(A + A_d * z[:, None, None]))
    if size.max() > 50:
        z = np.outer([1, 0.8, 0.6, 0.4, 0.2, 0], z).ravel()
        s = np.linalg.eigvals(A + A_d * z[:, None, None])
        size = abs(s[s.real >= c - 0.2 * abs(s)])
    return 1.1 * size.max(initial=abs(c))


def _polish(A, A_d, starts):
    """Newton's method from each start, for delay 1; what converged.

    With T(s) v = sigma u, the smallest singular value and its vectors,
    the step is -sigma / (u* T'(s) v). A root stays near its start, so
    that none is found from afar a second time.
    """
    one = np.eye(len(A))
    size = np.linalg.norm(A), np.linalg.norm(A_d)
    reach = 1e-3 * abs(starts) + 1e-5 * sum(size)
    s = starts.astype(complex)
    for _ in range(8):
        decay = np.exp(-s)
        late = A_d * decay[:, None, None]
        U, sigma, Vh = np.linalg.svd(s[:, None, None] * one - A - late)
        u, v = U[:, :, -1].conj(), Vh[:, -1].conj()
        slope = np.einsum("ki,kij,kj->k", u, one + late, v)
        scale = abs(s) + size[0] + size[1] * abs(decay)
        residual = sigma[:, -1] / scale
        moving = (residual > 2 * EPS) & (abs(slope) * reach > 1e-300)
        step = np.where(moving, sigma[:, -1], 0) / np.where(moving, slope, 1)
        step[abs(s - step - starts) > reach] = 0
        if (abs(step) <= 4 * EPS * abs(s)).all():
            break
        s = s - step
    s.imag[starts.imag == 0] = 0
    s = s[residual < 1e-12]
    return s[[not _rounding(A, A_d, root) for root in s]]


def _rounding(A, A_d, s):
    """True if the root s exists only by rounding errors in A_d.

    Far to the left e^-s is so large that the matrix is singular to
    working precision whatever s is, if A_d is nilpotent for example.
    """
    growth = np.exp(-s.real)
    if growth * np.linalg.norm(A_d) < 1e6 * (abs(s) + np.linalg.norm(A)):
        return False
    A, A_d = balanced(A, A_d, growth)  # the scaling may be to blame
    late, rest = np.linalg.norm(A_d) * growth, abs(s) + np.linalg.norm(A)
    T = s * np.eye(len(A)) - A - A_d * np.exp(-s)
    residual = np.linalg.svd(T, compute_uv=False)[-1] / (late + rest)
    return late > 1e6 * rest or residual > 1e-12
