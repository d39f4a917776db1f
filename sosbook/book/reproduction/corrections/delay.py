"""Corrections to sections 2.4.4 and 3.2, and to Theorem A.3."""

from ....delay import largest
from ... import ledger, thesis
from ..table import Erratum, filled

__all__ = ["delayed"]

#: The delayed input, its theorems and its two examples. What stands in braces is
#: computed.
TEXTS = (
    Erratum(
        "misprint",
        "(2.1)",
        "mu(t) <= |mu(t)| <= tau",
        "|mu(t)| <= mu <= tau",
        "every number is at most its modulus; Theorem 2.3 needs a bound "
        "mu, so that d(t) stays in [tau - mu, tau + mu]",
        "19_input_delay",
    ),
    Erratum(
        "single character",
        "(2.10.1)",
        "+ B_u K [r^T(t - d) r'^T(t - d) 0]^T",
        "- B_u K [r^T(t - d) r'^T(t - d) 0]^T",
        "insert (2.9.2) into (2.9.1): its minus stays",
        "19_input_delay",
    ),
    Erratum(
        "misprint",
        "(2.24), (A.20)",
        "Z / epsilon2 times + mu in the last block",
        "- mu Z / epsilon2",
        "a negative definite matrix has no positive diagonal block "
        "unless Z < 0, and then V isn't positive; computed: as printed "
        "it accepts x' = x - 0.1 x(t - d), whose root is +0.96 for "
        "d = 1. It stands twice: a machine that reads hardly slips twice "
        "alike. A.3 is quoted from Fenili et al. (2014), which we haven't seen",
        "20_delay_theorem",
        "the sign of Theorem A.3",
    ),
    Erratum(
        "misprint",
        "(A.21)",
        "A F^T + F A^T",
        "F A + A^T F^T",
        "the null term 2 x^T F (-x' + A x + A_d x(t - d)) gives F A; "
        "(2.25) has its transform right; computed: as printed it accepts "
        "an unstable loop without any delay",
        "20_delay_theorem",
        "the transpose of Theorem A.3",
    ),
    Erratum(
        "misprint",
        "(A.20)",
        "Gamma^T = mu [A_d^T F^T, alpha A_d^T G^T, 0, 0]",
        "without alpha",
        "A.3 has no alpha: it comes in by G = alpha F in Theorem 2.3; "
        "computed: with a small alpha it accepts x' = -x(t - d) on "
        "[0, 2], unstable at d = 2",
        "20_delay_theorem",
        "the alpha of Theorem A.3",
    ),
    Erratum(
        "single character",
        "(A.21), third diagonal block",
        "-epsilon1 (R3 + tau S)*",
        "-epsilon1 (R3 + tau S)",
        "the star stands for a symmetric block, of which a diagonal one has none",
        "20_delay_theorem",
    ),
    Erratum(
        "gap",
        "(2.25)",
        "G-bar, not defined",
        "alpha F-bar",
        "G = alpha F, multiplied by F-bar and F-bar^T, is alpha F-bar^T",
        "20_delay_theorem",
    ),
    Erratum(
        "improvement",
        "(2.25)",
        "E (...) E^T in the upper left blocks",
        "E beside F-bar only: leave out the congruence with diag(E, E, I, I)",
        "the same for one plant; for an uncertain mass it is "
        "quadratic in E, and the vertices don't cover the plants "
        "between",
        "20_delay_theorem",
    ),
    Erratum(
        "misprint",
        "(2.24), (2.25), Theorem 2.3, proof",
        "X^T B^T, E^-1 B K",
        "X^T B_u^T, E^-1 B_u K",
        "X has m rows and 2n + a columns; B has only n rows, B_u 2n + a",
        "20_delay_theorem",
    ),
    Erratum(
        "gap",
        "Theorems 2.3, A.3",
        "0 <= mu",
        "0 < mu; for mu = 0 delete the last block row and column",
        "with mu = 0 the last diagonal block is zero and the strict "
        "inequality has no solution",
        "20_delay_theorem",
    ),
    Erratum(
        "gap",
        "Theorem 2.3",
        "alpha different from zero",
        "0 < alpha < 1 / delta",
        "multiply (2.24), its sign corrected, from both sides by "
        "(alpha v, -v, alpha v, 0, 0): F-bar and X drop out, and for "
        "other alpha what is left isn't negative",
        "20_delay_theorem",
    ),
    Erratum(
        "misprint",
        "Theorem 2.3, proof",
        "the closed-loop matrix E^-1 (A(t) x(t) + A_d x(t - d(t)) + B_u(t) K)",
        "the matrices E^-1 A and E^-1 A_d, with A_d = B_u K",
        "a matrix and signals are added, and B_u K stands in A_d already",
        "20_delay_theorem",
    ),
    Erratum(
        "misprint",
        "Theorem 2.3, proof",
        "[P Q R1 R2 R3 Z], diag(E, E, I, I)",
        "[P Q S R1 R2 R3 Z], diag(E, E, I, I, I)",
        "S-bar stands in the LMIs too; (2.24) has five block rows",
        "20_delay_theorem",
    ),
    Erratum(
        "misprint",
        "Procedure 2.2",
        "for solving Problem 2.4.4",
        "for solving Problem 2",
        "2.4.4 is the section's number",
        "20_delay_theorem",
    ),
    Erratum(
        "gap",
        "Procedure 2.2, step 2",
        "define delta, alpha and mu",
        "define tau too, with mu <= tau",
        "epsilon1 and epsilon2 need tau; no step sets it",
        "20_delay_theorem",
    ),
    Erratum(
        "improvement",
        "Procedure 2.2",
        "four steps",
        "add a fifth: verify the LMIs for the rounded K, and the roots "
        "at constant delays",
        "the gains of Example 1 with delay would have failed it",
        "21_delay_examples",
    ),
    Erratum(
        "single character",
        "(3.5), D12",
        "2.5",
        "2.45",
        "the same sources; 2.5 may be its rounding, and the printed gains can't tell",
        "21_delay_examples",
        "D12 of the wing",
    ),
    Erratum(
        "single character",
        "(3.5), S22",
        "27",
        "2.7",
        "Frazer, Duncan and Collar (1938), and NLEVP. The digits of our "
        "copy can't be the plant of the printed gains: with 27 they "
        "don't stabilise it at the nominal delay, with 2.7 they do; only "
        "that wing flutters",
        "21_delay_examples",
        "S22 of the wing",
    ),
    Erratum(
        "claim refuted",
        "Example 1 with delay",
        "the rate 0.6 for mu = 0.5 tau",
        "proven for mu = {proven:.3f} tau; false for mu above {false:.3f} tau",
        "published data: the sharpest certificate of chapter 22 proves "
        "mu = {seconds} s, {share:.0%} of what can be true; the corrected "
        "theorem itself proves mu = {theorem} s. The constant delay 0.24 s "
        "has a slower rate, at 0.3 s the loop has a root of real part "
        "+0.10. With the printed data it is unstable at tau itself",
        "21_delay_examples",
        "the wing's promise",
    ),
)


def _numbers():
    """What the texts leave open: how far the wing's promise is proven, and false."""
    ex = thesis.delay_example_1(published=True)
    best = ledger.wing(ex.delta)
    theorem = largest("mu", ex.plant, ex.K, ex.U, ex.tau, 0.008, ex.delta, refuse=False)
    return {
        "proven": best.proven / best.tau,
        "false": best.false / best.tau,
        "seconds": best.proven,
        "share": best.share,
        "theorem": theorem.value,
    }


def delayed():
    """The delayed input, its theorems and its two examples."""
    return filled(TEXTS, _numbers())
