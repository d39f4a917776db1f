"""The theorems with a slack matrix: one Lyapunov matrix per vertex.

A closed loop E x' = A x is affine in the data of the plant, its LMIs in
P aren't: A P E' multiplies A by E. Finsler's lemma takes E x' = A x as a
constraint with multipliers [Lambda_1 x F; Lambda_2 x F] instead. After a
congruence with V = F^-1 each block is affine in (E, A, B_u, B_w): what
holds at the vertices holds between them, with P(a) = sum a_i P_i.
"""

import numpy as np

from ..language import block, eye, he, kron, turned


def slack_pole_region(c, alpha, beta, epsilon):
    r"""All poles in :math:`\alpha + \beta s + \beta^\top \bar s < 0`.

    Parameters
    ----------
    c : SlackVertex
        The vertex.
    alpha, beta : (k, k) array
        The matrices of the region.
    epsilon : scalar
        A positive scalar, in seconds. A disk doesn't use it.

    Returns
    -------
    (2kN, 2kN) matrix-like, (2N, 2N) for a disk
        Positive definite at all vertices, and all P_i > 0, imply: every
        plant of the polytope has all its poles in the region.

    Notes
    -----
    Source: Peaucelle, Arzelier, Bachelier and Bernussou (2000) for the
    regions R11 + R12 s + R12' s* + R22 |s|^2 < 0; de Oliveira, Bernussou
    and Geromel (1999) for the disk; here with E.
    """
    if _is_disk(beta):  # |s - q| < rho
        q, rho = -alpha[0, 1], -alpha[0, 0]
        return -block(_form(c, q * q - rho * rho, -q, 1, 1))
    k = eye(alpha.shape[0])
    return -block(_form(c, alpha, beta, 0 * k, epsilon * k))


def slack_stability(c, epsilon):
    """The half-plane Re s < 0 for a vertex c; ``epsilon`` is the slack scalar."""
    return -block(_form(c, 0, 1, 0, epsilon))


def slack_bounded_real(c, gamma2, mu, epsilon, step=0):
    """The H-infinity norm from w to y = C x is below gamma, for a vertex c.

    ``gamma2`` is its square, ``mu`` the scalar of Theorem 2.1, ``epsilon``
    that of the slack matrix, and ``step`` the tick of a plant of discrete time.

    Parameters as in `bounded_real` and `slack_pole_region`.
    """
    (rate, cross), (_, last) = _form(c, 0, 1, step, epsilon)
    y, w = c.EVC.shape[1], c.Bw.shape[1]
    return -block([
        [rate,    cross,            c.EVC,                 c.Bw],
        [cross.T, last,             c.EVA,                 epsilon * c.Bw],
        [c.EVC.T, turned(c.EVA),    -gamma2 / mu * eye(y), c.Dw],
        [c.Bw.T,  epsilon * c.Bw.T, turned(c.Dw),          -mu * eye(w)],
    ])


def slack_initial_state(P, V, x0):
    """x(0) lies in the ellipsoid of the matrix V' P^-1 V, by a slack matrix V.

    Parameters
    ----------
    P, V : (N, N) matrix-like
        The Lyapunov matrix of the vertex, and the slack matrix.
    x0 : (N,) array
        The initial state.

    Returns
    -------
    (1 + N, 1 + N) matrix-like
        Positive definite: ``x0' (V + V' - P)^-1 x0 < 1``. As V' P^-1 V is not
        below V + V' - P, its ellipsoid has x0 inside, too.
    """
    x0 = np.reshape(x0, (-1, 1))
    return block([[eye(1), x0.T], [x0, he(V) - P]])


def _is_disk(beta):
    return np.array_equal(beta, [[0, 1], [0, 0]])


def _form(c, R11, R12, R22, L2):
    """The four blocks that must be negative definite; the multiplier L1 is R12."""
    mixed = kron(R12, c.EPE - c.EVE) + kron(L2, c.Theta).T
    return [
        [kron(R11, c.EPE) + he(kron(R12, c.Theta)), mixed],
        [mixed.T, kron(R22, c.EPE) - he(kron(L2, c.EVE))],
    ]
