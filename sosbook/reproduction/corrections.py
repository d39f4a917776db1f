"""Corrections to the printed text."""

from functools import cache

from .table import Erratum

__all__ = ["errata"]


@cache
def errata():
    """Corrections to the printed text that this edition relies on."""
    return (
        Erratum(
            "(2.3)", "a 2 x 2 block matrix of E, A, B_u, B_w",
            "a tuple (E, A, B_u, B_w)",
            "the four blocks have sizes that don't fit together",
            "02_descriptor_form",
        ),
        Erratum(
            "(2.7)", "x3 = - integral of U e",
            "x3 = + integral of U e",
            "with the minus the printed gains of Example 1 are unstable; "
            "with the plus Table 3.1 is reproduced",
            "02_descriptor_form",
        ),
        Erratum(
            "(2.8.1)", "+ (B K_A) r''", "- (B K_A) r'', in the second "
            "block row",
            "insert (2.6) into (2.1): the term moves to the left side as "
            "M - B K_A and leaves - B K_A r'' behind",
            "02_descriptor_form",
        ),
        Erratum(
            "(2.8)-(2.10)", "[0 0 -U]^T r", "[0 0 -U^T]^T r",
            "the stacked column has a rows where U has a rows: U itself, "
            "not its transpose, acts on r",
            "02_descriptor_form",
        ),
        Erratum(
            "(2.13)", "sup over w of |y| / |w|", "add: from x(0) = 0",
            "any x(0) different from zero makes the quotient unbounded",
            "05_hinf",
        ),
        Erratum(
            "Theorems 2.1, 2.2", "E = M - B K_A",
            "E = diag(I, M - B K_A, I)",
            "the theorems use E with 2n + a rows, as (2.8) defines it",
            "05_hinf",
        ),
        Erratum(
            "(2.16)", "j = 1, ..., L", "no index j",
            "nothing in the inequality carries j", "05_hinf",
        ),
        Erratum(
            "Theorems 2.1, 2.2, proofs",
            "to check the LMIs at the vertices suffices",
            "also check the pairs (or let E be certain)",
            "A(a) P E(a)^T is quadratic in a; two counterexamples are "
            "computed in the tests: both vertices pass, a plant between "
            "them is unstable",
            "16_how_far_to_trust",
        ),
        Erratum(
            "Theorem 2.2", "if and only if",
            "sufficient, for more than one vertex",
            "one P for all plants is a restriction; for one plant the "
            "equivalence is Chilali and Gahinet's", "04_lmi_regions",
        ),
        Erratum(
            "Lemma 2.2", "u = K x alone",
            "add a stability LMI for the same P, r = 0, w = 0, K_A = 0",
            "without it the ellipsoid needn't be invariant: the chapter "
            "shows an unstable loop that satisfies (2.21)",
            "06_saturation",
        ),
        Erratum(
            "(A.15), (A.16)",
            "lower left entry - cos(theta) (z* - z)",
            "cos(theta) (z* - z)",
            "the matrix must be Hermitian; (2.20) has it right",
            "04_lmi_regions",
        ),
        Erratum(
            "Example 1", "half-plane Re(s) < 0.7", "Re(s) < -0.7",
            "Fig. 3.1 and the printed poles", "07_grasping_robot",
        ),
        Erratum(
            "Examples 1-4", "inner angle theta",
            "half-angle theta (inner angle 2 theta)",
            "Theorem 2.2 and (2.20) use the half-angle",
            "07_grasping_robot",
        ),
        Erratum(
            "Chapter 3, opening", "three delay-free examples",
            "four", "they are numbered 1 to 4", "07_grasping_robot",
        ),
    )
