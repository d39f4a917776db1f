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

from ..language import block, he, kron, named, pick


def legendre_functional(P, S, order, t):
    """Positive definite, with S, R, Z > 0, implies V > 0.

    ``P``: the matrix of the functional that multiplies xi; ``S``, (N, N): the matrix of
    its single integral; ``order``: how many polynomials; 0 gives Jensen's, 1
    Wirtinger's inequality; ``t``: the interval of the delay, and the decay rate.
    """
    if order == 0:
        return P
    parts = range(order + 1)
    rows = [[(2 * i - 1) / t.tau if i == j > 0 else 0 for j in parts] for i in parts]
    return P + kron(rows, S)


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
    names = "x", "x_tau", *(f"X_{k}" for k in range(order)), *(["v"] if mu else [])
    x, x_tau, *X = (named(name, pick(k, parts, N)) for k, name in enumerate(names))
    velocity = A @ x + Ad @ x_tau
    if mu:
        v = X.pop()
        velocity = velocity - mu * (Ad @ v)
    velocity = named("q", velocity)
    omega = [named(f"w_{k}", _omega(k, x, x_tau, X, tau)) for k in range(order + 1)]
    state = block([[e] for e in (x, *X)])
    rate = block([[e] for e in (velocity, *omega[:-1])])
    form = he(state.T @ P @ rate) + x.T @ S @ x - x_tau.T @ S @ x_tau
    form = form + velocity.T @ (tau * tau * R + 2 * mu * Z) @ velocity
    for k, o in enumerate(omega):
        form = form - (2 * k + 1) * (o.T @ R @ o)
    if mu:
        form = form - mu * (v.T @ Z @ v)
    return -form


def _omega(k, x, x_tau, X, tau):
    """The integral of L_k x' by parts, in terms of x, x_tau and X."""
    total = x - (-1) ** k * x_tau
    for i in range(k):
        if (k + i) % 2:
            total = total - 2 * (2 * i + 1) / tau * X[i]
    return total
