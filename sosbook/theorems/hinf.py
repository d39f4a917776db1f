"""Theorem 2.1: a bound on the H-infinity norm from w to y."""

from ..language import block, eye, he, turned


def bounded_real(c, gamma2, mu=1):
    r"""The matrix of (2.15), times -1.

    Parameters
    ----------
    c : Coupled
        A vertex, or a pair of them.
    gamma2 : scalar or 1 x 1 matrix-like
        Square of the bound :math:`\gamma`.
    mu : scalar
        Any positive number; the thesis has 1. 1 / sqrt(mu) is the unit in
        which w is measured.

    Returns
    -------
    (N + n + p, N + n + p) matrix-like
        Positive definite for all pairs, and P > 0, imply: every plant
        of the polytope is stable with :math:`\|T_{yw}\|_\infty < \gamma`.

    Notes
    -----
    Source: thesis (2.15) for mu = 1. P = Q / mu satisfies it for mu
    exactly if Q does for mu = 1, with the same gamma: mu matters only
    where another block fixes the size of P.
    """
    outputs, disturbances = c.EPC.shape[1], c.Bw.shape[1]
    return -block([
        [he(c.Theta), c.EPC,                       c.Bw],
        [c.EPC.T,     -gamma2 / mu * eye(outputs), c.Dw],
        [c.Bw.T,      turned(c.Dw),                -mu * eye(disturbances)],
    ])
