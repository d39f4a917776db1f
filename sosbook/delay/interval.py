r"""The functional over the whole interval, with the reciprocally convex bound.

The delay lies in [h1, h2], h1 = tau - mu, h2 = tau + mu. The functional
keeps the ends of the interval apart instead of one nominal delay,

.. math::

    V = \xi^\top P \xi + \int_{t-h_1}^t x^\top Q_1 x
    + \int_{t-h_2}^{t-h_1} x^\top Q_2 x
    + h_1 \int_{-h_1}^0\!\int_{t+\theta}^t \dot x^\top R_1 \dot x
    + (h_2 - h_1) \int_{-h_2}^{-h_1}\!\int_{t+\theta}^t
      \dot x^\top R_2 \dot x .

Order 0 has :math:`\xi = x` and Jensen's inequality. Order 1 has
:math:`\xi = [x; \int_{t-h_1}^t x; \int_{t-h_2}^{t-h_1} x]` and Bessel's
inequality of order 1, that is Wirtinger's.
"""

from ..language import block, he, kron, named, pick


def interval_functional(P, Q1, Q2, order, t):
    """Positive definite, with Q1, Q2, R1, R2 > 0, implies V > 0.

    Parameters
    ----------
    P : (N, N) matrix-like, or with order 1 (k N, k N)
        k = 3; 2 for mu = 0 and for mu = tau, where an interval is empty.
    Q1, Q2 : (N, N) matrix-like, or None
        None where its interval is empty.
    order : {0, 1}
        The order of Bessel's inequality.
    t : Times
        The delay's interval.
    """
    if order == 0:
        return P
    weighted = [] if Q1 is None else [Q1 / (t.tau - t.mu)]
    if Q2 is not None:
        weighted.append(Q2 / (2 * t.mu))
    parts = [0 * weighted[0], *weighted]
    rows = [[p if i == j else 0 for j in range(len(parts))]
            for i, p in enumerate(parts)]
    return P + block(rows)


def interval_kernel(R2, T, order):
    """Positive definite: the reciprocally convex bound holds with T.

    Parameters
    ----------
    R2 : (N, N) matrix-like
        The matrix of the functional's last integral.
    T : ((1 + order) N, (1 + order) N) matrix-like
        A free matrix of the bound.
    order : {0, 1}
        The order of Bessel's inequality.
    """
    if order == 0:
        return block([[R2, T], [T.T, R2]])
    wide = named("wide", kron([[1, 0], [0, 3]], R2))
    return block([[wide, T], [T.T, wide]])


def interval_decay(A, Ad, P, Q1, Q2, R1, R2, T, order, t, late):
    r"""Minus the bound of V's derivative, with the rate zero.

    Parameters
    ----------
    A, Ad : (N, N) matrix-like
        The matrices of the loop :math:`\dot x = A x + A_d x(t - d(t))`.
    P, Q1, Q2, R1, R2, T : matrix-like
        Q1, R1 are None for mu = tau, Q2, R2, T for mu = 0.
    order : {0, 1}
        The order of Bessel's inequality.
    t : Times
        ``delta`` isn't used: shift the loop instead.
    late : {0, 1}
        With order 1 the form is affine in the delay: 0 takes d = h1, 1
        takes d = h2. Order 0 has the same form at both.

    Returns
    -------
    (k N, k N) matrix-like
        A quadratic form in x(t), x(t - h1), x(t - d), x(t - h2) and, with
        order 1, the means of x over the three intervals between them. It
        is concave in (A, Ad): positive definite for two A_d it is so
        between them.

    Notes
    -----
    Source: Park, Ko and Jeong (2011), Theorem 1 in this form, for order 0;
    Seuret and Gouaisbaut (2013) for order 1.
    """
    N, h1, width = A.shape[0], t.tau - t.mu, 2 * t.mu
    names = ["x"] + ["x1"] * (R1 is not None) + ["xd", "x2"] * (R2 is not None)
    if order:
        names += ["m1"] * (R1 is not None) + ["m2", "m3"] * (R2 is not None)
    at = {e: named(e, pick(k, len(names), N)) for k, e in enumerate(names)}
    at.setdefault("x1", at["x"])
    at.setdefault("xd", at["x1"])
    q = named("q", A @ at["x"] + Ad @ at["xd"])
    state, rate, parts = [at["x"]], [q], []
    if R1 is not None:
        first = _moments(at["x"], at["x1"], at.get("m1"))
        parts += [
            _square(Q1, at["x"]) - _square(Q1, at["x1"]),
            h1 * h1 * _square(R1, q) - _bessel(R1, first),
        ]
        if order:
            state.append(h1 * at["m1"])
            rate.append(at["x"] - at["x1"])
    if R2 is not None:
        near = _moments(at["x1"], at["xd"], at.get("m2"))
        far = _moments(at["xd"], at["x2"], at.get("m3"))
        both = named("both", block([[e] for e in (*near, *far)]))
        parts += [
            _square(Q2, at["x1"]) - _square(Q2, at["x2"]),
            width * width * _square(R2, q),
            -_square(interval_kernel(R2, T, order), both),
        ]
        if order:
            state.append(width * (at["m2"] if late else at["m3"]))
            rate.append(at["x1"] - at["x2"])
    form = he(block([[e] for e in state]).T @ P @ block([[e] for e in rate]))
    for part in parts:
        form = form + part
    return -form


def _moments(new, old, mean):
    """The moments of x' between two times, from the values and the mean."""
    return [new - old] if mean is None else [new - old, new + old - 2 * mean]


def _square(X, v):
    return v.T @ X @ v


def _bessel(R, moments):
    """Jensen's, or Wirtinger's, bound of an integral times its length."""
    total = _square(R, moments[0])
    for m in moments[1:]:
        total = total + 3 * _square(R, m)
    return total
