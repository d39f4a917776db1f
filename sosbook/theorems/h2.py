"""The H2 norm from w to y: how much of white noise is seen.

P lies above the Gramian of what w reaches. `lqr_decay` and `lqr_cost` have the dual
one, of what y sees, which is the same number in one loop.
"""

from ..language import block, eye, he
from .hinf import with_square


def h2_noise(c, step=0):
    """White noise w keeps x in the covariance E'^-1 (E P E') E^-1 or below it.

    Parameters
    ----------
    c : Coupled
        A vertex, or a pair of them.
    step : scalar
        As in `bounded_real`.

    Notes
    -----
    Source: with X = P, A X E' + E X A' + B_w B_w' < 0 by Schur's complement. From tick
    to tick it is A X E' + E X A' + step (A X A' + B_w B_w') < 0, which is the same as
    that x' X^-1 x rises by less than w' w.
    """
    one = eye(c.Bw.shape[1])
    rows = [[he(c.Theta), c.Bw], [c.Bw.T, -one / step if step else -one]]
    return -block(with_square(rows, [c.Theta.T, c.Bw.T], c.EPE, step))


def slack_h2_noise(c, epsilon, step=0):
    """`h2_noise` with a slack matrix, for a vertex c and its scalar ``epsilon``;
    ``step`` is as there.
    """
    cross, one = c.EPE - c.EVE + epsilon * c.Theta.T, eye(c.Bw.shape[1])
    last = -epsilon * he(c.EVE)
    return -block([
        [he(c.Theta), cross,                c.Bw],
        [cross.T, last + step * c.EPE if step else last, epsilon * c.Bw],
        [c.Bw.T,      epsilon * c.Bw.T,     -one / step if step else -one],
    ])


def h2_output(EPC, EPE, J):
    """The covariance of y is below J: its trace bounds the square of the norm.

    Parameters
    ----------
    EPC, EPE : (N, q), (N, N) matrix-like
        Of a pair of vertices; of a vertex with a slack matrix E0 V C' and E0 P E0'.
    J : (q, q) matrix-like
        Symmetric.
    """
    return block([[J, EPC.T], [EPC, EPE]])
