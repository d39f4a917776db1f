"""The theorems for a known gain: a Lyapunov matrix per vertex, free multipliers.

With K known the loop E x' = A x + B w is affine in the plant. Its equation joins
the derivative of x' P x with multipliers F and G that are free: no gain waits to
be read from them, so G needn't be a multiple of F, and each requirement has P, F
and G of its own. What holds at the vertices holds between them, with
P(a) = sum a_i P_i and the same F and G.
"""

from ..language import block, eye, he, kron, turned


def free_pole_region(loop, R11, R12, R22):
    r"""All poles in R11 + R12 s + R12' conj(s) + R22 \|s\|^2 < 0.

    Parameters
    ----------
    loop : KnownVertex
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
    one = eye(R11.shape[0])
    E, A = kron(one, loop.E), kron(one, loop.A)
    cross = kron(R12, loop.P) - loop.F @ E + A.T @ loop.G.T
    return -block([
        [kron(R11, loop.P) + he(loop.F @ A), cross],
        [cross.T, kron(R22, loop.P) - he(loop.G @ E)],
    ])


def free_stability(loop):
    """The half-plane Re s < 0 for a vertex loop."""
    return free_pole_region(loop, 0 * eye(1), eye(1), 0 * eye(1))


def free_bounded_real(loop, gamma2, step=0):
    """The H-infinity norm from w to y is below gamma, for a vertex loop.

    ``gamma2`` is the square of gamma. With all P_i > 0 every plant is stable, too.
    ``step`` is the tick of a plant of discrete time, whose change is the loop.

    Notes
    -----
    Source: the bounded real lemma, by Finsler's. Along a motion the terms in F and
    G vanish, and the first three rows are the derivative of x' P x, less mu w'w;
    the last one, by Schur's complement, adds mu y'y / gamma2. From tick to tick, with
    the change v, x' P x rises by step times 2 x' P v + step v' P v.
    """
    cross = loop.P - loop.F @ loop.E + loop.A.T @ loop.G.T
    FB, GB, outputs = loop.F @ loop.B, loop.G @ loop.B, (loop.C, loop.rates, loop.D)
    C, H, D = (0 if isinstance(x, int) else loop.mu * x for x in outputs)
    y, w = C.shape[0], FB.shape[1]
    return -block([
        [he(loop.F @ loop.A), cross,      FB,                C.T],
        [cross.T, _last(loop, step),      GB,                turned(H)],
        [FB.T,    GB.T,                   -loop.mu * eye(w), turned(D)],
        [C,       H,                      D,         -gamma2 * loop.mu * eye(y)],
    ])


def free_lqr_decay(loop, weight, step=0):
    """x' P x falls faster than mu x' (weight) x, for a vertex loop.

    With a ``step``, as in `free_bounded_real`, that is meant of its mean in a tick.

    Then P / mu lies above the Gramian X of the loop, with E' as the weight of its
    input: the integral of x' (weight) x from x(0) is below x(0)' P x(0) / mu.
    """
    cross = loop.P - loop.F @ loop.E + loop.A.T @ loop.G.T
    return -block([
        [he(loop.F @ loop.A) + loop.mu * weight, cross],
        [cross.T, _last(loop, step)],
    ])


def _last(loop, step):
    """The share of the change, or derivative, of a loop's state alone."""
    free = -he(loop.G @ loop.E)
    return free + step * loop.P if step else free


def free_gramian(loop, J, H):
    """J lies above B' E'^-1 P E^-1 B, the noise's share of the cost, for a vertex loop.

    Parameters
    ----------
    loop : KnownVertex
        The loop of a vertex.
    J : (p, p) matrix-like
        With noise of intensity one on each channel the cost is below tr J / mu.
    H : (N, N) matrix-like
        A multiplier of its own.

    Notes
    -----
    Source: (H E - P) P^-1 (H E - P)' >= 0, so He(H E) - P <= H E P^-1 E' H'.
    """
    HB = H @ loop.B
    return block([[J, HB.T], [HB, he(H @ loop.E) - loop.P]])
