"""The rightmost characteristic roots, by collocation and Newton's method.

The generator of x'(t) = A x(t) + A_d x(t - h) is discretised on Chebyshev
nodes (Breda, Maset and Vermiglio 2005); each of its eigenvalues is then
polished on the characteristic matrix itself.
"""

import numpy as np
from scipy.linalg import eigvals, matrix_balance

LARGEST_ORDER = 1000  # of an eigenvalue problem that is solved
SHORT = 1e-8  # of the loop's own times: a delay of which squares are rounding
EPS = np.finfo(float).eps


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
    """Whether the root s exists only by rounding errors in A_d.

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
