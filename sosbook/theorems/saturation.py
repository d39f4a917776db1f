"""Lemma 2.2: a bound on K x(t) from a given initial state."""

import numpy as np

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
    x0 = np.asarray(x0)[:, None]
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
