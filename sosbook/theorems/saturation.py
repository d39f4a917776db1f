"""Lemma 2.2: a bound on K x(t) from a given initial state."""

import numpy as np

from ..exact.rational import inverse
from ..language import block, eye


def initial_state(P, x0):
    """The first matrix of (2.21): x(0) lies in the ellipsoid of P.

    Parameters
    ----------
    P : (N, N) matrix-like
        The Lyapunov matrix.
    x0 : (N,) array
        Initial state [z(0); z'(0); x3(0)].
    """
    x0 = np.reshape(x0, (-1, 1))
    return block([[eye(1), x0.T], [x0, P]])


def control_bound(P, Y, u_max2):
    """The second matrix of (2.21): |K x| <= u_max on the ellipsoid.

    Parameters
    ----------
    P : (N, N) matrix-like
        The Lyapunov matrix.
    Y : (m, N) matrix-like
        K P.
    u_max2 : scalar
        Square of the bound.

    Notes
    -----
    Source: thesis (2.21). The lemma needs, for the same P, an LMI that keeps
    the ellipsoid invariant: `stability` or `bounded_real`. It bounds K x
    without the acceleration term K_A e'', and only for the motion from x(0)
    with r = 0 and w = 0.
    """
    return block([[P, Y.T], [Y, u_max2 * eye(Y.shape[0])]])


def whole_control_bound(P, X, Y, K_A, mass, row, push, u_max2, some=None):
    """`control_bound` for the whole signal u = K x + K_A z''.

    ``P``, (N, N): the Lyapunov matrix; ``X``, ``Y``, (N, N): P and K P; with a slack
    matrix V' and K V'; ``K_A``, (m, n): the gain of the accelerations z''; ``mass``,
    ``row``, ``push``, (n, n): of the equation ``mass z'' = row x + push K x``; ``mass``
    is M - B K_A; ``u_max2``: square of the bound; ``some``: rows of I that pick inputs.
    """
    answer = K_A @ inverse(mass)
    signal = answer @ row @ X + (answer @ push + eye(Y.shape[0])) @ Y
    return control_bound(P, signal if some is None else some @ signal, u_max2)
