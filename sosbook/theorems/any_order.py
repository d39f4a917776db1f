"""What no linear controller does better, of any order, that sees y alone."""

from ..language import block, eye, he

__all__ = ["any_order"]


def any_order(plant, values, bound):
    r"""The two blocks of a plant for which some controller keeps a bound.

    Parameters
    ----------
    plant : tuple of matrix-like
        A, B_w, B, C_z, C, D_zw, D_zu and D_yw of x' = A x + B_w w + B u,
        z = C_z x + D_zw w + D_zu u, y = C x + D_yw w.
    values : dict
        X, Y (N, N) symmetric, and Ah (N, N), Bh (N, q), Ch (m, N), Dh (m, q).
    bound : scalar
        Of the H-infinity norm from w to z.

    Returns
    -------
    tuple of two matrix-like
        If a linear controller of any order, with whatever structure, keeps the norm
        below the bound, then both are positive definite for some values. So multipliers
        that exclude every value exclude every controller.

    Notes
    -----
    Source: C. Scherer, P. Gahinet and M. Chilali, Multiobjective output-feedback
    control via LMI optimization, IEEE Trans. Automat. Control 42, 1997. An idle stable
    state makes the order N or more without changing the norm. X and Y are the plant's
    corners of the inverse of a Lyapunov matrix of the loop and of itself; the blocks
    are the bounded real lemma's after a congruence.
    """
    A, Bw, B, Cz, C, Dzw, Dzu, Dyw = plant
    X, Y, Ah, Bh, Ch, Dh = (values[name] for name in ("X", "Y", "Ah", "Bh", "Ch", "Dh"))
    N, p, q = A.shape[0], Bw.shape[1], Cz.shape[0]
    left = A @ X + B @ Ch
    corner = A + B @ Dh @ C
    right = Y @ A + Bh @ C
    cross = corner + Ah.T
    w, YB = Bw + B @ Dh @ Dyw, Y @ Bw + Bh @ Dyw
    CX, CD, D = Cz @ X + Dzu @ Ch, Cz + Dzu @ Dh @ C, Dzw + Dzu @ Dh @ Dyw
    loop = -block([
        [he(left), cross,     w,               CX.T],
        [cross.T,  he(right), YB,              CD.T],
        [w.T,      YB.T,      -bound * eye(p), D.T],
        [CX,       CD,        D,               -bound * eye(q)],
    ])
    return block([[X, eye(N)], [eye(N), Y]]), loop
