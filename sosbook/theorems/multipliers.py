"""The theorems for a known gain: a Lyapunov matrix per vertex, free multipliers.

With K known the loop E x' = A x + B w is affine in the plant. Its equation joins
the derivative of x' P x with multipliers F and G that are free: no gain waits to
be read from them, so G needn't be a multiple of F, and each requirement has P, F
and G of its own. What holds at the vertices holds between them, with
P(a) = sum a_i P_i and the same F and G.
"""

from ..language import block, eye, he

__all__ = [
    "free_bounded_real",
    "free_gramian",
    "free_lqr_decay",
    "free_pole_region",
    "free_stability",
]


def free_pole_region(c, R11, R12, R22):
    r"""All poles in R11 + R12 s + R12' conj(s) + R22 \|s\|^2 < 0.

    Parameters
    ----------
    c : KnownVertex
        The loop of a vertex.
    R11, R12, R22 : (k, k) arrays
        The matrices of the region; R22 is positive semidefinite.

    Returns
    -------
    (2kN, 2kN) matrix-like
        Positive definite at all vertices, and all P_i > 0, imply: E of every
        plant of the polytope is regular, and all its poles are in the region.

    Notes
    -----
    Source: Peaucelle, Arzelier, Bachelier and Bernussou (2000), here with E. The
    mean of the blocks is that of the plant between, with the mean of the P_i. If
    E v = 0, the last block vanishes at any q x v. Let s be a pole, E s v = A v,
    and q any vector: at [q x v; s q x v] all terms in F and G cancel, and what is
    left is v* P v times q* (R11 + R12 s + ...) q.
    """
    one = eye(len(R11))
    E, A = _kron(one, c.E), _kron(one, c.A)
    cross = _kron(R12, c.P) - c.F @ E + A.T @ c.G.T
    return -block([
        [_kron(R11, c.P) + he(c.F @ A), cross],
        [cross.T, _kron(R22, c.P) - he(c.G @ E)],
    ])


def free_stability(c):
    """The half-plane Re s < 0 for a vertex c."""
    return free_pole_region(c, 0 * eye(1), eye(1), 0 * eye(1))


def free_bounded_real(c, gamma2):
    """The H-infinity norm from w to y = C x is below gamma, for a vertex c.

    ``gamma2`` is the square of gamma. With all P_i > 0 every plant is stable, too.

    Notes
    -----
    Source: the bounded real lemma, by Finsler's. Along a motion the terms in F and
    G vanish, and the first three rows are the derivative of x' P x, less mu w'w;
    the last one, by Schur's complement, adds mu y'y / gamma2.
    """
    cross = c.P - c.F @ c.E + c.A.T @ c.G.T
    FB, GB, C = c.F @ c.B, c.G @ c.B, c.mu * c.C
    y, w = C.shape[0], FB.shape[1]
    return -block([
        [he(c.F @ c.A), cross,           FB,             C.T],
        [cross.T,       -he(c.G @ c.E),  GB,             0],
        [FB.T,          GB.T,            -c.mu * eye(w), 0],
        [C,             0,               0,              -gamma2 * c.mu * eye(y)],
    ])


def free_lqr_decay(c, weight):
    """x' P x falls faster than mu x' (weight) x, for a vertex c.

    Then P / mu lies above the Gramian X of the loop, with E' as the weight of its
    input: the integral of x' (weight) x from x(0) is below x(0)' P x(0) / mu.
    """
    cross = c.P - c.F @ c.E + c.A.T @ c.G.T
    return -block([
        [he(c.F @ c.A) + c.mu * weight, cross],
        [cross.T, -he(c.G @ c.E)],
    ])


def free_gramian(c, J, H):
    """J lies above B' E'^-1 P E^-1 B, the noise's share of the cost, for a vertex c.

    Parameters
    ----------
    c : KnownVertex
        The loop of a vertex.
    J : (p, p) matrix-like
        With noise of intensity one on each channel the cost is below tr J / mu.
    H : (N, N) matrix-like
        A multiplier of its own.

    Notes
    -----
    Source: (H E - P) P^-1 (H E - P)' >= 0, so He(H E) - P <= H E P^-1 E' H'.
    """
    HB = H @ c.B
    return block([[J, HB.T], [HB, he(H @ c.E) - c.P]])


def _kron(factors, x):
    """The Kronecker product of k x k numbers and a matrix."""
    if len(factors) == 1:
        return factors[0][0] * x
    return block([[f * x for f in row] for row in factors])
