"""Corrections to sections 2.4.5 and 2.4.6."""

from ..table import Erratum

__all__ = ["REGULATOR_ERRATA"]

#: Lemma 2.3, Theorems 2.4 and 2.5.
REGULATOR_ERRATA = (
    Erratum(
        "gap",
        "Lemma 2.3",
        "|W|, not defined",
        "lambda_max(W) tr J",
        "right if |W| is the spectral norm, lambda_max(W); false if it is "
        "the determinant: the chapter has a loop whose true cost exceeds "
        "det W tr J. The notation doesn't say",
        "23_lqr",
        "|W| in Lemma 2.3",
    ),
    Erratum(
        "misprint",
        "Lemma 2.3, proof",
        "Lambda (Psi - P) + (Psi - P) Lambda^T + Theta <= 0",
        "Lambda^T (Psi - P) + (Psi - P) Lambda <= 0",
        "subtract (2.31) from (2.29): Theta cancels, and the transposes "
        "are the other way",
        "23_lqr",
    ),
    Erratum(
        "gap",
        "(2.30), last line",
        "ends with the integral",
        "add = tr(W Omega^T P(alpha) Omega)",
        "the next words define P(alpha), which (2.30) doesn't contain; "
        "the proof goes on with it",
        "23_lqr",
    ),
    Erratum(
        "gap",
        "Lemma 2.3, proof; (2.36)",
        "<= 0 implies that Lambda is Hurwitz",
        "add strictness, or detectability of (Theta, Lambda)",
        "z'' + z = u with Q = 0, P = I, Y = 0 satisfies (2.36) and "
        "swings forever; the bound itself holds at every time, without "
        "stability",
        "23_lqr",
    ),
    Erratum(
        "misprint",
        "Theorem 2.4",
        "P, Q of size n x n, Y of size m x n",
        "N x N and m x N, N = 2n + a (2n without U)",
        "the state of (2.8) is [z; z'; x3]",
        "23_lqr",
    ),
    Erratum(
        "misprint",
        "(2.37)",
        "J - B_w^T E^-1 P^-1 E^-1 B_w",
        "J - B_w^T E^-T P^-1 E^-1 B_w",
        "Omega^T = B_w^T E^-T; (2.38) has it right",
        "23_lqr",
    ),
    Erratum(
        "claim refuted",
        "Theorems 2.4, 2.5",
        "sqrt(tr J) bounds the cost",
        "tr J",
        "(2.30) bounds the cost itself, not its root",
        "27_pendulum_control",
        "the root of tr J",
    ),
    Erratum(
        "gap",
        "Theorem 2.5",
        "robustly stable",
        "stable at each vertex",
        "(2.45) holds the inverse of E-bar; certify with K and L fixed",
        "24_observer",
    ),
    Erratum(
        "misprint",
        "4.3.1, 4.3.2",
        "Q = I_n",
        "I_2n (PD), I_(2n + a) (PID), I_3 (observer)",
        "n is 2 in (4.25); the gains have 4, 5 and 3 columns",
        "27_pendulum_control",
    ),
    Erratum(
        "misprint",
        "(2.42)",
        "E-bar^-1 B_w w as the dual's disturbance",
        "(E-bar^-1 B_w)^T is an output of the dual",
        "a dual system exchanges inputs and outputs; (2.44) uses it so",
        "24_observer",
    ),
    Erratum(
        "misprint",
        "Theorem 2.5",
        "Q of 2n x 2n, P_1, P_2 of n x n, Y of q x n; the system (2.8)",
        "n stands for the length of the state, 2n in (2.11); the system (2.11)",
        "the observer (2.39) and its error are those of (2.11); Theorem "
        "2.4 counts n likewise",
        "24_observer",
    ),
    Erratum(
        "misprint",
        "Theorem 2.5, proof",
        "multiply by [0 E_i] and its transpose",
        "by diag(I, E_i) and its transpose",
        "(2.44) keeps J, which [0 E_i] would remove",
        "24_observer",
    ),
    Erratum(
        "misprint",
        "Procedure 2.5, step 2",
        "E-bar, A and C in (2.42)",
        "in (2.40)",
        "they are read off (2.40), as the line after (2.41) says",
        "24_observer",
    ),
)
