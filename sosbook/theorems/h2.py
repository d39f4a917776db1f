"""The H2 norm from w to y: how much of white noise is seen.

P lies above the Gramian of what w reaches. `lqr_decay` and `lqr_cost` have the dual
one, of what y sees, which is the same number in one loop.
"""

from ..language import block, eye, he


def h2_noise(c):
    """White noise w keeps x in the covariance E'^-1 (E P E') E^-1 or below it.

    Parameters
    ----------
    c : Coupled
        A vertex, or a pair of them.

    Notes
    -----
    Source: with X = P, A X E' + E X A' + B_w B_w' < 0 by Schur's complement.
    """
    return -block([
        [he(c.Theta), c.Bw],
        [c.Bw.T,      -eye(c.Bw.shape[1])],
    ])


def slack_h2_noise(c, epsilon):
    """`h2_noise` with a slack matrix, for a vertex c and its scalar ``epsilon``."""
    cross = c.EPE - c.EVE + epsilon * c.Theta.T
    return -block([
        [he(c.Theta), cross,                c.Bw],
        [cross.T,     -epsilon * he(c.EVE), epsilon * c.Bw],
        [c.Bw.T,      epsilon * c.Bw.T,     -eye(c.Bw.shape[1])],
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
