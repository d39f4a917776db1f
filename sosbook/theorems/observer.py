"""Theorem 2.5: an observer that the uncertainty doesn't upset."""

from ..language import block, eye, he, named


def observer_cost(E, B_w, P1, J):
    """The matrix of (2.44): J bounds the estimation error's cost.

    Parameters
    ----------
    E : (N, N) array
        A vertex.
    B_w : (N, p) array
        How the noise enters.
    P1 : (N, N) matrix-like
        The Lyapunov matrix of the error.
    J : (p, p) matrix-like
        Its trace bounds the cost.
    """
    return block([[J, B_w.T], [B_w, E @ P1 @ E.T]])


def observer_decay(A, C, P1, P2, Y, Q_F, R_F):
    """The matrix of (2.45), times -1.

    Parameters
    ----------
    A : (2N, 2N) array
        The matrix of the error and the state without L at a vertex, its
        inertia divided out: the inverse of E-bar times A-tilde of (2.41).
    C : (q, N) array
        The output matrix.
    P1, P2 : (N, N) matrix-like
        The Lyapunov matrices of the error and of the state.
    Y : (q, N) matrix-like
        L = P1^-1 Y'.
    Q_F : (2N, k) array
        Q = Q_F Q_F' weighs the dual state.
    R_F : (q, q) array
        R = R_F R_F' is the covariance of the measurement noise.

    Notes
    -----
    Source: thesis (2.45). The inverse of the inertia isn't affine in
    it: this holds at the vertices and says nothing between them.
    """
    P = named("P", block([[P1, 0], [0, P2]]))
    feed = named("feed", block([[C.T @ Y, 0], [0, 0 * P2]]))
    weighted = Y.T @ R_F
    noise = block([[weighted], [0 * weighted]])
    PQ = P @ Q_F
    return -block([
        [he(A.T @ P + feed), PQ, noise],
        [PQ.T, -eye(Q_F.shape[1]), 0],
        [noise.T, 0, -eye(R_F.shape[1])],
    ])
