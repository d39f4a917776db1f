r"""A sharper certificate: Bessel's inequality with Legendre polynomials.

The functional keeps the delayed input's Z term of Theorem A.3 and
replaces the rest by

.. math::

    V = \xi^\top P \xi + \int_{t-\tau}^t x^\top S x\, ds
    + \tau \int_{-\tau}^0\!\int_{t+\theta}^t \dot x^\top R \dot x

with :math:`\xi = [x; X_0; X_1; \dots]`, where :math:`X_k` is the integral
of :math:`L_k x` over :math:`[t - \tau, t]` and :math:`L_k` the shifted
Legendre polynomial.
"""

import numpy as np

from ..language import block, he

__all__ = ["legendre_decay", "legendre_functional"]


def legendre_functional(P, S, order, t):
    """Positive definite, with S, R, Z > 0, implies V > 0.

    Parameters
    ----------
    P : ((1 + order) N, (1 + order) N) matrix-like
        The matrix of the functional that multiplies xi.
    S : (N, N) matrix-like
        The matrix of its single integral.
    order : int
        How many polynomials; 0 gives Jensen's, 1 Wirtinger's
        inequality.
    t : Times
        The interval of the delay, and the decay rate.
    """
    if order == 0:
        return P
    N = S.shape[0]
    rows = [[0 * S if i == j == 0 else (
        (2 * i - 1) / t.tau * S if i == j else np.zeros((N, N), int))
        for j in range(order + 1)] for i in range(order + 1)]
    return P + block(rows)


def legendre_decay(A, Ad, P, S, R, Z, order, t):
    r"""Minus the bound of V's derivative, with the rate zero.

    Parameters
    ----------
    A, Ad : (N, N) matrix-like
        The matrices of the loop :math:`\dot x = A x + A_d x(t - d(t))`.
    P, S, R, Z : matrix-like
        The matrices of the functional.
    order : int
        How many polynomials.
    t : Times
        ``delta`` isn't used: shift the loop instead.

    Returns
    -------
    ((3 + order) N, (3 + order) N) matrix-like; 2 + order for mu = 0
        A quadratic form in x(t), x(t - tau), the X_k and, divided by
        mu, the integral of x' from t - d to t - tau. It is concave in
        (A, Ad): positive definite for two A_d it is so between them.

    Notes
    -----
    Source: Seuret and Gouaisbaut (2015), Theorem 5, for mu = 0; the Z
    term as in thesis (A.20).
    """
    N, tau, mu = A.shape[0], t.tau, t.mu
    parts = 2 + order + (1 if mu else 0)
    x, x_tau, *X = _pickers(N, parts)
    velocity = A @ x + Ad @ x_tau
    if mu:
        v = X.pop()
        velocity = velocity - mu * (Ad @ v)
    omega = [_omega(k, x, x_tau, X, tau) for k in range(order + 1)]
    state, rate = np.vstack([x, *X]), np.vstack([velocity, *omega[:-1]])
    form = he(state.T @ P @ rate) + x.T @ S @ x - x_tau.T @ S @ x_tau
    form = form + velocity.T @ (tau * tau * R + 2 * mu * Z) @ velocity
    for k, o in enumerate(omega):
        form = form - (2 * k + 1) * (o.T @ R @ o)
    if mu:
        form = form - mu * (v.T @ Z @ v)
    return -form


def _pickers(N, parts):
    """Matrices that pick the parts of a long vector."""
    return np.eye(parts * N, dtype=int).reshape(parts, N, parts * N)


def _omega(k, x, x_tau, X, tau):
    """The integral of L_k x' by parts, in terms of x, x_tau and X."""
    total = x - (-1) ** k * x_tau
    for i in range(k):
        if (k + i) % 2:
            total = total - 2 * (2 * i + 1) / tau * X[i]
    return total
