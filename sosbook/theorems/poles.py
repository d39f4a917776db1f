"""Theorem 2.2 and A.2: closed-loop poles in an LMI region."""

from ..language import he, kron


def pole_region(c, alpha, beta):
    r"""The matrix M_D of (A.9) in descriptor form, times -1.

    Parameters
    ----------
    c : Coupled
        A vertex, or a pair of them.
    alpha, beta : (k, k) array
        The region :math:`\alpha + \beta s + \beta^\top \bar s < 0`.

    Returns
    -------
    (kN, kN) matrix-like
        Positive definite for all pairs, and P > 0, imply: every plant
        of the polytope has all its poles in the region.

    Notes
    -----
    Source: thesis (A.9). With the half-plane, the disk and the sector
    of `sosbook.LMIRegion` this is (2.18), (2.19) and (2.20).
    """
    return -(kron(alpha, c.EPE) + he(kron(beta, c.Theta)))


def stability(c):
    """The half-plane Re s < 0 for a pair c: (2.18) with sigma = 0, times -1."""
    return -he(c.Theta)
