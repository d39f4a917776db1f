r"""Theorems A.3 and 2.3, corrected: stability under a varying input delay.

Both rest on the Lyapunov-Krasovskii functional

.. math::

    V = x^\top P x + 2 x^\top Q \eta
    + \int_{t-\tau}^t e^{2\delta(s-t)} x^\top S x\, ds
    + \int_{-\tau}^0\!\int_{t+\theta}^t e^{2\delta(s-t)} w^\top R w
    + \int_{-\mu}^{\mu}\!\int_{t-\tau+\theta}^t e^{2\delta(s-t)}
      \dot x^\top Z \dot x

with :math:`\eta = \int_{t-\tau}^t x` and :math:`w = [x; \dot x]`.
"""

from dataclasses import dataclass

from ..language import block, he

MISPRINTS = ("sign", "transpose", "alpha")


@dataclass(frozen=True, eq=False)
class Functional:
    """The matrices of the functional, each (N, N) matrix-like.

    P, S, R1, R3 and Z are symmetric; Q and R2 aren't. In Theorem 2.3 these
    are the matrices with a bar.
    """

    P: object
    Q: object
    S: object
    R1: object
    R2: object
    R3: object
    Z: object


@dataclass(frozen=True)
class Times:
    r"""The delay's interval and the decay rate, in any arithmetic.

    Parameters
    ----------
    tau, mu : scalar
        d(t) lies in [tau - mu, tau + mu]; ``0 <= mu <= tau``.
    delta : scalar
        The rate, in 1/s.
    epsilon1, epsilon2 : scalar
        :math:`e^{-2\delta\tau}/\tau` and
        :math:`e^{-2\delta(\tau+\mu)}`. The theorems hold for every
        smaller positive number as well, so rounding down is a proof.
    """

    tau: object
    mu: object
    delta: object
    epsilon1: object
    epsilon2: object


def delay_functional(v, t):
    """The matrices of (2.22), (2.23), that is (A.18), (A.19).

    Parameters
    ----------
    v : Functional
        The matrices of the functional.
    t : Times
        The interval of the delay, and the decay rate.

    Returns
    -------
    two (2N, 2N) matrix-likes
        Both positive definite, and Z > 0, imply V > 0.
    """
    return (
        block([[v.P, v.Q], [v.Q.T, t.epsilon1 * v.S]]),
        block([[v.R1, v.R2.T], [v.R2, v.R3]]),
    )


def delay_decay(E, A, Ad, v, F, G, t, misprints=(), alpha=1):
    r"""The matrix of (A.20), (A.21), corrected, times -1.

    Parameters
    ----------
    E, A, Ad : (N, N) matrix-like
        The matrices of the loop :math:`E\dot x = A x + A_d x(t - d(t))`; the
        thesis has E = I.
    v : Functional
        The matrices of the functional.
    F, G : (N, N) matrix-like
        The slack matrices.
    t : Times
        The interval of the delay, and the decay rate.
    misprints : collection of {"sign", "transpose", "alpha"}
        What to read as printed, for study: each is unsound. "sign": the
        lower right block Z / epsilon2, "transpose": A F' + F A' in
        (A.21), "alpha": the factor ``alpha`` in Gamma.
    alpha : scalar
        The factor of the misprint "alpha".

    Returns
    -------
    (5N, 5N) matrix-like, (4N, 4N) for mu = 0
        Positive definite, with `delay_functional`, implies that
        :math:`e^{2\delta t} V` doesn't grow, whatever the delay does
        inside its interval.

    Notes
    -----
    Source: thesis (A.21) with F A + A'F' for A F' + F A', (A.20) with
    -Z/epsilon2 for Z/epsilon2 and without the alpha of Gamma.
    """
    e2 = t.epsilon2
    first = he(A @ F.T) if "transpose" in misprints else he(F @ A)
    last = alpha * Ad.T @ G.T if "alpha" in misprints else Ad.T @ G.T
    return -_five(v, t, sign=1 if "sign" in misprints else -1, rows=(
        e2 * first,
        e2 * (G @ A - E.T @ F.T),
        -e2 * he(G @ E),
        e2 * Ad.T @ F.T,
        e2 * Ad.T @ G.T,
        Ad.T @ F.T,
        last,
    ))


def delay_stabilization(d, v, F, X, t, alpha, misprints=()):
    r"""The matrix of (2.24), (2.25), corrected, times -1.

    Parameters
    ----------
    d : Descriptor
        A vertex.
    v : Functional
        The matrices of the functional, which the thesis writes with a bar.
    F : (N, N) matrix-like
        The slack matrix, :math:`E\bar F` in the thesis.
    X : (m, N) matrix-like
        ``K F'``.
    t : Times
        The interval of the delay, and the decay rate.
    alpha : scalar
        A scalar in seconds, which weighs the velocity among the multipliers, G
        = alpha F in Theorem A.3.
    misprints : collection of {"sign"}
        As in `delay_decay`.

    Returns
    -------
    (5N, 5N) matrix-like, (4N, 4N) for mu = 0
        The blocks by name.

    Notes
    -----
    Source: thesis (2.25), corrected and congruent: E stands beside F
    only, so the matrix is affine in (E, A, B_u). Positive definite at
    the vertices, it is so over the polytope, with one functional.
    """
    e2, a = t.epsilon2, alpha
    BX = d.Bu @ X
    return -_five(v, t, sign=1 if "sign" in misprints else -1, rows=(
        e2 * he(d.A @ F.T),
        e2 * (a * (d.A @ F.T) - F @ d.E.T),
        -e2 * a * he(d.E @ F.T),
        e2 * BX.T,
        e2 * a * BX.T,
        BX.T,
        a * BX.T,
    ))


def _five(v, t, rows, sign=-1):
    """The block matrix; ``rows`` is what the loop's equation adds."""
    tau, mu, delta, e1 = t.tau, t.mu, t.delta, t.epsilon1
    r11, r21, r22, r31, r32, r51, r52 = rows
    b11 = 2 * delta * v.P + he(v.Q) + tau * v.R1 - e1 * v.R3 + v.S + r11
    b21 = v.P + tau * v.R2 + r21
    b22 = tau * v.R3 + 2 * mu * v.Z + r22
    b31, b32 = e1 * v.R3 - v.Q.T + r31, r32
    b33 = -e1 * (v.R3 + tau * v.S)
    b41, b42, b43 = 2 * delta * v.Q.T - e1 * v.R2.T, v.Q.T, e1 * v.R2.T
    four = [
        [b11, b21.T, b31.T, b41.T],
        [b21, b22,   b32.T, b42.T],
        [b31, b32,   b33,   b43.T],
        [b41, b42,   b43,   -e1 * v.R1],
    ]
    if mu == 0:
        return block(four)
    # block 5 is multiplied by 1 / mu from both sides
    last = [r51, r52, 0, 0, sign * v.Z / (t.epsilon2 * mu)]
    return block([
        *(row + [x if isinstance(x, int) else x.T]
          for row, x in zip(four, last)),
        last,
    ])
