"""Lemma 2.1 and Theorem A.1: acceleration feedback makes M regular."""

from ..language import block, eye, he


def regular_mass(M, B, K_A, beta):
    r"""The matrix of (2.12).

    Parameters
    ----------
    M : (n, n) matrix-like
        The mass matrix.
    B : (n, m) matrix-like
        The input matrix.
    K_A : (m, n) matrix-like
        Acceleration gain.
    beta : scalar
        Its square has the unit of a mass.

    Returns
    -------
    (2n, 2n) matrix-like
        Positive definite if and only if the symmetric part of
        ``M - B K_A`` exceeds :math:`\beta^2 I`; then ``M - B K_A`` is
        regular. Affine in ``M``, ``B`` for a given ``K_A``: at all
        vertices it holds over the whole polytope.

    Notes
    -----
    Source: thesis (2.12), with A_F = M - B K_A in (A.6).
    """
    mass, one = M - B @ K_A, eye(M.shape[0])
    return block([
        [he(mass / 2), beta * one],
        [beta * one,    one],
    ])
