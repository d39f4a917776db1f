"""What no linear controller does better, of any order, that sees y alone."""

from ..language import block, eye, he


def unseen(P, here, rate, push, out, bound):
    r"""The block of motions that sensors don't see, or that inputs don't move.

    Parameters
    ----------
    P : (r, r) matrix-like
        Symmetric.
    here, rate : (r, k) matrix-like
        x and x' of k motions that span all, in r coordinates.
    push : (p, k) matrix-like
        Their disturbance w.
    out : (q, k) matrix-like
        Their output z.
    bound : scalar
        Of the H-infinity norm from w to z.

    Returns
    -------
    matrix-like
        Positive definite for a P where a linear controller keeps the norm below the
        bound, of any order, that has these sensors. So multipliers that exclude every
        P exclude every controller.

    Notes
    -----
    Of x' = A x + B_w w + B u, z = C_z x + D_zw w + D_zu u, y = C x + D_yw w take the x
    of a subspace and the w for which y = 0 and x' is in the subspace. A controller at
    rest answers y = 0 with u = 0, so there the bounded real lemma of the whole loop,
    with a Lyapunov matrix L, is about Y alone, the plant's corner of L. The norm is
    that of the transposed loop, whose lemma has L^-1; so the same is true with A', B',
    C', ... in the place of A, C, B, ... and X, the plant's corner of L^-1. X and Y
    belong together: [X I; I Y] >= 0, as for every L, and > 0 with a little more of Y.
    In coordinates x = V v of the one subspace and U of the other it is
    [X U'V; V'U Y] > 0.

    Where the subspaces are as large as can be the three blocks say all: P. Gahinet and
    P. Apkarian, A linear matrix inequality approach to H-infinity control, Int. J.
    Robust Nonlinear Control 4, 1994, where sensors have noise and inputs a weight.
    """
    top = bound * (push.T @ push) - he(here.T @ P @ rate)
    return block([[top, out.T], [out, bound * eye(out.shape[0])]])
