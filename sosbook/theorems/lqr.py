"""Lemma 2.3 and Theorem 2.4: a bound of the quadratic cost."""

from ..language import block, eye, he, tr
from .hinf import with_square


def lqr_cost(EPE, noise, J):
    """The matrix of (2.35): J bounds the noise's share of the cost.

    Parameters
    ----------
    EPE : (N, N) matrix-like
        E P E' of a pair of vertices, for noise that enters E x'.
        P itself for noise that enters x'. With a slack matrix
        E V' E0' + E0 V E' - E0 P E0', a lower bound of that.
    noise : (N, q) matrix-like
        Where the noise enters: B_w in the thesis.
    J : (q, q) matrix-like
        With white noise of intensity W the cost is at most
        lambda_max(W) tr J.
    """
    return block([[J, noise.T], [noise, EPE]])


def lqr_decay(c, L, W, R_inv, step=0):
    """The matrix of (2.36), times -1.

    Parameters
    ----------
    c : Coupled
        The pair of vertices.
    L, W : (N, k), (k, k) array
        The weight of the state is Q = L W^-1 L', so L = Q_F where W = I.
    R_inv : (m, m) array
        The inverse of R, the weight of the input.
    step : scalar
        As in `bounded_real`.

    Returns
    -------
    (N + k + m, N + k + m) matrix-like
        Positive definite for all pairs, with P > 0 and `lqr_cost`,
        implies: every plant of the polytope is stable and its cost
        (2.33) is at most lambda_max(W) tr J for noise of intensity W.

    Notes
    -----
    Source: thesis Theorem 2.4, with N = 2n + a for its n; the bound is
    tr J times lambda_max(W), not the square root of tr J.
    """
    EPL = c.EP @ L
    rows = [
        [he(c.Theta), EPL, c.EY],
        [EPL.T, -W, 0],
        [c.EY.T, 0, -R_inv],
    ]
    return -block(with_square(rows, [c.Theta.T, 0, 0], c.EPE, step))


def slack_lqr_decay(c, L, W, R_inv, epsilon, step=0):
    """`lqr_decay` with a slack matrix: affine in (E, A, B_u).

    The arguments c, L, W and R_inv are those of `lqr_decay`, but c is a
    `SlackVertex`; ``epsilon`` is the scalar of the slack matrix, ``step`` as there.
    """
    EPL = c.EV @ L
    cross = c.EPE - c.EVE + epsilon * c.Theta.T
    last = -epsilon * he(c.EVE)
    return -block([
        [he(c.Theta), cross, EPL, c.EY],
        [cross.T, last + step * c.EPE if step else last, 0, 0],
        [EPL.T, 0, -W, 0],
        [c.EY.T, 0, 0, -R_inv],
    ])


def trace_bound(J, bound):
    """bound - tr J, as a matrix."""
    return bound * eye(1) - tr(J)
