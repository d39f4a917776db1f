"""Theorem 2.1: a bound on the H-infinity norm from w to y."""

from ..language import block, eye, he, turned


def bounded_real(c, gamma2, mu=1, step=0):
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
    step : scalar
        The tick of a plant of discrete time, whose change is the vertex; else zero.

    Returns
    -------
    (N + n + p, N + n + p) matrix-like
        Positive definite for all pairs, and P > 0, imply: every plant
        of the polytope is stable with :math:`\|T_{yw}\|_\infty < \gamma`.

    Notes
    -----
    Source: thesis (2.15) for mu = 1. P = Q / mu satisfies it for mu
    exactly if Q does for mu = 1, with the same gamma: mu matters only
    where another block fixes the size of P. From tick to tick x' P^-1 x
    changes by step times 2 x' P^-1 v + step v' P^-1 v, where v is the change: the last
    rows are that square, by Schur's complement.
    """
    outputs, disturbances = c.EPC.shape[1], c.Bw.shape[1]
    rows = [
        [he(c.Theta), c.EPC,                       c.Bw],
        [c.EPC.T,     -gamma2 / mu * eye(outputs), c.Dw],
        [c.Bw.T,      turned(c.Dw),                -mu * eye(disturbances)],
    ]
    return -block(with_square(rows, [c.Theta.T, 0, c.Bw.T], c.EPE, step))


def with_square(rows, column, EPE, step):
    """The ``rows`` of a block with the square of the change, whose ``column`` it is;
    with a zero ``step`` the rows themselves. ``EPE`` is E P E'.
    """
    if not step:
        return rows
    last = [turned(x) for x in column]
    several = [[*row, x] for row, x in zip(rows, column)]
    return [*several, [*last, -EPE / step]]
